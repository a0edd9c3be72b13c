//! How curves of precision are drawn.

use super::curve::{Curve, PowerPoint, table};
use crate::report::chart::{Axis, Mark, Panel};
use crate::report::table::Table;

/// A panel over powers.
pub fn panel(power_label: &str, y: Axis) -> Panel {
    Panel::new(Axis::log("power_pw", power_label), y)
}

/// Standard deviations over all positions, with rings where the coarse stage wavers, and
/// biases, each the mean over all positions.
pub fn panels(power_label: &str, curves: &[Curve]) -> [Panel; 2] {
    let rows = curves.iter().flat_map(|curve| curve.points.iter().map(|at| (&curve.label, at)));
    let rows: Vec<(&String, &PowerPoint)> = rows.collect();
    let drawn = Table::of(&rows)
        .column("series", |(label, _)| label.as_str())
        .column("power_pw", |(_, point)| point.power_pw)
        .interval("std_m", |(_, point)| point.std_m())
        .interval("bias_m", |(_, point)| point.bias_m())
        .column("wavers", |(_, point)| u32::from(point.wavers()))
        .table();
    let std = panel(power_label, Axis::log("std_m", "standard deviation (mm)"));
    let bias = panel(power_label, Axis::linear("bias_m", "bias (mm)"));
    [ringed(std.curves(&drawn, Mark::LineAndDots), &drawn), bias.curves(&drawn, Mark::LineAndDots)]
}

/// One curve's standard deviations position by position, with rings where the
/// coarse stage wavers, and lines at some limits.
pub fn positions_panel(power_label: &str, curve: &Curve, limits_mm: &[f64]) -> Panel {
    let drawn = table(std::slice::from_ref(curve)).named(|table, row| {
        let position = table.value(row, "position_steps").text();
        format!("{}, target + {position} T_s", row.name)
    });
    let y = Axis::log("std_m", "standard deviation (mm), by position of the target");
    let mut panel = panel(power_label, y).curves(&drawn, Mark::LineAndDots);
    for limit_mm in limits_mm {
        panel = panel.level(&format!("{limit_mm} mm"), *limit_mm);
    }
    ringed(panel, &drawn)
}

/// Adds rings where the coarse stage wavers.
fn ringed(panel: Panel, drawn: &Table) -> Panel {
    let wavers = drawn.only(|table, row| table.value(row, "wavers").number() == Some(1.0));
    panel.curves(&wavers.named(|_, _| "coarse stage wavers".to_owned()), Mark::Rings)
}
