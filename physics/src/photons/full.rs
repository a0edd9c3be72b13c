//! Models with every part at work, whether the scene needs it or not.
//!
//! A part with a neutral parameter does not exist in a [`DetectorModel`], and
//! costs nothing. Here it is put back with that neutral parameter: the numbers
//! that come out must be the same, bit for bit, and what the part costs can be
//! measured.

use crate::scene::PathIndex;
use std::sync::Arc;

use super::afterpulsing::Afterpulsing;
use super::detector::DetectorModel;
use super::light::{ExcessLight, LightRates};
use super::movement::PathMovement;
use super::paths::NumberedPath;
use super::random::scatter;

/// A rate at which nothing ever arrives.
const NEVER_HZ: f64 = 1e-290;

/// A part of the simulation that a scene may do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OptionalPart {
    /// Off-light, background and dark counts, which are one process.
    ConstantLight,
    /// Modulated light of one more path.
    OtherLight,
    /// Afterpulses.
    Afterpulsing,
    /// Timing jitter, or a draw of the counter's sign near its edges.
    Jitter,
    /// Delays that change in time, which only the plain loop follows.
    Movement,
}

impl OptionalPart {
    /// Every part.
    pub const ALL: [OptionalPart; 5] = [
        OptionalPart::ConstantLight,
        OptionalPart::OtherLight,
        OptionalPart::Afterpulsing,
        OptionalPart::Jitter,
        OptionalPart::Movement,
    ];
}

impl DetectorModel {
    /// The same model with `part` at work too, neutral; itself where the part is
    /// at work already. There is always room for one more path.
    pub fn with_neutral(&self, part: OptionalPart) -> DetectorModel {
        let mut model = self.clone();
        match part {
            OptionalPart::ConstantLight => {
                if model.constant_per_chip == 0.0 {
                    model.constant_per_chip = self.timing.clock.per_chip(NEVER_HZ);
                }
            }
            OptionalPart::OtherLight => {
                let dark = LightRates { on_hz: NEVER_HZ, off_hz: 0.0 };
                let others = &model.excess;
                let path = NumberedPath {
                    index: others.iter().map(|o| PathIndex(o.path.0 + 1)).max().unwrap_or_default(),
                    number: others.iter().map(|o| o.number).fold(0, scatter),
                };
                // The reference's own code leaves the common period as it is.
                let code = Arc::clone(&model.reference);
                let clock = self.timing.clock;
                let delay_ps = clock.ps(0.3);
                let light = ExcessLight::new(path, dark, &code, delay_ps, clock, others);
                model.excess.extend(light);
            }
            OptionalPart::Afterpulsing => {
                model.afterpulsing.get_or_insert(Afterpulsing {
                    mean_per_avalanche: 0.0,
                    time_constant_chips: 1.0,
                });
            }
            OptionalPart::Jitter => {
                model.jitter_chips.get_or_insert(0.0);
            }
            OptionalPart::Movement => {
                for light in &mut model.excess {
                    light.movement.get_or_insert_with(PathMovement::none);
                }
            }
        }
        model
    }

    /// The same model with every part at work.
    pub fn full(&self) -> DetectorModel {
        let parts = OptionalPart::ALL.into_iter();
        parts.fold(self.clone(), |model, part| model.with_neutral(part))
    }
}
