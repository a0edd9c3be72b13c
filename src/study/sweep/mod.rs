//! A scene simulated many times over, with other values of some keys each time.
//!
//! Every point is what [`simulate`](crate::simulate::simulate) gives of the scene with
//! the point's settings and the sweep's seed, whatever came before it: neither order nor interruption nor threads
//! change a number. Points are simulated side by side, and each is appended to one file of the
//! folder as soon as it is finished, so that a sweep that was cut off goes on with those that
//! are missing ([`Store`]).

mod axis;
mod points;
mod store;
mod table;

use std::sync::{Mutex, PoisonError, mpsc};
use std::thread;

pub use axis::{AxisValue, SweepAxis};
pub use points::{Sweep, SweepError, SweepOptions, SweepPoint};
use rayon::ThreadPoolBuilder;
pub use store::{Store, StoreError};
pub use table::{Plot, contradicted, empty};

use crate::cosim::engine::Engine;
use crate::simulate::Tier;
use crate::simulate::repeat::{Simulated, Simulation};
use crate::simulate::scans::{PreparedTier, ScansError};

/// Why a sweep came to no table.
#[derive(Debug, thiserror::Error)]
pub enum SweepRunError {
    /// A point is not a scene.
    #[error("{0}")]
    Sweep(#[from] SweepError),
    /// A tool failed, or the Verilog differs from the reference model.
    #[error("{0}")]
    Scans(#[from] ScansError),
    /// The folder cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// No threads for the points.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Simulates those of some points that the folder does not have yet, side by side on as many
/// threads as there are cores; points of the Verilog one after the other, whose scans take all
/// cores. `on_point` is told how many are done, before the first and after some.
///
/// # Errors
/// When a tool fails or a file cannot be written. A point that a tier cannot do is no
/// error: its row has the reason.
pub fn run(
    sweep: &Sweep,
    store: &mut Store,
    numbers: impl Iterator<Item = usize>,
    mut on_point: impl FnMut(usize),
) -> Result<(), SweepRunError> {
    let missing: Vec<usize> = numbers.filter(|&number| !store.has(number)).collect();
    let mut done = store.done();
    on_point(done);
    let threads = rayon::current_num_threads();
    let side_by_side = match sweep.options.fidelity {
        Tier::Rtl => 1,
        _ => threads.min(missing.len()).max(1),
    };
    let waiting = Mutex::new(missing.into_iter());
    let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
    let (finished, points) = mpsc::sync_channel(2 * side_by_side);
    thread::scope(|scope| {
        for _ in 0..side_by_side {
            let (finished, next) = (finished.clone(), &next);
            scope.spawn(move || {
                // Of few points each has several threads.
                let threads = ThreadPoolBuilder::new().num_threads(threads / side_by_side);
                let pool = match threads.use_current_thread().build() {
                    Ok(pool) => pool,
                    Err(error) => {
                        let _ = finished.send(Err(error.into()));
                        return;
                    }
                };
                while let Some(number) = next() {
                    let rows = pool.install(|| rows_csv(sweep, number));
                    // Whoever does not listen any more has seen an error.
                    if finished.send(rows.map(|rows| (number, rows))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(finished);
        // What it waits for ends with it, before the threads are waited for.
        let points = points;
        while let Ok(first) = points.recv() {
            let some: Result<Vec<_>, SweepRunError> =
                std::iter::once(first).chain(points.try_iter()).collect();
            let some = some?;
            store.keep(&some)?;
            done += some.len();
            on_point(done);
        }
        Ok(store.sync()?)
    })
}

/// The rows of a point.
fn rows_csv(sweep: &Sweep, number: usize) -> Result<String, SweepRunError> {
    let point = sweep.point(number)?;
    let over = &sweep.options.over;
    let table = match simulation(sweep, &point) {
        Ok(simulation) => table::of_point(over, &point, &simulation),
        Err(error @ (ScansError::Cosim(_) | ScansError::Mismatch)) => return Err(error.into()),
        Err(reason) => table::refused(over, &point, &reason.to_string()),
    };
    Ok(table.rows_csv())
}

/// A point as one of all, whose scans are held against what is expected of them together.
fn simulation(sweep: &Sweep, point: &SweepPoint) -> Result<Simulation, ScansError> {
    let SweepOptions { fidelity, seed, repetitions, .. } = sweep.options;
    let prepared = PreparedTier::new(&point.sensor, fidelity, Engine::Auto)?;
    let simulated = Simulated::new(&point.sensor, fidelity.scans(repetitions).seeded(seed))?;
    simulated.one_of(sweep.len()).simulate(&prepared, &mut |_| ())
}
