//! Counts of two simulators of one detector, place by place.
//!
//! What is generic, and what the product inlines, would be compiled in the tests, without optimisation.

use goldtof_physics::photons::fast::RegisteredTicks;
use goldtof_physics::photons::{Detection, DetectorModel};
use goldtof_sensor::math::{bisected, normal_cdf};
use goldtof_sensor::scan::Group;

use crate::Moments;

/// With fewer counts of both together no normal law is taken for granted.
const LEAST_COUNTS: f64 = 100.0;

/// Chips of a step of whole code periods, and steps of so many photons at a rate, in chips of 8 ns: some hundred
/// photons in each step, and 280 chips at least.
pub fn steps_of_photons(photons: f64, rate_cps: f64, code_chips: u64) -> (u64, u64) {
    let in_chip = rate_cps * 8e-9;
    let chips = ((500.0 / in_chip).max(280.0) as u64).next_multiple_of(code_chips);
    (chips, (photons / (in_chip * chips as f64)).ceil() as u64)
}

/// When a group's detections of the plain loop, or rising edges of several cells, are registered, in chips.
pub fn plain_times(model: &DetectorModel, seed: u64, repetition: u64, group: Group) -> Vec<f64> {
    model.step(seed, repetition, group).map(chips).collect()
}

/// The same of what the vector lanes record.
pub fn recorded_times(recorded: &[RegisteredTicks]) -> Vec<f64> {
    recorded.iter().map(|time| chips(time.detection())).collect()
}

fn chips(detection: Detection) -> f64 {
    detection.chip as f64 + detection.fraction
}

/// A column for the place of each time in a period of so many chips, of so many columns to a chip, and for each
/// the column behind those.
pub fn columns_of_times(times: &[f64], chips: usize, per_chip: usize) -> Vec<usize> {
    let columns = chips * per_chip;
    let place = |time: &f64| [(time * per_chip as f64) as usize % columns, columns];
    times.iter().flat_map(place).collect()
}

/// Columns of the runs of some detectors: of each detection its detector and its place in a code period of 31 chips, and of
/// each two within five chips how far apart they are.
pub fn columns_of_runs(runs: &[Vec<f64>]) -> Vec<usize> {
    let mut columns = Vec::new();
    let number = runs.len();
    for (a, of_a) in runs.iter().enumerate() {
        for time in of_a {
            columns.extend([a, number + a * 124 + (time * 4.0) as usize % 124]);
        }
        for (b, of_b) in runs.iter().enumerate().skip(a) {
            let mut from = 0;
            for time in of_a {
                from += of_b[from..].iter().take_while(|other| **other < time - 5.0).count();
                let near = of_b[from..].iter().take_while(|other| **other < time + 5.0);
                columns.extend(near.filter(|other| b > a || *other > time).map(|other| {
                    let apart = ((other - time + 5.0) * 16.0) as usize;
                    number * 125 + (a * number + b) * 160 + apart.min(159)
                }));
            }
        }
    }
    columns
}

/// What steps count in each of some columns.
#[derive(Debug, Clone)]
pub struct Tally {
    steps: f64,
    sums: Vec<f64>,
    squares: Vec<f64>,
    /// Of one step, and which columns are not 0.
    row: Vec<u32>,
    counting: Vec<usize>,
}

impl Tally {
    pub fn new(columns: usize) -> Tally {
        let zeros = || vec![0.0; columns];
        let row = vec![0; columns];
        Tally { steps: 0.0, sums: zeros(), squares: zeros(), row, counting: Vec::new() }
    }

    /// Takes a step: the column of each of its counts.
    pub fn take(&mut self, counts: &[usize]) {
        self.steps += 1.0;
        for &column in counts {
            if self.row[column] == 0 {
                self.counting.push(column);
            }
            self.row[column] += 1;
        }
        for column in self.counting.drain(..) {
            let count = f64::from(std::mem::take(&mut self.row[column]));
            self.sums[column] += count;
            self.squares[column] += count * count;
        }
    }

    /// Of a column's counts of a step.
    pub fn moments(&self, column: usize) -> Moments {
        let (sum, count) = (self.sums[column], self.steps);
        let variance = (self.squares[column] - sum * sum / count) / (count - 1.0);
        Moments { count, mean: sum / count, variance }
    }
}

/// How many standard errors two simulators are apart, over all that is compared.
#[derive(Debug, Clone, Default)]
pub struct Comparisons {
    number: f64,
    squares: f64,
    largest: f64,
    place: String,
}

impl Comparisons {
    /// Compares the means of each column, and of those that count enough in a step for it the variances.
    pub fn add(&mut self, [a, b]: [&Tally; 2], name: &dyn Fn(usize) -> String) {
        if a.steps.min(b.steps) == 0.0 {
            return;
        }
        for column in 0..a.sums.len() {
            let [a, b] = [a, b].map(|tally| tally.moments(column));
            if a.mean * a.count + b.mean * b.count < LEAST_COUNTS {
                continue;
            }
            let error = a.standard_error().hypot(b.standard_error());
            self.add_z((a.mean - b.mean) / error, || name(column));
            if a.mean > LEAST_COUNTS {
                let errors = [a.count, b.count].map(|n| (2.0 / (n - 1.0)).sqrt());
                let z = (a.variance / b.variance).ln() / errors[0].hypot(errors[1]);
                self.add_z(z, || format!("variance of {}", name(column)));
            }
        }
    }

    fn add_z(&mut self, z: f64, name: impl Fn() -> String) {
        self.number += 1.0;
        self.squares += z * z;
        if z.abs() > self.largest.abs() {
            (self.largest, self.place) = (z, name());
        }
    }

    /// The largest of as many normal numbers as were compared: that which it exceeds with a chance.
    fn largest_by(&self, chance: f64) -> f64 {
        let exceeds = |z: f64| -(self.number * (-2.0 * normal_cdf(-z)).ln_1p()).exp_m1();
        bisected([0.0, 40.0], 60, |z| exceeds(z) > chance)
    }

    /// The largest difference is one that chance makes of so many in one of a thousand such tests, and the
    /// mean square is that of normal numbers, of which so many tell the same.
    #[track_caller]
    fn assert_chance(&self, what: &str, alike: f64) {
        let Comparisons { number, squares, largest, place } = self;
        let [median, limit] = [0.5, 1e-3].map(|chance| self.largest_by(chance));
        let rms = (squares / number).sqrt();
        println!(
            "{what}: {number} comparisons, largest z {largest:+.2} ({place}); in half of such tests \
             above {median:.2}; rms {rms:.3}"
        );
        assert!(largest.abs() < limit, "{what}, {place}: {largest:.2} standard errors away");
        let z = (squares / number - 1.0) / (2.0 * alike / number).sqrt();
        crate::assert_within_standard_errors(z, 4.5, &format!("{what}: mean square"));
    }
}

/// Each case's differences, and those of all together, are those that chance makes, of numbers of which so many
/// tell the same. Cases of which too little is counted have none.
#[track_caller]
pub fn assert_chance(what: &str, cases: Vec<(String, Comparisons)>, alike: f64) {
    let mut all = Comparisons::default();
    for (name, case) in cases.into_iter().filter(|(_, case)| case.number > 0.0) {
        case.assert_chance(&name, alike);
        all.number += case.number;
        all.squares += case.squares;
        if case.largest.abs() > all.largest.abs() {
            (all.largest, all.place) = (case.largest, format!("{name}, {}", case.place));
        }
    }
    all.assert_chance(what, alike);
}
