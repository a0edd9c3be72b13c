//! Jobs that may take long, in a thread of their own.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;

use goldtof::Progress;

use crate::errors::failed;

/// How often signals are looked for, and progress is told.
const LOOK: Duration = Duration::from_millis(50);

/// What a job tells of itself, and what it is told.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    stop: AtomicBool,
    done: AtomicU64,
    all: AtomicU64,
}

/// What a job unwinds with when nobody waits for it any more. No panic hook hears of it.
struct Stopped;

impl Watch {
    /// Keeps how far the job has come; does not return when it is to stop.
    pub(crate) fn hear(&self, so_far: Progress) {
        if let Progress::Parts { done, of } = so_far {
            self.progress(done, of);
        }
    }

    /// [`Watch::hear`] of parts.
    pub(crate) fn progress(&self, done: u64, all: u64) {
        self.done.store(done, Ordering::Relaxed);
        self.all.store(all, Ordering::Relaxed);
        if self.stop.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
    }
}

/// The process whose threads the computing ones are.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Keeps which process loaded the package. A child of `fork` has none of its parent's
/// threads, and would wait for ever for those that compute.
pub(crate) fn remember_process() {
    PROCESS.store(std::process::id(), Ordering::Relaxed);
}

/// Does a job, in a child of `fork` with computing threads of its own.
fn in_living_threads<T: Send>(job: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    if PROCESS.load(Ordering::Relaxed) == std::process::id() {
        return job();
    }
    let threads = rayon::ThreadPoolBuilder::new().build();
    threads.map_err(|error| failed(format!("no threads to compute with: {error}")))?.install(job)
}

/// Runs a job without Python's lock, and tells `on_progress(done, all)` how far it has
/// come; where there is none, a bar in a terminal or a notebook. With Ctrl-C, or when the callback raises, the call ends at once, and the job at
/// its next progress.
pub(crate) fn wait_for<T: Send + 'static>(
    python: Python<'_>,
    on_progress: Option<Py<PyAny>>,
    job: impl FnOnce(&Watch) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let watch = Arc::new(Watch::default());
    let (to_us, mut from_job) = channel();
    let watched = Arc::clone(&watch);
    std::thread::Builder::new()
        .name("goldtof".to_owned())
        .spawn(move || {
            let ended = catch_unwind(AssertUnwindSafe(|| in_living_threads(|| job(&watched))));
            // Nobody may be left to hear it.
            let _ = to_us.send(ended);
        })
        .map_err(|error| failed(format!("no thread for the job: {error}")))?;
    let on_progress = match on_progress {
        Some(callback) => Some(callback),
        None => python.import("goldtof.progress")?.getattr("bar")?.call0()?.extract()?,
    };
    let mut told = 0;
    loop {
        // By a reference that nobody else has: a receiver is not shared between threads.
        let from_job = &mut from_job;
        let heard = python.detach(move || from_job.recv_timeout(LOOK));
        let (done, all) = (watch.done.load(Ordering::Relaxed), watch.all.load(Ordering::Relaxed));
        let is_over = !matches!(heard, Err(RecvTimeoutError::Timeout));
        let went_on = (done != told).then_some(()).and(on_progress.as_ref());
        told = done;
        let told_well = match went_on {
            Some(callback) => callback.call1(python, (done, all)).map(|_| ()),
            None => Ok(()),
        };
        if let Err(error) = told_well.and_then(|()| python.check_signals()) {
            watch.stop.store(true, Ordering::Relaxed);
            return Err(error);
        }
        if is_over {
            return match heard {
                Ok(Ok(ended)) => ended,
                Ok(Err(panic)) => {
                    Err(failed(format!("goldtof made a mistake: {}", words_of(&*panic))))
                }
                Err(_) => Err(failed("the job's thread ended without a word")),
            };
        }
    }
}

fn words_of(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("without a reason").to_owned()
}
