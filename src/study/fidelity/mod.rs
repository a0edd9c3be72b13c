//! Error against run time, tier by tier: the JSON of `goldtof fidelity`.
//!
//! The reference is the sampled tier with as many scans as the time allows: it is
//! bit for bit the hardware. Each tier's standard deviation, bias and share of scans
//! that miss the peak are held against it, with the standard errors of both. A tier
//! holds if the 95 % intervals of all three errors lie within the target; a target
//! that the reference itself does not resolve in the time is refused.

mod choice;
mod points;
mod text;

use std::time::{Duration, Instant};

use serde::Serialize;

use crate::cosim::engine::Engine;
use crate::estimate::{NoEstimate, check_modulated, predict};
use crate::plan::{self, Part};
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;
use crate::simulate::scans::{PreparedTier, ScansError};
use crate::simulate::{Tier, domain};

/// Name of the tier that the others are held against.
const REFERENCE_NAME: &str = "sampled";

/// What `goldtof fidelity` gives.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct FidelityReport {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The tier that the others are held against, and its number of scans.
    pub reference: FidelityReference,
    /// Every tier at every number of scans that was run, from the least of the
    /// sensor to the most.
    pub tiers: Vec<TierPoint>,
    /// The cheapest way to the error that was asked for.
    pub recommended: Option<Recommendation>,
    /// Why there is none, or none for the default error, where the budget was too small to tell.
    pub refusal: Option<NoRecommendation>,
    /// Domain of each tier, and where the scene is outside of it.
    pub domains: Vec<TierDomain>,
    /// The sensor's own trade: error of the distance against integration time
    /// and light.
    pub sensor: Vec<SensorPoint>,
    /// Parts of the simulation that the scene does without, and what that saves.
    pub left_out: Vec<Part>,
}

/// The reference.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Reference")]
pub struct FidelityReference {
    /// Its tier.
    pub fidelity: &'static str,
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
    pub bias_std_error_m: f64,
    /// Share of scans that miss the peak ([`PathStatistics::missed_fraction`]).
    ///
    /// [`PathStatistics::missed_fraction`]: crate::simulate::path_statistics::PathStatistics
    pub missed_fraction: f64,
    /// Its 95 % confidence interval.
    pub missed_fraction_ci95: [f64; 2],
    /// Whether these scans bear out what is expected of them; none without an expectation.
    pub expectation_holds: Option<bool>,
    /// How they contradict it, where they do.
    pub expectation_remark: Option<String>,
}

/// One tier at one number of scans.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct TierPoint {
    /// The tier.
    pub fidelity: String,
    /// Scans; none for the tier that draws no random numbers.
    pub repetitions: Option<u64>,
    /// Wall time.
    pub run_time_s: f64,
    /// Standard deviation of one scan's estimate.
    pub std_m: f64,
    /// Mean error.
    pub bias_m: f64,
    /// (standard deviation - reference's) / reference's.
    pub std_relative_error: f64,
    /// Its 95 % confidence interval, from the standard errors of both.
    pub std_relative_error_ci95: [f64; 2],
    /// (bias - reference's) / reference's standard deviation.
    pub bias_error_in_std: f64,
    /// Its 95 % confidence interval.
    pub bias_error_in_std_ci95: [f64; 2],
    /// Share of scans that miss the peak; none where the tier cannot tell.
    pub missed_fraction: Option<f64>,
    /// Its 95 % confidence interval; none of the tier that draws nothing.
    pub missed_fraction_ci95: Option<[f64; 2]>,
    /// Share of scans that miss the peak, less the reference's.
    pub missed_fraction_error: Option<f64>,
    /// Its 95 % confidence interval.
    pub missed_fraction_error_ci95: Option<[f64; 2]>,
    /// Whether all three errors are within the target.
    pub verdict: TargetAgreement,
    /// No other point is both faster and surer of the standard deviation.
    pub pareto: bool,
}

/// Whether a tier's errors of standard deviation (relative), bias (in standard
/// deviations) and share of missed peaks (of all scans) are within the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Agreement")]
pub enum TargetAgreement {
    /// The 95 % intervals of all three are within it.
    Holds,
    /// That of one is outside.
    Differs,
    /// Neither: too few scans.
    Unresolved,
}

impl std::fmt::Display for TargetAgreement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.serialize(f)
    }
}

