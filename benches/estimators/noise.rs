//! Biases and scatter with noise: many scans drawn by the counts tier.

use goldtof::Jobs as _;
use goldtof::scene::{EstimatorKind, OtherLight, Scene};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::path_statistics::PathStatistics;

use crate::noiseless::{add_interferer, gold};
use crate::{Outcome, cut_scan, set_detection_rate};

const SEED: u64 = 20_231;

fn statistics(scene: &Scene, estimator: EstimatorKind, scans: u64) -> Outcome<PathStatistics> {
    let mut scene = scene.clone();
    scene.estimator = estimator;
    let mut simulation = Sensor::new(&scene).simulate(Tier::Counts.scans(scans).seeded(SEED))?;
    Ok(simulation.estimates.swap_remove(0))
}

fn mm(metres: Option<f64>) -> f64 {
    metres.map_or(f64::NAN, |m| m * 1e3)
}

/// Bias and standard deviation of both estimators from 1 to 45 Mcps.
pub fn walk(scene: &Scene) -> Outcome {
    println!("walk at 3.2 m with noise, counts tier: errors in mm");
    println!(
        "  detected Mcps, integration |  phase bias     std |  model bias  +-s.e.     std   bound  std/bound +-s.e.  alarms"
    );
    for (integration_chips, name, scans) in
        [(130_000, "1.04 ms", 4_000), (13_100, "104.8 us", 4_000)]
    {
        for rate in [1e6, 2e6, 5e6, 10e6, 20e6, 30e6, 45e6] {
            let mut scene = scene.clone();
            set_detection_rate(&mut scene, rate)?;
            scene.scan.integration_chips = integration_chips;
            cut_scan(&mut scene, 14);
            let phase = statistics(&scene, EstimatorKind::Fft, scans)?;
            let model = statistics(&scene, EstimatorKind::Model, scans)?;
            let relative = 1.0 / (2.0 * (model.estimates as f64 - 1.0)).sqrt();
            let ratio = model.std_over_bound.unwrap_or(f64::NAN);
            println!(
                "  {:4.0} {name:>9} | {:9.3} {:9.3} | {:9.3} {:7.3} {:8.3} {:8.3}  {ratio:.3} +-{:.3}  {:.4}  ({} of {scans})",
                rate / 1e6,
                mm(phase.bias_m),
                mm(phase.std_m),
                mm(model.bias_m),
                mm(model.bias_std_error_m),
                mm(model.std_m),
                mm(model.bound_m),
                ratio * relative,
                model.chi_square_alarm_fraction.unwrap_or(f64::NAN),
                model.estimates,
            );
        }
    }
    Ok(())
}

/// An equal-power interferer at many relative delays, code given and searched for.
pub fn interference(scene: &Scene) -> Outcome {
    println!("equal-power interferer, 10 Mcps in all, 10.4 ms, counts tier: errors in mm");
    println!(
        "  relative delay | phase bias |  given bias +-s.e.  std/bound |  found bias +-s.e.  scans with the target"
    );
    let code = gold(417)?;
    let scans = 24;
    let mut worst: f64 = 0.0;
    for chips in
        [-700.37, -3.1, -1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 1.7, 2.6, 12.45, 333.3, 1023.5]
    {
        let mut scene = scene.clone();
        add_interferer(&mut scene, &code, chips);
        set_detection_rate(&mut scene, 10e6)?;
        scene.scan.integration_chips = 1_300_000;
        let phase = statistics(&scene, EstimatorKind::Fft, 4)?;
        scene.other_light = OtherLight::Given;
        let given = statistics(&scene, EstimatorKind::Model, scans)?;
        scene.other_light = OtherLight::Search;
        let found = statistics(&scene, EstimatorKind::Model, 6)?;
        worst = worst.max(mm(given.bias_m).abs());
        println!(
            "  {chips:8.2} chips | {:10.3} | {:9.3} {:7.3}  {:.3} | {:9.3} {:7.3}  {}",
            mm(phase.bias_m),
            mm(given.bias_m),
            mm(given.bias_std_error_m),
            given.std_over_bound.unwrap_or(f64::NAN),
            mm(found.bias_m),
            mm(found.bias_std_error_m),
            found.estimates,
        );
    }
    println!("  largest bias with the code given: {worst:.3} mm");
    Ok(())
}
