//! What the expected histogram, its covariances, the corrected phase and a fit to its bins cost.

use goldtof::estimate::CountingTier;
use goldtof::estimate::fit::BinFitter;
use goldtof::estimate::histogram::PhaseOfHistogram;
use goldtof::histogram::Histogram;
use goldtof::photons::DetectorModel;
use goldtof::response::{MeanResponse, SecondMoments};
use goldtof::scene::{Architecture, DetectorIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::histograms;

use crate::timing::milliseconds;
use crate::{Outcome, set_detection_rate};

const FIRST: DetectorIndex = DetectorIndex(0);
/// Code periods of a histogram.
const PERIODS: u64 = 70;

pub fn histogram(scene: &Scene) -> Outcome {
    println!("processor time in ms, one thread; histograms of {PERIODS} code periods");
    for rate in [1e6, 5e6, 20e6, 45e6] {
        let mut scene = scene.clone();
        set_detection_rate(&mut scene, rate)?;
        scene.hardware.architecture = Architecture::Histogram;
        scene.scan.integration_chips = PERIODS * scene.timing().code_chips();
        let sensor = Sensor::new(&scene);
        let model = DetectorModel::new(&sensor, FIRST);
        let means = milliseconds(20, || {
            MeanResponse::new(&model)?.mean_bins();
            Ok(())
        })?;
        let response = MeanResponse::new(&model)?;
        let bins = response.mean_bins();
        let covariance = milliseconds(10, || {
            let second = SecondMoments::new(&response)?;
            second.covariance_of_bin_sums(std::slice::from_ref(&bins));
            Ok(())
        })?;
        let mut made: Vec<Histogram> = Vec::new();
        histograms(&sensor, FIRST, Tier::Sampled, 3, 40, |histogram| made.push(histogram))?;
        let phase = PhaseOfHistogram::new(&sensor, FIRST, CountingTier::Sampled);
        let mut next = made.iter().cycle();
        let corrected = milliseconds(40, || {
            next.next().map(|histogram| phase.estimate(histogram)).transpose()?;
            Ok(())
        })?;
        let fitter = BinFitter::new(&sensor, FIRST)?;
        let mut steps = 0;
        let fitted = milliseconds(40, || {
            let fitted = next.next().map(|histogram| fitter.fit(histogram)).transpose()?;
            steps += fitted.map_or(0, |fitted| fitted.iterations);
            Ok(())
        })?;
        println!(
            "  {:2.0} Mcps: expected bins {means:.2}, variance of a sum of them {covariance:.2}, \
             corrected phase {corrected:.2}, fit {fitted:.1} ({:.1} steps)",
            rate / 1e6,
            f64::from(u32::try_from(steps)?) / 40.0
        );
    }
    Ok(())
}
