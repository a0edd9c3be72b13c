//! Which tier is worth its time.

use super::points::{Z_95, worst};
use super::{Recommendation, Reference, TierPoint};

/// Marks the points that no other one beats in both time and error of the
/// standard deviation.
pub fn mark_pareto(tiers: &mut [TierPoint]) {
    let points: Vec<(f64, f64)> = tiers
        .iter()
        .map(|tier| (tier.run_time_s, worst(tier.error_ci)))
        .collect();
    for (tier, &(time, error)) in tiers.iter_mut().zip(&points) {
        tier.pareto = !points
            .iter()
            .any(|&(t, e)| t <= time && e <= error && (t, e) != (time, error));
    }
}

/// The cheapest tier whose difference from the reference is no larger than
/// chance and target together, with as many scans as bring its own random error
/// below the target.
pub fn recommend(
    tiers: &[TierPoint],
    reference: &Reference,
    target_error: f64,
) -> Option<Recommendation> {
    let chance = Z_95 * reference.std_std_error_m / reference.std_m;
    let agrees = |tier: &TierPoint| {
        let half = (tier.error_ci[1] - tier.error_ci[0]) / 2.0;
        tier.error_vs_reference.abs() <= half.max(chance) + target_error
    };
    let cost = |tier: &TierPoint| match tier.repetitions {
        None => (None, tier.run_time_s),
        Some(repetitions) => {
            // The relative standard error of a standard deviation of n normal
            // numbers is 1 / sqrt(2 (n - 1)).
            let needed = (0.5 * (Z_95 / target_error).powi(2)).ceil() as u64 + 1;
            // What a tier sets up before its first scan is in every run's time.
            let shortest = tiers
                .iter()
                .filter(|other| other.name == tier.name && other.repetitions < tier.repetitions)
                .min_by_key(|other| other.repetitions);
            let (fewest, least_s) = shortest.map_or((0, 0.0), |run| {
                (run.repetitions.unwrap_or(0), run.run_time_s)
            });
            let per_scan_s = (tier.run_time_s - least_s).max(0.0) / (repetitions - fewest) as f64;
            let set_up_s = (least_s - per_scan_s * fewest as f64).max(0.0);
            (Some(needed), set_up_s + per_scan_s * needed as f64)
        }
    };
    // Of each tier the run with the most scans, whose time per scan is surest.
    let largest = |tier: &&TierPoint| {
        !tiers
            .iter()
            .any(|other| other.name == tier.name && other.repetitions > tier.repetitions)
    };
    tiers
        .iter()
        .filter(largest)
        .filter(|tier| agrees(tier))
        .map(|tier| (tier, cost(tier)))
        .min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b))
        .map(|(tier, (repetitions, run_time_s))| Recommendation {
            target_error,
            name: tier.name.clone(),
            repetitions,
            run_time_s,
            shown_error: worst(tier.error_ci),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCE: Reference = Reference {
        name: "sampled",
        repetitions: 20_000,
        run_time_s: 100.0,
        std_m: 0.01,
        std_std_error_m: 0.000_05,
        bias_m: 0.0,
        std_error_m: 0.000_07,
    };

    fn point(name: &str, scans: Option<u64>, run_time_s: f64, error: f64, half: f64) -> TierPoint {
        TierPoint {
            name: name.to_owned(),
            repetitions: scans,
            run_time_s,
            std_m: 0.01,
            bias_m: 0.0,
            error_vs_reference: error,
            error_ci: [error - half, error + half],
            bias_error_vs_reference: 0.0,
            bias_error_ci: [-half, half],
            pareto: false,
        }
    }

    #[test]
    fn a_point_that_another_beats_in_time_and_error_is_not_on_the_front() {
        let mut tiers = [
            point("a", Some(10), 1.0, 0.0, 0.4),
            point("b", Some(10), 2.0, 0.1, 0.4),
            point("b", Some(100), 3.0, 0.0, 0.1),
        ];
        mark_pareto(&mut tiers);
        assert_eq!(tiers.map(|tier| tier.pareto), [true, false, true]);
    }

    #[test]
    fn the_cheapest_tier_that_agrees_is_recommended_with_the_scans_it_needs() {
        let tiers = [
            // Wrong by a fifth, far more than chance.
            point("expected", None, 0.01, 0.2, 0.01),
            point("events", Some(1_000), 1.0, 0.02, 0.045),
            point("rtl", Some(100), 5.0, 0.0, 0.14),
        ];
        let best = recommend(&tiers, &REFERENCE, 0.05).expect("one agrees");
        assert_eq!(best.name, "events");
        // 1.96 / sqrt(2 (n - 1)) = 0.05 at n = 769.
        assert_eq!(best.repetitions, Some(770));
        assert!((best.run_time_s - 0.770).abs() < 1e-12);
        assert!((best.shown_error - 0.065).abs() < 1e-12);
    }

    #[test]
    fn what_a_tier_sets_up_counts_however_few_the_scans() {
        // 20 ms and 1 us a scan, against 16 ms in all.
        let tiers = [
            point("expected", None, 0.016, 0.0, 0.01),
            point("counts", Some(1_000), 0.021, 0.0, 0.01),
            point("counts", Some(100_000), 0.120, 0.0, 0.01),
        ];
        let best = recommend(&tiers, &REFERENCE, 0.05).expect("both agree");
        assert_eq!(best.name, "expected");
        let best = recommend(&tiers[1..], &REFERENCE, 0.05).expect("it agrees");
        assert_eq!(best.repetitions, Some(770));
        assert!((best.run_time_s - 0.020_77).abs() < 1e-12);
    }
}
