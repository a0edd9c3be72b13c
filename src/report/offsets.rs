//! What the estimators are off by, in millimetres: beside the truth, which is one line with them on the
//! scale of the counts.

use super::coordinate::AxisScale;
use super::prelude::*;

const WIDTH: f64 = 480.0;
const LEFT: f64 = 110.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 26.0;
const ROW: f64 = 46.0;
const BOTTOM: f64 = 46.0;
const TICKS: usize = 6;
/// Half the height of what is expected.
const HALF: f64 = 9.0;

/// What one estimator says, in millimetres from the truth.
struct Offset {
    name: &'static str,
    role: DrawingRole,
    error_mm: f64,
    /// Expected mean and standard deviation.
    expected_mm: Option<(f64, f64)>,
}

impl Offset {
    fn of(estimate: &EstimateReport) -> Option<Offset> {
        let expected = estimate.expected_bias_m.zip(estimate.expected_std_m);
        Some(Offset {
            name: estimator_name(estimate.estimator),
            role: match estimate.estimator {
                EstimatorKind::Fft => DrawingRole::Phase,
                EstimatorKind::Model => DrawingRole::Fit,
            },
            error_mm: estimate.error_m? * 1e3,
            expected_mm: expected.map(|(bias_m, std_m)| (bias_m * 1e3, std_m * 1e3)),
        })
    }

    /// Two standard deviations on either side of what is expected.
    fn interval_mm(&self) -> Option<[f64; 2]> {
        let (bias_mm, std_mm) = self.expected_mm?;
        Some([bias_mm - 2.0 * std_mm, bias_mm + 2.0 * std_mm])
    }

    fn told(&self) -> String {
        let mm = |mm: f64, signed| millimetres(mm * 1e-3, signed);
        let mut told = format!("{} is off by {}", self.name, mm(self.error_mm, true));
        if let Some((bias_mm, std_mm)) = self.expected_mm {
            let (bias, std) = (mm(bias_mm, true), mm(std_mm, false));
            told += &format!("; expected are {bias} and a scatter of {std}");
        }
        told
    }
}

/// Both estimates of a detector; none where neither is known beside a truth.
pub(super) fn figure(detector: DetectorIndex, both: &BothEstimates) -> Option<SvgFigure> {
    let offsets: Vec<Offset> = both.in_order().into_iter().filter_map(Offset::of).collect();
    if offsets.is_empty() {
        return None;
    }
    let ends = offsets.iter().flat_map(|offset| {
        let interval = offset.interval_mm().unwrap_or([offset.error_mm; 2]);
        [offset.error_mm, interval[0], interval[1]]
    });
    let axis = Coordinate::of(AxisScale::Linear, 0.05, ends.chain([0.0]));
    let place = |mm: f64| LEFT + axis.share(mm) * (WIDTH - LEFT - RIGHT);
    let bottom = TOP + ROW * offsets.len() as f64;
    let told: Vec<String> = offsets.iter().map(Offset::told).collect();
    Some(SvgFigure {
        id: format!("offsets-{detector}"),
        title: format!("Estimates of {}, from the truth", both.own.detector),
        description: format!("{}.", told.join(". ")),
        size: (WIDTH, bottom + BOTTOM),
        wide: false,
        content: html! {
            @for tick in axis.ticks(TICKS) {
                line class="grid" x1=(coordinate(place(tick))) x2=(coordinate(place(tick)))
                    y1=(coordinate(TOP)) y2=(coordinate(bottom)) {}
                (label(place(tick), bottom + 16.0, "middle", &axis.shown(tick)))
            }
            line class={ "mark " (DrawingRole::Truth.class()) } x1=(coordinate(place(0.0))) x2=(coordinate(place(0.0)))
                y1=(coordinate(TOP)) y2=(coordinate(bottom)) {}
            (label(place(0.0), TOP - 8.0, "middle small", "truth"))
            @for (number, (offset, told)) in offsets.iter().zip(&told).enumerate() {
                @let y = TOP + ROW * (number as f64 + 0.5);
                @let class = offset.role.class();
                (label(LEFT - 10.0, y + 4.0, "end", offset.name))
                @if let Some([low, high]) = offset.interval_mm() {
                    rect class={ "band " (class) } x=(coordinate(place(low))) y=(coordinate(y - HALF))
                        width=(coordinate(place(high) - place(low))) height=(coordinate(2.0 * HALF)) rx="3" {
                        title { (told) }
                    }
                }
                circle class={ "dot " (class) } cx=(coordinate(place(offset.error_mm))) cy=(coordinate(y)) r="4.5" {
                    title { (told) }
                }
            }
            (label((LEFT + WIDTH - RIGHT) / 2.0, bottom + BOTTOM - 10.0, "middle strong",
                "error (mm); bands: 19 of 20 are expected within"))
        },
    })
}
