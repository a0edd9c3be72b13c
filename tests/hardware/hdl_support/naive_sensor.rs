//! The sensor from its definition, clock by clock, without pipelines: what
//! the ports have to show.

use std::collections::VecDeque;
use std::ops::Range;

use goldtof::reference::predictor::Skip;
use goldtof::scan::Step;
use goldtof::scene::{Combination, Polarity};
use goldtof::sensor::interface::Interface;

/// Inputs at one rising clock edge.
#[derive(Debug, Clone, Copy)]
pub struct Inputs {
    pub reset: bool,
    pub ready: bool,
    /// Input i's samples from bit i S on.
    pub samples: u128,
}

/// Outputs after one rising clock edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outputs {
    pub laser: u64,
    pub epoch: bool,
    pub data: u128,
    pub valid: bool,
    pub last: bool,
    pub overrun: bool,
    pub saturated: bool,
    /// Detector d's from bit d b on, b bits each.
    pub peak_step: u128,
    pub peak_count: u128,
    pub peak_valid: bool,
}

/// A group's counts, in the order in which they are sent, and the edge,
/// counted from the first after reset, at which the stream takes them over.
struct Results {
    edge: u64,
    /// Signed count, and all hits.
    counts: Vec<(i64, u64)>,
    is_last: bool,
    saturates: bool,
}

/// Outputs for `inputs`, where steps and scans are cut short as `skips` say; the first input
/// has to be a reset.
pub fn outputs(interface: &Interface, inputs: &[Inputs], skips: &[Skip]) -> Vec<Outputs> {
    let mut out = Vec::new();
    let mut rest = inputs;
    while !rest.is_empty() {
        let in_reset = rest.iter().take_while(|i| i.reset).count();
        out.extend(std::iter::repeat_n(Outputs::default(), in_reset));
        rest = &rest[in_reset..];
        let running = rest.iter().take_while(|i| !i.reset).count();
        let clocks = out.len() as u64..(out.len() + running) as u64;
        let of_run = skips.iter().filter(|skip| clocks.contains(&skip.clock));
        let of_run = of_run.map(|skip| Skip { clock: skip.clock - clocks.start, ..*skip });
        out.extend(run(interface, &rest[..running], &of_run.collect::<Vec<_>>()));
        rest = &rest[running..];
    }
    out
}

/// From the first edge without reset on, from which skips count, too.
fn run(interface: &Interface, inputs: &[Inputs], skips: &[Skip]) -> Vec<Outputs> {
    let results = results(interface, inputs, skips);
    let peaks = peaks(interface, &results);
    let mut next_peak = peaks.iter().peekable();
    let mut shown = Outputs::default();
    // Counts behind the one shown.
    let mut behind: VecDeque<(i64, u64)> = VecDeque::new();
    let mut behind_is_last = false;
    let mut next = results.iter().peekable();
    inputs
        .iter()
        .zip(0u64..)
        .map(|(input, n)| {
            shown.laser = 0;
            for (m, code) in interface.source_codes.iter().enumerate() {
                let chip = code.chips[(n % code.len()) as usize];
                shown.laser |= u64::from(chip) << m;
            }
            shown.epoch = n % interface.reference_codes[0].len() == 0;
            let mut refill = shown.valid && input.ready;
            let blocked = shown.valid && (!input.ready || !behind.is_empty());
            if let Some(results) = next.next_if(|r| r.edge == n) {
                if blocked {
                    shown.overrun = true;
                } else {
                    behind.extend(&results.counts);
                    behind_is_last = results.is_last;
                    refill = true;
                }
                shown.saturated |= results.saturates;
            }
            if refill {
                shown.valid = !behind.is_empty();
                if let Some(result) = behind.pop_front() {
                    shown.data = data(interface, result);
                    shown.last = behind_is_last && behind.is_empty();
                }
            }
            let peak = next_peak.next_if(|p| p.edge == n);
            shown.peak_valid = peak.is_some();
            if let Some(peak) = peak {
                (shown.peak_step, shown.peak_count) = (peak.step, peak.count);
            }
            shown
        })
        .collect()
}

/// What the stream shows of a count and its hits: the count in whole bytes, and
/// above it, if the hardware sends them, the hits in whole bytes.
fn data(interface: &Interface, (count, hits): (i64, u64)) -> u128 {
    let count_bytes = interface.count_bits().div_ceil(8);
    let low = count as u128 & ((1 << (8 * count_bytes)) - 1);
    match interface.total() {
        None => low,
        Some(_) => low | u128::from(hits) << (8 * count_bytes),
    }
}

/// What the peak detector's ports show from an edge on.
struct Peaks {
    edge: u64,
    step: u128,
    count: u128,
}

