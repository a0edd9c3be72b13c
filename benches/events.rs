//! The fast photon engine beside the plain loop, on paper-single.
//!
//! Prints nanoseconds of processor time per detection of both in the same run,
//! least and median of some rounds, and the ratio of the least ones, for each
//! instruction set of this processor and several rates; then how counting scales
//! with the number of cores. Processor time, because a machine may be shared;
//! only the scaling needs a quiet one.
//!
//!     cargo bench --bench events

use std::error::Error;
use std::num::NonZero;
use std::path::Path;
use std::thread::available_parallelism;
use std::time::Instant;

use goldtof::photons::fast::{InstructionSet, StepCounter};
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::scan::Step;
use goldtof::scene::{self, DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use rustix::time::{ClockId, clock_gettime};

const ROUNDS: usize = 7;
/// Sensor time per measurement is such that there are about so many detections.
const DETECTIONS: f64 = 8e6;
/// The plain loop gets this share of the steps.
const PLAIN_SHARE: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = scene::load(Path::new("scenes/paper-single.toml"))?;
    println!("detections/s   engine     ns per detection (median)   plain loop (median)   ratio");
    for rate in [1e6, 10e6, 30e6, 45e6] {
        set_rate(&mut scene, rate);
        measure(&scene);
    }
    set_rate(&mut scene, 10e6);
    scaling(&scene);
    Ok(())
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
        scene.sources[0].mean_power_w *= ready(rate) / ready(found);
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
    for round in 0..ROUNDS {
        let seed = round as u64;
        for (&set, times) in sets.iter().zip(&mut fast) {
            let counter = StepCounter::new(&model).with_instruction_set(set);
            times.push(measured(&mut counts, |counts| {
                counter.count(seed, 0..repetitions, 0..4096, counts);
            }));
        }
        let plain_steps = counts.len() / PLAIN_SHARE;
        plain.push(measured(&mut counts[..plain_steps], |counts| {
            for (step, count) in (0..).zip(counts) {
                *count = count_step(&model, seed, step / 4096, Step(step % 4096));
            }
        }));
    }
    let plain = Times::of(&plain, |time| time.processor_ns);
    for (set, times) in sets.iter().zip(&fast) {
        let fast = Times::of(times, |time| time.processor_ns);
        let set = format!("{set:?}");
        println!(
            "{rate:9.2e}      {set:9} {:10.2} ({:.2}) {:18.1} ({:.1}) {:10.1}",
            fast.least,
            fast.median,
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
        let mut values: Vec<f64> = times.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        Times { least: values[0], median: values[values.len() / 2] }
    }
}
