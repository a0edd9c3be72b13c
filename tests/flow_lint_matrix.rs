//! Scenes drawn at random from the whole contract: no tool has anything to say
//! about their Verilog, and no warning is waived.

mod hdl_support;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use goldtof::hdl::{Emission, HdlError, emit, write};
use goldtof::scene::Scene;
use hdl_support::{Family, code, run, scene};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Scenes that are linted; those that `emit` refuses are drawn again.
const SCENES: usize = 200;
const SEED: u64 = 20_231_115;

fn draw_family(rng: &mut Xoshiro256PlusPlus) -> Family {
    match rng.random_range(0..8) {
        0..=3 => Family::Gold(rng.random_range(3..=16)),
        4 | 5 => Family::MSequence(rng.random_range(3..=16)),
        6 => Family::Square,
        _ => Family::Chips(rng.random_range(1..=300)),
    }
}

/// From 1 to `most`, each decade as likely as another.
fn draw_length(rng: &mut Xoshiro256PlusPlus, most: u64) -> u64 {
    let decades: f64 = rng.random();
    (most as f64).powf(decades) as u64
}

fn draw(rng: &mut Xoshiro256PlusPlus) -> Scene {
    let sources = rng.random_range(1..=4);
    let codes: Vec<_> = (0..sources)
        .map(|_| {
            let interleave = rng.random_range(0..=4);
            code(draw_family(rng), interleave, rng.random())
        })
        .collect();
    let reference = rng.random_range(0..sources);
    let lanes = 1 << rng.random_range(0..=4);
    let steps_per_period = u64::from(lanes) * codes[reference].len();
    let (first, steps) = if rng.random() {
        (0, None)
    } else {
        let first = rng.random_range(0..steps_per_period);
        (first, Some(rng.random_range(1..=steps_per_period)))
    };
    // Hours of integration at 8 ns a chip.
    let dwell = draw_length(rng, 2_000_000_000_000);
    let width = rng.random_bool(0.3).then(|| rng.random_range(2..=24));
    let mut scene = scene(&codes, reference, lanes, first, steps, dwell, width);
    if rng.random_bool(0.3) {
        scene.hardware.parallel = rng.random_range(2..=64);
    }
    if rng.random_bool(0.2) {
        scene.detectors.push(scene.detectors[0].clone());
    }
    scene
}

/// Design and bench under Verilator, Icarus and Yosys; what they said.
fn lint(emission: &Emission, folder: &Path) -> String {
    write(emission, folder).expect("the files can be written");
    // Warnings do not end the run, so that all tools get their say.
    let wall = ["--lint-only", "-Wall", "--timing", "-Wno-fatal"];
    let verilator = |top, list| {
        let arguments = [&wall[..], &["--top-module", top, "-f", list]].concat();
        run(folder, "verilator", &arguments)
    };
    let icarus = [
        "-Wall",
        "-g2005",
        "-s",
        "sensor_top_tb",
        "-o",
        "lint.vvp",
        "-f",
        "sensor_top_tb.f",
    ];
    let files: Vec<&str> = emission.files.iter().map(|f| f.name.as_str()).collect();
    let script = format!(
        "read_verilog {}; hierarchy -check -top sensor_top; proc; check -assert; \
         select -assert-none t:$dlatch t:$_DLATCH_*",
        files.join(" ")
    );
    verilator("sensor_top", "sensor_top.f")
        + &verilator("sensor_top_tb", "sensor_top_tb.f")
        + &run(folder, "iverilog", &icarus)
        + &run(folder, "yosys", &["-q", "-p", &script])
}

#[test]
fn two_hundred_random_scenes_are_clean_under_four_tools() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(SEED);
    let mut refused = BTreeMap::<String, usize>::new();
    let mut emissions = Vec::new();
    while emissions.len() < SCENES {
        match emit(&draw(&mut rng), "goldtof emit random.toml") {
            Ok(emission) => emissions.push(emission),
            Err(limit @ (HdlError::Limit { .. } | HdlError::ShortStep { .. })) => {
                let reason = limit.to_string();
                let kind = reason.split([':', ',']).next().unwrap_or_default();
                let kind = kind.trim_end_matches(|c: char| c.is_ascii_digit());
                *refused.entry(kind.to_owned()).or_default() += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder_of = |number: usize| folder.path().join(format!("scene-{number}"));
    let next = AtomicUsize::new(0);
    let said = Mutex::new(String::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(emission) = emissions.get(number) else {
                        return;
                    };
                    let words = lint(emission, &folder_of(number));
                    if !words.is_empty() {
                        let parameters = &emission.parameters;
                        *said.lock().expect("no panic") += &format!("{parameters:?}\n{words}\n");
                    }
                }
            });
        }
    });
    let said = said.into_inner().expect("no panic");
    assert!(said.is_empty(), "{said}");
    let folders: Vec<String> = (0..SCENES)
        .map(|number| folder_of(number).display().to_string())
        .collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // Beside the target's temporary folder, where scripts/python-tools puts it.
    let python = concat!(env!("CARGO_TARGET_TMPDIR"), "/../python/bin/python");
    let mut arguments = vec!["scripts/slang-lint"];
    arguments.extend(folders.iter().map(String::as_str));
    assert_eq!(run(root, python, &arguments), "", "slang");
    println!("{SCENES} scenes clean; drawn again:");
    for (reason, times) in refused {
        println!("{times:4} {reason}");
    }
}
