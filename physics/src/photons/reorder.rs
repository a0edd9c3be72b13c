//! Puts jittered times back in order.

use std::collections::VecDeque;

use super::time::ChipTime;

/// Registered times, each with what it is of, that later avalanches may still overtake.
#[derive(Debug, Clone, Default)]
pub struct ReorderBuffer<T = ()> {
    times: VecDeque<(ChipTime, T)>,
}

impl<T: Copy> ReorderBuffer<T> {
    /// Takes a time in; it mostly comes last.
    #[inline]
    pub fn insert(&mut self, time: ChipTime, of: T) {
        let mut place = self.times.len();
        while place > 0 && self.times[place - 1].0 > time {
            place -= 1;
        }
        self.times.insert(place, (time, of));
    }

    /// The earliest time, if nothing can come before it any more: every time
    /// inserted from now on is at or after `horizon`.
    #[inline]
    pub fn pop_before(&mut self, horizon: ChipTime) -> Option<(ChipTime, T)> {
        match self.times.front() {
            Some(&(time, _)) if time <= horizon => self.times.pop_front(),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_leave_in_order_once_they_are_safe() {
        let mut buffer = ReorderBuffer::default();
        for chip in [5, 3, 4, 9] {
            buffer.insert(ChipTime::at_chip(chip), ());
        }
        let horizon = ChipTime::at_chip(5);
        let mut left = Vec::new();
        while let Some((time, ())) = buffer.pop_before(horizon) {
            left.push(time.chip);
        }
        assert_eq!(left, [3, 4, 5]);
        assert_eq!(buffer.pop_before(ChipTime::at_chip(9)), Some((ChipTime::at_chip(9), ())));
    }
}
