//! Points in time that keep femtoseconds over hours.

/// A point in time: whole chips, and an offset inside the chip.
///
/// The two are never merged into one float, so that the resolution (2^-53 of a
/// chip) does not depend on how much time has passed.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct ChipTime {
    /// Whole chips since the origin, negative before it.
    pub chip: i64,
    /// Offset inside the chip in chips, 0 <= fraction < 1.
    pub fraction: f64,
}

/// Durations are cut to this many chips (92 days at 8 ns), which keeps every
/// sum inside `i64`.
const LONGEST_WAIT_CHIPS: f64 = 1e15;

impl ChipTime {
    /// Later than any simulation ends.
    pub const NEVER: ChipTime = ChipTime { chip: i64::MAX, fraction: 0.0 };

    /// The beginning of a chip.
    pub fn at_chip(chip: i64) -> ChipTime {
        ChipTime { chip, fraction: 0.0 }
    }

    /// The time `duration_chips` later; the duration is not negative.
    #[inline]
    pub fn after(self, duration_chips: f64) -> ChipTime {
        let offset = self.fraction + duration_chips.min(LONGEST_WAIT_CHIPS);
        // A cast truncates, which is the floor here, and costs no library call.
        let whole = offset as i64;
        ChipTime { chip: self.chip.saturating_add(whole), fraction: offset - whole as f64 }
    }

    /// The time shifted by a duration of either sign.
    #[inline]
    pub fn shifted(self, duration_chips: f64) -> ChipTime {
        if duration_chips >= 0.0 {
            return self.after(duration_chips);
        }
        let offset = self.fraction + duration_chips.max(-LONGEST_WAIT_CHIPS);
        // The floor, by a cast again.
        let towards_zero = offset as i64;
        let whole = towards_zero - i64::from(towards_zero as f64 > offset);
        let fraction = offset - whole as f64;
        let chip = self.chip.saturating_add(whole);
        // A tiny negative offset rounds up to a whole chip.
        if fraction < 1.0 {
            ChipTime { chip, fraction }
        } else {
            ChipTime::at_chip(chip.saturating_add(1))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adding_carries_whole_chips() {
        let t = ChipTime { chip: -3, fraction: 0.75 };
        assert_eq!(t.after(2.5), ChipTime { chip: 0, fraction: 0.25 });
        assert_eq!(t.shifted(-1.0), ChipTime { chip: -4, fraction: 0.75 });
    }

    #[test]
    fn a_tiny_step_back_over_a_chip_border_keeps_the_fraction_below_one() {
        let t = ChipTime::at_chip(7).shifted(-1e-20);
        assert_eq!(t, ChipTime::at_chip(7));
    }

    #[test]
    fn resolution_does_not_depend_on_elapsed_time() {
        // A thousand hours of 8 ns chips, then steps of 1 fs.
        let start = ChipTime::at_chip(450_000_000_000_000);
        let step = 1.0 / 8_388_608.0;
        let mut t = start;
        for _ in 0..8_388_608 {
            t = t.after(step);
        }
        assert_eq!(t, ChipTime::at_chip(start.chip + 1));
    }

    #[test]
    fn endless_waits_saturate() {
        assert!(ChipTime::NEVER.after(5.0) >= ChipTime::NEVER);
        assert!(ChipTime::at_chip(0).after(f64::INFINITY).chip >= 1_000_000_000_000_000);
    }
}
