//! The tiers without photons, on the article's sensor: a full scan of 16,376
//! phase steps.
//!
//! Prints milliseconds (least and median of some rounds) of the whole `expected`
//! tier, of setting up the `counts` tier, and of each stage of both.
//!
//!     cargo bench --bench expected

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use goldtof::estimate::theory;
use goldtof::fidelity::Tier;
use goldtof::fidelity::simulate::simulate;
use goldtof::optics::{
    CountSampler, CountingTier, DetectorModel, MeanResponse, MeanResponseError, SecondMoments,
};
use goldtof::scene;

const ROUNDS: usize = 15;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = scene::load(Path::new("scenes/paper-single.toml"))?;
    let model = DetectorModel::new(&scene, 0);
    println!("whole tiers, {} phase steps", scene.scan.steps);
    measure("expected: prediction and bound", || {
        theory(&scene, 0, &[0], CountingTier::Events)
    });
    measure("expected: as the command does", || {
        simulate(&scene, Tier::Expected, 1, 1)
    });
    measure("counts: set-up and one scan", || {
        let response = MeanResponse::of_tier(&model, CountingTier::Events)?;
        let second = SecondMoments::new(&response)?;
        Ok::<_, MeanResponseError>(CountSampler::of(&model, &second).scan(1, 0))
    });
    for tier in [CountingTier::Events, CountingTier::Sampled] {
        println!("{tier:?}, {} phase steps", scene.scan.steps);
        measure("state equation and tables", || {
            MeanResponse::of_tier(&model, tier)
        });
        let response = MeanResponse::of_tier(&model, tier)?;
        measure("tables alone (another delay)", || response.delayed(10.0));
        measure("means of all steps", || response.mean_counts());
        measure("variances of the total count", || {
            SecondMoments::new(&response)
        });
        let second = SecondMoments::new(&response)?;
        measure("second moments of one step", || second.of_step(1000));
        measure("second moments of all steps", || second.of_scan());
    }
    Ok(())
}

fn measure<T>(what: &str, mut work: impl FnMut() -> T) {
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            black_box(work());
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("  {what:<34} {:8.2} {:8.2} ms", times[0], times[ROUNDS / 2]);
}
