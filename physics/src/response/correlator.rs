//! Expected counts of the up/down correlator, step by step.
//!
//! The reference of phase step k = a S + b holds chip c from c + a + b / S on
//! (plus the tier's edge delay). So it divides time, for each b, into *slots* of
//! one chip, each with one sign chi_(i - a), and
//! r = sum over slots i of chi_(i - a) H_b\[i\], H_b\[i\] the detections of slot i.
//! Slots are taken from rising edges. Where falling edges have another delay, the
//! detections G_b\[i\] between the two still count up at each falling edge, hence
//! + 2 G_b\[i\] there.
//!
//! Whole code periods are a periodic correlation (an FFT for each b), what is
//! left of the integration time a sum over its slots.

use std::sync::OnceLock;

use goldtof_fft::num_complex::Complex64;

use super::column::{ChipColumn, Jitter};
use super::forward::{AllAndMerged, Detections};
use super::grid::{Grid, frame_chips};
use super::light::Light;
use super::sampling::{self, DetectionSampling};
use super::tier::EdgeTiming;
use crate::photons::DetectorModel;

/// Means of r\[k\] and of the total count N\[k\] of one phase step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanCount {
    /// Mean of the signed count r.
    pub signed: f64,
    /// Mean of the number of all detections N.
    pub total: f64,
}

/// Tables from which every step's expected counts follow.
#[derive(Debug, Clone)]
pub struct ResponseTables {
    reference: Reference,
    samples_per_chip: u64,
    period_chips: usize,
    hits_per_period: f64,
    /// Chips from the window's shift to the rising edge's.
    rising_after_window: f64,
    phases: Vec<Phase>,
    /// Detections before the window's edge at each chip.
    window: Vec<f64>,
    /// Of light that is even, whose slots all count alike: sums of the reference's signs, and of its falls,
    /// before each chip.
    even: Option<Vec<[f64; 2]>>,
    /// Expected signed count of every phase step over a code period, once it was asked for.
    of_all: OnceLock<Vec<f64>>,
}

/// What a correlator's tables follow from.
pub struct TableSource<'a> {
    /// Cells of integration.
    pub grid: &'a Grid,
    /// The light that the grid was made for.
    pub light: &'a Light,
    /// Mean detections.
    pub detections: &'a AllAndMerged,
    /// The tier's edges.
    pub timing: EdgeTiming,
    /// What samples show of detections; none for a counter in continuous time.
    pub sampling: Option<&'a DetectionSampling>,
    /// Added to every path's time of flight.
    pub delay_chips: f64,
}

/// The tables of one sub-chip phase b.
#[derive(Debug, Clone)]
struct Phase {
    /// Detections before each slot, period + 1 of them.
    before: Vec<f64>,
    /// H_b, over one period and once more.
    hits: Vec<f64>,
    /// 2 G_b alike; empty if both kinds of edge are equally late.
    falling: Vec<f64>,
}

/// The reference code, with more than one period in a row.
#[derive(Debug, Clone)]
struct Reference {
    length: usize,
    signs: Vec<f64>,
    /// 1 where the chip is 0 after a 1.
    falls: Vec<f64>,
}

impl ResponseTables {
    /// The tables of a detector's counts.
    pub fn new(model: &DetectorModel, source: &TableSource) -> ResponseTables {
        let timing = &source.timing;
        let samples_per_chip = u64::from(model.timing.clock.samples_per_chip);
        let period_chips = source.grid.period_chips;
        let offset = |phase| sampling::phase_chips(source.sampling, samples_per_chip, phase);
        let columns = |edge: f64, transition: f64| -> Vec<Vec<f64>> {
            (0..samples_per_chip)
                .map(|phase| source.column(model, offset(phase) + edge, transition))
                .collect()
        };
        let mut before = columns(timing.rising, timing.transition);
        let mut window = source.column(model, timing.window, 0.0);
        let mut hits_per_period = source.detections.per_period();
        if let Some(sampling) = source.sampling.filter(|sampling| !sampling.sees_all()) {
            // The edges of slots and of the window are sample instants: those of phase 0 that
            // before sample 0.
            let unseen = (0..samples_per_chip as i64)
                .map(|phase| source.column(model, sampling.seen_from(phase - 1), 0.0));
            before = seen(&before, &unseen.collect::<Vec<_>>());
            window = before[0].clone();
            hits_per_period = window[period_chips];
        }
        let lag = timing.falling - timing.rising;
        let fallen = (lag != 0.0).then(|| columns(timing.falling, timing.transition));
        let phases = before.into_iter().enumerate().map(|(phase, before)| {
            let falling = fallen.as_ref().map(|fallen| {
                let between = fallen[phase].iter().zip(&before);
                let between = between.map(|(f, r)| 2.0 * (f - r));
                twice(between.take(period_chips).collect())
            });
            let hits = before.windows(2).map(|edge| edge[1] - edge[0]).collect();
            Phase { before, hits: twice(hits), falling: falling.unwrap_or_default() }
        });
        let reference = Reference::new(&model.reference.chips, period_chips);
        let of_cell = ResponseTables {
            even: source.grid.is_even().then(|| reference.sums()),
            reference,
            samples_per_chip,
            period_chips,
            hits_per_period,
            rising_after_window: timing.rising - timing.window,
            phases: phases.collect(),
            window,
            of_all: OnceLock::new(),
        };
        of_cell.times(f64::from(model.added_cells()))
    }

