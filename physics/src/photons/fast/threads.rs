//! Work shared among threads of the common pool.

use std::num::NonZero;
use std::sync::{Mutex, PoisonError};

/// Places that a thread takes at a time: few enough that all threads get done
/// together.
const SHARE: usize = 64;
/// Shares that each thread gets, at least.
const SHARES_PER_THREAD: usize = 8;

/// Fills `out` in some tasks, as many as threads are wanted. Each calls `fill(next)` once, which gets from
/// `next` shares of places to fill, with the number of the first, until there are
/// none left.
pub fn share<T: Send>(
    threads: NonZero<usize>,
    out: &mut [T],
    fill: impl for<'o> Fn(&mut dyn FnMut() -> Option<(u64, &'o mut [T])>) + Sync,
) {
    if threads.get() == 1 || out.is_empty() {
        let mut all = Some((0, out));
        fill(&mut || all.take());
        return;
    }
    let size = (out.len() / (threads.get() * SHARES_PER_THREAD)).clamp(1, SHARE);
    let parts = Mutex::new((0_u64..).step_by(size).zip(out.chunks_mut(size)));
    let next = || {
        let mut parts = parts.lock().unwrap_or_else(PoisonError::into_inner);
        parts.next()
    };
    rayon::scope(|scope| {
        for _ in 0..threads.get() {
            scope.spawn(|_| fill(&mut || next()));
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
                share(threads, &mut out, |next| {
                    while let Some((first, part)) = next() {
                        for (number, place) in (first..).zip(part) {
                            *place += number + 1;
                        }
                    }
                });
                let expected: Vec<u64> = (1..=places as u64).collect();
                assert_eq!(out, expected);
            }
        }
    }
}
