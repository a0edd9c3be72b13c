//! Assumptions behind expectations, and how far a scene is from them.

use std::fmt;

/// An approximation, and its size in a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approximation {
    /// The assumption.
    pub name: &'static str,
    /// What its size is.
    pub measure: &'static str,
    /// Its size here.
    pub size: f64,
    /// The size up to which expectations are given.
    pub bound: f64,
    /// Whether the share of missed peaks depends on it, too.
    pub concerns_misses: bool,
}

impl fmt::Display for Approximation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Approximation { name, measure, size, bound, .. } = self;
        write!(
            f,
            "expectations assume {name}, which does not hold here: {measure} {size:.3}, limit {bound}"
        )
    }
}

impl std::error::Error for Approximation {}

impl Approximation {
    /// Whether the share of missed peaks is known all the same.
    pub fn keeps_the_share_of_misses(&self) -> bool {
        !self.concerns_misses
    }

    /// # Errors
    /// Itself, where its size is beyond its bound.
    pub fn check(self) -> Result<(), Approximation> {
        // No number is within no bound.
        if self.size <= self.bound { Ok(()) } else { Err(self) }
    }
}
