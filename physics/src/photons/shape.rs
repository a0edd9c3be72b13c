//! A laser's edges, as light of a few lasers without edges.
//!
//! Light is added up, and so are Poisson processes: an edge that rises in a straight
//! line is, but for its steps, that of several lasers of equal shares which turn on one
//! after another and off one after another. Each of these *strands* is the code, late by
//! some time. Where it turns off later than on, light of another strand is added while the
//! code was still on at the falling edge's delay, and no longer is at the rising one's;
//! where it turns off earlier, light is let through only while both are on.

use crate::code::Code;
use crate::scan::Clock;
use crate::scene::LaserResponse;

/// Lasers that stand for straight edges. What is left are steps of an eighth of the
/// edge: the light that has come at any time is off by at most 1/512 of the light of
/// an edge's length, 0.05 ps of it for an edge of 25 ps, 0.8 ps for one of 400 ps.
const EDGE_STRANDS: u32 = 8;

/// Of a straight edge so much lies between 10 and 90 %.
const SHARE_10_TO_90: f64 = 0.8;

/// How a code becomes light: strands whose shares add up to 1 while the light is on.
#[derive(Debug, Clone, PartialEq)]
pub struct PulseShape {
    /// What the light is made of.
    pub strands: Vec<Strand>,
}

/// Light of a code without edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strand {
    /// Share of the light.
    pub share: f64,
    /// How much later than the code, in chips; may be negative.
    pub delay_chips: f64,
    /// When the light is let through; `None` for always.
    pub gate: Option<LightGate>,
}

/// Light is let through while the code, late by another time, is on or off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightGate {
    /// How much later than the code.
    pub delay_chips: f64,
    /// The chip that lets light through, 0 or 1.
    pub open_at: u8,
}

impl PulseShape {
    /// On and off at once.
    pub fn ideal() -> PulseShape {
        PulseShape { strands: vec![Strand { share: 1.0, delay_chips: 0.0, gate: None }] }
    }

    /// The shape of a source's light.
    pub fn new(response: &LaserResponse, clock: Clock) -> PulseShape {
        let strands = match response {
            LaserResponse::Ideal => return PulseShape::ideal(),
            LaserResponse::Edges { rise_time_ps, fall_time_ps } => {
                with_edges(*rise_time_ps, *fall_time_ps, 0.0, clock)
            }
            LaserResponse::Stretched { rise_time_ps, fall_time_ps, longer_ps } => {
                with_edges(*rise_time_ps, *fall_time_ps, *longer_ps, clock)
            }
            LaserResponse::Measured(curve) => curve
                .points
                .iter()
                .map(|&[time_ps, share]| Strand {
                    share,
                    delay_chips: clock.chips(time_ps),
                    gate: None,
                })
                .collect(),
        };
        PulseShape { strands }
    }

    /// Chips of a code's period in which light is on, by how much of it is.
    pub fn lit_chips(&self, code: &Code) -> f64 {
        let (weight, runs) = (code.weight() as f64, code.runs() as f64);
        let lit_chips = |strand: &Strand| match strand.gate {
            None => weight,
            // What the code, late by one of the two, has over what it has late by the other too.
            Some(LightGate { delay_chips, open_at }) => {
                let apart = (strand.delay_chips - delay_chips).abs() * runs;
                if open_at == 0 { apart } else { weight - apart }
            }
        };
        self.strands.iter().map(|strand| strand.share * lit_chips(strand)).sum()
    }

    /// Whether light follows the code at once.
    pub fn is_ideal(&self) -> bool {
        *self == PulseShape::ideal()
    }
}

