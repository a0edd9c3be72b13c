//! Hardware that keeps histograms: Verilog and reference model agree under hostile inputs
//! and photons, what the Verilog sends is what the definition says.

use std::fs;

use goldtof::cosim::source::{SourceFile, Verilog, sources_of};
use goldtof::cosim::{CosimOptions, Cosimulation, StimulusKind, TOP, Verdict, cosimulate};
use goldtof::deliver::emit;
use goldtof::histogram::Histogram;
use goldtof::photons::DetectorModel;
use goldtof::reference::blocks::{Block, BlockMaker};
use goldtof::reference::photons::Photons;
use goldtof::reference::predictor::ReferenceModel;
use goldtof::reference::stimulus::{RESET_CLOCKS, clocks_for_scans, first_sample};
use goldtof::scene::{self, DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::sensor::layout::Layout;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::histograms;
use rayon::prelude::*;

use crate::hdl_support::{goldtof, models, run};

const SEED: u64 = 3;
/// A model of Lattice's block RAM.
const DP16KD: &str = include_str!("../../hdl/models/DP16KD.v");

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

/// A histogram of each kind.
pub fn scenes() -> Vec<(&'static str, Scene)> {
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
        ("two samples, interleaved", histogram(interleaved, 2, 3.0, SPAD)),
        ("the shortest code", histogram(given, 4, 3.0, EAGER)),
        ("the widest row", histogram(SHORT, 16, 200.0, EAGER)),
        ("two detectors", two),
        ("one memory", single(histogram(SHORT, 8, 7.0, SPAD), None)),
        ("one memory, a code period", single(histogram(SHORT, 4, 1.0, EAGER), None)),
        ("one memory, bins that saturate", single(histogram(SHORT, 8, 9.0, EAGER), Some(2))),
    ]
}

/// What stands for a memory.
#[derive(Clone, Copy)]
enum Memories {
    /// What synthesizers infer a memory from.
    Inferred,
    /// The same, but a word that is read at the clock that writes it is wrong: what
    /// `no_rw_check` allows.
    Collide,
    /// Lattice's DP16KD, as [`DP16KD`] has it; such a word is wrong there, too.
    OfEcp5,
}

impl Memories {
    /// Puts them into a design.
    fn put_into(self, sources: &mut Vec<SourceFile>) {
        let memory = sources
            .iter_mut()
            .find(|source| source.name == "block_memory.v")
            .expect("there is one");
        match self {
            Memories::Inferred => {}
            Memories::Collide => {
                let wrong = "i_write && i_write_address == i_address ? ~i_data : words[i_address]";
                let text = memory.text.replacen("words[i_address]", wrong, 1);
                assert_ne!(text, memory.text);
                memory.text = text;
            }
            Memories::OfEcp5 => {
                memory.text.insert_str(0, "`define ECP5_BLOCK_RAM\n");
                let name = "DP16KD.v".to_owned();
                let text = DP16KD.to_owned();
                let origin = None;
                sources.insert(0, SourceFile { name, text, origin });
            }
        }
    }
}

fn cosimulated(sensor: &Sensor, memories: Memories, stimulus: StimulusKind) -> Cosimulation {
    let emission = emit(sensor, "goldtof test").unwrap_or_else(|error| panic!("{error}"));
    let mut sources = sources_of(&emission.files);
    memories.put_into(&mut sources);
    let verilog = Verilog { top: TOP.to_owned(), sources, registers: None, cache: models() };
    let options = CosimOptions { stimulus, seed: SEED, ..Default::default() };
    cosimulate(sensor, &verilog, &options, |_, _| ()).expect("the tools are there")
}

#[test]
fn every_kind_of_histogram_matches_and_shows_all_its_cover_points() {
    scenes().into_par_iter().for_each(|(name, scene)| {
        let sensor = Sensor::new(&scene);
        let report = cosimulated(&sensor, Memories::Collide, StimulusKind::Adversarial).report;
        let mismatch = &report.first_mismatch;
        assert_eq!(report.verdict, Verdict::Match, "{name}: {mismatch:?}");
        let coverage = &report.coverage;
        assert_eq!(coverage.covered, coverage.points, "{name}: {coverage:?}");
    });
}

#[test]
fn histograms_in_block_ram_of_the_ecp5_match_as_well() {
    let mut scenes = scenes();
    // Eight samples, each with two memories, and with one; two detectors; a flag.
    scenes.retain(|(name, _)| {
        ["one adder", "two detectors", "one memory"].contains(name) || name.ends_with("saturate")
    });
    assert_eq!(scenes.len(), 4);
    scenes.into_par_iter().for_each(|(name, scene)| {
        let sensor = Sensor::new(&scene);
        let report = cosimulated(&sensor, Memories::OfEcp5, StimulusKind::Adversarial).report;
        let mismatch = &report.first_mismatch;
        assert_eq!(report.verdict, Verdict::Match, "{name}: {mismatch:?}");
        assert_eq!(report.coverage.covered, report.coverage.points, "{name}");
    });
}

