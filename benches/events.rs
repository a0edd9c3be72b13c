//! The fast photon engine beside the plain loop, on paper-single.
//!
//! Prints nanoseconds of processor time per detection of both in the same run,
//! least and median of some rounds, and the ratio of the least ones, for each
//! instruction set of this processor and several rates, of counts and of pulses; then what a detection
//! of any cell costs where a detector has other laws, beside one with none of them; then what a chip
//! costs over ranges of scene keys, with the largest step between neighbours; then how counting
//! scales with the number of cores. Processor time, because a machine may be shared;
//! only the scaling needs a quiet one.
//!
//!     cargo bench --bench events [-- DRAWING.svg]
//!
//! What a chip costs over the ranges is drawn into that file, too (docs/pictures/growth.svg).

use std::error::Error;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::Instant;

use goldtof::photons::fast::{InstructionSet, Recorder, StepCounter};
use goldtof::photons::{DetectorModel, PulseStream, StepCount, count_step};
use goldtof::report::chart::{Chart, ChartAxis, DrawingRole, Mark, Panel};
use goldtof::scan::{Group, Sample, Step};
use goldtof::scene::{self, CellOutputs, Combination, Crosstalk, Detector, DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use rustix::time::{ClockId, clock_gettime};

const ROUNDS: usize = 7;
/// Sensor time per measurement is such that there are about so many detections.
const DETECTIONS: f64 = 8e6;
const BLOCK_SAMPLES: u64 = 131_072;
/// The plain loop gets this share of the steps.
const PLAIN_SHARE: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo's own option comes before ours.
    let drawing = std::env::args().skip(1).find(|word| !word.starts_with('-')).map(PathBuf::from);
    let mut scene = scene::load(Path::new("scenes/paper-single.toml"))?;
    println!(
        "detections/s   engine     ns per detection (median)   pulse (median)   plain loop (median)   \
         ratio"
    );
    for rate in [1e6, 10e6, 30e6, 45e6] {
        set_rate(&mut scene, rate);
        measure(&scene);
    }
    laws()?;
    set_rate(&mut scene, 10e6);
    sweeps(drawing.as_deref())?;
    scaling(&scene);
    Ok(())
}

/// Settings of a detector, by what they make of it.
const LAWS: [(&str, &[&str]); 13] = [
    ("one SPAD", &[]),
    ("passive recharge", &["recharge=passive"]),
    ("OR of 4", &["cells=4"]),
    ("OR of 16", &["cells=16"]),
    ("2 of 4", &["cells=4", "coincidence=2"]),
    ("2 of 16", &["cells=16", "coincidence=2"]),
    ("XOR of 4", &["cells=4", "combination=xor"]),
    ("XOR of 16", &["cells=16", "combination=xor"]),
    ("adder of 4", &["cells=4", "cell_outputs=separate", "combination=adder"]),
    ("adder of 16", &["cells=16", "cell_outputs=separate", "combination=adder"]),
    ("OR of 4, crosstalk", &["cells=4", "cell_crosstalk={ probability = 0.1 }"]),
    ("OR of 16, crosstalk", &["cells=16", "cell_crosstalk={ probability = 0.1 }"]),
    (WITH_NEIGHBOUR, &[]),
];
const WITH_NEIGHBOUR: &str = "crosstalk of a second one";

/// Prints what a detection of any SPAD costs with each law, counted or not, and beside the first one, at
/// as many counted ones a second.
fn laws() -> Result<(), Box<dyn Error>> {
    for rate in [1e6, 10e6] {
        println!(
            "law at {rate:.0e} detections/s     ns of processor time for one of any SPAD (median)   ratio"
        );
        let mut first = None;
        for (name, settings) in LAWS {
            let settings = settings.iter().map(|setting| format!("detector.{setting}").parse());
            let settings: Vec<_> = settings.collect::<Result<_, _>>()?;
            let mut scene = scene::load_with(Path::new("scenes/paper-single.toml"), &settings)?;
            if name == WITH_NEIGHBOUR {
                let crosstalk = Some(Crosstalk { probability: 0.1, delay_ps: 0.0 });
                let other = scene.detectors[0].clone();
                scene.detectors.push(Detector { name: "second".to_owned(), crosstalk, ..other });
                let path = scene.paths[0].clone();
                scene.paths.push(scene::Path { detector: DetectorIndex(1), ..path });
            }
            set_rate(&mut scene, rate);
            let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
            let counter = StepCounter::new(&model);
            let steps = (DETECTIONS / rate / sensor_s(&scene, 1)).min(scene.scan.steps as f64);
            let mut counts = vec![StepCount::ZERO; steps as usize];
            let counted = counted_of_all(&scene, counts.len());
            let times = (0..ROUNDS as u64).map(|seed| {
                measured(&mut counts, |counts| {
                    counter.count(seed, 0..1, 0..counts.len() as u64, counts);
                })
            });
            let times = times.map(|time| time.processor_ns * counted);
            let times = Times::of_values(times.collect());
            let first = *first.get_or_insert(times.least);
            let (least, median, ratio) = (times.least, times.median, times.least / first);
            println!("{name:28} {least:18.2} ({median:.2}) {ratio:14.2}");
        }
    }
    Ok(())
}

