//! Scenes and codes for the tests of the emitted hardware, made without the
//! library's own generators.

pub mod block_testbench;
pub mod draw;
pub mod icarus;
pub mod naive_sensor;
pub mod stimulus;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, Mutex};

use goldtof::code::{Code, Generator, Lfsr};
use goldtof::deliver::{HdlError, emit};
use goldtof::scene::{
    CellOutputs, Combination, CounterTiming, Detector, EstimatorKind, FpgaTarget, Hardware,
    LEAST_CHIPS_OF_ROWS, LaserResponse, OtherLight, Polarity, Readout, Scan, Scene, Source,
    SourceClock, SourceIndex,
};
use goldtof::sensor::Sensor;

/// Chips of an LFSR, straight from the recurrence
/// c[t] = XOR over e > 0 of c[t - e].
pub fn recurrence(exponents: &[u32], seed: &[u8], length: usize) -> Vec<u8> {
    let mut chips = seed.to_vec();
    while chips.len() < length {
        let t = chips.len();
        let taps = exponents.iter().filter(|&&e| e > 0);
        chips.push(taps.fold(0, |sum, &e| sum ^ chips[t - e as usize]));
    }
    chips.truncate(length);
    chips
}

/// The `which`-th primitive polynomial of a degree, found by its period, once for all tests.
pub fn primitive(degree: u32, which: usize) -> Vec<u32> {
    static FOUND: Mutex<BTreeMap<(u32, usize), Vec<u32>>> = Mutex::new(BTreeMap::new());
    let mut found = FOUND.lock().expect("nobody has panicked");
    found.entry((degree, which)).or_insert_with(|| search_primitive(degree, which)).clone()
}

fn search_primitive(degree: u32, which: usize) -> Vec<u32> {
    let period = (1usize << degree) - 1;
    let is_primitive = |exponents: &[u32]| {
        let n = degree as usize;
        let chips = recurrence(exponents, &vec![1; n], 2 * period);
        (1..=period).find(|&shift| chips[shift..shift + n].iter().all(|&c| c == 1)) == Some(period)
    };
    (0u32..1 << (degree - 1))
        .map(|inner| {
            let middle = (1..degree).rev().filter(|e| inner >> (e - 1) & 1 == 1);
            std::iter::once(degree).chain(middle).chain([0]).collect()
        })
        .filter(|exponents: &Vec<u32>| is_primitive(exponents))
        .nth(which)
        .expect("every degree from 3 has two primitive polynomials")
}

pub fn lfsr(degree: u32, which: usize, seed_number: u32) -> Lfsr {
    Lfsr {
        degree,
        exponents: primitive(degree, which),
        seed: (0..degree).map(|i| (seed_number >> i & 1) as u8).collect(),
    }
}

/// One code family of the tests.
#[derive(Debug, Clone, Copy)]
pub enum Family {
    Gold(u32),
    MSequence(u32),
    Square,
    Chips(usize),
}

/// A code of `family`; `variant` picks seeds.
pub fn code(family: Family, interleave: u32, variant: u32) -> Arc<Code> {
    let seed = |n: u32| (variant.wrapping_mul(0x9e37_79b9) >> 7) % ((1 << n) - 1) + 1;
    let (generator, base) = match family {
        Family::Gold(n) => {
            let (u, v) = (lfsr(n, 0, (1 << n) - 1), lfsr(n, 1, seed(n)));
            let length = (1usize << n) - 1;
            let a = recurrence(&u.exponents, &u.seed, length);
            let b = recurrence(&v.exponents, &v.seed, length);
            let chips = a.iter().zip(&b).map(|(a, b)| a ^ b).collect();
            (Generator::Gold { u, v }, chips)
        }
        Family::MSequence(n) => {
            let u = lfsr(n, 0, seed(n));
            let chips = recurrence(&u.exponents, &u.seed, (1 << n) - 1);
            (Generator::MSequence(u), chips)
        }
        Family::Square => (Generator::Square, vec![1, 0]),
        Family::Chips(length) => {
            let mut state = variant.wrapping_mul(2_654_435_761) | 1;
            let chips: Vec<u8> = (0..length)
                .map(|_| {
                    state ^= state << 13;
                    state ^= state >> 17;
                    state ^= state << 5;
                    (state & 1) as u8
                })
                .collect();
            (Generator::Chips(chips.clone()), chips)
        }
    };
    Arc::new(Code { generator, interleave, chips: interleaved(&base, interleave) })
}

