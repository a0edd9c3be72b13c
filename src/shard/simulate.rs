//! Scans, a stretch of them for each shard.

use super::ShardError;
use super::job::{Results, SimulateJob};
use super::part::Part;
use crate::sensor::Sensor;
use crate::simulate::repeat::{Gathered, Simulated, Simulation, Tally};

/// The simulation that all shards together are.
///
/// # Errors
/// When a shard's results are not those of its scans, or the tier cannot do the scene.
pub fn simulation(
    job: &SimulateJob,
    sensor: &Sensor,
    shards: Vec<(Part, Results)>,
) -> Result<Simulation, ShardError> {
    let simulated = Simulated::new(sensor, job.options.fidelity)?;
    let mut all = simulated.nothing();
    for (part, results) in shards {
        let Results::Simulate(gathered) = results else {
            let reason = "it has no scans";
            return Err(ShardError::Unfit { part, reason });
        };
        check(part, job, &all, &gathered)?;
        all.append(gathered);
    }
    Ok(simulated.conclude(job.options.seed, job.options.repetitions, all)?)
}

/// Whether results are of a part's scans; `nothing` has as many detectors and paths.
fn check(
    part: Part,
    job: &SimulateJob,
    nothing: &Gathered,
    gathered: &Gathered,
) -> Result<(), ShardError> {
    let unfit = |reason| Err(ShardError::Unfit { part, reason });
    if gathered.tallies.len() != nothing.tallies.len() {
        return unfit("the scene has another number of detectors");
    }
    let stretch = part.stretch(job.options.repetitions);
    for (tally, of_none) in gathered.tallies.iter().zip(&nothing.tallies) {
        if tally.scans != stretch.end - stretch.start {
            return unfit("it has another number of scans");
        }
        if tally.errors_m.len() != of_none.errors_m.len() || !is_sound(tally) {
            return unfit("its estimates are not those of so many scans");
        }
    }
    Ok(())
}

/// Whether nothing was counted more often than there are scans.
fn is_sound(tally: &Tally) -> bool {
    let errors = tally.errors_m.iter().map(|errors_m| errors_m.len() as u64);
    let mut of_paths = errors.zip(&tally.found);
    tally.found.len() == tally.errors_m.len()
        && of_paths.all(|(errors, &found)| found <= errors && errors <= tally.scans)
        && tally.alarms <= tally.fits
        && tally.fits <= tally.scans
        && tally.remarks <= tally.scans
}
