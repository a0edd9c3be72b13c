//! The builds of docs/resources.md, row by row.

use super::{Size, longest_carry_chain};
use crate::parts::cells::FpgaCells;
use crate::scene::{Combination, FpgaTarget};
use crate::sensor;

/// The tables that `scripts/synth` writes: the one place of these numbers.
const TABLE: &str = include_str!("../../../../docs/resources.md");
/// Cells of a row in that table.
const COLUMNS: usize = 15;

/// A sensor that was synthesized.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Build<S> {
    pub name: &'static str,
    pub size: S,
    pub cells: FpgaCells,
}

/// What a row's name says of a sensor; the rest is as in the first row.
struct Options {
    degree: u32,
    lfsrs: u32,
    interleave: u32,
    samples: u32,
    integration_chips: u64,
    counter_width: Option<u32>,
    parallel: u32,
    detectors: u32,
    window: bool,
    total_counts: bool,
    peak_detector: bool,
    input_cells: sensor::cells::Cells,
}

impl Options {
    const BASE: Options = Options {
        degree: 11,
        lfsrs: 2,
        interleave: 0,
        samples: 8,
        integration_chips: 13_100,
        counter_width: None,
        parallel: 1,
        detectors: 1,
        window: false,
        total_counts: false,
        peak_detector: false,
        input_cells: sensor::cells::Cells::ONE,
    };

    /// `None` for a row that is not this sensor alone, or says what we do not know.
    fn read(name: &str) -> Option<Options> {
        let mut options = Options::BASE;
        let name = name.strip_prefix("base: ").unwrap_or(name);
        let name = name.split(" (").next()?;
        for word in name.split(", ") {
            options.take(word)?;
        }
        Some(options)
    }

    fn take(&mut self, word: &str) -> Option<()> {
        let (key, value) = word.split_once(" = ").unwrap_or((word, ""));
        let number = || value.split(' ').next()?.parse::<u32>().ok();
        match key {
            "Gold" => {}
            "n" => self.degree = number()?,
            "S" => self.samples = number()?,
            "nu" => self.interleave = number()?,
            "parallel" => self.parallel = number()?,
            "N" => self.detectors = number()?,
            "K" => self.input_cells.count = number()?,
            "M" => self.input_cells.coincidence = number()?,
            "OR" => self.input_cells.combination = Combination::Or,
            "XOR" => self.input_cells.combination = Combination::Xor,
            "adder" => self.input_cells.combination = Combination::Adder,
            "m-sequence" => self.lfsrs = 1,
            "square wave" => self.lfsrs = 0,
            "window of 64 steps" => self.window = true,
            "peak_detector" => self.peak_detector = true,
            "total_counts" => self.total_counts = true,
            "8-bit count" | "8-bit count that saturates" => self.counter_width = Some(8),
            // Chips of 8 ns.
            "20-bit count" => self.integration_chips = 125_000,
            "32-bit count" | "integration 4 s" => self.integration_chips = 500_000_000,
            "46-bit count" | "integration 17 h" => self.integration_chips = 7_650_000_000_000,
            _ => return None,
        }
        Some(())
    }

    fn size(&self, target: FpgaTarget) -> Size {
        let pairs = self.input_cells.edges() * (self.samples / 2).max(1);
        let most_hits = self.integration_chips * u64::from(pairs);
        let exact_bits = u64::BITS - most_hits.leading_zeros() + 1;
        let generators = 2 * self.detectors;
        Size {
            lfsr_bits: generators * self.lfsrs * self.degree,
            interleaving: generators * self.interleave,
            samples_per_chip: self.samples,
            detectors: self.detectors,
            parallel: self.parallel,
            exact_bits,
            count_bits: self.counter_width.unwrap_or(exact_bits).min(exact_bits),
            segmented: exact_bits > longest_carry_chain(target),
            realigns: self.window,
            total_counts: self.total_counts,
            peak_detector: self.peak_detector,
            input_cells: self.input_cells,
        }
    }
}

/// All builds for a target.
pub(super) fn builds(target: FpgaTarget) -> Vec<Build<Size>> {
    let columns = match target {
        FpgaTarget::Ecp525k6 => (3, 4),
        FpgaTarget::Ice40Hx8k => (7, 9),
        FpgaTarget::Xc7 => (12, 14),
    };
    rows(COLUMNS)
        .filter_map(|cells| {
            let size = Options::read(cells[0])?.size(target);
            let number = |column: usize| cells[column].parse().ok();
            Some(Build {
                name: cells[0],
                size,
                cells: FpgaCells { luts: number(columns.0)?, flip_flops: number(columns.1)? },
            })
        })
        .collect()
}

/// The rows of the table with so many columns, without those of its heading.
pub(super) fn rows(columns: usize) -> impl Iterator<Item = Vec<&'static str>> {
    let lines = TABLE.lines().filter(|line| line.starts_with("| "));
    let cells = lines.map(|line| {
        let inner = line.trim().trim_start_matches('|').trim_end_matches('|');
        inner.split('|').map(str::trim).collect::<Vec<_>>()
    });
    cells.filter(move |cells| cells.len() == columns && cells[3].parse::<u64>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_the_table_is_understood() {
        let unread: Vec<&str> = rows(COLUMNS)
            .map(|cells| cells[0])
            .filter(|name| Options::read(name).is_none())
            .collect();
        // Those with a receiver tied high are another design, and those with registers.
        let others = ["receiver never", "the same", "registers"];
        let is_other = |name: &&&str| others.iter().any(|other| name.starts_with(other));
        assert_eq!(unread.iter().filter(|name| !is_other(name)).count(), 0, "{unread:?}");
        assert!(builds(FpgaTarget::Ecp525k6).len() >= 30);
    }

    #[test]
    fn a_row_has_the_widths_that_its_name_says() {
        for build in builds(FpgaTarget::Ecp525k6) {
            let bits = |text: &str| build.name.contains(text);
            for (text, width) in [("20-bit", 20), ("32-bit", 32), ("46-bit", 46)] {
                assert!(!bits(text) || build.size.exact_bits == width, "{build:?}");
            }
        }
    }
}
