//! Photons and afterpulses of a detector by another construction than the product's.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use goldtof_sensor::scene::{Recharge, Scene};
use rand::RngExt as _;
use rand::rngs::StdRng;

/// Integer attoseconds of a chip, because floats have no order.
fn key(chips: f64) -> i64 {
    (chips * 1e12) as i64
}

fn exponential(rng: &mut StdRng) -> f64 {
    -(1.0 - rng.random::<f64>()).ln()
}

/// When photons and dark counts would fire a detector that is always ready: a list by thinning.
fn candidates(scene: &Scene, number: usize, rng: &mut StdRng, from: f64, end: f64) -> Vec<i64> {
    let spad = &scene.detectors[number];
    let source = &scene.sources[0];
    let chips = &source.code.chips;
    let chip_s = scene.chip_period_ps * 1e-12;
    let ones = chips.iter().filter(|&&c| c == 1).count() as f64;
    let length = chips.len() as f64;
    let energy = 6.626_070_15e-34 * 299_792_458.0 / (source.wavelength_nm * 1e-9);
    let path = scene.paths.iter().find(|path| path.detector.0 == number).expect("a path");
    // Of photons that are not detected nothing follows: these are a thinner Poisson process.
    let mean_detected = source.mean_power_w / energy
        * chip_s
        * path.transmission
        * spad.photon_detection_probability;
    let on = mean_detected * length / (ones + (length - ones) / source.extinction_ratio);
    let off = on / source.extinction_ratio;
    let constant = (spad.background_rate_cps * spad.photon_detection_probability
        + spad.dark_count_rate_cps)
        * chip_s;
    let mut candidates = Vec::new();
    let mut time = from;
    loop {
        time += exponential(rng) / (on + constant);
        if time > end + 10.0 {
            return candidates;
        }
        let sent = (time - path.delay_ps / scene.chip_period_ps).floor();
        let light = if chips[(sent as i64).rem_euclid(chips.len() as i64) as usize] == 1 {
            on
        } else {
            off
        };
        if rng.random::<f64>() < (light + constant) / (on + constant) {
            candidates.push(key(time));
        }
    }
}

/// Registered times of several detectors, in chips from 0, whose avalanches fire others, as many as
/// `fired` draws for one, with the delay of its crosstalk: all that may fire any of them in one heap,
/// without afterpulses.
pub fn coupled_detections(
    scene: &Scene,
    rng: &mut StdRng,
    end: f64,
    warm_up: f64,
    fired: &dyn Fn(&mut StdRng, usize) -> Vec<usize>,
) -> Vec<Vec<f64>> {
    let number = scene.detectors.len();
    let mut heap = BinaryHeap::new();
    for of in 0..number {
        heap.extend(
            candidates(scene, of, rng, -warm_up, end).into_iter().map(|t| Reverse((t, of))),
        );
    }
    let mut ready = vec![i64::MIN; number];
    let mut registered = vec![Vec::new(); number];
    while let Some(Reverse((time, of))) = heap.pop() {
        if time < ready[of] {
            continue;
        }
        let spad = &scene.detectors[of];
        ready[of] = time + key(spad.dead_time_ps / scene.chip_period_ps);
        let seen = time as f64 * 1e-12 + spad.delay_ps / scene.chip_period_ps;
        if (0.0..end).contains(&seen) {
            registered[of].push(seen);
        }
        let Some(talk) = spad.crosstalk else { continue };
        for other in fired(rng, of) {
            heap.push(Reverse((time + key(talk.delay_ps / scene.chip_period_ps), other)));
        }
    }
    registered
}

