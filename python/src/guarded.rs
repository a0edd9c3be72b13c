//! State that Python's threads share: one works with it, the others wait.

use std::sync::{Mutex, MutexGuard};

use pyo3::Python;
use pyo3::sync::MutexExt as _;

/// What a class keeps. A method that gives Python's lock away while it computes would
/// otherwise meet the next thread's call.
pub(crate) struct Guarded<T>(Mutex<T>);

impl<T> Guarded<T> {
    pub(crate) fn new(state: T) -> Guarded<T> {
        Guarded(Mutex::new(state))
    }

    /// The state, once no other thread works with it; Python goes on while this one waits.
    pub(crate) fn lock(&self, python: Python<'_>) -> MutexGuard<'_, T> {
        // What panicked half-way left what a reset makes whole.
        self.0.lock_py_attached(python).unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
