//! Recorded counts over what was expected, and what is left.

use super::chart::{Axis, Chart, Mark, Panel};
use super::table::Table;
use crate::recorded::{Assessment, BinResidual, HITS_OF_A_SUM};

/// Most points of a series: of longer scans the steps round the largest count.
const MOST_POINTS: usize = 400;

/// What a point of both panels says.
struct Shown {
    x: f64,
    count: f64,
    expected: f64,
    residual: f64,
}

/// Neighbouring bins together, at the middle of them: where hardly any bin counts at all, a
/// single hit would be many standard deviations.
fn sums_of_bins(bins: &[BinResidual]) -> Vec<Shown> {
    let mut sums = Vec::new();
    let (mut count, mut expected, mut beyond, mut first) = (0.0, 0.0, 0.0, 0);
    for (last, bin) in bins.iter().enumerate() {
        count += bin.count as f64;
        expected += bin.expected_count;
        beyond += bin.residual_in_std * bin.expected_count.max(0.0).sqrt();
        if expected >= HITS_OF_A_SUM {
            sums.push(Shown {
                x: 0.5 * (first + last) as f64,
                count,
                expected,
                residual: beyond / expected.sqrt(),
            });
            (count, expected, beyond, first) = (0.0, 0.0, 0.0, last + 1);
        }
    }
    sums
}

/// Counts and expected counts on the left, residuals in standard deviations on the
/// right; of a long scan the steps round the largest count. Of a histogram each point is the
/// sum of so many bins that five hits are expected, and of many those round the one that is
/// farthest from what is expected.
pub fn residual_plot(assessment: &Assessment) -> String {
    let of_steps = assessment.phase_steps.iter().map(|step| Shown {
        x: step.distance_m,
        count: step.count as f64,
        expected: step.expected_count,
        residual: step.residual_in_std,
    });
    let all: Vec<Shown> = of_steps.chain(sums_of_bins(&assessment.bins)).collect();
    let is_histogram = !assessment.bins.is_empty();
    let height = |shown: &Shown| match is_histogram {
        true => shown.residual.abs(),
        false => shown.count,
    };
    let middle = (0..all.len()).max_by(|&a, &b| height(&all[a]).total_cmp(&height(&all[b])));
    let first = middle.unwrap_or(0).saturating_sub(MOST_POINTS / 2);
    let first = first.min(all.len().saturating_sub(MOST_POINTS));
    let shown = &all[first..(first + MOST_POINTS).min(all.len())];
    let (along, title) = match is_histogram {
        true => {
            ("bin (sample of the code period; sums of neighbours)", "recorded bins and residuals")
        }
        false => ("distance of the phase step (m)", "recorded counts and residuals"),
    };
    let table = Table::of(shown)
        .column("recorded", |_| "recorded")
        .column("x", |shown| shown.x)
        .column("count", |shown| shown.count)
        .column("expected", |shown| shown.expected)
        .column("residual", |shown| shown.residual)
        .table();
    let panel = |column: &str, label: &str| {
        Panel::new(Axis::linear("x", along), Axis::linear(column, label))
    };
    let expected = table.named(|_, _| "expected".to_owned());
    let chart = Chart {
        title: format!("{}: {title}", assessment.detector),
        panels: vec![
            panel("count", "count")
                .curves_of(&expected, "expected", Mark::Line)
                .curves(&table, Mark::Dots),
            panel("residual", "residual (standard deviations)").curves(&table, Mark::Dots),
        ],
    };
    chart.svg()
}
