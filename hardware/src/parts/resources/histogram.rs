//! What hardware takes that keeps a histogram: memories as computed, cells measured or fitted to
//! the second table of docs/resources.md.

use std::ops::RangeInclusive;

use super::fit::Terms;
use super::measured::{Build, rows};
use crate::code::Generator;
use crate::parts::cells::FpgaCells;
use crate::scene::FpgaTarget;
use crate::sensor::Sensor;
use crate::sensor::histogram::HistogramPlan;

/// Columns of that table: the name, cells, and blocks of memory last.
const COLUMNS: usize = 14;

/// What decides the cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct HistogramSize {
    /// Flip-flops of all LFSRs, and interleaving depths of all generators together.
    lfsr_bits: u32,
    interleaving: u32,
    detectors: u32,
    /// Chips of the code period and bits that count them; bits that count code periods.
    rows: u64,
    row_bits: u32,
    period_bits: u32,
    samples_per_chip: u32,
    /// Adders of a detector.
    adders: u32,
    bin_bits: u32,
    saturates: bool,
    /// Memories of each detector.
    buffers: u32,
}

impl HistogramSize {
    /// Of a histogram for so many detectors, beside generators of these sizes.
    fn new(plan: &HistogramPlan, detectors: u32, lfsr_bits: u32, interleaving: u32) -> Self {
        HistogramSize {
            lfsr_bits,
            interleaving,
            detectors,
            rows: plan.rows,
            row_bits: u64::BITS - (plan.rows - 1).leading_zeros(),
            period_bits: u64::BITS - (plan.periods - 1).leading_zeros(),
            samples_per_chip: plan.row_bins,
            adders: plan.adders(),
            bin_bits: plan.bin_bits,
            saturates: plan.saturates(),
            buffers: plan.buffers,
        }
    }

    /// `None` for codes that were not measured.
    pub fn of(sensor: &Sensor, plan: &HistogramPlan) -> Option<HistogramSize> {
        let codes = &sensor.interface().source_codes;
        let firsts = (0..codes.len()).filter(|&index| !codes[..index].contains(&codes[index]));
        let (mut lfsr_bits, mut interleaving) = (0, 0);
        for code in firsts.map(|index| &codes[index]) {
            interleaving += code.interleave;
            lfsr_bits += match &code.generator {
                Generator::Gold { u, v } => u.degree + v.degree,
                Generator::MSequence(lfsr) => lfsr.degree,
                Generator::Square | Generator::Chips(_) => return None,
            };
        }
        let detectors = sensor.interface().reference_codes.len() as u32;
        Some(Self::new(plan, detectors, lfsr_bits, interleaving))
    }

    /// Whether the code period is as long as those of builds that tell about it.
    pub fn has_a_measured_length(&self, target: FpgaTarget) -> bool {
        measured_rows(target).contains(&self.rows)
    }
}

/// Chips of the code periods that were measured, and need nothing beside their blocks: in longer
/// ones of iCE40 a word is chosen among those of several blocks, shorter memories of 7-series
/// Yosys makes of LUTs.
fn measured_rows(target: FpgaTarget) -> RangeInclusive<u64> {
    match target {
        FpgaTarget::Ecp525k6 => 31..=8191,
        FpgaTarget::Ice40Hx8k => 31..=2047,
        FpgaTarget::Xc7 => 511..=8191,
    }
}

impl Terms for HistogramSize {
    fn terms(&self) -> Vec<f64> {
        let when = |condition: bool, number: u32| if condition { f64::from(number) } else { 0.0 };
        let bins = self.detectors * self.samples_per_chip;
        let sums = self.detectors * self.adders * self.bin_bits;
        let takes_turns = self.buffers == 2;
        vec![
            1.0,
            f64::from(self.lfsr_bits),
            f64::from(self.interleaving),
            f64::from(self.row_bits * self.buffers),
            f64::from(self.period_bits),
            f64::from(bins),
            f64::from(bins * self.bin_bits),
            // The choice of a row among those of several detectors.
            f64::from((self.detectors - 1) * self.samples_per_chip * self.bin_bits),
            when(takes_turns, bins * self.bin_bits),
            f64::from(sums),
            when(self.saturates, sums),
        ]
    }
}

/// What a row's name says; the rest is as in the table's first row, Table I's sensor.
fn read(name: &str) -> Option<HistogramSize> {
    let (mut degree, mut lfsrs, mut detectors) = (11, 2, 1);
    let mut size = HistogramSize {
        lfsr_bits: 0,
        interleaving: 0,
        detectors,
        rows: 0,
        row_bits: 0,
        period_bits: 0,
        samples_per_chip: 8,
        adders: 1,
        bin_bits: 0,
        saturates: false,
        buffers: 2,
    };
    for word in name.strip_prefix("histogram, ")?.split(", ") {
        let (key, value) = word.split_once(" = ").unwrap_or((word, ""));
        let number = || value.split(' ').next()?.parse::<u32>().ok();
        match key {
            "one memory" => size.buffers = 1,
            "two adders" => size.adders = 2,
            "four adders" => size.adders = 4,
            "m-sequence" => lfsrs = 1,
            "n" => degree = number()?,
            "nu" => size.interleaving = number()?,
            "N" => detectors = number()?,
            "S" => size.samples_per_chip = number()?,
            bins => {
                let (bits, of) = bins.split_once("-bit bins")?;
                size.bin_bits = bits.parse().ok()?;
                size.saturates = !of.is_empty();
                size.period_bits = match of.strip_prefix(" of ") {
                    Some(exact) => exact.parse().ok()?,
                    None => size.bin_bits,
                };
            }
        }
    }
    size.detectors = detectors;
    // Each detector has a source of its own, and they are all alike.
    size.lfsr_bits = detectors * lfsrs * degree;
    size.rows = ((1 << degree) - 1) << size.interleaving;
    size.row_bits = degree + size.interleaving;
    size.interleaving *= detectors;
    Some(size)
}

