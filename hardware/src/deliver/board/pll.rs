//! The dividers of a PLL: one law, with each family's ranges.

use std::ops::RangeInclusive;

use serde::Serialize;

/// What a family's PLL can do. Frequencies in megahertz.
#[derive(Debug)]
pub struct Pll {
    /// The vendor's name of the primitive.
    pub name: &'static str,
    /// Where the feedback comes from.
    pub feedback: Feedback,
    /// Dividers of the input.
    pub input_dividers: RangeInclusive<u32>,
    /// Multipliers, which are dividers of the feedback.
    pub multipliers: RangeInclusive<u32>,
    /// Dividers between VCO and output.
    pub output_dividers: &'static [u32],
    /// At the input.
    pub input_mhz: RangeInclusive<f64>,
    /// At the phase detector: input over its divider.
    pub phase_detector_mhz: RangeInclusive<f64>,
    /// Of the oscillator in the PLL.
    pub vco_mhz: RangeInclusive<f64>,
    /// At the output.
    pub output_mhz: RangeInclusive<f64>,
    /// The vendor's document that has these ranges.
    pub source: &'static str,
}

/// Where a PLL's feedback comes from. With input f, its divider r, multiplier m and output divider o:
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feedback {
    /// Output f m / r, VCO o times that.
    Output,
    /// VCO f m / r, output that over o.
    Vco,
}

/// The dividers of a PLL.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Dividers {
    /// Of the input.
    pub input_divider: u32,
    /// Of the feedback, by which the PLL multiplies.
    pub multiplier: u32,
    /// Between VCO and output.
    pub output_divider: u32,
}

/// A frequency in hertz, exactly: a numerator over a denominator, in lowest terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Frequency {
    /// Numerator, in hertz.
    pub numerator_hz: u64,
    /// Denominator.
    pub denominator: u64,
}

impl Frequency {
    /// A frequency of so many hertz over so many.
    pub fn new(numerator_hz: u64, denominator: u64) -> Frequency {
        let divisor = greatest_common_divisor(numerator_hz, denominator);
        Frequency { numerator_hz: numerator_hz / divisor, denominator: denominator / divisor }
    }

    /// The frequency over a whole number.
    pub fn over(self, divider: u32) -> Frequency {
        Frequency::new(self.numerator_hz, self.denominator * u64::from(divider))
    }

    /// In hertz.
    pub fn hz(self) -> f64 {
        self.numerator_hz as f64 / self.denominator as f64
    }

    /// In megahertz.
    pub fn mhz(self) -> f64 {
        self.hz() / 1e6
    }

    /// Its period in picoseconds.
    pub fn period_ps(self) -> f64 {
        1e12 * self.denominator as f64 / self.numerator_hz as f64
    }
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

impl Dividers {
    /// What a PLL of this law makes of an input.
    pub fn output(self, pll: &Pll, input_hz: u64) -> Frequency {
        let multiplied = input_hz * u64::from(self.multiplier);
        let over = match pll.feedback {
            Feedback::Output => self.input_divider,
            Feedback::Vco => self.input_divider * self.output_divider,
        };
        Frequency::new(multiplied, u64::from(over))
    }

    /// The frequency of the oscillator in the PLL.
    pub fn vco(self, pll: &Pll, input_hz: u64) -> Frequency {
        let times = match pll.feedback {
            Feedback::Output => self.multiplier * self.output_divider,
            Feedback::Vco => self.multiplier,
        };
        Frequency::new(input_hz * u64::from(times), u64::from(self.input_divider))
    }
}

impl Pll {
    /// All dividers within the ranges for an input of so many hertz.
    fn possible(&self, input_hz: u64) -> impl Iterator<Item = Dividers> + '_ {
        let input_mhz = input_hz as f64 / 1e6;
        let of_input = self.input_dividers.clone().filter(move |&divider| {
            self.input_mhz.contains(&input_mhz)
                && self.phase_detector_mhz.contains(&(input_mhz / f64::from(divider)))
        });
        let with_multiplier = of_input.flat_map(|input_divider| {
            self.multipliers.clone().map(move |multiplier| (input_divider, multiplier))
        });
        let all = with_multiplier.flat_map(|(input_divider, multiplier)| {
            self.output_dividers.iter().map(move |&output_divider| Dividers {
                input_divider,
                multiplier,
                output_divider,
            })
        });
        all.filter(move |dividers| {
            self.vco_mhz.contains(&dividers.vco(self, input_hz).mhz())
                && self.output_mhz.contains(&dividers.output(self, input_hz).mhz())
        })
    }

