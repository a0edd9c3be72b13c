//! The scene's clock for the timing analysis of three families of tools.

use serde::Serialize;

use crate::deliver::design::{EmittedDesign, EmittedFile};

/// Clock constraints.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Constraints {
    /// Synopsys Design Constraints.
    pub sdc: EmittedFile,
    /// Lattice preference file, as nextpnr-ecp5 reads it.
    pub lpf: EmittedFile,
    /// Xilinx Design Constraints.
    pub xdc: EmittedFile,
}

/// Constraint files of a design.
pub(super) fn constraints(design: &EmittedDesign) -> Constraints {
    let chip_period_ps = design.sensor.clock().chip_period_ps;
    of_period(&design.top(), chip_period_ps, design.made_by)
}

/// Constraint files for a chip period.
fn of_period(top: &str, chip_period_ps: f64, made_by: &str) -> Constraints {
    let period_ns = chip_period_ps / 1e3;
    let mhz = 1e6 / chip_period_ps;
    let file = |extension: &str, comment: &str, command: String| EmittedFile {
        name: format!("{top}.{extension}"),
        text: format!(
            "{comment} Clock of {top}: one cycle is one chip of {period_ns} ns. Pins and the \
             timing of other ports\n{comment} are the board's.\n{comment}\n{comment} Made by  \
             {made_by}\n\n{command}\n"
        ),
    };
    let create_clock = || format!("create_clock -name i_clk -period {period_ns} [get_ports i_clk]");
    Constraints {
        sdc: file("sdc", "#", create_clock()),
        lpf: file("lpf", "#", format!("FREQUENCY PORT \"i_clk\" {mhz:.6} MHZ;")),
        xdc: file("xdc", "#", create_clock()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last_line(file: &EmittedFile) -> &str {
        file.text.lines().last().expect("a command")
    }

    #[test]
    fn a_chip_of_8_ns_is_a_clock_of_125_mhz() {
        let files = of_period("sensor_top", 8000.0, "a test");
        let clock = "create_clock -name i_clk -period 8 [get_ports i_clk]";
        assert_eq!(last_line(&files.sdc), clock);
        assert_eq!(last_line(&files.xdc), clock);
        assert_eq!(last_line(&files.lpf), "FREQUENCY PORT \"i_clk\" 125.000000 MHZ;");
    }

    #[test]
    fn a_period_in_picoseconds_keeps_its_digits() {
        let files = of_period("sensor_top", 3333.25, "a test");
        assert_eq!(
            last_line(&files.sdc),
            "create_clock -name i_clk -period 3.33325 [get_ports i_clk]"
        );
    }
}
