//! The fast photon engine beside the plain loop, on paper-single.
//!
//! Prints nanoseconds per detection of both in the same run, their ratio, for
//! each instruction set of this processor and several rates, and how counting
//! scales with the number of cores.
//!
//!     cargo bench --bench events

use std::error::Error;
use std::num::NonZero;
use std::path::Path;
use std::thread::available_parallelism;
use std::time::Instant;

use goldtof::optics::fast::{InstructionSet, StepCounter};
use goldtof::optics::{DetectorModel, StepCount, count_step};
use goldtof::scene::{self, Scene};

const ROUNDS: usize = 7;
/// Sensor time per measurement is such that there are about so many detections.
const DETECTIONS: f64 = 8e6;
/// The plain loop gets this share of the steps.
const PLAIN_SHARE: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = scene::load(Path::new("scenes/paper-single.toml"))?;
    println!("detections/s   engine      ns per detection   plain loop   ratio");
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
        let model = DetectorModel::new(scene, 0);
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
    let model = DetectorModel::new(scene, 0);
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
            times.push(ns_per_detection(&mut counts, |counts| {
                counter.count(seed, 0..repetitions, 0..4096, counts);
            }));
        }
        let plain_steps = counts.len() / PLAIN_SHARE;
        plain.push(ns_per_detection(&mut counts[..plain_steps], |counts| {
            for (step, count) in (0..).zip(counts) {
                *count = count_step(&model, seed, step / 4096, step % 4096);
            }
        }));
    }
    let plain = median(&mut plain);
    for (set, times) in sets.iter().zip(&mut fast) {
        let fast = median(times);
        let set = format!("{set:?}");
        println!(
            "{:9.2e}      {set:9} {fast:8.2} (best {:.2}) {plain:14.1} {:8.1}",
            rate,
            times[0],
            plain / fast
        );
    }
}

/// Prints how much faster all cores are than one.
fn scaling(scene: &Scene) {
    let model = DetectorModel::new(scene, 0);
    let counter = StepCounter::new(&model);
    let cores = available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    let steps = scene.scan.steps;
    let mut counts = vec![StepCount::ZERO; steps as usize];
    let (mut one, mut all) = (Vec::new(), Vec::new());
    for round in 0..4 * ROUNDS {
        for (threads, times) in [(NonZero::<usize>::MIN, &mut one), (cores, &mut all)] {
            times.push(ns_per_detection(&mut counts, |counts| {
                counter.count_on_threads(threads, round as u64, 0..1, 0..steps, counts);
            }));
        }
    }
    let medians = (median(&mut one), median(&mut all));
    // The quietest rounds: other programs take cores away, not work.
    let (one, all) = (one[0], all[0]);
    println!(
        "a scan of {steps} steps: {one:.2} ns on one core, {all:.2} ns on {cores}: \
         {:.2} times as fast (median {:.2})",
        one / all,
        medians.0 / medians.1
    );
}

fn ns_per_detection(counts: &mut [StepCount], work: impl FnOnce(&mut [StepCount])) -> f64 {
    let started = Instant::now();
    work(counts);
    started.elapsed().as_secs_f64() * 1e9 / total(counts)
}

/// Sorts, too.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
