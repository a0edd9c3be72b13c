//! The tiers without photons, on the article's sensor: a full scan of 16,376
//! phase steps.
//!
//! Prints milliseconds of the whole `expected` tier, of setting up the `counts`
//! tier, and of each stage of both: processor time of all threads, which other
//! programs do not change much, and wall time; the least of some rounds.
//!
//!     cargo bench --bench expected

use goldtof::Jobs as _;
use goldtof::scene::{DetectorIndex, PathIndex};
use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use goldtof::estimate::theory;
use goldtof::photons::DetectorModel;
use goldtof::response::{
    CountSampler, CountingTier, MeanResponse, MeanResponseError, SecondMoments,
};
use goldtof::scan::Step;
use goldtof::scene;
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use rustix::time::{ClockId, clock_gettime};

const ROUNDS: usize = 15;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = scene::load(Path::new("scenes/paper-single.toml"))?;
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    println!("whole tiers, {} phase steps", scene.scan.steps);
    measure("expected: prediction and bound", || {
        theory(&Sensor::new(&scene), DetectorIndex(0), &[PathIndex(0)], CountingTier::Events)
    });
    measure("expected: as the command does", || {
        Sensor::new(&scene).simulate(Tier::Expected.scans(1))
    });
    measure("counts: set-up and one scan", || {
        let response = MeanResponse::of_tier(&model, CountingTier::Events)?;
        let second = SecondMoments::new(&response)?;
        Ok::<_, MeanResponseError>(CountSampler::of(&model, &second)?.scan(1, 0))
    });
    for tier in [CountingTier::Events, CountingTier::Sampled] {
        println!("{tier:?}, {} phase steps", scene.scan.steps);
        measure("state equation and tables", || MeanResponse::of_tier(&model, tier));
        let response = MeanResponse::of_tier(&model, tier)?;
        measure("tables alone (another delay)", || {
            response.delayed(10.0).expect("it can be solved")
        });
        measure("means of all steps", || response.mean_counts());
        measure("variances of the total count", || SecondMoments::new(&response));
        let second = SecondMoments::new(&response)?;
        measure("second moments of one step", || second.of_step(Step(1000)));
        measure("second moments of all steps", || second.of_scan());
    }
    Ok(())
}

fn measure<T>(what: &str, mut work: impl FnMut() -> T) {
    let (mut processor_ms, mut wall_ms) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        let (wall, processor) = (Instant::now(), processor_time_ms());
        black_box(work());
        wall_ms = wall_ms.min(wall.elapsed().as_secs_f64() * 1e3);
        processor_ms = processor_ms.min(processor_time_ms() - processor);
    }
    println!("  {what:<34} {processor_ms:8.2} ms of processor time {wall_ms:8.2} ms");
}

/// Of all threads so far.
fn processor_time_ms() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}
