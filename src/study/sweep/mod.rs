//! A scene simulated many times over, with other values of some keys each time.
//!
//! Every point is what [`simulate_one_of`] gives of the scene with the point's settings and
//! the sweep's seed, whatever came before it: neither order nor interruption nor threads
//! change a number. Each finished point is a file of its own in the folder, on the
//! disk before the next one begins, so that a sweep that was cut off goes on behind the
//! last one ([`Store`]).

mod axis;
mod plot;
mod points;
mod store;
mod table;

pub use axis::{Axis, Value};
pub use plot::plot;
pub use points::{Point, Sweep, SweepError, SweepOptions};
pub use store::{Store, StoreError};
pub use table::contradicted;
pub(crate) use table::empty;

use crate::report::table::{Table, Unreadable};
use crate::simulate::repeat::simulate_one_of;
use crate::simulate::scans::ScansError;

/// Why a sweep came to no table.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scene of a point is invalid.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A tool failed, or the Verilog differs from the reference model.
    #[error(transparent)]
    Scans(#[from] ScansError),
    /// The folder cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A finished point is not what was written.
    #[error(
        "a finished point cannot be read back: {0}; remove the sweep's folder, or name another"
    )]
    Point(#[from] Unreadable),
}

/// Simulates every point that the folder does not have yet, and reads all of them.
/// `on_point` is that of [`run_points`].
///
/// # Errors
/// As there; and when a finished point cannot be read.
pub fn run(sweep: &Sweep, store: &Store, on_point: impl FnMut(usize)) -> Result<Table, RunError> {
    run_points(sweep, store, 0..sweep.len(), on_point)?;
    let mut table = empty(&sweep.options.over);
    for number in 0..sweep.len() {
        table.read_csv(&store.point(number)?)?;
    }
    Ok(table)
}

/// Simulates those of some points that the folder does not have yet. `on_point` is told how
/// many are done, before the first and after each.
///
/// # Errors
/// When a tool fails or a file cannot be written. A point that a tier cannot do is no
/// error: its row has the reason.
pub fn run_points(
    sweep: &Sweep,
    store: &Store,
    numbers: impl Iterator<Item = usize>,
    mut on_point: impl FnMut(usize),
) -> Result<(), RunError> {
    let mut done = store.done()?;
    on_point(done.len());
    for number in numbers {
        if done.contains(&number) {
            continue;
        }
        let point = sweep.point(number)?;
        let SweepOptions { fidelity, seed, repetitions, .. } = sweep.options;
        let points = sweep.len();
        let table = match simulate_one_of(&point.sensor, fidelity, seed, repetitions, points) {
            Ok(simulation) => table::of_point(&sweep.options.over, &point, &simulation),
            Err(error @ (ScansError::Cosim(_) | ScansError::Mismatch)) => return Err(error.into()),
            Err(reason) => table::refused(&sweep.options.over, &point, &reason.to_string()),
        };
        store.keep(number, &table.csv())?;
        done.insert(number);
        on_point(done.len());
    }
    Ok(())
}