    /// All counts so many times as large.
    fn times(mut self, times: f64) -> ResponseTables {
        let scale = |table: &mut Vec<f64>| table.iter_mut().for_each(|value| *value *= times);
        for phase in &mut self.phases {
            [&mut phase.before, &mut phase.hits, &mut phase.falling].into_iter().for_each(scale);
        }
        scale(&mut self.window);
        self.hits_per_period *= times;
        self
    }

    /// The tables less those of the same counter under other light, by `times`. All that is
    /// read off tables is linear in them.
    pub fn less(&self, other: &ResponseTables, times: f64) -> ResponseTables {
        let less = |here: &[f64], there: &[f64]| -> Vec<f64> {
            here.iter().zip(there).map(|(here, there)| (here - there) * times).collect()
        };
        let phases = self.phases.iter().zip(&other.phases).map(|(here, there)| Phase {
            before: less(&here.before, &there.before),
            hits: less(&here.hits, &there.hits),
            falling: less(&here.falling, &there.falling),
        });
        ResponseTables {
            reference: self.reference.clone(),
            even: self.even.clone().filter(|_| other.even.is_some()),
            hits_per_period: (self.hits_per_period - other.hits_per_period) * times,
            phases: phases.collect(),
            window: less(&self.window, &other.window),
            of_all: OnceLock::new(),
            ..*self
        }
    }

    /// Expected detections at each sample of the code period, by the rising
    /// edges that divide samples.
    pub fn hits_per_sample(&self) -> Vec<f64> {
        let mut before: Vec<f64> = Vec::new();
        for chip in 0..self.period_chips {
            before.extend(self.phases.iter().map(|phase| phase.before[chip]));
        }
        before.push(before[0] + self.hits_per_period);
        before.windows(2).map(|edge| edge[1] - edge[0]).collect()
    }

    /// Expected detections in a whole code period.
    pub fn hits_per_period(&self) -> f64 {
        self.hits_per_period
    }

    /// Expected detections in `chips` chips, less than a period, from `first` on.
    pub fn hits_between(&self, first: usize, chips: usize) -> f64 {
        self.hits_before(first + chips) - self.window[first]
    }

    fn hits_before(&self, chip: usize) -> f64 {
        match chip.checked_sub(self.period_chips) {
            None => self.window[chip],
            Some(past) => self.window[past] + self.hits_per_period,
        }
    }

    /// Expected signed count of phase step `phase_step` over a code period.
    pub fn signed_per_period(&self, phase_step: u64) -> f64 {
        let (delay, phase) = self.split(phase_step);
        self.slots(phase, delay, 0, self.period_chips)
    }

    /// The same for every phase step of the reference's period.
    pub fn signed_per_period_of_all(&self) -> &[f64] {
        self.of_all.get_or_init(|| self.correlated())
    }

