//! The reference model in batches: from Python, with an array for every port, against the
//! same clocks in Rust, which gives the records that hold all ports.
//!
//!     cargo bench -p goldtof-python --bench batch
//!
//! Needs target/python with numpy, which scripts/python-tools installs. Prints, of
//! rounds that take turns, each one's shortest time and their ratio.

#[path = "../tests/package/mod.rs"]
mod package;

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use goldtof::batch::{Inputs, Model};
use goldtof::sensor::Sensor;

const CLOCKS: usize = 10_000_000;
const BLOCK: usize = 16_384;
const ROUNDS: usize = 7;
/// A pulse of two samples in a word of this many, and on: 10 million a second.
const WORDS_PER_PULSE: u64 = 12;

const SCRIPT: &str = r#"
import sys, time
import numpy as np
import goldtof
samples = np.fromfile(sys.argv[2], np.uint8)
reset = np.zeros(len(samples), np.uint8)
reset[:2] = 1
model = goldtof.ReferenceModel(goldtof.Scene.load(sys.argv[1]))
started = time.perf_counter()
outputs = model.clock(samples, reset)
took_s = time.perf_counter() - started
print(took_s, int(outputs["m_axis_tvalid"].sum()), len(model.take_results()["count"]))
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let scene = root.join("scenes/paper-single.toml");
    let samples = samples();
    let folder = package::folder();
    let file = folder.join("samples.bin");
    fs::write(&file, &samples)?;
    let python = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../python/bin/python");
    let (mut best_rust, mut best_python) = (f64::INFINITY, f64::INFINITY);
    let mut best_at_once = f64::INFINITY;
    for _ in 0..ROUNDS {
        let (took_s, beats) = in_rust(&scene, &samples, BLOCK)?;
        best_rust = best_rust.min(took_s);
        best_at_once = best_at_once.min(in_rust(&scene, &samples, CLOCKS)?.0);
        let ran = Command::new(&python)
            .args(["-P", "-c", SCRIPT])
            .args([&scene, &file])
            .env("PYTHONPATH", &folder)
            .output()?;
        let told = String::from_utf8(ran.stdout)?;
        let words: Vec<&str> = told.split_whitespace().collect();
        let [took_s, found, results] = words[..] else {
            return Err(String::from_utf8(ran.stderr)?.into());
        };
        assert_eq!((found, results), (&*beats.to_string(), &*beats.to_string()));
        best_python = best_python.min(took_s.parse()?);
    }
    println!(
        "{CLOCKS} clocks: {best_at_once:.3} s in Rust in one call, {best_rust:.3} s in blocks of \
         {BLOCK}; {best_python:.3} s from Python: {:.2} and {:.2} times",
        best_python / best_at_once,
        best_python / best_rust
    );
    Ok(())
}

/// Sample words without an aim.
fn samples() -> Vec<u8> {
    let mut state = 7u64;
    (0..CLOCKS)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let drawn = state >> 33;
            match drawn % WORDS_PER_PULSE {
                0 => 3 << (drawn / WORDS_PER_PULSE % 7),
                _ => 0,
            }
        })
        .collect()
}

/// Seconds that all clocks take, and the beats of the stream.
fn in_rust(scene: &Path, samples: &[u8], block: usize) -> Result<(f64, usize), Box<dyn Error>> {
    let mut model = Model::new(&Sensor::new(&goldtof::scene::load(scene)?))?;
    let mut reset = vec![0; samples.len()];
    reset[..2].fill(1);
    let valid = model.layout().outputs.field("m_axis_tvalid").clone();
    let words = model.layout().outputs.words;
    let (mut records, mut beats, mut took_s) = (Vec::new(), 0, 0.0);
    for (samples, reset) in samples.chunks(block).zip(reset.chunks(block)) {
        let inputs = Inputs {
            samples,
            reset,
            ready: &[],
        };
        let started = Instant::now();
        model.clock(&inputs, &mut records)?;
        took_s += started.elapsed().as_secs_f64();
        let records = records.chunks_exact(words);
        beats += records.filter(|record| valid.low_word(record) == 1).count();
    }
    Ok((took_s, beats))
}
