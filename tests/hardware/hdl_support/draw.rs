//! Scenes drawn at random from the interface.

use goldtof::deliver::{Emission, EmittedFile, HdlError, Prefix, emit, verilog};
use goldtof::scene::{Architecture, FpgaTarget, Polarity, Registers, Scene, Share};
use goldtof::sensor::Sensor;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{Family, code, give_cells, scene};

/// How far a drawn scene may go.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    pub most_degree: u32,
    pub most_integration_chips: u64,
    pub most_steps: u64,
}

impl Extent {
    /// All that the interface has: hours of integration at 8 ns a chip.
    pub const WHOLE: Extent =
        Extent { most_degree: 16, most_integration_chips: 2_000_000_000_000, most_steps: u64::MAX };

    /// Scans of which a simulator runs several in a second.
    pub const SHORT: Extent =
        Extent { most_degree: 8, most_integration_chips: 600, most_steps: 150 };
}

/// Gains, and thresholds, of hardware that follows a target.
const SHARES: [Share; 4] = [Share::Whole, Share::Half, Share::Eighth, Share::Part128];

/// A scene that can be emitted, its emission, and why those drawn before it cannot.
pub fn emitted(
    rng: &mut Xoshiro256PlusPlus,
    extent: Extent,
    on_refusal: impl FnMut(String),
) -> (Scene, Emission) {
    emitted_with(rng, extent, Registers::None, on_refusal)
}

/// The same, of hardware with these registers.
pub fn emitted_with(
    rng: &mut Xoshiro256PlusPlus,
    extent: Extent,
    registers: Registers,
    on_refusal: impl FnMut(String),
) -> (Scene, Emission) {
    let draw = |rng: &mut _| match registers {
        Registers::None => draw(rng, extent),
        Registers::Axi4Lite => draw_hosted(rng, extent),
    };
    made(rng, draw, on_refusal, |sensor| emit(sensor, "goldtof emit random.toml"))
}

/// A scene that can be emitted, and the modules of its design.
pub fn modules(rng: &mut Xoshiro256PlusPlus, extent: Extent) -> (Scene, Vec<EmittedFile>) {
    made(
        rng,
        |rng| draw(rng, extent),
        |_| (),
        |sensor| verilog(sensor, &Prefix::default(), "goldtof emit random.toml"),
    )
}

fn made<T>(
    rng: &mut Xoshiro256PlusPlus,
    draw: impl Fn(&mut Xoshiro256PlusPlus) -> Scene,
    mut on_refusal: impl FnMut(String),
    make: impl Fn(&Sensor) -> Result<T, HdlError>,
) -> (Scene, T) {
    loop {
        let scene = draw(rng);
        match make(&Sensor::new(&scene)) {
            Ok(made) => return (scene, made),
            Err(limit @ (HdlError::Limit { .. } | HdlError::ShortStep { .. })) => {
                on_refusal(limit.to_string());
            }
            Err(error) => panic!("{error}"),
        }
    }
}

fn draw(rng: &mut Xoshiro256PlusPlus, extent: Extent) -> Scene {
    let sources = rng.random_range(1..=4);
    let codes: Vec<_> = (0..sources)
        .map(|_| {
            let interleave = rng.random_range(0..=4);
            code(draw_family(rng, extent), interleave, rng.random())
        })
        .collect();
    let reference = rng.random_range(0..sources);
    let lanes = 1 << rng.random_range(0..=4);
    let steps_per_period = u64::from(lanes) * codes[reference].len();
    let most_steps = steps_per_period.min(extent.most_steps);
    let (first, steps) = if most_steps == steps_per_period && rng.random() {
        (0, None)
    } else {
        let first = rng.random_range(0..steps_per_period);
        (first, Some(rng.random_range(1..=most_steps)))
    };
    let integration = draw_length(rng, extent.most_integration_chips);
    let width = rng.random_bool(0.3).then(|| rng.random_range(2..=24));
    let mut scene = scene(&codes, reference, lanes, first, steps, integration, width);
    if rng.random_bool(0.3) {
        scene.hardware.parallel = rng.random_range(2..=64);
    }
    if rng.random_bool(0.2) {
        scene.detectors.push(scene.detectors[0].clone());
    }
    scene.hardware.peak_detector = rng.random_bool(0.4);
    scene.hardware.total_counts = Some(rng.random());
    if rng.random_bool(0.3) {
        scene.hardware.target = FpgaTarget::Ice40Hx8k;
    }
    if rng.random_bool(0.2) {
        // With the shorter one, several samples of a word can be hits.
        let dead_time_ps = [14_000.0, 2_000.0][rng.random_range(0..=1)];
        scene.detectors.iter_mut().for_each(|d| d.dead_time_ps = dead_time_ps);
        keep_histogram(&mut scene, rng.random_range(1..=2));
    }
    if rng.random_bool(0.3) {
        scene.hardware.polarity = Polarity::Low;
    }
    // Drawn apart, so that nothing else is drawn otherwise.
    let rng = &mut rng.clone();
    if rng.random_bool(0.2) {
        let cells = rng.random_range(2..=9);
        give_cells(&mut scene, cells, rng.random_range(0..=cells + 1));
    }
    scene
}

/// A scene that a host sets; half of them follow a target.
fn draw_hosted(rng: &mut Xoshiro256PlusPlus, extent: Extent) -> Scene {
    let mut scene = loop {
        let scene = draw(rng, extent);
        let is_even = scene.scan.steps.is_multiple_of(scene.hardware.parallel.into());
        if scene.hardware.architecture == Architecture::UpDown && is_even {
            break scene;
        }
    };
    let hardware = &mut scene.hardware;
    hardware.registers = Registers::Axi4Lite;
    hardware.code_taps = rng.random();
    let window_steps = 2 * u64::from(scene.samples_per_chip);
    if rng.random() && window_steps <= scene.scan.steps_per_period {
        hardware.parallel = 1;
        hardware.peak_detector = true;
        hardware.track = true;
        hardware.track_gain = SHARES[rng.random_range(0..SHARES.len())];
        hardware.track_threshold = SHARES[rng.random_range(0..SHARES.len())];
        hardware.track_patience = rng.random_range(1..=15);
        scene.detectors.truncate(1);
        give_cells(&mut scene, 1, 1);
    }
    scene
}

/// A histogram of every phase step over whole code periods in place of up/down counts.
fn keep_histogram(scene: &mut Scene, buffers: u32) {
    let detector = &scene.detectors[0];
    let period = scene.sources[detector.reference].code.len();
    let chips = scene.scan.integration_chips.next_multiple_of(period);
    scene.scan.integration_chips = chips;
    scene.scan.first_step = 0;
    scene.scan.steps = scene.scan.steps_per_period;
    let hardware = &mut scene.hardware;
    hardware.architecture = Architecture::Histogram;
    hardware.buffers = buffers;
    hardware.parallel = 1;
    hardware.peak_detector = false;
    hardware.total_counts = None;
}

fn draw_family(rng: &mut Xoshiro256PlusPlus, extent: Extent) -> Family {
    match rng.random_range(0..8) {
        0..=3 => Family::Gold(rng.random_range(3..=extent.most_degree)),
        4 | 5 => Family::MSequence(rng.random_range(3..=extent.most_degree)),
        6 => Family::Square,
        _ => Family::Chips(rng.random_range(1..=300)),
    }
}

/// From 1 to `most`, each decade as likely as another.
fn draw_length(rng: &mut Xoshiro256PlusPlus, most: u64) -> u64 {
    let decades: f64 = rng.random();
    (most as f64).powf(decades) as u64
}
