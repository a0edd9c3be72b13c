//! Standard deviation of the distance against optical power: Figs. 5, 6 and 8.

mod curve;
mod drawing;
pub mod gold_square;
pub mod interleaving;
mod precise;
pub mod two_sources;

use super::statistics::{Measured, mean};
use curve::Curve;

/// Mean optical power at the detector, in picowatts: 0.6 to 78 million primary
/// detections per second.
const POWERS_PW: [f64; 8] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

/// Label of the horizontal axis, of one source.
const POWER: &str = "optical power at the detector (pW)";

/// Mean over the powers of the decibels by which one curve is above another; none
/// where nothing can be compared.
fn mean_loss(above: &Curve, below: &Curve) -> Option<Measured> {
    let losses = above.decibels_above(below);
    let values: Vec<Measured> = losses.iter().map(|(_, loss)| *loss).collect();
    (!values.is_empty()).then(|| mean(&values))
}

/// Value and interval with two decimals, without unit.
fn with_interval(measured: Measured) -> String {
    format!("{:.2} ({:.2} to {:.2})", measured.value, measured.low, measured.high)
}