/// Why no tier can be recommended: the reference's own intervals are too wide.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Refusal")]
pub struct NoRecommendation {
    /// The error that was asked for.
    pub target_error: f64,
    /// The least that these scans resolve.
    pub resolved_error: f64,
    /// Scans of the reference that would resolve the one that was asked for.
    pub needed_scans: u64,
    /// `--budget-s` that would be enough for them, and the other tiers' shares.
    pub needed_budget_s: f64,
}

impl NoRecommendation {
    /// The least that these scans resolve, in whole percents.
    fn resolved_percent(&self) -> f64 {
        (100.0 * self.resolved_error).ceil() / 100.0
    }
}

impl std::fmt::Display for NoRecommendation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the budget cannot resolve a target error of {} %: it resolves {:.2} %; {} scans of the \
             sampled tier would, with --budget-s {:.0}",
            self.target_error * 100.0,
            self.resolved_error * 100.0,
            self.needed_scans,
            self.needed_budget_s
        )
    }
}

/// For which scenes a tier's answers hold.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct TierDomain {
    /// The tier.
    pub fidelity: String,
    /// The domain.
    pub domain: &'static str,
    /// Wall time of what is done once and for all scans to come, and is in no
    /// run time: the Verilog's build (next to nothing where the cache has it).
    pub build_time_s: Option<f64>,
    /// Where the scene is outside of it, and what that does to the answer.
    pub warnings: Vec<String>,
}

/// The cheapest tier for an error.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Recommendation {
    /// The error that was asked for: of the standard deviation, relative; of the bias,
    /// in standard deviations; of the share of missed peaks, in shares of all scans.
    pub target_error: f64,
    /// The tier.
    pub fidelity: String,
    /// Scans to run; none for the tier that draws no random numbers.
    pub repetitions: Option<u64>,
    /// Wall time that they take.
    pub run_time_s: f64,
    /// The tier was seen to differ from the reference by no more than this in any of
    /// the three, with 95 % confidence each.
    pub shown_error: f64,
}

/// The sensor at one light level and integration time.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
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
    pub coarse_failure_bound_fraction: f64,
    /// Expected share of scans that miss the peak.
    pub missed_fraction: Option<f64>,
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
    /// The reference's estimates are spread all over the range.
    #[error("the reference tier's estimates have no scatter to compare: {0}")]
    NoScatter(String),
}

/// How well a tier is to do, and how long the comparison may take.
#[derive(Debug, Clone, clap::Args)]
pub struct FidelityOptions {
    /// Largest error of standard deviation, bias (in standard deviations) and share of
    /// missed peaks for a recommended tier, 0.01% to 99%: --target-error 5%, or 0.05
    /// [default: 5%, or what the budget resolves where that is more]
    #[arg(long, value_name = "E", value_parser = parse_error)]
    pub target_error: Option<f64>,
    /// Approximate run time in seconds, 1 to 86400, for example --budget-s 300
    #[arg(long, value_name = "S", default_value_t = FidelityOptions::default().budget_s,
          value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub budget_s: u64,
    /// Seed of all random numbers
    #[arg(skip)]
    pub seed: u64,
}

impl Default for FidelityOptions {
    fn default() -> FidelityOptions {
        FidelityOptions { target_error: None, budget_s: 60, seed: 1 }
    }
}

/// The error that is asked for where none is.
const DEFAULT_ERROR: f64 = 0.05;
/// The smallest error that scans can show: it takes 2 10^8 of them.
const LEAST_ERROR: f64 = 1e-4;
const MOST_ERROR: f64 = 0.99;

/// Reads a relative error: "1%" or "0.01".
fn parse_error(text: &str) -> Result<f64, String> {
    let (number, scale) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if (LEAST_ERROR..=MOST_ERROR).contains(&(value * scale)) => Ok(value * scale),
        _ => Err(format!(
            "\"{text}\" is not a relative error from 0.01% to 99%; write for example 1% or 0.01"
        )),
    }
}