/// Share of the detections of all SPADs that are simulated for the first detector which it counts: cells of which
/// some are counted as one, and a neighbour that is simulated beside it.
fn counted_of_all(scene: &Scene, steps: usize) -> f64 {
    let mut added = scene.clone();
    let spad = &mut added.detectors[0];
    if spad.cells > 1 {
        (spad.combination, spad.coincidence) = (Combination::Adder, 1);
        spad.cell_outputs = CellOutputs::Separate;
    }
    let count = |scene: &Scene, of: DetectorIndex| {
        let model = DetectorModel::new(&Sensor::new(scene), of);
        let mut counts = vec![StepCount::ZERO; steps];
        StepCounter::new(&model).count(0, 0..1, 0..steps as u64, &mut counts);
        total(&counts)
    };
    let all: f64 = DetectorIndex::of(&added.detectors).map(|of| count(&added, of)).sum();
    count(scene, DetectorIndex(0)) / all
}

/// Scenes that differ in a key, from neighbour to neighbour.
struct Sweep {
    name: &'static str,
    file: &'static str,
    /// What the value is, with its unit; nothing where it is not a number.
    axis: Option<ChartAxis>,
    /// The value, and the settings that make it.
    scenes: Vec<(f64, Vec<String>)>,
}

fn swept() -> Vec<Sweep> {
    const SINGLE: &str = "scenes/paper-single.toml";
    let code = |degree: u32| {
        let family = if degree.is_multiple_of(4) { "m-sequence" } else { "gold" };
        format!("code={{ family = \"{family}\", degree = {degree} }}")
    };
    let degrees = |source: &str| {
        (3..=16)
            .map(|degree| (f64::from(degree), vec![format!("{source}.{}", code(degree))]))
            .collect()
    };
    let edges = [["0 s", "0 s"], ["1 ns", "1 ns"], ["1 ns", "1.2 ns"], ["6 ns", "1 ns"]];
    let edges = edges.map(|[rise, fall]| {
        vec![format!("source.rise_time={rise}"), format!("source.fall_time={fall}")]
    });
    let nanoseconds = |key: &str, values: &[f64], has_list: bool| {
        let setting = |ns: f64| match has_list {
            true => format!("detector.{key}=[\"{ns} ns\"]"),
            false => format!("detector.{key}={ns} ns"),
        };
        values.iter().map(|&ns| (ns, vec![setting(ns)])).collect()
    };
    let movements: [&[&str]; 3] = [
        &["path.velocity=0 m/s"],
        &["path.velocity=5 m/s"],
        &[
            "path.velocity=5 m/s",
            "path.fluctuation={ std = \"5 mm\", correlation_time = \"1 ms\" }",
        ],
    ];
    let movements = movements.map(|settings| settings.iter().map(|s| s.to_string()).collect());
    let recharge = ["active", "passive"].map(|law| (0.0, vec![format!("detector.recharge={law}")]));
    let parallel = [1_u32, 2, 4, 8, 16]
        .map(|steps| (f64::from(steps), vec![format!("hardware.parallel={steps}")]));
    let sweep = |name, file, axis: Option<ChartAxis>, scenes| Sweep { name, file, axis, scenes };
    let linear = |label: &str| Some(ChartAxis::linear("", label));
    let log = |label: &str| Some(ChartAxis::log("", label));
    vec![
        sweep("degree", SINGLE, linear("degree of the code"), degrees("source")),
        sweep(
            "unlike periods",
            "scenes/dual-view.toml",
            linear("degree of the other laser's code, beside 11"),
            degrees("source[other]"),
        ),
        sweep(
            "jitter",
            SINGLE,
            log("jitter (ns)"),
            nanoseconds("jitter", &[0.0, 0.05, 0.2, 0.4, 1.0, 4.0, 16.0], true),
        ),
        sweep(
            "dead time",
            SINGLE,
            log("dead time (ns)"),
            nanoseconds("dead_time", &[0.0, 14.0, 250.0, 500.0, 1e3, 2e3, 4e3, 8e3], false),
        ),
        sweep("parallel", SINGLE, log("phase steps at once"), parallel.into()),
        sweep("edges", SINGLE, None, edges.map(|settings| (0.0, settings)).into()),
        sweep("recharge", SINGLE, None, recharge.into()),
        sweep("movement", SINGLE, None, movements.map(|settings| (0.0, settings)).into()),
    ]
}