    /// Periodic correlations with the code, of which a transform of a length without small factors would make
    /// several of a power of two: with zeros behind both, what wraps round stands apart from what does not.
    fn correlated(&self) -> Vec<f64> {
        let length = self.reference.length;
        let padded = match length.is_power_of_two() {
            true => length,
            false => (2 * length).next_power_of_two(),
        };
        let [forward, inverse] = goldtof_fft::pair(padded);
        let [mut scratch, mut inverse_scratch] = [&forward, &inverse]
            .map(|transform| vec![Complex64::ZERO; transform.get_inplace_scratch_len()]);
        // Of one row of numbers, or two: one real, one imaginary.
        let mut spectrum = |rows: &[&[f64]]| {
            let mut values = vec![Complex64::ZERO; padded];
            for (row, unit) in rows.iter().zip([Complex64::ONE, Complex64::I]) {
                // Period by period of the code: a division for each chip takes as long as the transform.
                for numbers in row.chunks(length) {
                    values
                        .iter_mut()
                        .zip(numbers)
                        .for_each(|(value, number)| *value += unit * number);
                }
            }
            forward.process_with_scratch(&mut values, &mut scratch);
            values
        };
        // What each code is correlated with, phase by phase.
        type Table = fn(&Phase) -> &[f64];
        let Reference { signs, falls, .. } = &self.reference;
        let tables: [(_, Table); 2] =
            [(signs, |phase| &phase.hits), (falls, |phase| &phase.falling)];
        let tables = tables.into_iter().filter(|(_, table)| !table(&self.phases[0]).is_empty());
        let tables: Vec<(Vec<Complex64>, Table)> =
            tables.map(|(code, table)| (spectrum(&[&code[..length]]), table)).collect();

        let mut counts = vec![0.0; length * self.phases.len()];
        let mut product = vec![Complex64::ZERO; padded];
        for (pair, both) in self.phases.chunks(2).enumerate() {
            // The counts of two phases, one real, one imaginary.
            product.fill(Complex64::ZERO);
            for (code, table) in &tables {
                let rows = both.iter().map(|phase| &table(phase)[..self.period_chips]);
                let values = spectrum(&rows.collect::<Vec<_>>());
                let products = code.iter().zip(values).map(|(code, value)| code.conj() * value);
                product.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
            }
            inverse.process_with_scratch(&mut product, &mut inverse_scratch);
            for delay in 0..length {
                let mut value = product[delay];
                if padded > length {
                    value += product[padded - length + delay];
                }
                let counts = &mut counts[delay * self.phases.len() + 2 * pair..];
                for (count, value) in counts.iter_mut().zip([value.re, value.im]).take(both.len()) {
                    *count = value / padded as f64;
                }
            }
        }
        counts
    }

    /// Expected signed count over `chips` chips from `first` on, 0 < chips <
    /// period; `whole` is the count of a whole period.
    pub fn signed_between(&self, phase_step: u64, first: usize, chips: usize, whole: f64) -> f64 {
        if 2 * chips > self.period_chips {
            let rest = self.period_chips - chips;
            let start = (first + chips) % self.period_chips;
            return whole - self.signed_in_window(phase_step, start, rest);
        }
        self.signed_in_window(phase_step, first, chips)
    }

    fn signed_in_window(&self, phase_step: u64, first: usize, chips: usize) -> f64 {
        if chips == 0 {
            return 0.0;
        }
        let (delay, phase) = self.split(phase_step);
        let tables = &self.phases[phase];
        let period = self.period_chips as i64;
        // Slot i starts i + lead chips after the window's edge of chip 0.
        let lead = phase as f64 / self.samples_per_chip as f64 + self.rising_after_window;
        let first_slot = first as i64 - lead.floor() as i64;
        let last_slot = first_slot + chips as i64 - 1;
        let before_slot = |slot: i64| {
            let turns = slot.div_euclid(period);
            tables.before[slot.rem_euclid(period) as usize] + turns as f64 * self.hits_per_period
        };
        let sign = |slot: i64| {
            let index = (slot - delay as i64).rem_euclid(self.reference.length as i64);
            self.reference.signs[index as usize]
        };
        // The slots that the window's edges cut, and those between. Of falling
        // edges all that belong to slots that start inside are counted in full:
        // a detection between the two delays that is itself cut off by the
        // window's edge, some tens of picoseconds in all, is not told apart.
        let head = before_slot(first_slot) - self.window[first];
        let tail = self.hits_before(first + chips) - before_slot(last_slot);
        let start = first_slot.rem_euclid(period) as usize;
        let mut sum = sign(first_slot - 1) * head + sign(last_slot) * tail;
        sum += self.slots(phase, delay, start, chips - 1);
        if let Some(last) = tables.falling.get(last_slot.rem_euclid(period) as usize)
            && sign(last_slot) < 0.0
            && sign(last_slot - 1) > 0.0
        {
            sum += last;
        }
        sum
    }

