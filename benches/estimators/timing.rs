//! What a fit costs, and its parts.

use std::fs;

use goldtof::estimate::fit::{Fitter, OtherLight, fit};
use goldtof::photons::DetectorModel;
use goldtof::response::{CountSampler, MeanResponse, SecondMoments};
use goldtof::scene::{DetectorIndex, Scene};
use goldtof::sensor::Sensor;

use crate::{Outcome, TIER, cut_scan, set_detection_rate};
use goldtof::scan::Step;

/// Processor time of this thread, which others on the machine do not lengthen.
fn processor_ms() -> Outcome<f64> {
    let statistics = fs::read_to_string("/proc/thread-self/schedstat")?;
    let nanoseconds = statistics.split_whitespace().next().unwrap_or_default();
    Ok(nanoseconds.parse::<f64>()? * 1e-6)
}

pub fn milliseconds(times: u32, mut work: impl FnMut() -> Outcome) -> Outcome<f64> {
    let start = processor_ms()?;
    for _ in 0..times {
        work()?;
    }
    Ok((processor_ms()? - start) / f64::from(times))
}

pub fn timing(scene: &Scene) -> Outcome {
    println!("processor time in ms, one thread");
    for rate in [5e6, 20e6, 45e6] {
        let mut scene = scene.clone();
        set_detection_rate(&mut scene, rate)?;
        cut_scan(&mut scene, 14);
        scene.scan.integration_chips = 130_000;
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let response = MeanResponse::of_tier(&model, TIER)?;
        let second = SecondMoments::new(&response)?;
        let sampler = CountSampler::of(&model, &second).expect("finite moments");
        let solve = milliseconds(20, || {
            MeanResponse::of_tier(&model, TIER)?;
            Ok(())
        })?;
        let later = milliseconds(20, || {
            response.delayed(10.0).expect("it can be solved");
            Ok(())
        })?;
        let means = milliseconds(20, || {
            response.mean_counts();
            Ok(())
        })?;
        let states = milliseconds(5, || {
            SecondMoments::new(&response)?;
            Ok(())
        })?;
        let moments = milliseconds(10, || {
            second.of_step(Step(3));
            Ok(())
        })?;
        let mut repetition = 0;
        let whole = milliseconds(20, || {
            repetition += 1;
            fit(
                &Sensor::new(&scene),
                DetectorIndex(0),
                TIER,
                &sampler.scan(3, repetition),
                OtherLight::None,
            )?;
            Ok(())
        })?;
        let sensor = Sensor::new(&scene);
        let fitter = Fitter::new(&sensor, DetectorIndex(0), TIER, OtherLight::None);
        let one_of_many = milliseconds(400, || {
            repetition += 1;
            fitter.fit(&sampler.scan(3, repetition))?;
            Ok(())
        })?;
        println!(
            "  {:2.0} Mcps: mean response {solve:.2}, delayed {later:.2}, counts {means:.2}; \
             second moments {states:.2}, of a step {moments:.2}; a fit {whole:.1}, \
             one of 400 {one_of_many:.1}",
            rate / 1e6
        );
    }
    Ok(())
}
