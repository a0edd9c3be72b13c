//! Which tier is worth its time, and whether that can be told at all.

use super::points::{RESOLUTION, TierRun, cost, needed_scans, worst};
use super::{FidelityReference, NoRecommendation, Recommendation, TargetAgreement, TierPoint};
use crate::math::NORMAL_95;

/// Share of the whole budget that the reference gets.
pub const REFERENCE_SHARE: f64 = 0.4;
/// The runs before the last one, and what the clock is unsure of.
const MARGIN: f64 = 2.0;

/// Marks the points that no other one beats in both time and error of the
/// standard deviation.
pub fn mark_pareto(tiers: &mut [TierPoint]) {
    let points: Vec<(f64, f64)> =
        tiers.iter().map(|tier| (tier.run_time_s, worst(tier.std_relative_error_ci95))).collect();
    for (tier, &(time, error)) in tiers.iter_mut().zip(&points) {
        tier.pareto =
            !points.iter().any(|&(t, e)| t <= time && e <= error && (t, e) != (time, error));
    }
}

/// Refuses a target error that the reference's runs do not resolve: with such
/// intervals no tier could be seen to hold.
pub fn refuse(
    runs: &[TierRun],
    reference: &FidelityReference,
    target_error: f64,
) -> Option<NoRecommendation> {
    let of_missed =
        reference.missed_fraction_ci95.map(|end| (end - reference.missed_fraction).abs());
    let half_width = [
        NORMAL_95 * reference.std_std_error_m / reference.std_m,
        NORMAL_95 * reference.bias_std_error_m / reference.std_m,
        of_missed[0].max(of_missed[1]),
    ]
    .into_iter()
    .fold(0.0, f64::max);
    // As many scans as were asked for are enough, whatever chance makes of them.
    if half_width <= 1.1 * RESOLUTION * target_error {
        return None;
    }
    let (last, asked) = (runs.last()?, RESOLUTION * target_error);
    // Of a handful of estimates the scatter is not known: as for normal ones.
    let per_estimate = last.repetitions as f64 / last.statistics.estimates.max(1) as f64;
    let of_normal = ((NORMAL_95 / asked).powi(2) * per_estimate).ceil() as u64;
    let scans = needed_scans(last, asked).unwrap_or(of_normal);
    let times: Vec<(u64, f64)> = runs.iter().map(|r| (r.repetitions, r.run_time_s)).collect();
    let (set_up_s, per_scan_s) = cost(&times)?;
    let needed_budget_s = MARGIN * (set_up_s + per_scan_s * scans as f64) / REFERENCE_SHARE;
    Some(NoRecommendation {
        target_error,
        resolved_error: half_width / RESOLUTION,
        needed_scans: scans,
        needed_budget_s: needed_budget_s.ceil(),
    })
}

/// The cheapest tier that was seen to hold in all three errors, with as many scans as
/// bring its own random errors below the target.
pub fn recommend(tiers: &[TierPoint], target_error: f64) -> Option<Recommendation> {
    // Of each tier the run with the most scans, whose time per scan is surest.
    let largest = |tier: &&TierPoint| {
        !tiers
            .iter()
            .any(|other| other.fidelity == tier.fidelity && other.repetitions > tier.repetitions)
    };
    tiers
        .iter()
        .filter(largest)
        .filter(|tier| tier.verdict == TargetAgreement::Holds)
        .map(|tier| (tier, time_of(tiers, tier, target_error)))
        .min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b))
        .map(|(tier, (repetitions, run_time_s))| Recommendation {
            target_error,
            fidelity: tier.fidelity.clone(),
            repetitions,
            run_time_s,
            shown_error: tier.shown_error(),
        })
}

