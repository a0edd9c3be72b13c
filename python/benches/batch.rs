//! The reference model in batches, with an array for every port: from Python, against the
//! same calls in Rust; and in Rust without the arrays, its records thrown away.
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

use goldtof::batch::{BatchInputs, Model, PortValues};
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
    let mut best_records = f64::INFINITY;
    for _ in 0..ROUNDS {
        let (took_s, beats) = in_rust(&scene, &samples, true)?;
        best_rust = best_rust.min(took_s);
        best_records = best_records.min(in_rust(&scene, &samples, false)?.0);
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
        "{CLOCKS} clocks: {best_rust:.3} s in Rust, {best_python:.3} s from Python: {:.2} times; \
         {best_records:.3} s in Rust without arrays",
        best_python / best_rust
    );
    Ok(())
}

/// Sample words without an aim.
fn samples() -> Vec<u8> {
    let mut state = 7u64;
    (0..CLOCKS)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let drawn = state >> 33;
            match drawn % WORDS_PER_PULSE {
                0 => 3 << (drawn / WORDS_PER_PULSE % 7),
                _ => 0,
            }
        })
        .collect()
}

/// Seconds that all clocks take, with arrays of the ports or without, and the beats of the
/// stream.
fn in_rust(scene: &Path, samples: &[u8], with_ports: bool) -> Result<(f64, usize), Box<dyn Error>> {
    let mut model = Model::new(&Sensor::new(&goldtof::scene::load(scene)?))?;
    let mut reset = vec![0; samples.len()];
    reset[..2].fill(1);
    let layout = model.layout().outputs.clone();
    let (mut records, mut results) = (Vec::new(), 0);
    let started = Instant::now();
    let (narrow, wide): (Vec<_>, Vec<_>) = layout.fields.iter().partition(|f| f.port.width <= 8);
    assert!(wide.iter().all(|field| field.port.width <= 32));
    let clocks = if with_ports { samples.len() } else { 0 };
    let mut bytes = vec![vec![0; clocks]; narrow.len()];
    let mut words = vec![vec![0; clocks]; wide.len()];
    for first in (0..samples.len()).step_by(BLOCK) {
        let block = first..(first + BLOCK).min(samples.len());
        let inputs = BatchInputs {
            samples: &samples[block.clone()],
            reset: &reset[block],
            ready: &[],
            host: &[],
        };
        model.clock(&inputs, &mut records)?;
        results += model.take_results().count();
        if with_ports {
            for (field, to) in narrow.iter().zip(&mut bytes) {
                PortValues::U8(to).copy(&records, layout.words, field, first);
            }
            for (field, to) in wide.iter().zip(&mut words) {
                PortValues::U32(to).copy(&records, layout.words, field, first);
            }
        }
    }
    Ok((started.elapsed().as_secs_f64(), results))
}
