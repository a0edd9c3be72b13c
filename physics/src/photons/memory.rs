//! How long a detector remembers: the one place for every question of that kind.
//!
//! A dead time ties a detection to the one before it, and an afterpulse to its
//! avalanche. Near saturation the detector fires like a clock, whose phase scatters
//! by 1 / rate at each detection: it forgets when it started only after the square
//! of (rate x dead time) dead times.

use super::afterpulsing::Afterpulsing;

/// No start is followed for longer than so many dead times.
const MOST_DEAD_TIMES: f64 = 1e5;
/// Time constants of afterpulsing after which nothing is left of it: e^-30.
const RELEASES_TO_FORGET: f64 = 30.0;

/// How precisely a start is to be forgotten: dead times, and more of them per
/// square of (rate x dead time).
struct Forgetting {
    dead_times: f64,
    per_saturation_squared: f64,
}

/// For random counts.
const SIMULATED: Forgetting = Forgetting { dead_times: 32.0, per_saturation_squared: 2.0 };
/// For a solution, which is as precise as its numbers.
const SOLVED: Forgetting = Forgetting { dead_times: 48.0, per_saturation_squared: 3.0 };

/// What a detector's memory follows from, under light of some brightness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectorMemory {
    dead_time_chips: f64,
    /// Primary detections in a dead time.
    saturation: f64,
    /// Time constant of afterpulsing, 0 without it.
    release_chips: f64,
}

impl DetectorMemory {
    /// Of a detector under light of at most `brightest_per_chip` primary detections.
    pub fn new(
        dead_time_chips: f64,
        afterpulsing: Option<Afterpulsing>,
        brightest_per_chip: f64,
    ) -> DetectorMemory {
        DetectorMemory {
            dead_time_chips,
            saturation: brightest_per_chip * dead_time_chips,
            release_chips: afterpulsing.map_or(0.0, |a| a.time_constant_chips),
        }
    }

    /// Primary detections in a dead time.
    pub fn saturation(&self) -> f64 {
        self.saturation
    }

    /// Whether a start is forgotten before it is given up on.
    pub fn forgets_its_start(&self) -> bool {
        self.dead_times(&SIMULATED) <= MOST_DEAD_TIMES
    }

    /// Chips after which a simulation has forgotten how it started, as far as it
    /// ever does.
    pub fn simulated_start_chips(&self) -> f64 {
        self.start_chips(&SIMULATED)
    }

    /// The same for an exact solution.
    pub fn solved_start_chips(&self) -> f64 {
        self.start_chips(&SOLVED)
    }

    /// Chips over which pairs of detections know of each other.
    pub fn of_pairs_chips(&self) -> usize {
        let chips = (3.0 + 3.0 * self.saturation) * self.dead_time_chips + 3.0 * self.release_chips;
        chips.ceil() as usize + 2
    }

    /// Chips over which pairs of detections know of each other so little that no variance
    /// shows it: the phase of a detector that fires like a clock is forgotten as
    /// exp(-2 pi^2 n / (1 + saturation)^2) after n dead times.
    pub fn of_ends_chips(&self) -> usize {
        let dead_times = 4.0 + 0.5 * self.saturation * self.saturation;
        (dead_times * self.dead_time_chips + 8.0 * self.release_chips).ceil() as usize + 2
    }

    /// The scale on which counts are correlated, which a phase step must be long
    /// beside for its variance to grow with its length.
    pub fn scale_chips(&self) -> f64 {
        (1.0 + self.saturation * self.saturation) * self.dead_time_chips + self.release_chips
    }

    fn start_chips(&self, forgetting: &Forgetting) -> f64 {
        let dead_times = self.dead_times(forgetting).min(MOST_DEAD_TIMES);
        (dead_times * self.dead_time_chips).max(RELEASES_TO_FORGET * self.release_chips)
    }

    fn dead_times(&self, forgetting: &Forgetting) -> f64 {
        forgetting.dead_times
            + forgetting.per_saturation_squared * self.saturation * self.saturation
    }
}
