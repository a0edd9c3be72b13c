//! Work shared among threads.

use std::num::NonZero;
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Places that a thread takes at a time: few enough to share evenly, many enough
/// that lanes seldom run dry.
const SHARE: usize = 1024;

/// Fills `out` by calls of `fill(first, part)`, with `part` beginning at place
/// `first` of it, on some threads. Each takes the next part as it gets done.
pub fn share<T: Send>(threads: NonZero<usize>, out: &mut [T], fill: impl Fn(u64, &mut [T]) + Sync) {
    if threads.get() == 1 || out.is_empty() {
        fill(0, out);
        return;
    }
    let size = out.len().div_ceil(threads.get()).min(SHARE);
    let parts = Mutex::new((0_u64..).step_by(size).zip(out.chunks_mut(size)));
    let next = || {
        let mut parts = parts.lock().unwrap_or_else(PoisonError::into_inner);
        parts.next()
    };
    thread::scope(|scope| {
        for _ in 0..threads.get() {
            scope.spawn(|| {
                while let Some((first, part)) = next() {
                    fill(first, part);
                }
            });
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_filled_once_with_its_number() {
        for threads in [1, 2, 3, 8] {
            for places in [0, 1, 2, 1023, 5000] {
                let mut out = vec![0; places];
                let threads = NonZero::new(threads).expect("not zero");
                share(threads, &mut out, |first, part| {
                    for (number, place) in (first..).zip(part) {
                        *place += number + 1;
                    }
                });
                let expected: Vec<u64> = (1..=places as u64).collect();
                assert_eq!(out, expected);
            }
        }
    }
}
