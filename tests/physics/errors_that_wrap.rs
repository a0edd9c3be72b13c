//! Estimates of a code so short that errors come round its period.

use goldtof::Jobs as _;
use goldtof::estimate::report::Reporter;
use goldtof::estimate::{CountingTier, calibration_offset_ps, distance_m, estimate};
use goldtof::scene::{DetectorIndex, Path, Scene, SourceIndex};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::path_statistics::PathStatistics;
use goldtof::simulate::scans::scans;
use optics_support::{code, table_i_scene};

const RANGE_PS: f64 = 16_000.0;

/// A square wave over a weak path, beside light of the same modulation, thirty times as
/// strong, about half a period later: estimates follow that.
fn misled(delay_ps: f64) -> Scene {
    let mut scene = table_i_scene(code(&[1, 0]), 5e6, 13_100);
    let mut other = scene.sources[0].clone();
    other.name = "other".to_owned();
    scene.sources[0].mean_power_w /= 30.0;
    scene.sources.push(other);
    scene.paths[0].delay_ps = delay_ps;
    let strong = Path {
        source: SourceIndex(1),
        delay_ps: delay_ps + 0.5 * RANGE_PS - 40.0,
        ..scene.paths[0].clone()
    };
    scene.paths.push(strong);
    scene
}

fn statistics(scene: &Scene, tier: Tier, scans: u64) -> PathStatistics {
    let simulated = Sensor::new(scene)
        .simulate(tier.scans(scans).seeded(3))
        .expect("the scene can be simulated");
    simulated.estimates.into_iter().next().expect("its path")
}

fn fold(error_m: f64) -> f64 {
    let range_m = distance_m(RANGE_PS);
    error_m - range_m * (error_m / range_m).round()
}

#[test]
fn a_bias_of_half_the_period_is_what_was_expected() {
    // Also with the truth on the border of the period, and beyond the range.
    for delay_ps in [5_000.0, 0.0, 3.0 * RANGE_PS + 15_990.0] {
        let scene = misled(delay_ps);
        let range_m = distance_m(RANGE_PS);
        for tier in [Tier::Events, Tier::Sampled, Tier::Expected] {
            let found = statistics(&scene, tier, 300);
            let [bias_m, expected_m] = [found.bias_m, found.expected_bias_m].map(Option::unwrap);
            assert!(bias_m.abs() > 0.45 * range_m, "{tier} {delay_ps}: {bias_m}");
            let std_m = found.expected_std_m.unwrap();
            let error_m = std_m / 300_f64.sqrt();
            assert!(fold(bias_m - expected_m).abs() < 4.0 * error_m, "{tier}: {found:?}");
            let ratio = found.std_m.unwrap() / std_m;
            assert!((ratio - 1.0).abs() < 0.2, "{tier}: {ratio}");
            assert_eq!(found.correct_coarse_fraction.map(|right| right < 0.01), Some(true));
            let mean_distance_m = found.mean_distance_m.unwrap();
            assert!(
                (0.0..range_m).contains(&mean_distance_m)
                    && (0.0..range_m).contains(&found.true_distance_m)
            );
            assert!(fold(mean_distance_m - found.true_distance_m - bias_m).abs() < 1e-9);
        }
    }
}

#[test]
fn the_errors_do_wrap() {
    // Without circular statistics the test above would have nothing to find.
    let sensor = Sensor::new(&misled(5_000.0));
    let detector = DetectorIndex(0);
    let offset_ps = calibration_offset_ps(&sensor, detector, CountingTier::Sampled);
    let (mut signs, reporter) = ([0, 0], Reporter::new(&sensor, detector));
    scans(&sensor, detector, Tier::Sampled, 3, 100, |counts| {
        let signed: Vec<i64> = counts.iter().map(|count| count.signed).collect();
        let estimate = estimate(sensor.timing(), &signed, offset_ps).expect("there is light");
        let error_m = fold(estimate.distance_m - distance_m(5_000.0));
        signs[usize::from(error_m > 0.0)] += 1;
        // One scan against its expectation, the shorter way round.
        let report = reporter.scan(counts);
        let [bias_m, std_m] = [report.expected_bias_m, report.expected_std_m].map(Option::unwrap);
        assert!((fold(error_m - bias_m) / std_m).abs() < 6.0, "{report:?}");
    })
    .expect("the scene can be simulated");
    assert!(signs[0] > 0 && signs[1] > 0, "{signs:?}");
    // The other source's light says nothing of the own distance: without own light one scan in fifty has one.
    let dark = sensor.with(|scene| scene.paths = scene.paths.split_off(1));
    let mut told = 0;
    scans(&dark, detector, Tier::Sampled, 3, 100, |counts| {
        told += u32::from(reporter.scan(counts).distance_m.is_some());
    })
    .expect("the scene can be simulated");
    assert!(told <= 8, "{told}");
}

#[test]
fn estimates_all_round_the_period_have_no_mean() {
    let mut scene = table_i_scene(code(&[1, 0]), 5e3, 2_000);
    scene.detectors[0].background_rate_cps = 4e6;
    for tier in [Tier::Events, Tier::Expected] {
        let found = statistics(&scene, tier, 400);
        for value in [found.mean_distance_m, found.bias_m, found.std_m, found.expected_bias_m] {
            assert_eq!(value, None, "{tier}: {found:?}");
        }
        let remark = found.remark.expect("a remark");
        assert!(remark.contains("no mean") && remark.contains("unambiguous range"), "{remark}");
        // Half of the period is within a quarter of it on either side.
        let missed = found.missed_fraction.unwrap();
        assert!((missed - 0.5).abs() < 0.1, "{tier}: {missed}");
    }
    // No scan's error says more than it can, either.
    scans(&Sensor::new(&scene), DetectorIndex(0), Tier::Events, 3, 1, |counts| {
        let report = Reporter::new(&Sensor::new(&scene), DetectorIndex(0)).scan(counts);
        assert_eq!((report.expected_bias_m, report.deviation_in_std), (None, None));
        assert!(report.remark.is_some_and(|remark| remark.contains("no mean")));
    })
    .expect("the scene can be simulated");
}
