//! Error against run time, tier by tier: the JSON of `goldtof fidelity`.
//!
//! The reference is the sampled tier with as many scans as the time allows: it is
//! bit for bit the hardware. Each tier's standard deviation and bias are held
//! against it, with the standard errors of both.

mod choice;
mod files;
mod points;
mod sensor;
mod text;
mod window;

use std::time::{Duration, Instant};

use serde::Serialize;

use super::scans::{Prepared, ScansError};
use super::{Tier, domain};
use crate::estimate::{NoEstimate, check_modulated, predict};
use crate::plan::{self, Part};
use crate::scene::Scene;

/// What `goldtof fidelity` gives.
#[derive(Debug, Clone, Serialize)]
pub struct FidelityReport {
    /// The scene's name.
    pub scene: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The tier that the others are held against, and its number of scans.
    pub reference: Reference,
    /// Every tier at every number of scans that was run, from the least of the
    /// sensor to the most.
    pub tiers: Vec<TierPoint>,
    /// The cheapest way to the error that was asked for.
    pub recommended: Option<Recommendation>,
    /// Domain of each tier, and where the scene is outside of it.
    pub domains: Vec<TierDomain>,
    /// The sensor's own trade: error of the distance against integration time
    /// and light.
    pub sensor: Vec<SensorPoint>,
    /// Parts of the simulation that the scene does without, and what that saves.
    pub left_out: Vec<Part>,
}

/// The reference.
#[derive(Debug, Clone, Serialize)]
pub struct Reference {
    /// Its name.
    pub name: &'static str,
    /// Scans.
    pub repetitions: u64,
    /// Wall time.
    pub run_time_s: f64,
    /// Standard deviation of one scan's estimate.
    pub std_m: f64,
    /// Standard error of that.
    pub std_std_error_m: f64,
    /// Mean error.
    pub bias_m: f64,
    /// Standard error of that.
    pub std_error_m: f64,
}

/// One tier at one number of scans.
#[derive(Debug, Clone, Serialize)]
pub struct TierPoint {
    /// Name of the tier.
    pub name: String,
    /// Scans; none for the tier that draws no random numbers.
    pub repetitions: Option<u64>,
    /// Wall time.
    pub run_time_s: f64,
    /// Standard deviation of one scan's estimate.
    pub std_m: f64,
    /// Mean error.
    pub bias_m: f64,
    /// (standard deviation - reference's) / reference's.
    pub error_vs_reference: f64,
    /// Its 95 % confidence interval, from the standard errors of both.
    pub error_ci: [f64; 2],
    /// (bias - reference's) / reference's standard deviation.
    pub bias_error_vs_reference: f64,
    /// Its 95 % confidence interval.
    pub bias_error_ci: [f64; 2],
    /// No other point is both faster and surer of the standard deviation.
    pub pareto: bool,
}

/// For which scenes a tier's answers hold.
#[derive(Debug, Clone, Serialize)]
pub struct TierDomain {
    /// Name of the tier.
    pub name: String,
    /// The domain.
    pub domain: &'static str,
    /// Wall time of what is done once and for all scans to come, and is in no
    /// run time: the Verilog's build (next to nothing where the cache has it).
    pub build_time_s: Option<f64>,
    /// Where the scene is outside of it, and what that does to the answer.
    pub warnings: Vec<String>,
}

/// The cheapest tier for an error.
#[derive(Debug, Clone, Serialize)]
pub struct Recommendation {
    /// The error that was asked for, of the standard deviation, relative.
    pub target_error: f64,
    /// Name of the tier.
    pub name: String,
    /// Scans to run; none for the tier that draws no random numbers.
    pub repetitions: Option<u64>,
    /// Wall time that they take.
    pub run_time_s: f64,
    /// The tier was seen to differ from the reference by no more than this, with
    /// 95 % confidence: more than the target where the reference itself is not
    /// known that well.
    pub shown_error: f64,
}

