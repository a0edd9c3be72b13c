//! The fastest target over the gain, measured beside what theory says.

use super::{Fastest, Tracking};
use crate::report::chart::{Chart, ChartAxis, ChartPoint, DrawingRole, Mark, Panel};
use crate::simulate::effort::TooMuch;

/// Gains that are drawn, by their halvings.
const HALVINGS: std::ops::RangeInclusive<u32> = 0..=4;

impl Tracking<'_> {
    /// The fastest target at gains from 1 down, as a drawing (SVG).
    ///
    /// # Errors
    /// When it would take too long.
    pub fn speeds_svg(&self) -> Result<String, TooMuch> {
        let speeds: Vec<Fastest> =
            HALVINGS.map(|halvings| self.fastest(halvings)).collect::<Result<_, _>>()?;
        let expected = speeds.iter().map(|one| (one.gain, one.expected_m_per_s));
        let held = speeds.iter().map(|one| {
            let [low, high] = one.held_m_per_s;
            ChartPoint { x: one.gain, y: low, interval: Some((low, high)) }
        });
        let panel = Panel::new(
            ChartAxis::log("gain", "gain"),
            ChartAxis::log("speed_m_per_s", "fastest target that is held (m/s)"),
        )
        .with("expected", DrawingRole::Expected, Mark::Line, expected)
        .with_points(
            "held, up to the next speed that was tried",
            DrawingRole::Counts,
            Mark::Dots,
            held.collect(),
        );
        let title = format!("Fastest target of {}", self.sensor.scene().name);
        Ok(Chart { title, panels: vec![panel] }.svg())
    }
}
