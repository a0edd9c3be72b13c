//! Cells, detectors that fire one another and passive recharge: the vector lanes against the plain
//! loop, by what is counted, where in the code's period, and how far apart.

use goldtof::photons::DetectorModel;
use goldtof::photons::fast::{OutsideDomain, Recorder, StepCounter};
use goldtof::scan::Group;
use goldtof::scene::{
    CellOutputs, Combination, Crosstalk, Detector, DetectorIndex, Movement, Path, Recharge, Scene,
};
use goldtof::sensor::Sensor;
use optics_support::compared::{
    Comparisons, Tally, assert_chance, columns_of_runs, plain_times, recorded_times,
    steps_of_photons,
};
use optics_support::{gold_5, repeated, table_i_scene};
use rayon::prelude::*;

/// A pixel in light of so many primary detections a second, with afterpulses and jitter of Table I.
fn pixel(rate: f64, photons: f64, change: impl FnOnce(&mut Detector)) -> (Scene, u64) {
    let (chips, steps) = steps_of_photons(photons, rate, 31);
    let mut scene = table_i_scene(gold_5(), rate, chips);
    // Cells that fire at once make two edges of an XOR just a pulse apart: not at a column's border.
    scene.detectors[0].pulse_width_ps = 5.1e3;
    change(&mut scene.detectors[0]);
    (scene, steps)
}

/// A row of detectors whose dead times, dark counts and afterpulses are unlike, or alike.
fn row(rate: f64, photons: f64, number: usize, is_alike: bool, talk: Crosstalk) -> (Scene, u64) {
    let (mut scene, steps) = pixel(rate, photons / number as f64, |_| {});
    let (spad, path) = (scene.detectors.remove(0), scene.paths.remove(0));
    for place in 0..number {
        let unlike = if is_alike { 0.0 } else { place as f64 };
        let mut spad = Detector { name: format!("spad {place}"), ..spad.clone() };
        // The last one is heard by nobody, and hears.
        spad.crosstalk = Some(talk).filter(|_| is_alike || place + 1 < number);
        spad.dead_time_ps *= 1.0 + 0.6 * unlike;
        spad.dark_count_rate_cps *= 1.0 + unlike;
        spad.afterpulsing_probability /= 1.0 + unlike;
        spad.afterpulsing_time_constant_ps *= 1.0 + 2.0 * unlike;
        if unlike == 1.0 {
            spad.afterpulsing_probability = 0.0;
        }
        scene.detectors.push(spad);
        let delay_ps = path.delay_ps + 33_000.0 * place as f64;
        let transmission = [1.0, 0.3, 0.6, 0.1, 0.9][place];
        let detector = DetectorIndex(place);
        scene.paths.push(Path { detector, delay_ps, transmission, ..path.clone() });
    }
    (scene, steps)
}

/// Both engines' runs, all detectors of each group beside one another: they see one history. None of those that
/// are mostly blind.
fn compared(number: usize, name: &str, scene: &Scene, steps: u64) -> Option<Comparisons> {
    let sensor = Sensor::new(scene);
    let indices = DetectorIndex::of(&scene.detectors);
    let models: Vec<_> = indices.map(|index| DetectorModel::new(&sensor, index)).collect();
    let refused = StepCounter::new(&models[0]).outside_domain();
    if matches!(refused, Some(OutsideDomain::MostlyBlind { .. })) {
        return None;
    }
    let detectors = models.len();
    let [mut plain, mut lanes] =
        [(); 2].map(|()| Tally::new(detectors * 125 + detectors * detectors * 160));
    let seed = 40 + number as u64;
    for step in 0..steps {
        let runs = models.iter().map(|model| plain_times(model, seed, 0, Group(step)));
        plain.take(&columns_of_runs(&runs.collect::<Vec<_>>()));
    }
    let recorders: Vec<_> = models.iter().map(Recorder::new).collect();
    let at_once = recorders.iter().map(Recorder::groups_at_once);
    let at_once = at_once.min().flatten().unwrap_or_else(|| {
        let reasons = models.iter().map(|model| StepCounter::new(model).outside_domain());
        panic!("{name}: not by the lanes: {:?}", reasons.collect::<Vec<_>>());
    });
    let groups: Vec<_> = (0..steps).map(|step| (1, Group(step))).collect();
    for groups in groups.chunks(at_once) {
        let lists: Vec<_> = recorders.iter().map(|r| r.record(seed, groups)).collect();
        for group in 0..groups.len() {
            let runs = lists.iter().map(|lists| recorded_times(&lists[group]));
            lanes.take(&columns_of_runs(&runs.collect::<Vec<_>>()));
        }
    }
    let mut compared = Comparisons::default();
    compared.add([&plain, &lanes], &|column| format!("column {column}"));
    Some(compared)
}

#[test]
fn lanes_of_several_members_agree_with_the_plain_loop() {
    lanes_agree(repeated(60_000, 1_000_000) as f64);
}

#[test]
#[ignore = "three million photons a case, over 10^8 in all; some minutes"]
fn lanes_of_several_members_agree_with_the_plain_loop_over_10_to_the_8_photons() {
    lanes_agree(3e6);
}

