//! Processor time of `goldtof run scenes/paper-single.toml`, all built before, part by part: against
//! the same verilated model in a bare C++ loop, and against the time that the sensor takes.
//!
//! Each part is done again by itself, and the rest is what is left of the whole. Times are medians of
//! processor time, that of the models' processes included; on a machine that others use, too, only
//! the column of ratios says something. Of the whole, wall time as well.
//!
//!     cargo bench --bench run

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use goldtof::cosim::build::{Built, build, cache_dir, file_identity};
use goldtof::cosim::error::CosimError;
use goldtof::cosim::lanes::{LaneRefusal, PreparedLanes};
use goldtof::cosim::source::{SourceFile, Verilog, sources_of};
use goldtof::cosim::verilated::Verilated;
use goldtof::cosim::{CosimOptions, Cosimulation, TOP, cosimulate};
use goldtof::deliver::Emission;
use goldtof::photons::DetectorModel;
use goldtof::recorded::{AsItIs, RecordedScan, fit_distance_alone};
use goldtof::reference::stimulus::clocks_for_scans;
use goldtof::report::curves::IntegrationCurves;
use goldtof::scene::DetectorIndex;
use goldtof::sensor::Sensor;
use goldtof::sensor::layout::Layout;
use goldtof::{RunOptions, deliver, scene};
use rustix::time::{ClockId, clock_gettime};

const ROUNDS: usize = 5;
const BARE_CLOCKS: u64 = 20_000_000;
const MADE_BY: &str = "goldtof run paper-single.toml";

/// Processor time so far: of this process, and of its children that have ended.
#[derive(Clone, Copy)]
struct Spent {
    own_s: f64,
    children_s: f64,
}

impl Spent {
    fn now() -> Result<Spent, Box<dyn Error>> {
        let own = clock_gettime(ClockId::ProcessCPUTime);
        let stat = std::fs::read_to_string("/proc/self/stat")?;
        // Behind the name, which is in brackets: user and system time of children, in ticks.
        let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
        let ticks: Vec<f64> =
            fields.skip(13).take(2).filter_map(|field| field.parse().ok()).collect();
        Ok(Spent {
            own_s: own.tv_sec as f64 + own.tv_nsec as f64 * 1e-9,
            children_s: ticks.iter().sum::<f64>() / rustix::param::clock_ticks_per_second() as f64,
        })
    }
}

/// Does something several times: processor time of this process, and of its children, each time.
fn measured(
    mut work: impl FnMut(u64) -> Result<(), Box<dyn Error>>,
) -> Result<Spent, Box<dyn Error>> {
    work(0)?;
    let mut own = Vec::new();
    let children = Spent::now()?.children_s;
    for round in 1..=ROUNDS as u64 {
        let before = Spent::now()?;
        work(round)?;
        own.push(Spent::now()?.own_s - before.own_s);
    }
    own.sort_by(f64::total_cmp);
    // Ticks are long: of all rounds together.
    let children_s = (Spent::now()?.children_s - children) / ROUNDS as f64;
    Ok(Spent { own_s: own[ROUNDS / 2], children_s })
}

/// What is measured.
struct Scan {
    sensor: Sensor,
    /// By the other estimator.
    other: Sensor,
    emission: Emission,
    sources: Vec<SourceFile>,
    cache: PathBuf,
    clocks: u64,
}