/// Registered times of a detector, in chips from 0, by another construction: a list of all
/// photons by thinning, a heap of afterpulses, one comparison per candidate.
pub fn detections(
    scene: &Scene,
    number: usize,
    rng: &mut StdRng,
    end: f64,
    warm_up: f64,
) -> Vec<f64> {
    let spad = &scene.detectors[number];
    let photons = candidates(scene, number, rng, -warm_up, end);
    let mut candidates: BinaryHeap<_> = photons.into_iter().map(Reverse).collect();
    // A last one, or the last avalanche before it would have no afterpulses.
    candidates.push(Reverse(key(end + 20.0)));
    let dead_time = key(spad.dead_time_ps / scene.chip_period_ps);
    let time_constant = spad.afterpulsing_time_constant_ps / scene.chip_period_ps;
    let mut ready = i64::MIN;
    let mut has_traps = false;
    let mut registered = Vec::new();
    while let Some(Reverse(time)) = candidates.pop() {
        if time < ready {
            if spad.recharge == Recharge::Passive {
                ready = time + dead_time;
            }
            continue;
        }
        if std::mem::take(&mut has_traps) {
            // A unit-rate Poisson process up to the mean number, from the dead time's end on.
            let mean = -(1.0 - spad.afterpulsing_probability).ln();
            let mut passed = exponential(rng);
            while passed < mean {
                candidates.push(Reverse(ready + key(exponential(rng) * time_constant)));
                passed += exponential(rng);
            }
            // One of them may come before this one.
            candidates.push(Reverse(time));
            continue;
        }
        ready = time + dead_time;
        has_traps = true;
        registered.push(time as f64 * 1e-12 + spad.delay_ps / scene.chip_period_ps);
    }
    registered.retain(|&time| (0.0..end).contains(&time));
    registered
}

/// When the level of several cells behind one input rises, and what is the case at each of some
/// instants: of each cell the registered times, each of which makes a pulse of `width`. By sorting all
/// edges; `is_high` says what so many pulses make of the level.
pub fn level_of_cells(
    registered: &[Vec<f64>],
    width: f64,
    is_high: &dyn Fn(usize) -> bool,
) -> Vec<[f64; 2]> {
    let mut edges = Vec::new();
    for times in registered {
        // A cell's own pulses that overlap are one.
        let mut until = f64::NEG_INFINITY;
        for &time in times {
            if time > until {
                edges.push((time, 1));
            } else {
                edges.pop();
            }
            until = time + width;
            edges.push((until, -1));
        }
    }
    edges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pulses: Vec<[f64; 2]> = Vec::new();
    let (mut high, mut was_high) = (0_i64, false);
    for (time, change) in edges {
        high += change;
        let now = is_high(high as usize);
        match (was_high, now) {
            (false, true) => pulses.push([time, f64::INFINITY]),
            (true, false) => {
                if let Some(last) = pulses.last_mut() {
                    last[1] = time;
                }
            }
            _ => {}
        }
        was_high = now;
    }
    pulses
}

/// How many of a level's pulses, in order, begin with a high sample after a low one, of the first `chips` chips of so
/// many samples each.
pub fn sampled_rises(pulses: &[[f64; 2]], samples: f64, chips: f64) -> usize {
    let mut low_from = f64::NEG_INFINITY;
    let rises = pulses.iter().filter(|[rise, fall]| {
        let [first, end] = [rise, fall].map(|time| (time * samples).ceil());
        let before = if first < end { std::mem::replace(&mut low_from, end) } else { first };
        before < first && first < chips * samples
    });
    rises.count()
}

/// Rising edges of a level that is looked at `chips` times at each of some instants of a chip, which
/// are in chips: it is high for `width` after each of the `registered` times, which are in order. The
/// number of each look at which it is high and was low before, from 0.
pub fn rising_edges(registered: &[f64], width: f64, instants: &[f64], chips: u64) -> Vec<u64> {
    let mut rises = Vec::new();
    let (mut next, mut high_until) = (0, f64::NEG_INFINITY);
    let mut was_high = false;
    for chip in 0..chips {
        for (number, instant) in (0_u64..).zip(instants) {
            let now = chip as f64 + instant;
            while registered.get(next).is_some_and(|time| *time <= now) {
                high_until = registered[next] + width;
                next += 1;
            }
            let is_high = now < high_until;
            if is_high && !was_high {
                rises.push(chip * instants.len() as u64 + number);
            }
            was_high = is_high;
        }
    }
    rises
}