/// So many primary detections a case.
fn lanes_agree(photons: f64) {
    let talk = |probability, delay_ps| Crosstalk { probability, delay_ps };
    let mut cases: Vec<(String, (Scene, u64))> = Vec::new();
    for rate in [1e5, 20e6, 100e6, 600e6] {
        for (afterpulsing, time_constant_ps) in [(0.0, 5e3), (0.137, 5e3), (0.45, 40e3)] {
            let scene = pixel(rate, photons, |spad| {
                spad.recharge = Recharge::Passive;
                spad.afterpulsing_probability = afterpulsing;
                spad.afterpulsing_time_constant_ps = time_constant_ps;
            });
            cases.push((format!("passive, afterpulses {afterpulsing}, {rate:e}"), scene));
        }
        for (cells, heard) in [
            (2, talk(0.5, 0.0)),
            (3, talk(0.02, 300.0)),
            (4, talk(0.3, 14e3)),
            (16, talk(0.2, 20e3)),
            (64, talk(0.1, 100.0)),
            (4, talk(0.0, 0.0)),
        ] {
            let scene = pixel(rate, photons, |spad| {
                spad.cells = cells;
                spad.combination = [Combination::Xor, Combination::Or][cells as usize % 2];
                spad.coincidence = if cells == 16 { 2 } else { 1 };
                if cells >= 16 {
                    spad.combination = Combination::Or;
                }
                spad.cell_dark_count_rates_cps = vec![1e-3 * rate; cells as usize];
                spad.cell_dark_count_rates_cps[1] = 0.2 * rate;
                spad.cell_crosstalk = Some(heard);
                if cells == 3 {
                    // Most of an avalanche's afterpulses outlive the dead time that the first of them begins.
                    spad.afterpulsing_probability = 0.45;
                    spad.afterpulsing_time_constant_ps = 40e3;
                }
                if heard.probability == 0.0 {
                    spad.recharge = Recharge::Passive;
                    spad.afterpulsing_time_constant_ps = 30e3;
                    spad.combination = Combination::Adder;
                    spad.cell_outputs = CellOutputs::Separate;
                }
            });
            cases.push((format!("{cells} cells, {heard:?}, {rate:e}"), scene));
        }
    }
    for (number, is_alike, heard) in [
        (2, true, talk(0.1, 0.0)),
        (2, false, talk(0.5, 300.0)),
        (3, false, talk(0.4, 20e3)),
        (4, true, talk(1.0, 310.0)),
        (5, false, talk(0.3, 1_310.0)),
    ] {
        for rate in [1e5, 40e6, 300e6] {
            let scene = row(rate, photons, number, is_alike, heard);
            cases.push((format!("{number} detectors, {heard:?}, {rate:e}"), scene));
        }
    }
    // A third of them with paths that go their own ways, by half a chip and more.
    for (name, (scene, _)) in cases.iter_mut().skip(1).step_by(3) {
        for (place, path) in scene.paths.iter_mut().enumerate() {
            let velocity_m_per_s = [3_000.0, -2_000.0, 700.0, -5_000.0, 1_500.0][place];
            path.movement = Some(Movement { velocity_m_per_s, fluctuation: None });
        }
        *name += ", moving";
    }
    let cases: Vec<_> = cases.into_iter().enumerate().collect();
    let number = cases.len();
    let compared = cases.into_par_iter().filter_map(|(number, (name, (scene, steps)))| {
        let compared = compared(number, &name, &scene, steps)?;
        Some((name, compared))
    });
    let compared: Vec<_> = compared.collect();
    assert!(compared.len() + 6 >= number, "{} of {number}", compared.len());
    // Detectors that surely fire one another tell the same.
    assert_chance("members in lanes", compared, 4.0);
}

/// What lanes cannot do exactly, or not quickly, is left to the plain loop, by name: more that is pending than is looked through,
/// delays that no word holds, and members that lose most of their light.
#[test]
fn what_lanes_of_several_members_do_not_do_is_left_to_the_plain_loop() {
    let of = |rate, delay_ps, time_constant_ps| {
        let (scene, _) = pixel(rate, 1e3, |spad| {
            spad.cells = 16;
            spad.afterpulsing_probability = if time_constant_ps > 0.0 { 0.01 } else { 0.0 };
            spad.afterpulsing_time_constant_ps = time_constant_ps;
            spad.cell_crosstalk = Some(Crosstalk { probability: 0.5, delay_ps });
        });
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        StepCounter::new(&model).outside_domain()
    };
    assert_eq!(of(400e6, 5e3, 0.0), None);
    let Some(OutsideDomain::TooManyPending { mean, .. }) = of(400e6, 50e3, 0.0) else {
        panic!("by lanes")
    };
    // Each of 16 cells fires once in 14 ns at most, and half of that is pending for 50 ns.
    assert!(mean > 8.0 && mean <= 16.0 * 0.5 * 50.0 / 14.0, "{mean}");
    // 2,047 chips of 8 ns are 16.4 us.
    assert_eq!(of(1e5, 16e6, 0.0), None);
    assert!(matches!(of(1e5, 17e6, 0.0), Some(OutsideDomain::PendingTooLong { .. })));
    // One afterpulse in 10^11 comes after 25 time constants.
    assert_eq!(of(1e5, 0.0, 600e3), None);
    assert!(matches!(of(1e5, 0.0, 700e3), Some(OutsideDomain::PendingTooLong { .. })));
    // 16 cells have a 16th of the light each, twice as much while the laser is on, and are blind for 14 ns.
    assert_eq!(of(16.0 * 380e6, 0.0, 0.0), None);
    assert!(matches!(of(16.0 * 500e6, 0.0, 0.0), Some(OutsideDomain::MostlyBlind { .. })));
}
