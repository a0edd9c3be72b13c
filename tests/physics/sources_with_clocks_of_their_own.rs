//! Other sensors' sources, whose clocks are not the detector's.

use goldtof::photons::DetectorModel;
use goldtof::response::{CountingTier, MeanCount, MeanResponse};
use goldtof::scan::Group;
use goldtof::scene::{DetectorIndex, Path, Scene, SourceClock, SourceIndex};
use goldtof::sensor::Sensor;

use optics_support::{code, gold, gold_5, ideal_scene, table_i_scene};

/// The own source is dark; the other one has one on-chip in seven.
fn flashes(clock: SourceClock, delay_chips: f64) -> Scene {
    let mut scene = ideal_scene(code(&[1, 1, 1, 0, 1, 0, 0]), 20e6, 2_000);
    let mut other = scene.sources[0].clone();
    other.name = "other".to_owned();
    other.code = code(&[1, 0, 0, 0, 0, 0, 0]);
    other.clock = clock;
    scene.sources.push(other);
    scene.paths[0] = Path {
        source: SourceIndex(1),
        delay_ps: delay_chips * scene.chip_period_ps,
        ..scene.paths[0].clone()
    };
    scene
}

/// Every photon was emitted while the other source's chip was on, by its own clock: at
/// t (1 + offset) + drift t^2 / 2 of it, t after the first scan began.
#[test]
fn photons_come_from_on_chips_by_their_sources_own_clock() {
    let clock = SourceClock { offset: 800e-6, drift_per_s: 8e-6 };
    let delay_chips = 3.3;
    let scene = flashes(clock, delay_chips);
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let chip_s = scene.chip_period_ps * 1e-12;
    let mut slipped = 0.0_f64;
    let mut detections = 0;
    for (repetition, group) in [(0, 0), (0, 7), (3, 5), (4_000, 11)] {
        let start = model.timing().first_chip(repetition, Group(group)).0 as f64;
        for detection in model.step(9, repetition, Group(group)) {
            let t = start + detection.chip as f64 + detection.fraction;
            let ahead = t * (clock.offset + 0.5 * clock.drift_per_s * chip_s * t);
            let place = (t - delay_chips + ahead).rem_euclid(7.0);
            assert!(
                !(1.0 + 1e-6..=7.0 - 1e-6).contains(&place),
                "{repetition} {group}: chip {place}"
            );
            slipped = slipped.max(ahead);
            detections += 1;
        }
    }
    // Some hundred photons, over many periods of slip.
    assert!(detections > 500 && slipped > 1e5, "{detections} {slipped}");
}

/// Own and other light at `rate_cps` each.
fn two_sensors(rate_cps: f64) -> Scene {
    let mut scene = table_i_scene(gold_5(), rate_cps, 31 * 1000);
    let mut other = scene.sources[0].clone();
    other.name = "other".to_owned();
    // The second sequence shifted by one chip: another code of the set.
    other.code = {
        let u = gold(5, &[5, 2], &[5, 4, 3, 2]).chips.clone();
        let v = optics_support::m_sequence(5, &[5, 4, 3, 2]);
        let chips: Vec<u8> = (0..31).map(|i| u[i] ^ v[i] ^ v[(i + 1) % 31]).collect();
        code(&chips)
    };
    scene.sources.push(other);
    scene.paths.push(Path { source: SourceIndex(1), ..scene.paths[0].clone() });
    scene
}

fn means(scene: &Scene) -> Vec<MeanCount> {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, CountingTier::Events).expect("it can be solved");
    response.mean_counts()
}

/// Expected counts of a source that runs away are those of constant light. Their truth is
/// the mean over all delays of the same source with the detector's clock; what is
/// left is dead time, which takes more of light that comes in chips.
#[test]
fn light_that_slips_is_constant_on_average_up_to_what_dead_time_makes_of_it() {
    for (rate_cps, most) in [(0.5e6, 0.004), (5e6, 0.02)] {
        let mut slipping = two_sensors(rate_cps);
        slipping.sources[1].clock.offset = 20e-6;
        let averaged = means(&slipping);
        let mut truth = vec![[0.0; 2]; averaged.len()];
        let delays = 31 * 2;
        for number in 0..delays {
            let mut scene = two_sensors(rate_cps);
            scene.paths[1].delay_ps = (f64::from(number) + 0.26) * 4_000.0;
            for (sum, mean) in truth.iter_mut().zip(means(&scene)) {
                sum[0] += mean.signed / f64::from(delays);
                sum[1] += mean.total / f64::from(delays);
            }
        }
        let peak = truth.iter().map(|mean| mean[0]).fold(0.0, f64::max);
        let worst = averaged.iter().zip(&truth).map(|(a, b)| (a.signed - b[0]).abs() / peak);
        let worst = worst.fold(0.0, f64::max);
        let totals = averaged[0].total / truth[0][1] - 1.0;
        println!("{rate_cps:.1e}: signed {worst:.2e} of the peak, totals {totals:.2e}");
        assert!(worst < most && totals.abs() < most, "{worst} {totals}");
        // One delay by itself is much further off.
        let one = means(&two_sensors(rate_cps));
        let off = one.iter().zip(&truth).map(|(a, b)| (a.signed - b[0]).abs() / peak);
        assert!(off.fold(0.0, f64::max) > 0.1);
    }
}
