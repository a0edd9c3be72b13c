//! Where the delays of paths that move go straight on.

use super::arithmetic::{LANES, LaneWords};
use super::excess::LaneExcessLight;
use super::places::{CHIP_BITS, LONGEST_CHIPS, LaneTimes, ticks};

/// Half of what a lane's clock counts.
const LONGEST_PIECE_CHIPS: f64 = (1 << 30) as f64;

/// Straight pieces of the delays of all paths that move.
#[derive(Debug, Clone)]
pub struct Pieces {
    /// When the present one ends.
    ends: [i64; LANES],
    /// The time, before or after that.
    pub clock: LaneTimes,
}

impl Pieces {
    pub fn new() -> Pieces {
        Pieces { ends: [0; LANES], clock: LaneTimes::new() }
    }

    /// No wait is longer than the piece.
    #[inline(always)]
    pub fn cut(&self, cuts: &mut LaneWords) {
        for lane in 0..LANES {
            let chips = 0_u32.wrapping_sub(self.clock.chips[lane]).min(LONGEST_CHIPS);
            let left = (chips << CHIP_BITS).wrapping_sub(self.clock.fractions[lane]);
            cuts[lane] = cuts[lane].min(left);
        }
    }

    /// The lane's next piece begins at a time, in ticks.
    pub fn begin(&mut self, lane: usize, now: i64, paths: &mut [LaneExcessLight]) {
        let lengths = paths.iter_mut().filter_map(|path| {
            let (place, length_chips) = path.movement.as_mut()?.begin(lane, now)?;
            path.places.set(lane, place);
            Some(length_chips)
        });
        let chips = lengths.fold(LONGEST_PIECE_CHIPS, f64::min);
        // To the next whole tick, or it would never end.
        let length = ticks(chips).ceil().max(1.0) as i64;
        self.ends[lane] = now + length;
        self.clock.set(lane, -length);
    }

    /// Begins the next piece in each lane whose last one has ended.
    #[cold]
    #[inline(never)]
    pub fn go_on(&mut self, paths: &mut [LaneExcessLight]) {
        for lane in 0..LANES {
            if self.clock.is_at_border(lane) {
                self.begin(lane, self.ends[lane] + self.clock.ticks(lane), paths);
            }
        }
    }
}
