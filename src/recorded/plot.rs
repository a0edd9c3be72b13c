//! Recorded counts over what was expected, and what is left.

use super::observed::HITS_OF_A_SUM;
use super::report::{Assessment, BinResidual};
use crate::report::chart::{Axis, Chart, ChartError, Legend, Mark, Panel, Point, Scale, Series};

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
///
/// # Errors
/// When the drawing library gives up.
pub fn residual_plot(assessment: &Assessment) -> Result<String, ChartError> {
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
    let chart = Chart {
        title: format!("{}: {title}", assessment.detector),
        panels: panels(shown, along).into(),
    };
    chart.svg()
}

/// Counts on the left, residuals on the right, along what `along` says.
fn panels(shown: &[Shown], along: &str) -> [Panel; 2] {
    let axis = |label: &str| Axis { label: label.to_owned(), scale: Scale::Linear };
    let of = |value: fn(&Shown) -> f64| {
        let points =
            shown.iter().map(|shown| Point { x: shown.x, y: value(shown), interval: None });
        points.collect::<Vec<Point>>()
    };
    let series = |label: &str, mark, colour, points| Series {
        label: label.to_owned(),
        mark,
        colour,
        points,
    };
    let counts = Panel {
        x: axis(along),
        y: axis("count"),
        series: vec![
            series("expected", Mark::Line, 0, of(|s| s.expected)),
            series("recorded", Mark::Dots, 1, of(|s| s.count)),
        ],
        legend: Legend::UpperRight,
        headroom: 0.2,
    };
    let residuals = Panel {
        x: axis(along),
        y: axis("residual (standard deviations)"),
        series: vec![series("", Mark::Dots, 1, of(|s| s.residual))],
        legend: Legend::UpperRight,
        headroom: 0.0,
    };
    [counts, residuals]
}