/// The sensor at one light level and integration time.
#[derive(Debug, Clone, Serialize)]
pub struct SensorPoint {
    /// Power of every source, relative to the scene's.
    pub relative_power: f64,
    /// Rate of counted detections.
    pub detected_rate_cps: f64,
    /// Integration time per phase step.
    pub integration_s: f64,
    /// Expected standard deviation of one scan's estimate.
    pub std_m: f64,
    /// Expected bias, which no integration removes.
    pub bias_m: f64,
    /// At most this share of scans takes a wrong step for the peak.
    pub coarse_failure_bound: f64,
}

/// Why tiers could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum FidelityError {
    /// A tier failed.
    #[error(transparent)]
    Scans(#[from] ScansError),
    /// No path of the detector's own source.
    #[error(
        "no path leads from the first detector's own source to it, so there is no error to compare"
    )]
    NoPath,
    /// No tier can give an estimate.
    #[error("no tier has an estimate to compare: {0}")]
    NoEstimate(#[from] NoEstimate),
    /// The reference gave too few estimates.
    #[error(
        "the reference tier found the path in fewer than two of {0} scans: more light, or a longer integration, is needed"
    )]
    NoEstimates(u64),
}

/// Compares tiers on the first detector's first own path, within about
/// `budget` of wall time.
///
/// # Errors
/// When a tier cannot do the scene, or there is nothing to compare.
pub fn compare(
    scene: &Scene,
    seed: u64,
    budget: Duration,
    target_error: f64,
) -> Result<FidelityReport, FidelityError> {
    let own = scene.detectors[0].reference;
    let path = (0..scene.paths.len())
        .find(|&p| scene.paths[p].detector == 0 && scene.paths[p].source == own)
        .ok_or(FidelityError::NoPath)?;
    check_modulated(scene, 0)?;
    let (windowed, unscanned) = window::round_peak(scene, path);
    let share = budget.div_f64(5.0);

    let prepared = Prepared::new(&windowed, Tier::Sampled)?;
    let mut sampled = points::grow(&windowed, &prepared, path, seed, share * 2)?;
    let reference = points::reference(sampled.pop())?;
    let counting = Tier::Expected.counting();
    let predicted = [(path, predict(&windowed, 0, path, counting))];
    let mut tiers = Vec::new();
    let mut domains = Vec::new();
    for tier in Tier::ALL {
        let mut warnings = domain::warnings(&windowed, 0, tier, &predicted);
        let started = Instant::now();
        let prepared = Prepared::new(&windowed, tier)?;
        let build_time_s = (tier == Tier::Rtl).then(|| started.elapsed().as_secs_f64());
        // The reference's own smaller runs share their random numbers with it:
        // their errors are a little too small.
        let runs = match tier {
            Tier::Sampled => Ok(std::mem::take(&mut sampled)),
            _ => points::grow(&windowed, &prepared, path, seed ^ 0x5bd1_e995, share),
        };
        let runs = match runs {
            // A tier that works the response out may not be able to; others can.
            Err(FidelityError::Scans(
                reason @ (ScansError::MeanResponse(_) | ScansError::Prediction(_)),
            )) => {
                warnings.push(format!("left out: {reason}"));
                Vec::new()
            }
            other => other?,
        };
        tiers.extend(runs.iter().filter_map(|run| points::point(run, &reference)));
        domains.push(TierDomain {
            name: tier.to_string(),
            domain: domain::of(tier),
            build_time_s,
            warnings,
        });
    }
    choice::mark_pareto(&mut tiers);
    let plan = plan::with_savings(plan::plan(scene), scene);
    let mut left_out: Vec<Part> = plan.simulation.into_iter().filter(|p| !p.kept).collect();
    left_out.extend(unscanned);
    Ok(FidelityReport {
        scene: scene.name.clone(),
        seed,
        recommended: choice::recommend(&tiers, &reference, target_error),
        reference,
        tiers,
        domains,
        sensor: sensor::trade(&windowed, path),
        left_out,
    })
}