    /// The dividers whose output is nearest to so many hertz: of equal ones those with the fastest
    /// phase detector, and of these those whose VCO is nearest to the middle of its range. `None` if
    /// the ranges leave none.
    pub fn nearest(&self, input_hz: u64, output_hz: f64) -> Option<Dividers> {
        let middle_mhz = (self.vco_mhz.start() + self.vco_mhz.end()) / 2.0;
        let rank = |dividers: &Dividers| {
            (
                (dividers.output(self, input_hz).hz() - output_hz).abs(),
                dividers.input_divider,
                (dividers.vco(self, input_hz).mhz() - middle_mhz).abs(),
            )
        };
        self.possible(input_hz).min_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::{ECP5, GW1NR_9, GW2AR_18, ICE40, XC7};
    use super::*;

    /// Output in megahertz, and VCO.
    fn achieved(pll: &Pll, input_mhz: u64, output_mhz: f64) -> (f64, f64) {
        let input_hz = input_mhz * 1_000_000;
        let dividers = pll.nearest(input_hz, output_mhz * 1e6).expect("there are some");
        (dividers.output(pll, input_hz).mhz(), dividers.vco(pll, input_hz).mhz())
    }

    #[test]
    fn outputs_are_those_of_the_vendors_tools() {
        // As icepll of Project IceStorm 2025 says: -i 12 -o 125, 48, 60, 33.
        for (asked, expected, vco) in
            [(125.0, 124.5, 996.0), (48.0, 48.0, 768.0), (60.0, 60.0, 960.0), (33.0, 33.0, 1056.0)]
        {
            assert_eq!(achieved(&ICE40.pll, 12, asked), (expected, vco), "{asked} MHz");
        }
        // As ecppll of Project Trellis: -i 25 -o 250, -i 12 -o 250 (its nearest is 252).
        assert_eq!(achieved(&ECP5.pll, 25, 250.0).0, 250.0);
        assert_eq!(achieved(&ECP5.pll, 12, 250.0).0, 252.0);
        // As gowin_pll of Apycula 0.32: -i 27 -o 500 -d "GW1NR-9 C6/I5", "GW2AR-18 C8/I7".
        assert_eq!(achieved(&GW1NR_9.pll, 27, 500.0), (499.5, 999.0));
        assert_eq!(achieved(&GW2AR_18.pll, 27, 500.0), (499.5, 999.0));
        // 100 MHz x 10 / 2, and the tie with x 5 / 1 goes to the middle of 600 to 1200 MHz.
        assert_eq!(achieved(&XC7.pll, 100, 500.0), (500.0, 1000.0));
    }

    #[test]
    fn an_achieved_period_is_exact() {
        let dividers = GW2AR_18.pll.nearest(27_000_000, 500e6).expect("there are some");
        assert_eq!(dividers, Dividers { input_divider: 2, multiplier: 37, output_divider: 2 });
        let bit_clock = dividers.output(&GW2AR_18.pll, 27_000_000);
        assert_eq!(bit_clock, Frequency { numerator_hz: 499_500_000, denominator: 1 });
        let chip_clock = bit_clock.over(4);
        assert_eq!(chip_clock, Frequency { numerator_hz: 124_875_000, denominator: 1 });
        // 8 ns x 500 / 499.5.
        assert!((chip_clock.period_ps() - 8_008.008_008_008_008).abs() < 1e-9);
    }

    #[test]
    fn an_input_beyond_the_range_has_no_dividers() {
        assert_eq!(ICE40.pll.nearest(5_000_000, 48e6), None);
    }
}
