//! Hardware that keeps histograms: Verilog and reference model agree under hostile inputs
//! and photons, what the Verilog sends is what the definition says.

use std::sync::LazyLock;

use goldtof::cosim::engine::Engine;
use goldtof::cosim::source::sources_of;
use goldtof::cosim::window::Window;
use goldtof::cosim::{Cosimulation, Request, StimulusKind, TOP, Verdict, cosimulate};
use goldtof::deliver::emit;
use goldtof::histogram::Histogram;
use goldtof::photons::DetectorModel;
use goldtof::reference::blocks::{Block, BlockMaker};
use goldtof::reference::photons::Photons;
use goldtof::reference::predictor::Reference;
use goldtof::reference::stimulus::{RESET_CLOCKS, clocks_for_scans, first_sample};
use goldtof::scene::{self, DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::sensor::layout::Layout;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::histograms;
use rayon::prelude::*;
use tempfile::TempDir;

const SEED: u64 = 3;

/// A scene with strong light and a histogram over `periods` code periods.
fn histogram(code: &str, samples: u32, periods: f64, detector: &str) -> Scene {
    let text = format!(
        r#"
        clock = {{ chip_period = "8 ns", samples_per_chip = {samples} }}
        source = [{{ name = "laser", code = {code}, wavelength = "783 nm", mean_power = "40 pW", extinction_ratio = 10 }}]
        [[detector]]
        name = "near"
        reference = "laser"
        {detector}
        [[path]]
        source = "laser"
        detector = "near"
        distance = "3.2 m"
        [scan]
        integration = "1 s"
        [hardware]
        architecture = "histogram"
        "#
    );
    let mut scene = scene::parse("histogram.toml", &text).unwrap_or_else(|e| panic!("{e}"));
    let chips = scene.sources[0].code.len();
    scene.scan.integration_chips = (periods * chips as f64) as u64;
    scene
}

const SHORT: &str = "{ family = \"gold\", degree = 5 }";
const SPAD: &str = "dead_time = \"14 ns\"\npulse_width = \"7 ns\"\ndark_count_rate = \"71 kcps\"";
/// A detector that is ready again at once: hits as close as samples allow.
const EAGER: &str = "pulse_width = \"1 ns\"\ndark_count_rate = \"20 Mcps\"";

/// The same with one memory, and bins of so many bits.
fn single(mut scene: Scene, counter_width: Option<u32>) -> Scene {
    scene.hardware.buffers = 1;
    scene.hardware.counter_width = counter_width;
    scene
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let mut two = histogram(SHORT, 8, 3.0, SPAD);
    let mut far = two.detectors[0].clone();
    far.name = "far".to_owned();
    two.detectors.push(far);
    let mut path = two.paths[0].clone();
    path.detector = DetectorIndex(1);
    path.delay_ps += 12e3;
    two.paths.push(path);
    let interleaved = "{ family = \"m-sequence\", degree = 4, interleave = 1 }";
    let given = "{ family = \"chips\", chips = \"01101000\" }";
    let mut coarse = histogram(SHORT, 16, 3.0, SPAD);
    coarse.chip_period_ps = 16e3;
    vec![
        ("one adder", histogram(SHORT, 8, 7.0, SPAD)),
        ("two adders for 16 samples", coarse),
        ("one sample", histogram(SHORT, 1, 5.0, SPAD)),
        (
            "two samples, interleaved",
            histogram(interleaved, 2, 3.0, SPAD),
        ),
        ("the shortest code", histogram(given, 4, 3.0, EAGER)),
        ("the widest row", histogram(SHORT, 16, 200.0, EAGER)),
        ("two detectors", two),
        ("one memory", single(histogram(SHORT, 8, 7.0, SPAD), None)),
        (
            "one memory, a code period",
            single(histogram(SHORT, 4, 1.0, EAGER), None),
        ),
        (
            "one memory, bins that saturate",
            single(histogram(SHORT, 8, 9.0, EAGER), Some(2)),
        ),
    ]
}

/// Models that both tests need are built once.
static CACHE: LazyLock<TempDir> =
    LazyLock::new(|| tempfile::tempdir().expect("a temporary folder"));

/// A bank whose memories give a wrong word for one that is written at the same clock: what
/// `no_rw_check` allows.
fn collides(bank: &str) -> String {
    let mut text = bank.to_owned();
    let reads: Vec<&str> = bank
        .lines()
        .map(str::trim)
        .filter(|line| line.contains("_q <= memory"))
        .collect();
    assert!(!reads.is_empty(), "{bank}");
    for read in reads {
        let (q, word) = read
            .trim_end_matches(';')
            .split_once(" <= ")
            .expect("a read");
        let (memory, row) = word
            .trim_end_matches(']')
            .split_once('[')
            .expect("of a row");
        let write = format!(")\n            {memory}[i_write_row] <= ");
        let (before, written) = bank.split_once(&write).expect("it is written");
        let (written, _) = written.split_once(';').expect("an end");
        let writes = &before[before.rfind("if (").expect("at times") + 4..];
        let wrong = format!("{q} <= ({writes}) & (i_write_row == ({row})) ? ~{written} : {word};");
        text = text.replace(read, &wrong);
    }
    text
}

fn cosimulated(sensor: &Sensor, stimulus: StimulusKind) -> Cosimulation {
    let emission = emit(sensor, "goldtof test").unwrap_or_else(|error| panic!("{error}"));
    let mut sources = sources_of(&emission);
    if stimulus == StimulusKind::Adversarial {
        let mut banks = sources
            .iter_mut()
            .filter(|source| source.name == "bin_bank.v");
        let bank = banks.next().expect("there is one");
        bank.text = collides(&bank.text);
    }
    let request = Request {
        top: TOP.to_owned(),
        window: Window::Found,
        sources,
        registers: None,
        cache: CACHE.path().to_owned(),
        stimulus,
        clocks: None,
        seed: SEED,
        engine: Engine::Auto,
    };
    cosimulate(sensor, &request, |_, _| ()).expect("the tools are there")
}

#[test]
fn every_kind_of_histogram_matches_and_shows_all_its_cover_points() {
    scenes().into_par_iter().for_each(|(name, scene)| {
        let sensor = Sensor::new(&scene);
        let report = cosimulated(&sensor, StimulusKind::Adversarial).report;
        let mismatch = &report.first_mismatch;
        assert_eq!(report.verdict, Verdict::Match, "{name}: {mismatch:?}");
        let coverage = &report.coverage;
        assert_eq!(coverage.covered, coverage.points, "{name}: {coverage:?}");
    });
}

/// r[k] of the first frame, from its hits: the sum of the signs that the reference, delayed
/// by k samples, has at each of them.
fn by_definition(sensor: &Sensor) -> Vec<Vec<i64>> {
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let models: Vec<DetectorModel> = DetectorIndex::of(&sensor.scene().detectors)
        .map(|detector| DetectorModel::new(sensor, detector))
        .collect();
    let mut reference = Reference::new(interface.clone()).expect("it can be predicted");
    let mut photons = Photons::new(&models, interface, SEED);
    let clocks = clocks_for_scans(interface, 1);
    let mut maker = BlockMaker::new(&mut reference, &mut photons, &layout, clocks);
    let lanes = u64::from(interface.lanes());
    let start = first_sample(interface, RESET_CLOCKS);
    let samples = interface.timing.scan.integration_chips * lanes;
    let codes = &interface.reference_codes;
    let period = codes[0].len() * lanes;
    let mut counts = vec![vec![0; period as usize]; models.len()];
    let mut block = Block::default();
    while maker.make(&mut block) {
        for (detector, hits) in DetectorIndex::all().zip(maker.hits()) {
            let in_frame = hits
                .iter()
                .filter(|&&hit| (start..start + samples).contains(&hit));
            for hit in in_frame {
                for (k, count) in (0..).zip(counts[detector.0].iter_mut()) {
                    let at = (hit - start + period - k) % period / lanes;
                    *count += 2 * i64::from(codes[detector.0].chips[at as usize]) - 1;
                }
            }
        }
    }
    counts
}

/// Bins of the first frames, as one tier of the simulation has them.
fn simulated(sensor: &Sensor, detector: DetectorIndex, tier: Tier, frames: u64) -> Vec<Vec<u64>> {
    let mut bins = Vec::new();
    let keep = |histogram: Histogram| bins.push(histogram.bins().to_vec());
    histograms(sensor, detector, tier, SEED, frames, keep).expect("the tier has histograms");
    bins
}

/// No photon is lost between one frame and the next, and none counted twice.
#[test]
fn frames_that_the_verilog_sends_one_after_another_are_those_of_the_samples() {
    for (name, scene) in scenes() {
        if scene.detectors.len() == 1 && scene.hardware.buffers == 2 {
            continue;
        }
        let sensor = Sensor::new(&scene);
        for detector in DetectorIndex::of(&scene.detectors) {
            let [verilog, samples] =
                [Tier::Rtl, Tier::Sampled].map(|tier| simulated(&sensor, detector, tier, 3));
            assert_eq!(verilog.len(), 3, "{name}");
            assert!(verilog.iter().flatten().any(|&bin| bin > 0), "{name}");
            assert_eq!(verilog, samples, "{name}");
        }
    }
}

#[test]
fn every_phase_steps_count_follows_from_the_histogram_that_the_verilog_sent() {
    // Photons of an eager detector come as close as its pulses allow, too.
    let mut scenes = scenes();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/histogram.toml");
    let standard = scene::load(path.as_ref()).unwrap_or_else(|error| panic!("{error}"));
    scenes.push(("Table I's sensor, 16,376 phase steps", standard));
    scenes.into_par_iter().for_each(|(name, scene)| {
        let sensor = Sensor::new(&scene);
        let done = cosimulated(&sensor, StimulusKind::Photons);
        assert_eq!(done.report.verdict, Verdict::Match, "{name}");
        if sensor.interface().saturates() {
            return;
        }
        let expected = by_definition(&sensor);
        assert!(expected.iter().flatten().any(|&count| count > 0), "{name}");
        for (sent, expected) in done.counts.iter().zip(&expected) {
            let sent: Vec<i64> = sent.iter().map(|count| count.signed).collect();
            assert_eq!(&sent, expected, "{name}");
        }
        for (detector, sent) in DetectorIndex::all().zip(&done.counts) {
            let bins: Vec<u64> = sent.iter().filter_map(|count| count.bin).collect();
            assert_eq!(
                [bins],
                simulated(&sensor, detector, Tier::Sampled, 1)[..],
                "{name}"
            );
        }
    });
}