/// Eq. 23: every chip 2^nu times, every odd one inverted.
pub fn interleaved(base: &[u8], depth: u32) -> Vec<u8> {
    (0..base.len() << depth)
        .map(|i| base[i >> depth] ^ if depth > 0 { (i & 1) as u8 } else { 0 })
        .collect()
}

/// A scene with nothing but what the hardware needs.
pub fn scene(
    codes: &[Arc<Code>],
    reference: usize,
    samples_per_chip: u32,
    first_step: u64,
    steps: Option<u64>,
    integration_chips: u64,
    counter_width: Option<u32>,
) -> Scene {
    let steps_per_period = u64::from(samples_per_chip) * codes[reference].len();
    Scene {
        name: "test".into(),
        origin: Default::default(),
        chip_period_ps: 8000.0,
        samples_per_chip,
        sources: codes
            .iter()
            .enumerate()
            .map(|(m, code)| Source {
                name: format!("laser-{m}"),
                code: code.clone(),
                wavelength_nm: 783.0,
                mean_power_w: 4e-12,
                extinction_ratio: 10.0,
                response: LaserResponse::Ideal,
                clock: SourceClock::default(),
            })
            .collect(),
        detectors: vec![Detector {
            photon_detection_probability: 0.31,
            dark_count_rate_cps: 71e3,
            dead_time_ps: 14e3,
            afterpulsing_probability: 0.137,
            afterpulsing_time_constant_ps: 5e3,
            delay_ps: 1750.0,
            jitter_ps: vec![53.5, 4.0],
            counter: CounterTiming {
                rising_delay_ps: 340.0,
                falling_delay_ps: 390.0,
                transition_ps: 1.5,
            },
            ..Detector::ideal("spad", SourceIndex(reference), 7e3)
        }],
        paths: Vec::new(),
        scan: Scan {
            first_step,
            steps: steps.unwrap_or(steps_per_period),
            steps_per_period,
            integration_chips,
            requested_integration_ps: integration_chips as f64 * 8000.0,
        },
        estimator: EstimatorKind::Fft,
        other_light: OtherLight::Given,
        hardware: Hardware { counter_width, ..Hardware::default() },
        array: None,
    }
}

/// Where models are kept that are built alike in every run: Verilator's run-time library is
/// compiled once for all of them.
pub fn models() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("models")
}

/// What Verilator's makefiles are told where a model runs for moments: optimising it takes
/// three times as long as all else.
pub const PLAIN_MAKE: &str = "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0";

/// Runs goldtof in the package's folder.
pub fn goldtof(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_goldtof"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program is there")
}

/// Runs goldtof: exit status and the JSON that it printed.
pub fn goldtof_json(arguments: &[&str]) -> (Option<i32>, serde_json::Value) {
    let output = goldtof(arguments);
    let json = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    (output.status.code(), json)
}

/// Runs a tool and returns what it said; panics with it if it failed.
pub fn run(folder: &Path, tool: &str, arguments: &[&str]) -> String {
    // The script that starts Verilator's program takes longer than the program does for most designs.
    let program = if tool == "verilator" { "verilator_bin" } else { tool };
    let output = Command::new(program)
        .args(arguments)
        .env("MAKEFLAGS", PLAIN_MAKE)
        .current_dir(folder)
        .output()
        .unwrap_or_else(|error| panic!("{tool} is needed for this test: {error}"));
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(output.status.success(), "{tool} {arguments:?} failed:\n{said}");
    said
}

