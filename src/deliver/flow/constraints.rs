//! The scene's clock for the timing analysis of three families of tools.

use super::Constraints;
use crate::deliver::emission::EmittedFile;

/// Name of the design, which names its files.
const DESIGN: &str = "sensor_top";

/// Constraint files for a chip period.
pub(super) fn constraints(chip_period_ps: f64, made_by: &str) -> Constraints {
    let period_ns = chip_period_ps / 1e3;
    let mhz = 1e6 / chip_period_ps;
    let file = |extension: &str, comment: &str, command: String| EmittedFile {
        name: format!("{DESIGN}.{extension}"),
        text: format!(
            "{comment} Clock of {DESIGN}: one cycle is one chip of {period_ns} ns. Pins and the \
             timing of other ports\n{comment} are the board's.\n{comment}\n{comment} Made by  \
             {made_by}\n\n{command}\n"
        ),
    };
    let create_clock = || format!("create_clock -name i_clk -period {period_ns} [get_ports i_clk]");
    Constraints {
        sdc: file("sdc", "#", create_clock()),
        lpf: file(
            "lpf",
            "#",
            format!("FREQUENCY PORT \"i_clk\" {mhz:.6} MHZ;"),
        ),
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
        let files = constraints(8000.0, "a test");
        let clock = "create_clock -name i_clk -period 8 [get_ports i_clk]";
        assert_eq!(last_line(&files.sdc), clock);
        assert_eq!(last_line(&files.xdc), clock);
        assert_eq!(
            last_line(&files.lpf),
            "FREQUENCY PORT \"i_clk\" 125.000000 MHZ;"
        );
    }

    #[test]
    fn a_period_in_picoseconds_keeps_its_digits() {
        let files = constraints(3333.25, "a test");
        assert_eq!(
            last_line(&files.sdc),
            "create_clock -name i_clk -period 3.33325 [get_ports i_clk]"
        );
    }
}