    /// Sum over `count` whole slots from slot `start` (of 0..period) on, at most
    /// a period.
    fn slots(&self, phase: usize, delay: usize, start: usize, count: usize) -> f64 {
        let length = self.reference.length;
        let code_start = (start + length - delay % length) % length;
        let code = code_start..code_start + count;
        let slots = start..start + count;
        let tables = &self.phases[phase];
        if let Some(sums) = &self.even {
            let [signs, falls] = [0, 1].map(|of| sums[code.end][of] - sums[code.start][of]);
            return signs * tables.hits[0] + falls * tables.falling.first().unwrap_or(&0.0);
        }
        let mut sum = dot(&self.reference.signs[code.clone()], &tables.hits[slots.clone()]);
        if !tables.falling.is_empty() {
            sum += dot(&self.reference.falls[code], &tables.falling[slots]);
        }
        sum
    }

    fn split(&self, phase_step: u64) -> (usize, usize) {
        (
            (phase_step / self.samples_per_chip) as usize,
            (phase_step % self.samples_per_chip) as usize,
        )
    }
}

impl TableSource<'_> {
    /// Expected detections that count, registered before a time after the start of
    /// chips 0..=period.
    ///
    /// Merged ones are taken off where they would be without jitter: they come, by
    /// what merging is, before the sample instant that they would have counted at.
    fn column(&self, model: &DetectorModel, time: f64, transition: f64) -> Vec<f64> {
        let jitter =
            Jitter { sigma_chips: model.jitter_chips.unwrap_or(0.0), tail: model.tail.as_ref() };
        // Registered time to the grid's avalanche time.
        let origin = -(frame_chips(self.light) + self.delay_chips + model.delay_chips);
        let before = |jitter: Jitter, detections: &Detections| {
            let column = ChipColumn::new(self.grid, time + origin, jitter, transition);
            column.cumulative(self.grid, detections)
        };
        let mut counted = before(jitter, &self.detections.all);
        if let Some(merged) = &self.detections.merged {
            for (counted, merged) in counted.iter_mut().zip(before(Jitter::NONE, merged)) {
                *counted -= merged;
            }
        }
        counted
    }
}

/// What is seen before each sample instant, the first of chip 0 being the origin, from
/// what is registered until each instant and until a pulse is first seen there: one
/// row per sample of a chip, with a value per chip.
fn seen(until: &[Vec<f64>], unseen_until: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut before = until.to_vec();
    let mut sum = 0.0;
    for chip in 0..until[0].len() {
        for sample in 0..until.len() {
            if (chip, sample) != (0, 0) {
                sum += until[sample][chip] - unseen_until[sample][chip];
            }
            before[sample][chip] = sum;
        }
    }
    before
}

impl Reference {
    fn new(chips: &[u8], period_chips: usize) -> Reference {
        let length = chips.len();
        let sign = |&chip: &u8| 2.0 * f64::from(chip) - 1.0;
        let before = chips[length - 1..].iter().chain(chips);
        let falls = |(&chip, &before): (&u8, &u8)| f64::from(u8::from(before == 1 && chip == 0));
        let row = |of_code: Vec<f64>| of_code.repeat(1 + period_chips / length);
        Reference {
            length,
            signs: row(chips.iter().map(sign).collect()),
            falls: row(chips.iter().zip(before).map(falls).collect()),
        }
    }

    /// Sums of signs and of falls before each chip, and of all.
    fn sums(&self) -> Vec<[f64; 2]> {
        let mut sums = vec![[0.0; 2]];
        let mut sum = [0.0; 2];
        for (sign, falls) in self.signs.iter().zip(&self.falls) {
            sum = [sum[0] + sign, sum[1] + falls];
            sums.push(sum);
        }
        sums
    }
}

fn twice(values: Vec<f64>) -> Vec<f64> {
    values.repeat(2)
}

/// Scalar product, with the widest vectors that the processor has: no operation
/// differs.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the processor has the instructions, as just made sure.
            return unsafe { dot_avx512(a, b) };
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: as above.
            return unsafe { dot_avx2(a, b) };
        }
    }
    dot_in_sums(a, b)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn dot_avx512(a: &[f64], b: &[f64]) -> f64 {
    dot_in_sums(a, b)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn dot_avx2(a: &[f64], b: &[f64]) -> f64 {
    dot_in_sums(a, b)
}

/// In so many sums that none waits for the one before it.
const SUMS: usize = 32;

/// In sums that the compiler keeps side by side.
#[inline(always)]
fn dot_in_sums(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (a_blocks, b_blocks) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest = a_blocks.remainder().iter().zip(b_blocks.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    for (x, y) in a_blocks.zip(b_blocks) {
        for lane in 0..SUMS {
            sums[lane] += x[lane] * y[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}