/// Processor time of a part, with its name.
type Part = (&'static str, f64);

fn sum(spent: Spent) -> f64 {
    spent.own_s + spent.children_s
}

impl Scan {
    fn of(path: &str) -> Result<Scan, Box<dyn Error>> {
        let scene = scene::load(Path::new(path))?;
        let sensor = Sensor::new(&scene);
        let emission = deliver::emit(&sensor, MADE_BY)?;
        Ok(Scan {
            other: Sensor::new(&scene.estimated_by(scene.estimator.other())),
            sources: sources_of(&emission.files),
            clocks: clocks_for_scans(sensor.interface(), 1),
            cache: cache_dir()?,
            emission,
            sensor,
        })
    }

    fn cosimulate(&self, seed: u64) -> Result<Cosimulation, CosimError> {
        let verilog = Verilog {
            top: TOP.to_owned(),
            sources: self.sources.clone(),
            registers: Some(self.emission.scan_registers.clone()),
            cache: self.cache.clone(),
        };
        let options = CosimOptions { seed, ..Default::default() };
        cosimulate(&self.sensor, &verilog, &options, |_, _| ())
    }

    fn built(&self) -> Result<Built, CosimError> {
        build(TOP, &self.sources, self.sensor.interface(), &self.cache)
    }

    fn prepared(&self) -> Result<PreparedLanes, LaneRefusal> {
        PreparedLanes::new(TOP, &self.sources, self.sensor.interface(), self.clocks, &self.cache)
    }

    fn cosimulation(&self) -> Result<Vec<Part>, Box<dyn Error>> {
        let tools = measured(|_| {
            self.built()?;
            Ok(self.prepared().map(drop)?)
        })?;
        let prepared = self.prepared()?;
        let detectors = [DetectorModel::new(&self.sensor, DetectorIndex(0))];
        let (clocks, go_on) = (self.clocks, AtomicBool::new(false));
        let photons = measured(|seed| Ok(prepared.photons(&detectors, seed, clocks, &go_on)?))?;
        let expected =
            measured(|seed| Ok(prepared.expectations(&detectors, seed, clocks, &go_on)?))?;
        let lanes = measured(|seed| {
            let outcome = prepared.run(&detectors, seed, clocks, &go_on, &|_| ())?;
            match outcome.differs {
                None => Ok(()),
                Some(clock) => Err(format!("the lanes differ at clock {clock}").into()),
            }
        })?;
        let whole = measured(|seed| Ok(self.cosimulate(seed).map(drop)?))?;
        Ok(vec![
            ("tools and what is kept of builds", sum(tools)),
            ("photons", sum(photons)),
            ("reference model", sum(expected) - sum(photons)),
            ("painting, and talk with the lanes", lanes.own_s - expected.own_s),
            ("gates: lanes, and their referee", lanes.children_s),
            ("lock-step beside them, twice 500,000 clocks", sum(whole) - sum(lanes) - sum(tools)),
        ])
    }

    /// And what the cache keeps of theory.
    fn others(&self) -> Result<(Vec<Part>, f64), Box<dyn Error>> {
        let detector = DetectorIndex(0);
        let counts: Vec<_> =
            self.cosimulate(1)?.counts[0].iter().map(|sent| sent.step_count()).collect();
        let emission = measured(|_| Ok(deliver::emit(&self.sensor, MADE_BY).map(drop)?))?;
        let mut curves = Vec::new();
        let theory = measured(|_| {
            curves = IntegrationCurves::of_first_paths(&self.sensor);
            Ok(())
        })?;
        let estimate =
            |sensor| IntegrationCurves::reporter(&curves, sensor, detector).scan(&counts);
        let both = || [&self.sensor, &self.other].map(estimate);
        let estimates = measured(|_| {
            drop(both());
            Ok(())
        })?;
        let scan = RecordedScan { detector, counts: counts.clone(), has_totals: false };
        let [phase, model] = both();
        let as_it_is = AsItIs::new(&self.sensor, detector);
        let distance = measured(|_| {
            fit_distance_alone(&self.sensor, (&scan, &as_it_is), &phase, &mut model.clone());
            Ok(())
        })?;
        let expected = measured(|_| {
            drop(AsItIs::new(&self.sensor, detector));
            Ok(())
        })?;
        let parts = vec![
            ("emission", sum(emission)),
            ("both estimates", sum(estimates)),
            ("fit of the distance alone", sum(distance)),
            ("what the scene expects of each count", sum(expected)),
        ];
        Ok((parts, sum(theory)))
    }

    /// Processor time and wall time of all of it.
    fn whole(&self) -> Result<(f64, f64), Box<dyn Error>> {
        let out = tempfile::tempdir()?;
        let mut wall_s = Vec::new();
        let whole = measured(|seed| {
            let options = RunOptions {
                out: Some(out.path().to_owned()),
                seed,
                made_by: MADE_BY.to_owned(),
                program: Some(file_identity(Path::new("/proc/self/exe"))?),
                ..Default::default()
            };
            let started = Instant::now();
            goldtof::run(&self.sensor, &options, |_| ())?;
            wall_s.push(started.elapsed().as_secs_f64());
            Ok(())
        })?;
        wall_s.sort_by(f64::total_cmp);
        Ok((sum(whole), wall_s[wall_s.len() / 2]))
    }

    /// Processor time of the bare loop for as many clocks.
    fn bare_s(&self) -> Result<f64, Box<dyn Error>> {
        let layout = Layout::of(self.sensor.interface());
        let mut ready = vec![0; layout.inputs.words];
        let field = layout.inputs.field(goldtof::sensor::port::PortRole::Ready);
        ready[field.word] = 1 << field.shift;
        let built = self.built()?;
        let bare =
            measured(|_| Ok(Verilated::load(&built, &layout)?.run_bare(&ready, BARE_CLOCKS)?))?;
        Ok(sum(bare) * self.clocks as f64 / BARE_CLOCKS as f64)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scan = Scan::of("scenes/paper-single.toml")?;
    let mut parts = scan.cosimulation()?;
    let (others, theory_s) = scan.others()?;
    parts.extend(others);
    let (whole_s, wall_s) = scan.whole()?;
    let bare_s = scan.bare_s()?;
    let sensor_s = scan.clocks as f64 / scan.sensor.timing().clock.frequency_hz();
    let rest = whole_s - parts.iter().map(|(_, s)| s).sum::<f64>();
    println!("{:45} {:>9} {:>8} {:>10} {:>10}", "part", "s", "of all", "of sensor", "of bare");
    for (name, s) in parts.into_iter().chain([("rest", rest), ("all", whole_s)]) {
        let [all, own, loops] = [whole_s, sensor_s, bare_s].map(|whole| 100.0 * s / whole);
        println!("{name:45} {s:9.4} {all:7.1}% {own:9.2}% {loops:9.2}%");
    }
    println!("theory that the cache keeps, which a first run takes beside that: {theory_s:.3} s");
    println!("wall time of all of it: {wall_s:.2} s");
    println!("the sensor takes {sensor_s:.2} s; the bare loop {bare_s:.2} s for as many clocks");
    Ok(())
}