/// Prints what a chip of a step, and a chip of a group's pulses, cost over ranges of keys; draws it into a
/// file, if there is one.
fn sweeps(drawing: Option<&Path>) -> Result<(), Box<dyn Error>> {
    println!("scene: ns of processor time for a chip of a step, and of a group's pulses");
    let mut largest = (0.0, String::new());
    let mut panels = Vec::new();
    for Sweep { name, file, axis, scenes } in swept() {
        let mut costs_ns: Vec<(f64, [f64; 2])> = Vec::new();
        for (value, settings) in scenes {
            let parsed: Vec<_> = settings.iter().map(|s| s.parse()).collect::<Result<_, _>>()?;
            let scene = scene::load_with(Path::new(file), &parsed)?;
            let costs = chip_costs_ns(&scene);
            println!("{name:14} {:60} {:8.3} {:8.3}", settings.join(" "), costs[0], costs[1]);
            for (cost, before) in costs.iter().zip(costs_ns.last().iter().flat_map(|(_, of)| of)) {
                if cost / before > largest.0 {
                    largest = (cost / before, settings.join(" "));
                }
            }
            costs_ns.push((value, costs));
        }
        if let Some(axis) = axis {
            let of = |kind: usize| costs_ns.iter().map(move |(value, costs)| (*value, costs[kind]));
            let y = ChartAxis::log("", "processor time of a chip (ns)");
            let panel = Panel::new(axis, y)
                .with("counts of a step", DrawingRole::Counts, Mark::LineAndDots, of(0))
                .with("pulses of a group", DrawingRole::Other(1), Mark::LineAndDots, of(1));
            panels.push(panel);
        }
    }
    println!("largest step between neighbours: {:.2} times, to {}", largest.0, largest.1);
    if let Some(path) = drawing {
        let title =
            "A chip's cost in the fast photon engine, 10 million detections a second".to_owned();
        std::fs::write(path, Chart { title, panels }.svg())?;
    }
    Ok(())
}

/// Counting, and pulses.
fn chip_costs_ns(scene: &Scene) -> [f64; 2] {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let (counter, recorder) = (StepCounter::new(&model), Arc::new(Recorder::new(&model)));
    let groups = model.timing().groups().min(512);
    let steps = (groups * u64::from(scene.hardware.parallel)).min(scene.scan.steps);
    let chips = scene.scan.integration_chips as f64;
    let mut counts = vec![StepCount::ZERO; steps as usize];
    let least = |work: &mut dyn FnMut()| {
        let times = (0..3).map(|_| {
            let started = processor_s();
            work();
            processor_s() - started
        });
        times.fold(f64::INFINITY, f64::min)
    };
    let counting_s = least(&mut || counter.count(1, 0..1, 0..steps, &mut counts));
    let pulses_s = least(&mut || {
        pulses(&recorder, 1, groups);
    });
    [counting_s / steps as f64, pulses_s / groups as f64].map(|s| s * 1e9 / chips)
}

/// Number of pulses of the first groups of a scan, in blocks of clocks as a co-simulation asks for them.
fn pulses<'m>(recorder: &Arc<Recorder<'m>>, seed: u64, groups: u64) -> usize {
    let timing = recorder.model().timing();
    let samples = timing.sampling().samples_of(groups * timing.scan.integration_chips);
    let mut stream = PulseStream::of_groups(recorder, seed, 0, Group(0), Some(Group(groups)));
    let (mut pulses, mut number, mut until) = (Vec::new(), 0, 0);
    while until < samples {
        until += BLOCK_SAMPLES;
        pulses.clear();
        stream.advance(Sample(until), &mut pulses);
        number += pulses.len();
    }
    number
}

/// Sets the light to a rate of detections: the dead time stands between the two,
/// so it is found by counting.
fn set_rate(scene: &mut Scene, rate: f64) {
    for _ in 0..12 {
        let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
        let mut counts = vec![StepCount::ZERO; 512];
        StepCounter::new(&model).count(1, 0..1, 0..512, &mut counts);
        let found = total(&counts) / sensor_s(scene, counts.len());
        let spad = &scene.detectors[0];
        let ready = |rate: f64| rate / (1.0 - rate * spad.dead_time_ps * 1e-12);
        // Coincidences grow as the square of the light.
        scene.sources[0].mean_power_w *= (ready(rate) / ready(found)).sqrt();
    }
}

fn sensor_s(scene: &Scene, steps: usize) -> f64 {
    let chips = steps as f64 * scene.scan.integration_chips as f64;
    chips * scene.chip_period_ps * 1e-12
}

