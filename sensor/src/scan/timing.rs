//! What follows from a sensor's clock and its scan: the one place where chips
//! become picoseconds, and where it is said how scans follow one another.

use super::{Chip, Group, Grouping, Sampling, Step};

/// Code periods of preparation where a host sets the scan's first step: in the first the reference is
/// held until the transmitter is ahead by its delay, in the second its last chips come to where they
/// are needed.
pub const PERIODS_OF_PREPARATION: u64 = 2;

/// Chips from a scan's last to the first of a code period at which the next one's preparation may begin:
/// the transmit generators run three chips ahead of the lasers, and the scan has ended before that.
pub const CHIPS_TO_PREPARATION: u64 = 4;

/// Chip period, and the samples that a chip is divided into.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Chip period T_c; one clock cycle of the hardware.
    pub chip_period_ps: f64,
    /// Samples per chip, S = 2^zeta: 1, 2, 4, ...
    pub samples_per_chip: u32,
}

impl Clock {
    /// Chips per second, which is the clock of the hardware.
    pub fn frequency_hz(&self) -> f64 {
        1e12 / self.chip_period_ps
    }

    /// Sample period T_s = T_c / S; also by how much the reference's delay differs
    /// between two neighbouring phase steps.
    pub fn sample_period_ps(&self) -> f64 {
        self.chip_period_ps / f64::from(self.samples_per_chip)
    }

    /// Sample period in chips, 1 / S.
    pub fn sample_period_chips(&self) -> f64 {
        1.0 / f64::from(self.samples_per_chip)
    }

    /// A duration in chips.
    pub fn chips(&self, duration_ps: f64) -> f64 {
        duration_ps / self.chip_period_ps
    }

    /// A duration in picoseconds.
    pub fn ps(&self, duration_chips: f64) -> f64 {
        duration_chips * self.chip_period_ps
    }

    /// A rate per chip.
    pub fn per_chip(&self, rate_hz: f64) -> f64 {
        rate_hz * self.chip_period_ps * 1e-12
    }

    /// A rate per second.
    pub fn hz(&self, rate_per_chip: f64) -> f64 {
        rate_per_chip / (self.chip_period_ps * 1e-12)
    }
}

/// The phase steps of one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scan {
    /// First phase step k, 0..K.
    pub first_step: u64,
    /// Number of phase steps, 1..=K; they wrap round K.
    pub steps: u64,
    /// Phase steps per code period, K = S L'.
    pub steps_per_period: u64,
    /// Integration time per phase step, D, in whole chips (at least 1).
    pub integration_chips: u64,
    /// The integration time that was asked for.
    pub requested_integration_ps: f64,
}

impl Scan {
    /// Phase step k that the reference is delayed by in a step of the scan, 0..K.
    pub fn phase_step(&self, step: Step) -> u64 {
        (self.first_step + step.0) % self.steps_per_period
    }

    /// Whether the scan covers the whole code period.
    pub fn is_full(&self) -> bool {
        self.steps == self.steps_per_period
    }

    /// The scan of a histogram, or of one that is added up, which integrates over whole periods of a code of
    /// `code_chips` chips: the nearest number of them, at least one.
    #[must_use]
    pub fn in_whole_periods(self, code_chips: u64) -> Scan {
        let periods = (self.integration_chips + code_chips / 2) / code_chips;
        Scan { integration_chips: periods.max(1) * code_chips, ..self }
    }

    /// Phase steps between two steps of the scan, the shorter way round the period.
    pub fn steps_apart(&self, a: Step, b: Step) -> u64 {
        let apart = self.phase_step(a).abs_diff(self.phase_step(b));
        apart.min(self.steps_per_period - apart)
    }
}

/// When a sensor does what: its clock, its scan, and how many steps share their
/// light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Chips and samples.
    pub clock: Clock,
    /// Phase steps and integration time.
    pub scan: Scan,
    /// Phase steps correlated at once.
    pub parallel: u32,
    /// Chips from the code period's first, at which the hardware begins to prepare a scan, to the
    /// scan's first: whole code periods, and none where scans always begin alike.
    pub preparation_chips: u64,
}

impl Timing {
    /// How the scan's steps share their light.
    pub fn grouping(&self) -> Grouping {
        Grouping { steps: self.scan.steps, parallel: u64::from(self.parallel) }
    }

    /// How clocks and samples number one another.
    pub fn sampling(&self) -> Sampling {
        Sampling::new(self.clock.samples_per_chip)
    }

    /// Groups of a scan.
    pub fn groups(&self) -> u64 {
        self.grouping().groups()
    }

    /// Chips of the references' code, L'.
    pub fn code_chips(&self) -> u64 {
        self.scan.steps_per_period / u64::from(self.clock.samples_per_chip)
    }

    /// Period of the references' code.
    pub fn code_period_ps(&self) -> f64 {
        self.clock.ps(self.code_chips() as f64)
    }

    /// Integration time of a phase step, in whole chips.
    pub fn integration_ps(&self) -> f64 {
        self.clock.ps(self.scan.integration_chips as f64)
    }

