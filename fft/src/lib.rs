//! The Fourier transforms that goldtof needs, compiled once.
//!
//! rustfft's planner is generic, so every package that calls it compiles all its
//! butterflies anew: a third of what the compiler had to do for goldtof. Here they
//! are compiled for `f64` and `f32`, and goldtof only calls them.
//!
//! Transforms are not normalised: a forward and an inverse one of length n multiply
//! by n. Element 0 is frequency 0.

use std::fmt;
use std::sync::Arc;

use rustfft::FftPlanner;
pub use rustfft::{Fft, FftNum, num_complex};

/// Plans transforms in double precision, and keeps what they share.
pub struct Planner(FftPlanner<f64>);

impl Planner {
    /// A planner that has planned nothing yet.
    pub fn new() -> Planner {
        Planner(FftPlanner::new())
    }

    /// The forward transform of `length` points.
    pub fn forward(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.0.plan_fft_forward(length)
    }

    /// The inverse transform of `length` points, times `length`.
    pub fn inverse(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.0.plan_fft_inverse(length)
    }
}

impl Default for Planner {
    fn default() -> Planner {
        Planner::new()
    }
}

impl fmt::Debug for Planner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Planner")
    }
}

/// Forward and inverse transform of `length` points in double precision.
pub fn double_pair(length: usize) -> [Arc<dyn Fft<f64>>; 2] {
    let mut planner = FftPlanner::new();
    [planner.plan_fft_forward(length), planner.plan_fft_inverse(length)]
}

/// Forward and inverse transform of `length` points in single precision.
pub fn single_pair(length: usize) -> [Arc<dyn Fft<f32>>; 2] {
    let mut planner = FftPlanner::new();
    [planner.plan_fft_forward(length), planner.plan_fft_inverse(length)]
}
