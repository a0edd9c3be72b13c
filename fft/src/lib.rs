//! The Fourier transforms that goldtof needs, compiled once.
//!
//! rustfft's planner is generic, so every package that calls it compiles all its
//! butterflies anew: a third of what the compiler had to do for goldtof. Here they
//! are compiled, and goldtof only calls them.
//!
//! Transforms are not normalised: a forward and an inverse one of length n multiply
//! by n. Element 0 is frequency 0.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

pub use rustfft::{Fft, FftNum, num_complex};
use rustfft::{FftPlanner, FftPlannerScalar};

/// Points of all plans that are kept, at most, unless one alone has more: some 20 MB.
const MOST_POINTS: usize = 1 << 18;

/// A forward transform, and an inverse one times the length.
pub type Pair<T> = [Arc<dyn Fft<T>>; 2];

/// Plans by their lengths: to make one takes many times as long as a transform.
#[derive(Default)]
struct Plans {
    pairs: HashMap<usize, Pair<f64>>,
    points: usize,
}

static PLANS: LazyLock<Mutex<Plans>> = LazyLock::new(Mutex::default);

/// Transforms of `length` points in double precision, planned once as long as few lengths are asked for.
pub fn pair(length: usize) -> Pair<f64> {
    let mut plans = PLANS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pair) = plans.pairs.get(&length) {
        return pair.clone();
    }
    if plans.points + length > MOST_POINTS {
        *plans = Plans::default();
    }
    let mut planner = FftPlanner::new();
    let pair = [planner.plan_fft_forward(length), planner.plan_fft_inverse(length)];
    plans.points += length;
    plans.pairs.insert(length, pair.clone());
    pair
}

/// The same in single precision, planned anew, and in plain code: it is there to be compared with the double
/// one, and butterflies for vectors would be as much to compile as those that goldtof computes with.
pub fn single_pair(length: usize) -> Pair<f32> {
    let mut planner = FftPlannerScalar::new();
    [planner.plan_fft_forward(length), planner.plan_fft_inverse(length)]
}
