//! Counts of the fast engine do not depend on how they are computed.

use std::num::NonZero;

use goldtof::photons::fast::{
    InstructionSet, OutsideDomain, Recorder, StepCounter, count_steps, count_steps_on_all_cores,
};
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::scan::{Group, Step};
use goldtof::scene::{DetectorIndex, JitterTail, LaserResponse, Recharge, Scene, SourceIndex};
use goldtof::sensor::Sensor;
use optics_support::{code, gold_5, gold_11, table_i_scene};

fn scene() -> Scene {
    table_i_scene(gold_11(), 12e6, 3_000)
}

fn counts(model: &DetectorModel, seed: u64, steps: std::ops::Range<u64>) -> Vec<StepCount> {
    let mut counts = vec![StepCount::ZERO; (steps.end - steps.start) as usize];
    count_steps(model, seed, 4, steps, &mut counts);
    counts
}

#[test]
fn every_instruction_set_gives_the_same_counts() {
    let scene = scene();
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let expected = counts(&model, 9, 0..300);
    for set in InstructionSet::available() {
        let mut found = vec![StepCount::ZERO; 300];
        let counter = StepCounter::new(&model).with_instruction_set(set);
        counter.count(9, 4..5, 0..300, &mut found);
        assert_eq!(found, expected, "{set:?}");
    }
}

#[test]
fn neither_instruction_set_nor_company_changes_a_registered_time() {
    let mut scene = scene();
    scene.sources[0].response = LaserResponse::Edges { rise_time_ps: 900.0, fall_time_ps: 2e3 };
    scene.detectors[0].jitter_tail =
        JitterTail::Exponential { share: 0.2, time_constant_ps: 300.0 };
    for recharge in [Recharge::Active, Recharge::Passive] {
        scene.detectors[0].recharge = recharge;
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let groups: Vec<_> = (0..100).map(|group| (4, Group(group))).collect();
        let expected = Recorder::new(&model).record(9, &groups);
        assert!(expected.iter().all(|list| list.len() > 50 && list.is_sorted()));
        for set in InstructionSet::available() {
            let recorder = Recorder::new(&model).with_instruction_set(set);
            assert_eq!(recorder.record(9, &groups), expected, "{set:?}");
            for (group, expected) in groups.iter().zip(&expected) {
                assert_eq!(&recorder.record(9, &[*group])[0], expected, "{set:?} {group:?}");
            }
        }
    }
}

#[test]
fn neither_threads_nor_parts_change_a_count() {
    let scene = scene();
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let expected = counts(&model, 9, 0..300);
    for threads in 2..5 {
        let mut found = vec![StepCount::ZERO; 300];
        let threads = NonZero::new(threads).expect("not zero");
        StepCounter::new(&model).count_on_threads(threads, 9, 4..5, 0..300, &mut found);
        assert_eq!(found, expected, "{threads} threads");
    }
    let mut found = vec![StepCount::ZERO; 300];
    count_steps_on_all_cores(&model, 9, 4, 0..300, &mut found);
    assert_eq!(found, expected);
    for first in [0, 1, 17, 250, 299] {
        let part = counts(&model, 9, first..300);
        assert_eq!(part, expected[first as usize..], "from {first} on");
    }
}

#[test]
fn scans_follow_one_another_in_the_results() {
    let scene = scene();
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let mut found = vec![StepCount::ZERO; 3 * 50];
    StepCounter::new(&model).count(9, 3..6, 100..150, &mut found);
    for (scan, counts) in (3..).zip(found.chunks(50)) {
        let mut expected = vec![StepCount::ZERO; 50];
        count_steps(&model, 9, scan, 100..150, &mut expected);
        assert_eq!(counts, expected, "scan {scan}");
    }
}

#[test]
fn other_seeds_scans_and_steps_give_other_counts() {
    let scene = scene();
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let these = counts(&model, 9, 0..50);
    assert_ne!(these, counts(&model, 10, 0..50));
    assert_ne!(these, counts(&model, 9, 50..100));
}

#[test]
fn no_steps_are_no_work() {
    let scene = scene();
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    assert_eq!(counts(&model, 9, 7..7), []);
}

#[test]
fn models_beyond_the_lanes_go_through_the_plain_loop() {
    let bare = || table_i_scene(gold_5(), 5e6, 200);
    let outside = |change: &dyn Fn(&mut Scene)| {
        let mut scene = bare();
        change(&mut scene);
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let plain: Vec<StepCount> =
            (0..5).map(|step| count_step(&model, 3, 4, Step(step))).collect();
        assert_eq!(counts(&model, 3, 0..5), plain);
        StepCounter::new(&model).outside_domain()
    };
    let far = outside(&|scene| scene.detectors[0].dead_time_ps = 9e6);
    assert!(matches!(far, Some(OutsideDomain::DeadTimeTooLong { .. })));
    let wide = outside(&|scene| scene.detectors[0].jitter_ps = vec![2e6]);
    assert!(matches!(wide, Some(OutsideDomain::TooMuchJitter { .. })));
    let quick = outside(&|scene| scene.detectors[0].afterpulsing_time_constant_ps = 0.5);
    assert!(matches!(quick, Some(OutsideDomain::TooQuick { .. })));
    let bright = outside(&|scene| scene.detectors[0].background_rate_cps = 1e15);
    assert!(matches!(bright, Some(OutsideDomain::TooQuick { .. })));
    let long = outside(&|scene| {
        let mut other = scene.sources[0].clone();
        let chips: Vec<u8> = (0..2_097_153).map(|chip| (chip % 2) as u8).collect();
        other.code = code(&chips);
        scene.sources.push(other);
        let mut path = scene.paths[0].clone();
        path.source = SourceIndex(1);
        scene.paths.push(path);
    });
    assert!(matches!(long, Some(OutsideDomain::CodeTooLong { .. })));
}
