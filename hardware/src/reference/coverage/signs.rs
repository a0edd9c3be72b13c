//! The signs of a detector's reference.

use std::ops::Range;

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
    /// Chips among them that are 0 and followed by another 0, and the same of 1.
    pairs: [Vec<u64>; 2],
    lanes: u64,
    detector_period: u64,
}

impl Signs {
    pub(super) fn of(interface: &Interface, detector: DetectorIndex) -> Signs {
        let code = &interface.reference_codes[detector];
        let following = code.chips.iter().cycle().skip(1);
        let pairs = [0, 1].map(|of| {
            let both = code.chips.iter().zip(following.clone());
            sums(both.map(|(&chip, &next)| chip == of && next == of))
        });
        Signs {
            ones: sums(code.chips.iter().map(|&chip| chip == 1)),
            pairs,
            lanes: u64::from(interface.lanes()),
            detector_period: code.len(),
        }
    }

    /// Of chips in the code period, and behind it as often as it comes, those that are among `sums`.
    fn among(&self, sums: &[u64], chips: Range<u64>) -> u64 {
        let up_to = |chip: u64| {
            let (periods, rest) = (chip / self.detector_period, chip % self.detector_period);
            periods * sums[sums.len() - 1] + sums[rest as usize]
        };
        up_to(chips.end) - up_to(chips.start)
    }

    /// Whether some step that is the first of its group counts all hits of a word down, and up, that has one on every
    /// other sample.
    pub(super) fn fill_words(&self, interface: &Interface) -> [bool; 2] {
        let integration = interface.timing.scan.integration_chips;
        let mut filled = [false; 2];
        for sample in self.starts(interface, 0) {
            let chips = sample / self.lanes..sample / self.lanes + integration;
            let later = chips.start + 1..chips.end + 1;
            let ups = |chips: Range<u64>| self.among(&self.ones, chips);
            // A word's samples of a chip, and those of the next behind them: every other one may be of a single chip.
            let words = match sample % self.lanes {
                0 | 1 => [integration - ups(chips.clone()), ups(chips)],
                samples if samples + 1 == self.lanes => {
                    [integration - ups(later.clone()), ups(later)]
                }
                _ => self.pairs.each_ref().map(|pairs| self.among(pairs, chips.clone())),
            };
            filled = [0, 1].map(|of| filled[of] || words[of] > 0);
        }
        filled
    }

    /// Whether some step that is the `step`-th of its group counts a hit of a lane down,
    /// and up.
    pub(super) fn reached(&self, interface: &Interface, step: usize, lane: u32) -> [bool; 2] {
        let integration = interface.timing.scan.integration_chips.min(self.detector_period);
        let mut reached = [false; 2];
        for sample in self.starts(interface, step) {
            let chip = (sample + u64::from(lane)) / self.lanes;
            let ups = self.among(&self.ones, chip..chip + integration);
            reached[1] |= ups > 0;
            reached[0] |= ups < integration;
            if reached == [true; 2] {
                break;
            }
        }
        reached
    }

    /// Most hits that a step which is the `step`-th of its group may count down, and up, each pulse a sample long: at
    /// most, since an edge of the code may halve a chip.
    pub(super) fn most_hits(&self, interface: &Interface, step: usize) -> [u64; 2] {
        let chips = interface.timing.scan.integration_chips;
        let of_chip = self.lanes.div_ceil(2) * u64::from(interface.input_cells.edges());
        let ups = |sample: u64| {
            let chip = sample / self.lanes;
            self.among(&self.ones, chip..chip + chips)
        };
        self.starts(interface, step).fold([0; 2], |[down, up], sample| {
            let ups = ups(sample);
            [down.max((chips - ups + 1) * of_chip), up.max((ups + 1) * of_chip)]
        })
    }

    /// The sample of the code period with which each step begins that is the `step`-th of its group.
    fn starts(&self, interface: &Interface, step: usize) -> impl Iterator<Item = u64> + '_ {
        let (scan, parallel) = (interface.timing.scan, u64::from(interface.parallel()));
        let period = self.detector_period * self.lanes;
        let groups = interface.groups().min(MOST_STEPS_LOOKED_AT);
        let numbers = (0..groups).map(move |group| (group, group * parallel + step as u64));
        numbers.take_while(move |&(_, number)| number < scan.steps).map(move |(group, number)| {
            let start = (group % self.detector_period)
                * (scan.integration_chips % self.detector_period)
                % self.detector_period;
            start * self.lanes + period - scan.phase_step(Step(number)) % period
        })
    }
}

/// How many of the first n are true, for each n.
fn sums(of: impl Iterator<Item = bool>) -> Vec<u64> {
    let mut sum = 0;
    let sums = of.map(|is| {
        sum += u64::from(is);
        sum
    });
    std::iter::once(0).chain(sums).collect()
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
