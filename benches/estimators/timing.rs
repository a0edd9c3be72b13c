//! What a fit costs, and its parts.

use std::time::Instant;

use goldtof::estimate::model::{OtherLight, fit};
use goldtof::optics::{CountSampler, DetectorModel, MeanResponse, SecondMoments};
use goldtof::scene::Scene;

use crate::{Outcome, TIER, cut_scan, set_detection_rate};

fn milliseconds(times: u32, mut work: impl FnMut() -> Outcome) -> Outcome<f64> {
    let start = Instant::now();
    for _ in 0..times {
        work()?;
    }
    Ok(1e3 * start.elapsed().as_secs_f64() / f64::from(times))
}

pub fn timing(scene: &Scene) -> Outcome {
    println!("times in ms, one thread");
    for rate in [5e6, 20e6, 45e6] {
        let mut scene = scene.clone();
        set_detection_rate(&mut scene, rate)?;
        cut_scan(&mut scene, 14);
        scene.scan.integration_chips = 130_000;
        let model = DetectorModel::new(&scene, 0);
        let response = MeanResponse::of_tier(&model, TIER)?;
        let second = SecondMoments::new(&response)?;
        let sampler = CountSampler::of(&model, &second);
        let solve = milliseconds(20, || {
            MeanResponse::of_tier(&model, TIER)?;
            Ok(())
        })?;
        let later = milliseconds(20, || {
            response.delayed(10.0);
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
            second.of_step(3);
            Ok(())
        })?;
        let mut repetition = 0;
        let whole = milliseconds(20, || {
            repetition += 1;
            fit(
                &scene,
                0,
                TIER,
                &sampler.scan(3, repetition),
                OtherLight::None,
            )?;
            Ok(())
        })?;
        println!(
            "  {:2.0} Mcps: mean response {solve:.2}, delayed {later:.2}, counts {means:.2}; \
             second moments {states:.2}, of a step {moments:.2}; a fit {whole:.1}",
            rate / 1e6
        );
    }
    Ok(())
}
