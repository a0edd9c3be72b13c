//! The signs of a detector's reference.

use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;

/// Most phase steps that are looked at for a sign: a code that has none in these has
/// hardly one at all.
const MOST_STEPS_LOOKED_AT: u64 = 1 << 16;

/// The signs of a detector's reference.
pub(super) struct Signs {
    /// Ones among the first n chips.
    ones: Vec<u64>,
    lanes: u64,
    detector_period: u64,
}

impl Signs {
    pub(super) fn of(interface: &Interface, detector: DetectorIndex) -> Signs {
        let code = &interface.reference_codes[detector];
        let mut sum = 0;
        let ones = std::iter::once(0).chain(code.chips.iter().map(|&chip| {
            sum += u64::from(chip);
            sum
        }));
        Signs {
            ones: ones.collect(),
            lanes: u64::from(interface.lanes()),
            detector_period: code.len(),
        }
    }

    pub(super) fn are_both(&self) -> bool {
        let ones = self.ones[self.ones.len() - 1];
        ones > 0 && ones < self.detector_period
    }

    fn up_to(&self, chip: u64) -> u64 {
        let (periods, rest) = (chip / self.detector_period, chip % self.detector_period);
        periods * self.ones[self.ones.len() - 1] + self.ones[rest as usize]
    }

    /// Whether some step that is the `step`-th of its group counts a hit of a lane down,
    /// and up.
    pub(super) fn reached(&self, interface: &Interface, step: usize, lane: u32) -> [bool; 2] {
        let (scan, parallel) = (&interface.timing.scan, u64::from(interface.parallel()));
        let period = self.detector_period * self.lanes;
        let integration = scan.integration_chips.min(self.detector_period);
        let mut reached = [false; 2];
        let groups = interface.groups().min(MOST_STEPS_LOOKED_AT);
        for group in 0..groups {
            let number = group * parallel + step as u64;
            if number >= scan.steps {
                break;
            }
            let start = (group % self.detector_period)
                * (scan.integration_chips % self.detector_period)
                % self.detector_period;
            let sample = start * self.lanes + u64::from(lane) + period
                - scan.phase_step(Step(number)) % period;
            let chip = sample / self.lanes;
            let ups = self.up_to(chip + integration) - self.up_to(chip);
            reached[1] |= ups > 0;
            reached[0] |= ups < integration;
            if reached == [true; 2] {
                break;
            }
        }
        reached
    }
}

/// Whether any phase step of a scan counts a detector's hits down, and up: with few chips per
/// step it may not.
pub fn signs_reached(interface: &Interface, detector: DetectorIndex) -> [bool; 2] {
    let signs = Signs::of(interface, detector);
    let places =
        super::steps(interface).flat_map(|step| (0..interface.lanes()).map(move |l| (step, l)));
    places
        .map(|(step, lane)| signs.reached(interface, step, lane))
        .fold([false; 2], |all, of| [all[0] | of[0], all[1] | of[1]])
}
