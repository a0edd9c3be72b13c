//! Counts over what is expected of them, and what is left.

use super::chart::{Chart, ChartPoint};
use super::prelude::*;
use crate::recorded::{Assessment, BinResidual, HITS_OF_A_SUM, StepResidual};

/// Most points of a series: of longer scans the steps round the largest count.
const MOST_POINTS: usize = 400;
/// Half the width of the band, in standard deviations: 19 of 20 counts are within.
const BAND_IN_STD: f64 = 2.0;

/// What a count, or a sum of neighbouring bins, says beside its expectation.
#[derive(Debug, Clone, Copy)]
struct Residual {
    x: f64,
    count: f64,
    expected: f64,
    std: f64,
    residual_in_std: f64,
}

/// Counts of a scan, or of a histogram, beside what is expected of them.
#[derive(Debug, Clone)]
pub(super) struct Residuals {
    along: String,
    counted: Vec<Residual>,
    of_bins: bool,
}

impl Residuals {
    /// Of phase steps, in order of distance: also of a window that wraps round the code period.
    pub fn of_steps(steps: &[StepResidual]) -> Residuals {
        let of_step = |step: &StepResidual| Residual {
            x: step.distance_m,
            count: step.count as f64,
            expected: step.expected_count,
            std: step.expected_count_std,
            residual_in_std: step.residual_in_std,
        };
        let mut counted: Vec<Residual> = steps.iter().map(of_step).collect();
        counted.sort_by(|a, b| a.x.total_cmp(&b.x));
        Residuals { along: "distance of the phase step (m)".to_owned(), counted, of_bins: false }
    }

    /// Of bins, neighbours together where hardly any bin counts at all: a single hit would be many
    /// standard deviations.
    pub fn of_bins(bins: &[BinResidual]) -> Residuals {
        let hits: f64 = bins.iter().map(|bin| bin.expected_count).sum();
        let together = (HITS_OF_A_SUM * bins.len() as f64 / hits.max(f64::MIN_POSITIVE)).ceil();
        let together = (together as usize).clamp(1, bins.len().max(1));
        let of_sum = |(number, sum): (usize, &[BinResidual])| {
            let total = |of: fn(&BinResidual) -> f64| sum.iter().map(of).sum::<f64>();
            let expected = total(|bin| bin.expected_count);
            let beyond = total(|bin| bin.residual_in_std * bin.expected_count.max(0.0).sqrt());
            Residual {
                x: (number * together) as f64 + 0.5 * (sum.len() - 1) as f64,
                count: total(|bin| bin.count as f64),
                expected,
                std: total(|bin| bin.expected_count_std.powi(2)).sqrt(),
                residual_in_std: beyond / expected.sqrt().max(f64::MIN_POSITIVE),
            }
        };
        Residuals {
            along: match together {
                1 => "bin (sample of the code period)".to_owned(),
                _ => format!("bin (sample of the code period), {together} together"),
            },
            counted: bins.chunks(together).enumerate().map(of_sum).collect(),
            of_bins: true,
        }
    }

    fn of(assessment: &Assessment) -> Residuals {
        match assessment.bins.as_slice() {
            [] => Residuals::of_steps(&assessment.phase_steps),
            bins => Residuals::of_bins(bins),
        }
    }

    fn within(&self, from: f64, to: f64) -> impl Iterator<Item = &Residual> {
        self.counted.iter().filter(move |one| (from..=to).contains(&one.x))
    }

    /// Counts over the expected ones with their band, from one place to another.
    pub fn counts(&self, from: f64, to: f64, whose: &str) -> Panel {
        let band = self.within(from, to).map(|one| {
            let half = BAND_IN_STD * one.std;
            let interval = Some((one.expected - half, one.expected + half));
            ChartPoint { x: one.x, y: one.expected, interval }
        });
        let expected = self.within(from, to).map(|one| (one.x, one.expected));
        let counts = self.within(from, to).map(|one| (one.x, one.count));
        Panel::new(ChartAxis::linear("", &self.along), ChartAxis::linear("", "count"))
            .with_points("", DrawingRole::Expected, Mark::Band, band.collect())
            .with("expected, \u{b1}2 std", DrawingRole::Expected, Mark::Line, expected)
            .with(whose, DrawingRole::Counts, Mark::Dots, counts)
    }

    /// Residuals, from one place to another.
    pub fn residuals(&self, from: f64, to: f64) -> Panel {
        let shown = self.within(from, to).map(|one| (one.x, one.residual_in_std));
        let axis = ChartAxis::linear("", "residual (standard deviations)");
        Panel::new(ChartAxis::linear("", &self.along), axis)
            .with("", DrawingRole::Counts, Mark::Dots, shown)
            .limits(BAND_IN_STD, "standard deviations")
    }

    /// First and last of no more than so many points: round the largest count, or, of bins, round
    /// what is farthest from expected.
    pub fn near(&self, most: usize) -> (f64, f64) {
        let height = |one: &Residual| match self.of_bins {
            true => one.residual_in_std.abs(),
            false => one.count,
        };
        let all = &self.counted;
        let middle = (0..all.len()).max_by(|&a, &b| height(&all[a]).total_cmp(&height(&all[b])));
        let first = middle.unwrap_or(0).saturating_sub(most / 2);
        let first = first.min(all.len().saturating_sub(most));
        let shown = &all[first..(first + most).min(all.len())];
        let ends = shown.first().zip(shown.last());
        ends.map_or((0.0, 0.0), |(first, last)| (first.x, last.x))
    }

    /// Sum of the squares of all residuals, and their number.
    pub fn chi_square(&self) -> (f64, usize) {
        let squares = self.counted.iter().map(|one| one.residual_in_std.powi(2));
        (squares.sum(), self.counted.len())
    }
}

/// Counts and expected counts on the left, residuals in standard deviations on the right; of a long
/// scan those round the largest count, of a histogram those round what is farthest from expected.
pub fn residual_plot(assessment: &Assessment) -> String {
    let comparison = Residuals::of(assessment);
    let (from, to) = comparison.near(MOST_POINTS);
    let title = match assessment.bins.is_empty() {
        true => "recorded counts and residuals",
        false => "recorded bins and residuals",
    };
    let chart = Chart {
        title: format!("{}: {title}", assessment.detector),
        panels: vec![comparison.counts(from, to, "recorded"), comparison.residuals(from, to)],
    };
    chart.svg()
}