    /// By how much the reference is delayed in a step of the scan.
    pub fn reference_delay_ps(&self, step: Step) -> f64 {
        self.scan.phase_step(step) as f64 * self.clock.sample_period_ps()
    }

    /// Time from the start of a scan to the middle of a step, or of the group of
    /// steps that it belongs to.
    pub fn middle_of_step_ps(&self, step: Step) -> f64 {
        let group = self.grouping().group_of(step);
        (group.0 as f64 + 0.5) * self.integration_ps()
    }

    /// Chips of a scan.
    pub fn scan_chips(&self) -> u128 {
        self.start_of_group(Group(self.groups())).0
    }

    /// Duration of a scan.
    pub fn scan_duration_ps(&self) -> f64 {
        self.groups() as f64 * self.integration_ps()
    }

    /// Whether scans follow one another without a gap. Only those over the whole
    /// code period, in whole groups, end where the reference began; after any
    /// other the hardware waits for the reference's next first chip.
    pub fn is_gapless(&self) -> bool {
        self.scan.is_full() && self.grouping().is_even()
    }

    /// First chip of the scan that follows one which ends before chip `end`.
    pub fn next_scan_after(&self, end: Chip) -> Chip {
        if self.is_gapless() {
            end
        } else {
            let pause = match self.preparation_chips {
                0 => 0,
                _ => u128::from(CHIPS_TO_PREPARATION),
            };
            let next = (end.0 + pause).next_multiple_of(u128::from(self.code_chips()));
            Chip(next + u128::from(self.preparation_chips))
        }
    }

    /// Chips from the start of one scan to the start of the next.
    pub fn scan_pitch_chips(&self) -> u128 {
        self.next_scan_after(Chip(self.scan_chips())).0
    }

    /// The same from step 0 with as many groups as fit into the bits of the number that the whole code
    /// period has: what has room for this has room for any scan.
    pub fn of_any_scan(&self) -> Timing {
        let parallel = u64::from(self.parallel);
        let whole = self.scan.steps_per_period.div_ceil(parallel);
        let steps = ((whole + 1).next_power_of_two() - 1) * parallel;
        let scan = Scan { first_step: 0, steps, steps_per_period: steps, ..self.scan };
        Timing { scan, ..*self }
    }

    /// First chip of a group of the first scan.
    pub fn start_of_group(&self, group: Group) -> Chip {
        Chip(u128::from(group.0) * u128::from(self.scan.integration_chips))
    }

    /// First chip of a group of scan number `repetition`.
    pub fn first_chip(&self, repetition: u64, group: Group) -> Chip {
        self.start_of_group(group) + u128::from(repetition) * self.scan_pitch_chips()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A code of 7 chips, 4 samples each; steps of 10 chips.
    fn timing(steps: u64, parallel: u32) -> Timing {
        Timing {
            clock: Clock { chip_period_ps: 8000.0, samples_per_chip: 4 },
            scan: Scan {
                first_step: 3,
                steps,
                steps_per_period: 28,
                integration_chips: 10,
                requested_integration_ps: 80e3,
            },
            parallel,
            preparation_chips: 0,
        }
    }

    #[test]
    fn durations_follow_from_the_chip_period() {
        let timing = timing(28, 2);
        assert_eq!(timing.clock.sample_period_ps(), 2000.0);
        assert_eq!(timing.code_period_ps(), 56_000.0);
        assert_eq!(timing.integration_ps(), 80_000.0);
        assert_eq!(timing.scan_duration_ps(), 14.0 * 80_000.0);
        // Steps 4 and 5 are the third group.
        assert_eq!(timing.middle_of_step_ps(Step(5)), 2.5 * 80_000.0);
        // Step 26 wraps to phase step 1.
        assert_eq!(timing.reference_delay_ps(Step(26)), 2000.0);
        assert_eq!(timing.clock.per_chip(1e6), 0.008);
        assert_eq!(timing.clock.hz(0.008), 1e6);
        // Phase steps 27 and 1, over the end of the period.
        assert_eq!(timing.scan.steps_apart(Step(24), Step(26)), 2);
    }

    #[test]
    fn a_scan_that_does_not_end_where_it_began_waits_for_the_code() {
        // 28 steps of 10 chips are 40 codes; in groups of three they are 100 chips.
        for (steps, parallel, gapless, pitch) in
            [(28, 1, true, 280), (28, 3, false, 105), (14, 1, false, 140), (5, 1, false, 56)]
        {
            let timing = timing(steps, parallel);
            assert_eq!(timing.is_gapless(), gapless, "{steps} {parallel}");
            assert_eq!(timing.scan_pitch_chips(), pitch, "{steps} {parallel}");
            assert_eq!(timing.first_chip(2, Group(3)), Chip(2 * pitch + 30));
            let prepared = Timing { preparation_chips: 14, ..timing };
            // A scan of 140 chips ends with a code, and 4 chips on another has begun.
            let pause = match pitch {
                280 => 0,
                140 => 14 + 7,
                _ => 14,
            };
            assert_eq!(prepared.scan_pitch_chips(), pitch + pause, "{steps} {parallel}");
        }
    }
}
