//! What is expected of scans, held against photons: where the coarse stage wavers between steps,
//! where steps share their light, and where nothing can be expected.

use std::path::Path;

use crate::optics_support::{gold_5, table_i_scene};
use goldtof::scene::{Scene, load_with};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::path_statistics::PathStatistics;
use goldtof::simulate::repeat::{Simulation, simulate};

fn simulated(scene: &Scene, tier: Tier, scans: u64) -> Simulation {
    simulate(&Sensor::new(scene), tier, 5, scans).expect("it can be simulated")
}

fn of_first_path(scene: &Scene, tier: Tier, scans: u64) -> PathStatistics {
    simulated(scene, tier, scans).estimates.into_iter().next().expect("its path")
}

/// Two samples a chip, and light half-way between two phase steps: either may count most, and
/// the phase round it is another. Its linearisation says half of the scatter.
#[test]
fn scatter_of_a_coarse_stage_that_wavers_is_expected() {
    for (parallel, rate_cps) in [(1, 4e6), (31, 4e6), (1, 1e6)] {
        let mut scene = table_i_scene(gold_5(), rate_cps, 31 * 60);
        scene.samples_per_chip = 2;
        scene.scan.steps = 62;
        scene.hardware.parallel = parallel;
        for steps in [20.25, 20.5, 20.9] {
            scene.paths[0].delay_ps = steps * 4000.0 - 1750.0 - 4000.0;
            let found = of_first_path(&scene, Tier::Sampled, 400);
            let told = format!("{parallel} {rate_cps} {steps}: {found:?}");
            assert_eq!(found.expectation_holds, Some(true), "{told}");
            let [std_m, expected_m] = [found.std_m, found.expected_std_m].map(Option::unwrap);
            // Standard error of 400 scans: 3.5 %.
            assert!((std_m / expected_m - 1.0).abs() < 0.2, "{told}");
            let bias_m = found.bias_m.unwrap() - found.expected_bias_m.unwrap();
            assert!(bias_m.abs() < 5.0 * std_m / 20.0 + 1e-3, "{told}");
        }
    }
}

/// Light at 3.2 m in a scan round 25 m.
#[test]
fn nothing_is_expected_of_a_path_that_the_scan_does_not_come_by() {
    let window = "scan.steps={ around = \"25 m\", halfwidth = 16 }".parse().expect("a setting");
    let scene = load_with(Path::new("scenes/quick.toml"), &[window]).expect("it is sound");
    for tier in [Tier::Expected, Tier::Counts, Tier::Events, Tier::Sampled] {
        let found = of_first_path(&scene, tier, 20);
        let values = [found.expected_bias_m, found.expected_std_m, found.expected_missed_fraction];
        assert_eq!(values, [None; 3], "{tier}");
        assert_eq!(found.expectation_holds, None, "{tier}");
        let remark = found.remark.expect("a remark");
        assert!(remark.contains("the true delay is in the scan"), "{tier}: {remark}");
    }
}
