//! What wrong parameters of detector and light cost: exact counts of the true
//! detector, fitted with wrong ones.

use goldtof::estimate::fit::{OtherLight, fit_means};
use goldtof::scene::{DetectorIndex, Scene};
use goldtof::sensor::Sensor;

use crate::{Outcome, TIER, cut_scan, error_mm, set_detection_rate};
use optics_support::stepped::Stepped;

/// What the true detector has, and what the fit believes.
struct Mistake {
    name: &'static str,
    truth: fn(&mut Scene, f64),
    belief: fn(&mut Scene),
}

const MISTAKES: [Mistake; 11] = [
    Mistake { name: "none", truth: |_, _| {}, belief: |_| {} },
    Mistake {
        name: "dead time + 0.1 ns",
        truth: |_, _| {},
        belief: |s| s.detectors[0].dead_time_ps += 100.0,
    },
    Mistake {
        name: "dead time - 0.1 ns",
        truth: |_, _| {},
        belief: |s| s.detectors[0].dead_time_ps -= 100.0,
    },
    Mistake {
        name: "afterpulsing + 1 %",
        truth: |_, _| {},
        belief: |s| s.detectors[0].afterpulsing_probability += 0.01,
    },
    Mistake {
        name: "afterpulsing - 1 %",
        truth: |_, _| {},
        belief: |s| s.detectors[0].afterpulsing_probability -= 0.01,
    },
    Mistake {
        name: "extinction ratio + 10 %",
        truth: |_, _| {},
        belief: |s| s.sources[0].extinction_ratio *= 1.1,
    },
    Mistake {
        name: "extinction ratio - 10 %",
        truth: |_, _| {},
        belief: |s| s.sources[0].extinction_ratio *= 0.9,
    },
    Mistake {
        name: "ambient a third, none believed",
        truth: |s, rate_cps| s.detectors[0].background_rate_cps = rate_cps / 3.0 / 0.31,
        belief: |s| s.detectors[0].background_rate_cps = 0.0,
    },
    Mistake {
        name: "dark counts twice as many",
        truth: |s, _| s.detectors[0].dark_count_rate_cps *= 2.0,
        belief: |s| s.detectors[0].dark_count_rate_cps /= 2.0,
    },
    Mistake {
        name: "jitter + 10 %",
        truth: |_, _| {},
        belief: |s| s.detectors[0].jitter_ps[0] *= 1.1,
    },
    Mistake {
        name: "detector delay + 10 ps",
        truth: |_, _| {},
        belief: |s| s.detectors[0].delay_ps += 10.0,
    },
];

pub fn wrong(scene: &Scene) -> Outcome {
    println!("wrong parameters in the fit, without noise: bias in mm, in brackets how many");
    println!("standard deviations chi-square of a scan of 1.04 ms is raised by (5 are an alarm)");
    let rates = [1e6, 5e6, 10e6, 20e6, 30e6, 45e6];
    print!("  {:30}", "detected Mcps");
    for rate in rates {
        print!("{:>17.0}", rate / 1e6);
    }
    println!();
    for mistake in MISTAKES {
        print!("  {:30}", mistake.name);
        for rate in rates {
            let mut scene = scene.clone();
            (mistake.truth)(&mut scene, rate);
            scene.paths[0].delay_ps = 21_350.0;
            set_detection_rate(&mut scene, rate)?;
            scene.scan.integration_chips = 64 * scene.sources[0].code.len();
            cut_scan(&mut scene, 14);
            let counts = Stepped::new(&scene, 25.0).counts();
            let mut believed = scene.clone();
            (mistake.belief)(&mut believed);
            let fitted = fit_means(
                &Sensor::new(&believed),
                DetectorIndex(0),
                TIER,
                &counts,
                OtherLight::None,
            )?;
            let raised = fitted.chi_square / (2.0 * fitted.degrees_of_freedom as f64).sqrt();
            print!("  {:8.3} ({raised:4.1})", error_mm(&scene, fitted.delay_ps));
        }
        println!();
    }
    Ok(())
}