/// Any scene of the interface that is small enough to be simulated: all
/// families, depths, windows, widths, several detectors and steps at once.
pub fn random_scene(noise: &mut stimulus::Noise, case: u32) -> Scene {
    let family = match noise.below(6) {
        0 => Family::Square,
        1 => Family::Chips(1 + noise.below(70) as usize),
        2 => Family::MSequence(3 + noise.below(4) as u32),
        _ => Family::Gold(3 + noise.below(4) as u32),
    };
    let interleave = noise.below(5) as u32;
    let lanes = 1 << noise.below(5);
    let mut codes = vec![code(family, interleave, case)];
    for other in 0..noise.below(3) as u32 {
        let same = noise.below(3) == 0;
        codes.push(if same {
            codes[0].clone()
        } else {
            code(Family::Gold(3 + other), other, case + 7)
        });
    }
    let reference = noise.below(codes.len() as u64) as usize;
    let length = codes[reference].len();
    let period = length * lanes;
    let is_full = period < 300 && noise.below(3) == 0;
    let steps = (!is_full).then(|| 1 + noise.below(period.min(40)));
    let first = noise.below(period);
    let parallel = match noise.below(3) {
        0 => 1,
        1 => 1 + noise.below(6),
        _ => 1 + noise.below(40),
    };
    let parallel = parallel.min(steps.unwrap_or(period));
    let integration = match noise.below(4) {
        0 => 1 + noise.below(3),
        _ => 1 + noise.below(40),
    }
    .max(parallel.div_ceil(lanes));
    let width = (noise.below(3) == 0).then(|| 2 + noise.below(4) as u32);
    let mut scene = scene(&codes, reference, lanes as u32, first, steps, integration, width);
    scene.hardware.parallel = parallel as u32;
    if noise.below(3) == 0 {
        scene.hardware.target = FpgaTarget::Ice40Hx8k;
    }
    for number in 0..noise.below(3) as u32 {
        // Another code of the same length.
        scene.sources.push(Source {
            name: format!("further-{number}"),
            code: code(Family::Chips(length as usize), 0, case + 31 * number + 3),
            ..scene.sources[0].clone()
        });
        scene.detectors.push(Detector {
            name: format!("spad-{number}"),
            reference: SourceIndex(scene.sources.len() - 1),
            ..scene.detectors[0].clone()
        });
    }
    if case % 3 == 2 {
        scene.hardware.polarity = Polarity::Low;
    }
    scene.hardware.total_counts = Some(noise.below(2) == 0);
    with_peak_if_possible(&mut scene, noise.below(2) == 0);
    if case % 6 == 5 {
        read_by_rows_if_possible(&mut scene);
    }
    // As many as a record of 128 bits has room for.
    let most = (128 / (lanes * scene.detectors.len() as u64)).min(20);
    if case % 4 == 1 && most > 1 {
        let cells = 2 + noise.below(most - 1) as u32;
        give_cells(&mut scene, cells, noise.below(u64::from(cells) + 2) as u32);
    }
    scene
}

/// Gives every detector so many cells with an input each, of which so many have to fire; of 0 an odd
/// number. With more than there are all count, if a counter can take that.
pub fn give_cells(scene: &mut Scene, cells: u32, coincidence: u32) {
    let takes_all = scene.hardware.architecture == goldtof::scene::Architecture::UpDown;
    let combination = match coincidence {
        0 => Combination::Xor,
        _ if coincidence > cells && takes_all => Combination::Adder,
        _ => Combination::Or,
    };
    let most = if combination == Combination::Or { cells } else { 1 };
    for spad in &mut scene.detectors {
        spad.cells = cells;
        spad.cell_outputs = if cells > 1 { CellOutputs::Separate } else { CellOutputs::Combined };
        spad.coincidence = coincidence.clamp(1, most);
        spad.combination = combination;
    }
}

/// Reads several detectors out by rows, one step at a time, in windows of any number.
fn read_by_rows_if_possible(scene: &mut Scene) {
    let detectors = scene.detectors.len();
    if detectors < 2 || scene.hardware.architecture != goldtof::scene::Architecture::UpDown {
        return;
    }
    let chips = scene.scan.integration_chips.max(LEAST_CHIPS_OF_ROWS).max(detectors as u64);
    scene.scan.integration_chips = chips;
    scene.hardware = Hardware {
        readout: Readout::Rows,
        parallel: 1,
        counter_width: None,
        total_counts: Some(false),
        peak_detector: false,
        ..scene.hardware.clone()
    };
}

/// Adds a peak detector if it is `wanted` and phase steps are long enough for its comparisons.
pub fn with_peak_if_possible(scene: &mut Scene, wanted: bool) {
    scene.hardware.peak_detector = wanted;
    let emitted = emit(&Sensor::new(scene), "goldtof emit test.toml");
    scene.hardware.peak_detector &= !matches!(emitted, Err(HdlError::Limit { .. }));
}