/// The first of each scan's largest counts, detector by detector.
fn peaks(interface: &Interface, results: &[Results]) -> Vec<Peaks> {
    let Some(plan) = interface.peak() else {
        return Vec::new();
    };
    let detectors = interface.reference_codes.len();
    let mut scan = vec![Vec::new(); detectors];
    let mut found = Vec::new();
    for group in results {
        let steps = group.counts.len() / detectors;
        for (counts, group) in scan.iter_mut().zip(group.counts.chunks(steps)) {
            counts.extend(group.iter().map(|&(count, _)| count));
        }
        if !group.is_last {
            continue;
        }
        let latency = u64::from(plan.latency_clocks - interface.result_latency_clocks);
        let mut peak = Peaks { edge: group.edge + latency, step: 0, count: 0 };
        for (detector, counts) in scan.iter_mut().enumerate() {
            let largest = *counts.iter().max().expect("a scan has steps");
            let first = counts.iter().position(|&count| count == largest);
            let step = interface.timing.scan.first_step + first.expect("it is there") as u64;
            let step = step % interface.timing.scan.steps_per_period;
            let count = largest as u128 & (u128::MAX >> (128 - plan.count_bits));
            peak.step |= u128::from(step) << (detector as u32 * plan.step_bits);
            peak.count |= count << (detector as u32 * plan.count_bits);
            counts.clear();
        }
        found.push(peak);
    }
    found
}

fn results(interface: &Interface, inputs: &[Inputs], skips: &[Skip]) -> Vec<Results> {
    let period = interface.reference_codes[0].len();
    let scan = &interface.timing.scan;
    let (integration, steps) = (scan.integration_chips, scan.steps);
    let parallel = u64::from(interface.parallel());
    let mut found = Vec::new();
    // First cycle of the group, and the steps that the delay lags behind.
    let (mut first, mut lag) = (0, 0);
    loop {
        let groups = steps.div_ceil(parallel);
        let mut group = 0;
        while group < groups {
            let mut chips = integration;
            for skip in skips {
                // The word of cycle n comes at edge n + 1.
                let chip = skip.clock.wrapping_sub(1 + first);
                if chip < chips {
                    assert_eq!((skip.chip, skip.group.0), (chip, group));
                    chips -= skip.chips;
                    group += skip.groups;
                    lag += skip.groups * parallel;
                }
            }
            let edge = first + chips + u64::from(interface.result_latency_clocks);
            if edge >= inputs.len() as u64 {
                return found;
            }
            let half = 1i64 << (interface.count_bits() - 1);
            let (mut counts, mut saturates) = (Vec::new(), false);
            for detector in 0..interface.reference_codes.len() {
                for j in group * parallel..((group + 1) * parallel).min(steps) {
                    let period = scan.steps_per_period;
                    let step = (scan.phase_step(Step(j)) + period - lag % period) % period;
                    let words = (first..first + chips)
                        .map(|n| signed_hits(interface, inputs, detector, n, step));
                    let exact = words.fold((0, 0), |(up, down), word| (up + word.0, down + word.1));
                    let (count, hits) = (exact.0 - exact.1, (exact.0 + exact.1) as u64);
                    let most =
                        interface.total().map_or(u64::MAX, |_| (1 << interface.count_bits()) - 1);
                    counts.push((count.clamp(-half, half - 1), hits.min(most)));
                    saturates |= counts.last() != Some(&(count, hits));
                }
            }
            found.push(Results { edge, counts, is_last: group + 1 == groups, saturates });
            first += chips;
            group += 1;
        }
        if !scan.is_full() || steps % parallel != 0 {
            first = first.div_ceil(period) * period;
            lag = 0;
        }
    }
}

/// Hits up and hits down of a detector in the word of cycle `n` by its reference
/// delayed by `k` samples.
fn signed_hits(
    interface: &Interface,
    inputs: &[Inputs],
    detector: usize,
    n: u64,
    k: u64,
) -> (i64, i64) {
    let code = &interface.reference_codes[detector];
    let (lanes, cells) = (i128::from(interface.lanes()), i128::from(interface.input_cells.count));
    let is_adder = interface.input_cells.combination == Combination::Adder;
    let level = |of: Range<i128>, lane: i128| {
        // Sample `lane` of cycle n; lane -1 is the last of the word before.
        let edge = (n + 1) as usize - usize::from(lane < 0);
        let first = detector as i128 * cells * lanes + lane.rem_euclid(lanes);
        let is_high = |cell: &i128| {
            let sample = inputs[edge].samples >> (first + cell * lanes) & 1 == 1;
            sample == (interface.polarity == Polarity::High)
        };
        let high = of.filter(is_high).count() as u32;
        match interface.input_cells.combination {
            Combination::Or | Combination::Adder => high >= interface.input_cells.coincidence,
            Combination::Xor => high % 2 == 1,
        }
    };
    let (mut up, mut down) = (0, 0);
    // Levels with edges of their own.
    let levels = if is_adder { cells } else { 1 };
    let cells_of = |level: i128| if is_adder { level..level + 1 } else { 0..cells };
    let hits = (0..levels).map(cells_of).flat_map(|of| {
        let rises = move |l: &i128| level(of.clone(), *l) && !level(of.clone(), l - 1);
        (0..lanes).filter(rises)
    });
    for l in hits {
        let chip = (i128::from(n) * lanes + l - i128::from(k)).div_euclid(lanes);
        match code.chips[chip.rem_euclid(i128::from(code.len())) as usize] {
            1 => up += 1,
            _ => down += 1,
        }
    }
    (up, down)
}
