//! Jitter makes pulses reach each other that are a little more than a sample apart
//! without it: the detector is treated as one whose pulses merge, though none of its
//! detections waits for a sample.

use std::path::Path;

use goldtof::recorded::expected_csv;
use goldtof::response::CountingTier;
use goldtof::scene::{self, Setting};
use goldtof::sensor::Sensor;

/// Means of the signed and the total count of every step, dead time 15 ns, samples 1 ns.
fn means(pulse_width: &str) -> Vec<[f64; 2]> {
    means_of(&["detector.dead_time=15 ns", "detector.jitter=[\"53.5 ps\"]", pulse_width])
}

fn means_of(settings: &[&str]) -> Vec<[f64; 2]> {
    let settings: Vec<Setting> = settings.iter().map(|setting| setting.parse().unwrap()).collect();
    let scene = scene::load_with(Path::new("scenes/quick.toml"), &settings).unwrap();
    let csv = expected_csv(&Sensor::new(&scene), CountingTier::Sampled).unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let heading = reader.headers().unwrap().clone();
    let column = |name: &str| heading.iter().position(|found| found == name).unwrap();
    let columns = [column("count_mean"), column("total_count_mean")];
    let records = reader.records().map(Result::unwrap);
    records.map(|record| columns.map(|column| record[column].parse().unwrap())).collect()
}

#[test]
fn they_count_as_pulses_that_never_merge() {
    let far = means("detector.pulse_width=13 ns");
    assert!(far.iter().all(|[_, total]| *total > 1.0));
    for near in ["detector.pulse_width=13.9 ns", "detector.pulse_width=14 ns"] {
        let near_means = means(near);
        assert_eq!(near_means.len(), far.len());
        for (step, (near_mean, far_mean)) in near_means.iter().zip(&far).enumerate() {
            for (a, b) in near_mean.iter().zip(far_mean) {
                let tolerance = 1e-3 * far_mean[1];
                assert!((a - b).abs() < tolerance, "{near}, step {step}: {a} and {b}");
            }
        }
    }
}

/// Darkness without dead time: a sample counts where a detection is within the sample period before
/// it, and none within the three periods before that, which pulses of three samples would reach into.
/// A femtosecond more or less makes no difference.
#[test]
fn pulses_of_whole_samples_or_nearly_merge_as_poisson_statistics_say() {
    let detections: f64 = 0.03;
    let counted = (1.0 - (-detections).exp()) * (-3.0 * detections).exp();
    // Samples of a step of 20 us.
    let expected = 20_000.0 * counted;
    for width in
        ["3 ns", "2.999999 ns", "3.0000005 ns", "3.000001 ns", "3.0000015 ns", "3.000002 ns"]
    {
        let width = format!("detector.pulse_width={width}");
        let means = means_of(&[
            "detector.dead_time=0 ns",
            "detector.afterpulsing.probability=0",
            "detector.jitter=[]",
            "detector.dark_count_rate=30 Mcps",
            "source.mean_power=1e-9 pW",
            &width,
        ]);
        for [_, total] in means {
            assert!((total / expected - 1.0).abs() < 1e-5, "{width}: {total}, not {expected}");
        }
    }
}
