//! Numbers of chips.

use std::ops::Add;

/// Number of a chip of a running sensor, from 0 at the first scan's first: scans of
/// hours have more of them than 64 bits tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Chip(pub u128);

impl Chip {
    /// Which chip of a code it is, if the code's first is chip 0 and the code goes on
    /// again and again.
    pub fn of_code(self, code_chips: u64) -> u64 {
        (self.0 % u128::from(code_chips)) as u64
    }
}

impl Add<u128> for Chip {
    type Output = Chip;

    fn add(self, chips: u128) -> Chip {
        Chip(self.0 + chips)
    }
}