/// Compares tiers on the first detector's first own path, within about the budget of wall time.
///
/// # Errors
/// When a tier cannot do the scene, or there is nothing to compare.
pub fn compare(scene: &Scene, options: &FidelityOptions) -> Result<FidelityReport, FidelityError> {
    let seed = options.seed;
    let mut target_error = options.target_error.unwrap_or(DEFAULT_ERROR);
    let budget = Duration::from_secs(options.budget_s);
    let path = scene.own_paths(DetectorIndex(0)).next().ok_or(FidelityError::NoPath)?;
    let sensor = Sensor::new(scene);
    check_modulated(&sensor, DetectorIndex(0))?;
    let (windowed, unscanned) = points::round_peak(&sensor, path, target_error);
    let share = (budget.div_f64(5.0), target_error);
    let of_reference = (budget.mul_f64(choice::REFERENCE_SHARE), target_error);

    let prepared = PreparedTier::new(&windowed, Tier::Sampled, Engine::Auto)?;
    let mut sampled = points::grow(&windowed, &prepared, path, seed, of_reference)?;
    let reference = points::reference(sampled.last())?;
    let refusal = choice::refuse(&sampled, &reference, target_error);
    let resolved = refusal.as_ref().map(NoRecommendation::resolved_percent);
    if let (None, Some(resolved)) = (options.target_error, resolved) {
        target_error = resolved.min(MOST_ERROR);
    }
    let is_resolved = resolved.is_none_or(|resolved| resolved <= target_error);
    let counting = Tier::Expected.counting(&windowed);
    let predicted = [(path, predict(&windowed, DetectorIndex(0), path, counting))];
    let mut tiers = Vec::new();
    let mut domains = Vec::new();
    for tier in Tier::ALL {
        let mut warnings = domain::warnings(&windowed, DetectorIndex(0), tier, &predicted);
        let started = Instant::now();
        let prepared = PreparedTier::new(&windowed, tier, Engine::Auto)?;
        let build_time_s = (tier == Tier::Rtl).then(|| started.elapsed().as_secs_f64());
        // The reference's own runs share their random numbers with it: their errors
        // are a little too small, and that of the last is none.
        let runs = match tier {
            Tier::Sampled => std::mem::take(&mut sampled),
            _ => {
                let runs = points::grow(&windowed, &prepared, path, seed ^ 0x5bd1_e995, share);
                unless_left_out(runs, &mut warnings)?
            }
        };
        tiers.extend(points_of(&runs, &reference, target_error, &mut warnings));
        domains.push(TierDomain {
            fidelity: tier.to_string(),
            domain: domain::of(tier, scene.hardware.architecture),
            build_time_s,
            warnings,
        });
    }
    choice::mark_pareto(&mut tiers);
    let plan = plan::with_savings(plan::plan(&sensor), &sensor);
    let mut left_out: Vec<Part> = plan.simulation.into_iter().filter(|p| !p.kept).collect();
    left_out.extend(unscanned);
    Ok(FidelityReport {
        scene: scene.name.clone(),
        seed,
        recommended: choice::recommend(&tiers, target_error).filter(|_| is_resolved),
        refusal,
        reference,
        tiers,
        domains,
        sensor: points::trade(scene, path),
        left_out,
    })
}

/// The runs of a tier: none, with a warning, of one that works the response out and cannot;
/// others can.
fn unless_left_out<R>(
    runs: Result<Vec<R>, FidelityError>,
    warnings: &mut Vec<String>,
) -> Result<Vec<R>, FidelityError> {
    match runs {
        Err(FidelityError::Scans(
            reason @ (ScansError::MeanResponse(_)
            | ScansError::TooMuch(_)
            | ScansError::Prediction(_)
            | ScansError::Histograms(_)),
        )) => {
            warnings.push(format!("left out: {reason}"));
            Ok(Vec::new())
        }
        other => other,
    }
}

/// What a tier's runs say beside the reference; a warning if they say nothing.
fn points_of(
    runs: &[points::TierRun],
    reference: &FidelityReference,
    target_error: f64,
    warnings: &mut Vec<String>,
) -> Vec<TierPoint> {
    let points = runs.iter().map(|run| points::point(run, reference, target_error));
    let known: Vec<TierPoint> = points.flatten().collect();
    if let (true, Some(run)) = (known.is_empty(), runs.last()) {
        let reason = run.statistics.remark.as_deref();
        let reason = reason.unwrap_or("fewer than two scans found the path");
        warnings.push(format!("left out, without a standard deviation: {reason}"));
    }
    known
}

#[cfg(test)]
mod tests {
    use super::parse_error;

    #[test]
    fn an_error_is_a_percentage_or_a_fraction() {
        assert_eq!(parse_error("1%"), Ok(0.01));
        assert_eq!(parse_error("0.25"), Ok(0.25));
        for wrong in ["", "%", "0", "-1%", "100%", "nan", "one", "1e-300", "0.001%"] {
            assert!(parse_error(wrong).is_err(), "{wrong}");
        }
    }
}