/// All builds for a target, with the blocks of memory of each.
fn measured(target: FpgaTarget) -> impl Iterator<Item = (Build<HistogramSize>, u64)> {
    let [luts, flip_flops, blocks] = match target {
        FpgaTarget::Ecp525k6 => [3, 4, 5],
        FpgaTarget::Ice40Hx8k => [6, 8, 9],
        FpgaTarget::Xc7 => [10, 12, 13],
    };
    rows(COLUMNS).filter_map(move |cells| {
        let number = |column: usize| cells[column].parse().ok();
        let build = Build {
            name: cells[0],
            size: read(cells[0])?,
            cells: FpgaCells { luts: number(luts)?, flip_flops: number(flip_flops)? },
        };
        Some((build, number(blocks)?))
    })
}

/// All builds for a target.
pub(super) fn builds(target: FpgaTarget) -> Vec<Build<HistogramSize>> {
    measured(target)
        .map(|(build, _)| build)
        .filter(|build| build.size.has_a_measured_length(target))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::fit::Fit;
    use super::super::measured::rows;
    use super::*;
    use crate::parts::resources::Basis;
    use crate::sensor::block_ram::block_ram;

    #[test]
    fn every_row_of_the_table_is_understood() {
        let unread: Vec<&str> =
            rows(COLUMNS).map(|cells| cells[0]).filter(|name| read(name).is_none()).collect();
        assert!(unread.is_empty(), "{unread:?}");
        assert!(builds(FpgaTarget::Ecp525k6).len() >= 25);
    }

    /// The blocks that Yosys takes, for which the plan has never seen Yosys.
    #[test]
    fn blocks_of_memory_are_those_of_the_synthesized_sensors() {
        for target in [FpgaTarget::Ecp525k6, FpgaTarget::Ice40Hx8k, FpgaTarget::Xc7] {
            for (Build { name, size, .. }, blocks) in measured(target) {
                if target == FpgaTarget::Xc7 && !size.has_a_measured_length(target) {
                    assert_eq!(blocks, 0, "{name}: of LUTs");
                    continue;
                }
                let of_memory = block_ram(target).blocks_of(size.rows, size.bin_bits);
                let memories = size.buffers * size.detectors * size.samples_per_chip;
                assert_eq!(u64::from(memories) * of_memory, blocks, "{target:?}: {name}");
            }
        }
    }

    #[test]
    fn the_fit_is_as_good_as_it_says() {
        for target in [FpgaTarget::Ecp525k6, FpgaTarget::Ice40Hx8k, FpgaTarget::Xc7] {
            let builds = builds(target);
            let Basis::Fitted { largest_relative_error, cross_validation_relative_error, .. } =
                Fit::of(&builds).basis(&builds)
            else {
                unreachable!()
            };
            assert!(largest_relative_error < 0.12, "{target:?}: {largest_relative_error}");
            assert!(
                cross_validation_relative_error < 0.11,
                "{target:?}: {cross_validation_relative_error}"
            );
        }
    }

    /// Sensors that were synthesized as those of the table, and are not in it: LUTs and
    /// flip-flops of ECP5, iCE40 and 7-series.
    const UNSEEN: [(&str, [[u64; 2]; 3]); 5] = [
        ("histogram, one memory, two adders, n = 9, 6-bit bins", [[99, 315], [89, 363], [62, 363]]),
        ("histogram, two adders, n = 9, 6-bit bins", [[238, 380], [239, 476], [178, 476]]),
        ("histogram, N = 2 detectors, S = 4, 12-bit bins", [[407, 572], [425, 764], [265, 764]]),
        ("histogram, N = 3 detectors, S = 4, 6-bit bins", [[373, 535], [367, 679], [261, 679]]),
        // Its code has n = 10 and nu = 1.
        ("histogram, one memory, n = 10, nu = 1, 12-bit bins", [[116, 449], [113, 545], [85, 545]]),
    ];

    #[test]
    fn the_fit_holds_for_sensors_that_are_not_in_the_table() {
        let targets = [FpgaTarget::Ecp525k6, FpgaTarget::Ice40Hx8k, FpgaTarget::Xc7];
        for (place, target) in targets.into_iter().enumerate() {
            let fit = Fit::of(&builds(target));
            for (name, found) in UNSEEN {
                let fitted = fit.cells(&read(name).unwrap());
                let error = |fitted: u64, found: u64| (fitted as f64 / found as f64 - 1.0).abs();
                let [luts, flip_flops] = found[place];
                assert!(
                    error(fitted.luts, luts) < 0.12 && error(fitted.flip_flops, flip_flops) < 0.06,
                    "{target:?}: {name}: {fitted:?}, found {luts} and {flip_flops}"
                );
            }
        }
    }
}