/// Light with straight edges that lasts longer than its chips.
fn with_edges(rise_time_ps: f64, fall_time_ps: f64, longer_ps: f64, clock: Clock) -> Vec<Strand> {
    // Light without edges is one strand.
    let strands = if rise_time_ps == 0.0 && fall_time_ps == 0.0 { 1 } else { EDGE_STRANDS };
    let strand = |number: u32| {
        let place = (f64::from(number) + 0.5) / f64::from(strands) - 0.5;
        let delay =
            |time_ps: f64, later_ps: f64| clock.chips(place * time_ps / SHARE_10_TO_90 + later_ps);
        let rise = delay(rise_time_ps, -0.5 * longer_ps);
        of_edges(1.0 / f64::from(strands), rise, delay(fall_time_ps, 0.5 * longer_ps))
    };
    (0..strands).flat_map(strand).collect()
}

/// Light that turns on and off so much later than the code.
fn of_edges(share: f64, rise_chips: f64, fall_chips: f64) -> Vec<Strand> {
    let strand = |delay_chips: f64, gate: Option<LightGate>| Strand { share, delay_chips, gate };
    let late = |delay_chips: f64, open_at: u8| Some(LightGate { delay_chips, open_at });
    if rise_chips == fall_chips {
        vec![strand(rise_chips, None)]
    } else if fall_chips > rise_chips {
        vec![strand(rise_chips, None), strand(fall_chips, late(rise_chips, 0))]
    } else {
        vec![strand(rise_chips, late(fall_chips, 1))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::Generator;

    /// The level of a shape, as its strands say.
    fn level(shape: &PulseShape, chips: &[u8], time: f64) -> f64 {
        let chip = |time: f64| chips[(time.floor() as i64).rem_euclid(chips.len() as i64) as usize];
        let lit = |strand: &&Strand| {
            chip(time - strand.delay_chips) == 1
                && strand.gate.is_none_or(|gate| chip(time - gate.delay_chips) == gate.open_at)
        };
        shape.strands.iter().filter(lit).map(|s| s.share).sum()
    }

    #[test]
    fn edges_are_straight_from_10_to_90_per_cent_and_keep_the_light() {
        let clock = Clock { chip_period_ps: 8000.0, samples_per_chip: 8 };
        let response = LaserResponse::Edges { rise_time_ps: 800.0, fall_time_ps: 2400.0 };
        let shape = PulseShape::new(&response, clock);
        let chips = [1, 1, 0, 1, 0, 0];
        // Up at 0 and 3 within 1000 ps, down at 2 and 4 within 3000 ps; half at the edge.
        for (time_ps, expected) in [
            (0.0, 0.5),
            (-400.0, 0.1),
            (400.0, 0.9),
            (16_000.0, 0.5),
            (14_800.0, 0.9),
            (17_200.0, 0.1),
            (24_400.0, 0.9),
            (33_200.0, 0.1),
            (8_000.0, 1.0),
            (20_000.0, 0.0),
        ] {
            let found = level(&shape, &chips, clock.chips(time_ps + 1.0));
            assert!((found - expected).abs() < 0.07, "{time_ps}: {found}");
        }
        let stretched = LaserResponse::Stretched {
            rise_time_ps: 800.0,
            fall_time_ps: 2400.0,
            longer_ps: -1600.0,
        };
        let shorter = PulseShape::new(&stretched, clock);
        for time_ps in [800.0, 15_200.0, 24_800.0, 31_200.0_f64] {
            let found = level(&shorter, &chips, clock.chips(time_ps + 1.0));
            assert!((found - 0.5).abs() < 0.07, "{time_ps}: {found}");
        }
        let code = |chips: &[u8]| Code {
            generator: Generator::Chips(chips.to_vec()),
            interleave: 0,
            chips: chips.to_vec(),
        };
        // Three chips of six in two runs, each shorter by a fifth of a chip.
        assert!((shape.lit_chips(&code(&chips)) - 3.0).abs() < 1e-12);
        assert!((shorter.lit_chips(&code(&chips)) - 2.6).abs() < 1e-12);
        let points = 48_000;
        let mean = (0..points)
            .map(|n| level(&shape, &chips, 6.0 * (f64::from(n) + 0.5) / f64::from(points)))
            .sum::<f64>()
            / f64::from(points);
        assert!((mean - 0.5).abs() < 1e-3, "{mean}");
    }
}
