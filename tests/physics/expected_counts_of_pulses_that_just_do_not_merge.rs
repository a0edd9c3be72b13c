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
    let settings = ["dead_time=15 ns", "jitter=[\"53.5 ps\"]", pulse_width];
    let settings = settings.map(|setting| format!("detector.{setting}").parse().unwrap());
    let settings: Vec<Setting> = settings.into();
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
    let far = means("pulse_width=13 ns");
    assert!(far.iter().all(|[_, total]| *total > 1.0));
    for near in ["pulse_width=13.9 ns", "pulse_width=14 ns"] {
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