/// Scans that a tier needs for the target, and their time.
fn time_of(tiers: &[TierPoint], tier: &TierPoint, target_error: f64) -> (Option<u64>, f64) {
    if tier.repetitions.is_none() {
        return (None, tier.run_time_s);
    }
    // The bias of n estimates is known to sigma / sqrt(n), a share to
    // sqrt(p (1 - p) / n), the standard deviation better than either.
    let missed = tier.missed_fraction.unwrap_or(0.0);
    let of_bias = 1.0 / (1.0 - missed).max(0.01);
    let needed = (NORMAL_95 / target_error).powi(2) * of_bias.max(missed * (1.0 - missed));
    let needed = needed.ceil() as u64;
    let runs = tiers.iter().filter(|other| other.fidelity == tier.fidelity);
    let runs = runs.filter_map(|run| Some((run.repetitions?, run.run_time_s)));
    let (set_up_s, per_scan_s) = cost(&runs.collect::<Vec<_>>()).unwrap_or_default();
    (Some(needed), set_up_s + per_scan_s * needed as f64)
}

impl TierPoint {
    /// The largest error that its intervals hold; of the reference nothing.
    fn shown_error(&self) -> f64 {
        if self.fidelity == super::REFERENCE_NAME {
            return 0.0;
        }
        let intervals = [
            Some(self.std_relative_error_ci95),
            Some(self.bias_error_in_std_ci95),
            self.missed_fraction_error_ci95,
        ];
        intervals.into_iter().flatten().map(worst).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(
        name: &str,
        scans: Option<u64>,
        run_time_s: f64,
        verdict: TargetAgreement,
    ) -> TierPoint {
        TierPoint {
            fidelity: name.to_owned(),
            repetitions: scans,
            run_time_s,
            std_m: 0.01,
            bias_m: 0.0,
            missed_fraction: Some(0.0),
            missed_fraction_ci95: None,
            std_relative_error: 0.0,
            std_relative_error_ci95: [-0.01, 0.02],
            bias_error_in_std: 0.0,
            bias_error_in_std_ci95: [-0.03, 0.01],
            missed_fraction_error: Some(0.0),
            missed_fraction_error_ci95: Some([-0.01, 0.01]),
            verdict,
            pareto: false,
        }
    }

    #[test]
    fn a_point_that_another_beats_in_time_and_error_is_not_on_the_front() {
        let of = |name, run_time_s, error: f64| TierPoint {
            std_relative_error_ci95: [-error, error],
            ..point(name, Some(10), run_time_s, TargetAgreement::Holds)
        };
        let mut tiers = [of("a", 1.0, 0.4), of("b", 2.0, 0.5), of("c", 3.0, 0.1)];
        mark_pareto(&mut tiers);
        assert_eq!(tiers.map(|tier| tier.pareto), [true, false, true]);
    }

    #[test]
    fn the_cheapest_tier_that_holds_is_recommended_with_the_scans_it_needs() {
        let tiers = [
            point("expected", None, 0.01, TargetAgreement::Differs),
            point("counts", Some(1_000), 0.1, TargetAgreement::Unresolved),
            point("events", Some(1_000), 1.0, TargetAgreement::Holds),
            point("rtl", Some(100), 5.0, TargetAgreement::Holds),
        ];
        let best = recommend(&tiers, 0.05).expect("one holds");
        assert_eq!(best.fidelity, "events");
        // (1.96 / 0.05)^2 = 1536.6.
        assert_eq!(best.repetitions, Some(1537));
        assert!((best.run_time_s - 1.537).abs() < 1e-12);
        assert!((best.shown_error - 0.03).abs() < 1e-12);
        assert!(recommend(&tiers[..2], 0.05).is_none());
    }

    #[test]
    fn what_a_tier_sets_up_counts_however_few_the_scans() {
        // 20 ms and 1 us a scan, against 16 ms in all.
        let tiers = [
            point("expected", None, 0.016, TargetAgreement::Holds),
            point("counts", Some(1_000), 0.021, TargetAgreement::Holds),
            point("counts", Some(100_000), 0.120, TargetAgreement::Holds),
        ];
        let best = recommend(&tiers, 0.05).expect("both hold");
        assert_eq!(best.fidelity, "expected");
        let best = recommend(&tiers[1..], 0.05).expect("it holds");
        assert_eq!(best.repetitions, Some(1537));
        assert!((best.run_time_s - 0.021_537).abs() < 1e-9);
    }
}
