//! Work on every processor.

use std::num::NonZero;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Shares of the work that each thread gets, about: enough that none waits long
/// for the last.
const SHARES_PER_THREAD: usize = 8;

/// `work` for every index below `count`, on all processors, in order.
pub fn in_parallel<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let share = (count / (threads * SHARES_PER_THREAD)).max(1);
    let next = AtomicUsize::new(0);
    let take = || -> Option<Range<usize>> {
        let start = next.fetch_add(share, Ordering::Relaxed);
        (start < count).then(|| start..(start + share).min(count))
    };
    let run = || -> Vec<(usize, Vec<T>)> {
        std::iter::from_fn(take)
            .map(|range| (range.start, range.map(&work).collect()))
            .collect()
    };
    let mut done: Vec<(usize, Vec<T>)> = thread::scope(|scope| {
        let workers: Vec<_> = (1..threads.min(count)).map(|_| scope.spawn(run)).collect();
        let mut done = run();
        for worker in workers {
            match worker.join() {
                Ok(results) => done.extend(results),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        done
    });
    done.sort_unstable_by_key(|(start, _)| *start);
    done.into_iter().flat_map(|(_, results)| results).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_each_once() {
        for count in [0, 1, 2, 15, 16, 17, 1000] {
            let squares: Vec<usize> = (0..count).map(|i| i * i).collect();
            assert_eq!(in_parallel(count, |i| i * i), squares);
        }
    }
}