/// A design of one memory of `words` words of `bits` bits, as it is inferred and as blocks of the
/// ECP5, and what writes and reads both at random: never a word at the clock that writes it.
fn memories_side_by_side(words: u64, bits: u32) -> String {
    let address_bits = u64::BITS - (words - 1).leading_zeros();
    format!(
        "`timescale 1ns / 1ps
module bench;
    reg clk = 0, write = 0, read = 0;
    reg [{a}:0] write_address = 0, address = 0;
    reg [{d}:0] data = 0;
    wire [{d}:0] inferred, of_blocks;
    integer clock, written, wrong = 0, seed = 1;

    block_memory #(.WORDS({words}), .ADDRESS_BITS({address_bits}), .BITS({bits})) a (
        clk, write, write_address, data, read, address, inferred);
    ecp5_memory #(.WORDS({words}), .ADDRESS_BITS({address_bits}), .BITS({bits})) b (
        clk, write, write_address, data, read, address, of_blocks);

    initial begin
        for (clock = 0; clock < {words} + 5000; clock = clock + 1) begin
            // Every word once, each read behind its writing, then any.
            write = clock < {words} || $random(seed) % 2 == 0;
            write_address = clock < {words} ? clock : $unsigned($random(seed)) % {words};
            data = {{$random(seed), $random(seed)}};
            read = $random(seed) % 4 != 0;
            address = $unsigned($random(seed)) % {words};
            if (clock < {words}) begin
                read = 1;
                address = clock == 0 ? {words} - 1 : clock - 1;
            end else if (clock % 3 == 0) address = (write_address + 1) % {words};
            if (address == write_address) read = 0;
            #1 clk = 1;
            #1 clk = 0;
            if (inferred !== of_blocks) wrong = wrong + 1;
        end
        $display(\"%0d wrong, last %h\", wrong, inferred);
        $finish;
    end
endmodule
",
        a = address_bits - 1,
        d = bits - 1,
    )
}

/// Every width that a block can have, several blocks side by side, and more words than one has.
#[test]
fn a_memory_of_ecp5_blocks_holds_what_an_inferred_one_does() {
    const MEMORY: &str = include_str!("../../hardware/src/rtl/back/block_memory.v");
    let sizes = [
        (8, 1),
        (31, 20),
        (1024, 18),
        (1025, 9),
        (2047, 16),
        (4095, 7),
        (8192, 3),
        (16_384, 2),
        (20_000, 3),
    ];
    for (words, bits) in sizes {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let of_blocks = MEMORY.replace("block_memory", "ecp5_memory");
        let files = [
            ("inferred.v", MEMORY.to_owned()),
            ("DP16KD.v", DP16KD.to_owned()),
            ("of_blocks.v", format!("`define ECP5_BLOCK_RAM\n{of_blocks}")),
            ("bench.v", memories_side_by_side(words, bits)),
        ];
        for (name, text) in &files {
            std::fs::write(folder.path().join(name), text).expect("it can be written");
        }
        let mut arguments = vec!["-g2005", "-s", "bench", "-o", "bench.vvp"];
        arguments.extend(files.iter().map(|(name, _)| *name));
        run(folder.path(), "iverilog", &arguments);
        let said = run(folder.path(), "vvp", &["-n", "bench.vvp"]);
        assert!(said.starts_with("0 wrong, last "), "{words} x {bits}: {said}");
        assert!(!said.contains('x'), "{words} x {bits}: {said}");
        let widths = [
            format!("-GWORDS={words}"),
            format!("-GADDRESS_BITS={}", u64::BITS - (words - 1).leading_zeros()),
            format!("-GBITS={bits}"),
        ];
        let mut arguments = vec!["--lint-only", "-Wall", "--top-module", "ecp5_memory"];
        arguments.extend(widths.iter().map(String::as_str));
        arguments.extend(["-Wno-DECLFILENAME", "of_blocks.v", "DP16KD.v"]);
        assert_eq!(run(folder.path(), "verilator", &arguments), "", "{words} x {bits}");
    }
}

/// r[k] of the first frame, from its hits: the sum of the signs that the reference, delayed
/// by k samples, has at each of them.
fn by_definition(sensor: &Sensor) -> Vec<Vec<i64>> {
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let models: Vec<DetectorModel> = DetectorIndex::of(&sensor.scene().detectors)
        .map(|detector| DetectorModel::new(sensor, detector))
        .collect();
    let mut reference = ReferenceModel::new(interface.clone()).expect("it can be predicted");
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
            let in_frame = hits.iter().filter(|&&hit| (start..start + samples).contains(&hit));
            for &hit in in_frame {
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
        let done = cosimulated(&sensor, Memories::Inferred, StimulusKind::Photons);
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
            assert_eq!([bins], simulated(&sensor, detector, Tier::Sampled, 1)[..], "{name}");
        }
    });
}

/// Each half of sixteen samples has an adder, so that one signal is made in two places.
#[test]
fn an_event_driven_simulator_comes_to_rest_with_an_adder_for_half_the_samples() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rtl = folder.path().join("rtl");
    let out = rtl.to_str().expect("text");
    let sets = ["clock.samples_per_chip=16", "source.code.degree=5", "scan.integration=2480 ns"];
    let sets = sets.iter().flat_map(|set| ["--set", *set]);
    let words = ["emit", "scenes/histogram.toml", "--out", out, "--quiet"];
    let emitted = goldtof(&words.into_iter().chain(sets).collect::<Vec<_>>());
    assert!(emitted.status.success(), "{}", String::from_utf8_lossy(&emitted.stderr));
    // As many clocks as take moments.
    let bench = rtl.join("sensor_top_tb.v");
    let text = fs::read_to_string(&bench).expect("it is there");
    let shorter = text.replace("localparam CLOCKS = 100000;", "localparam CLOCKS = 2000;");
    assert_ne!(text, shorter);
    fs::write(&bench, shorter).expect("it can be written");
    let list = ["-g2005", "-s", "sensor_top_tb", "-o", "bench.vvp", "-f", "sensor_top_tb.f"];
    run(&rtl, "iverilog", &list);
    let said = run(&rtl, "timeout", &["60", "vvp", "-n", "bench.vvp"]);
    assert!(said.contains("PASS"), "{said}");
}