fn total(counts: &[StepCount]) -> f64 {
    counts.iter().map(|count| count.total as f64).sum()
}

/// Prints a line for each instruction set.
fn measure(scene: &Scene) {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let mut counts = vec![StepCount::ZERO; 4096];
    StepCounter::new(&model).count(0, 0..1, 0..4096, &mut counts);
    let rate = total(&counts) / sensor_s(scene, counts.len());
    let steps = (DETECTIONS / total(&counts) * counts.len() as f64) as usize;
    let repetitions = steps.div_ceil(4096) as u64;
    counts.resize(4096 * repetitions as usize, StepCount::ZERO);

    let sets = InstructionSet::available();
    let mut fast = vec![Vec::new(); sets.len()];
    let mut plain = Vec::new();
    let mut sampled = vec![Vec::new(); sets.len()];
    for round in 0..ROUNDS {
        let seed = round as u64;
        for (&set, times) in sets.iter().zip(&mut fast) {
            let counter = StepCounter::new(&model).with_instruction_set(set);
            times.push(measured(&mut counts, |counts| {
                counter.count(seed, 0..repetitions, 0..4096, counts);
            }));
        }
        for (&set, times) in sets.iter().zip(&mut sampled) {
            let recorder = Arc::new(Recorder::new(&model).with_instruction_set(set));
            let started = processor_s();
            let number = pulses(&recorder, seed, 4096);
            times.push((processor_s() - started) * 1e9 / number as f64);
        }
        let plain_steps = counts.len() / PLAIN_SHARE;
        plain.push(measured(&mut counts[..plain_steps], |counts| {
            for (step, count) in (0..).zip(counts) {
                *count = count_step(&model, seed, step / 4096, Step(step % 4096));
            }
        }));
    }
    let plain = Times::of(&plain, |time| time.processor_ns);
    for ((set, times), pulses) in sets.iter().zip(&fast).zip(&sampled) {
        let fast = Times::of(times, |time| time.processor_ns);
        let pulses = Times::of_values(pulses.clone());
        let set = format!("{set:?}");
        println!(
            "{rate:9.2e}      {set:9} {:10.2} ({:.2}) {:18.2} ({:.2}) {:10.1} ({:.1}) {:10.1}",
            fast.least,
            fast.median,
            pulses.least,
            pulses.median,
            plain.least,
            plain.median,
            plain.least / fast.least
        );
    }
}

/// Prints how much faster all cores are than one.
fn scaling(scene: &Scene) {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let counter = StepCounter::new(&model);
    let cores = available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    let steps = scene.scan.steps;
    let mut counts = vec![StepCount::ZERO; steps as usize];
    let (mut one, mut all) = (Vec::new(), Vec::new());
    for round in 0..4 * ROUNDS {
        for (threads, times) in [(NonZero::<usize>::MIN, &mut one), (cores, &mut all)] {
            times.push(measured(&mut counts, |counts| {
                counter.count_on_threads(threads, round as u64, 0..1, 0..steps, counts);
            }));
        }
    }
    let wall = |times: &[PerDetection]| Times::of(times, |time| time.wall_ns);
    let (one_wall, all_wall) = (wall(&one), wall(&all));
    let work = |times: &[PerDetection]| Times::of(times, |time| time.processor_ns).least;
    // The quietest rounds: other programs take cores away, not work.
    println!(
        "a scan of {steps} steps: {:.2} ns on one core, {:.2} ns on {cores}: {:.2} times as fast \
         (median {:.2}); processor time of all threads over that of one: {:.3}",
        one_wall.least,
        all_wall.least,
        one_wall.least / all_wall.least,
        one_wall.median / all_wall.median,
        work(&all) / work(&one)
    );
}

/// Nanoseconds per detection.
#[derive(Clone, Copy)]
struct PerDetection {
    wall_ns: f64,
    /// Of all threads together.
    processor_ns: f64,
}

fn measured(counts: &mut [StepCount], work: impl FnOnce(&mut [StepCount])) -> PerDetection {
    let (wall, processor) = (Instant::now(), processor_s());
    work(counts);
    let (wall_s, processor_s) = (wall.elapsed().as_secs_f64(), processor_s() - processor);
    let detections = total(counts);
    PerDetection {
        wall_ns: wall_s * 1e9 / detections,
        processor_ns: processor_s * 1e9 / detections,
    }
}

/// Processor time of all threads so far.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

struct Times {
    least: f64,
    median: f64,
}

impl Times {
    fn of(times: &[PerDetection], value: impl Fn(&PerDetection) -> f64) -> Times {
        Times::of_values(times.iter().map(value).collect())
    }

    fn of_values(mut values: Vec<f64>) -> Times {
        values.sort_by(f64::total_cmp);
        Times { least: values[0], median: values[values.len() / 2] }
    }
}
