//! A part of the simulation that a scene does without, put back with its neutral
//! parameter, changes no bit of any result for the same seed.

use goldtof::photons::fast::StepCounter;
use goldtof::photons::{DetectorModel, OptionalPart, Pulse, PulseStream, StepCount, count_step};
use goldtof::scan::{Sample, Step};
use goldtof::scene::{DetectorIndex, Path, Scene};
use goldtof::sensor::Sensor;
use optics_support::{code, gold_5, m_sequence, table_i_scene};
use proptest::prelude::*;

/// What a random scene has of everything that may be left out.
#[derive(Debug, Clone)]
struct Choice {
    code: u8,
    rate_cps: f64,
    extinct: bool,
    dark: bool,
    dead_time_ps: f64,
    afterpulsing: f64,
    jitter: bool,
    transition: bool,
    second_path: bool,
    delay_ps: f64,
    parallel: u32,
    first_step: u64,
    steps: u64,
    chips: u64,
}

fn choices() -> impl Strategy<Value = Choice> {
    let light = (0_u8..3, 0.0..60e6, any::<bool>(), any::<bool>());
    let detector = (
        prop_oneof![Just(0.0), 500.0..40e3],
        prop_oneof![Just(0.0), 0.01..0.4],
        any::<bool>(),
        any::<bool>(),
    );
    let path = (any::<bool>(), 0.0..300e3);
    let scan = (1_u32..4, 0_u64..48, 1_u64..40, 1_u64..400);
    (light, detector, path, scan).prop_map(
        |(
            (code, rate_cps, extinct, dark),
            (dead_time_ps, afterpulsing, jitter, transition),
            (second_path, delay_ps),
            (parallel, first_step, steps, chips),
        )| Choice {
            code,
            rate_cps,
            extinct,
            dark,
            dead_time_ps,
            afterpulsing,
            jitter,
            transition,
            second_path,
            delay_ps,
            parallel,
            first_step,
            steps,
            chips,
        },
    )
}

fn scene_of(choice: &Choice) -> Scene {
    let code = match choice.code {
        0 => gold_5(),
        1 => code(&m_sequence(3, &[3, 2])),
        _ => code(&[1, 0]),
    };
    let mut scene = table_i_scene(code, choice.rate_cps, choice.chips);
    scene.sources[0].extinction_ratio = if choice.extinct { f64::INFINITY } else { 10.0 };
    scene.paths[0].delay_ps = choice.delay_ps;
    if choice.second_path {
        scene.paths.push(Path {
            delay_ps: 2.5 * choice.delay_ps,
            transmission: 0.4,
            ..scene.paths[0].clone()
        });
    }
    let spad = &mut scene.detectors[0];
    if choice.dark {
        spad.dark_count_rate_cps = 0.0;
    }
    spad.dead_time_ps = choice.dead_time_ps;
    spad.pulse_width_ps = 0.5 * choice.dead_time_ps.max(2e3);
    spad.afterpulsing_probability = choice.afterpulsing;
    if !choice.jitter {
        spad.jitter_ps.clear();
    }
    if !choice.transition {
        spad.counter.transition_ps = 0.0;
    }
    scene.hardware.parallel = choice.parallel;
    let period = scene.scan.steps_per_period;
    scene.scan.first_step = choice.first_step % period;
    scene.scan.steps = choice.steps.min(period);
    scene
}

fn pulses(model: &DetectorModel, mut stream: PulseStream) -> Vec<Pulse> {
    let samples = model.timing().groups() * model.timing().scan.integration_chips * 8;
    let mut pulses = Vec::new();
    stream.advance(Sample(samples), &mut pulses);
    pulses
}

fn plain_pulses(model: &DetectorModel, seed: u64) -> Vec<Pulse> {
    pulses(model, PulseStream::of_plain_loop(model, seed, 1))
}

fn plain_counts(model: &DetectorModel, seed: u64) -> Vec<StepCount> {
    let count = |step| count_step(model, seed, 1, Step(step));
    (0..model.timing().scan.steps).map(count).collect()
}

/// Counts and pulses of the vector lanes; none if they cannot do the model.
fn in_lanes(model: &DetectorModel, seed: u64) -> Option<(Vec<StepCount>, Vec<Pulse>)> {
    let counter = StepCounter::new(model);
    let steps = model.timing().scan.steps;
    let mut counts = vec![StepCount::ZERO; steps as usize];
    counter.count(seed, 1..2, 0..steps, &mut counts);
    let pulses = || pulses(model, PulseStream::new(model, seed, 1));
    counter.outside_domain().is_none().then(|| (counts, pulses()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn specialised_and_full_path_agree_bit_for_bit(choice in choices(), seed: u64) {
        let specialised = DetectorModel::new(&Sensor::new(&scene_of(&choice)), DetectorIndex(0));
        let expected = (plain_pulses(&specialised, seed), plain_counts(&specialised, seed));
        let full = specialised.full();
        prop_assert_eq!(&(plain_pulses(&full, seed), plain_counts(&full, seed)), &expected);
        for part in OptionalPart::ALL {
            let with = specialised.with_neutral(part);
            let found = (plain_pulses(&with, seed), plain_counts(&with, seed));
            prop_assert_eq!(&found, &expected, "{:?}", part);
        }
        if let Some(expected) = in_lanes(&specialised, seed) {
            let mut together = specialised.clone();
            for part in OptionalPart::ALL {
                let with = in_lanes(&specialised.with_neutral(part), seed);
                prop_assert_eq!(with.as_ref(), Some(&expected), "{:?} in lanes", part);
                together = together.with_neutral(part);
            }
            prop_assert_eq!(in_lanes(&together, seed), Some(expected));
        }
    }
}

/// The property above would hold of parts that are never put back.
#[test]
fn a_part_that_is_put_back_is_at_work() {
    let mut scene = table_i_scene(gold_5(), 20e6, 100);
    scene.sources[0].extinction_ratio = f64::INFINITY;
    let spad = &mut scene.detectors[0];
    spad.dark_count_rate_cps = 0.0;
    spad.afterpulsing_probability = 0.0;
    spad.jitter_ps.clear();
    let specialised = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    for part in OptionalPart::ALL {
        let with = specialised.with_neutral(part);
        assert_ne!(format!("{with:?}"), format!("{specialised:?}"), "{part:?}");
        assert!(in_lanes(&with, 1).is_some(), "{part:?}");
    }
}
