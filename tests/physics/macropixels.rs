//! Several SPADs behind one input: against closed forms, and against a simulator that lists every
//! edge of every cell.

use goldtof::estimate::histogram::{Uncorrected, dead_time};
use goldtof::photons::fast::{Recorder, StepCounter};
use goldtof::photons::{CellLevels, DetectorModel, Level, Pulse, PulseStream, StepCount};
use goldtof::response::{CountingTier, MeanResponse, MeanResponseError, SecondMoments};
use goldtof::scan::{Group, Sample, Step};
use goldtof::scene::{
    self, CellOutputs, Combination, Crosstalk, Detector, DetectorIndex, Path, Scene,
};
use goldtof::sensor::Sensor;
use goldtof::sensor::cells::{CellChange, Cells};
use optics_support::compared::{
    Comparisons, Tally, assert_chance, columns_of_times, plain_times, recorded_times,
    steps_of_photons,
};
use optics_support::{
    Moments, assert_within_standard_errors, code, ideal_scene, naive, repeated, table_i_scene,
};
use rand::rngs::StdRng;
use rand::{RngExt as _, SeedableRng};
use rayon::prelude::*;

const SPAD: DetectorIndex = DetectorIndex(0);
/// How long before a step cells start.
const WARM_UP_CHIPS: f64 = 600.0;

fn model(scene: &Scene) -> DetectorModel {
    DetectorModel::new(&Sensor::new(scene), SPAD)
}

/// Constant light on a pixel, whose cells have the dead time of Table I and pulses of 7 ns.
fn constant_light(rate_cps: f64, change: impl FnOnce(&mut Detector)) -> Scene {
    let mut scene = ideal_scene(code(&[1]), rate_cps, 1_000);
    let spad = &mut scene.detectors[0];
    (spad.dead_time_ps, spad.pulse_width_ps) = (14e3, 7e3);
    change(spad);
    scene
}

fn totals(scene: &Scene, seed: u64, steps: u64) -> Moments {
    let model = model(scene);
    let mut counts = vec![StepCount::ZERO; steps as usize];
    StepCounter::new(&model).count(seed, 0..steps, 0..1, &mut counts);
    Moments::of(counts.iter().map(|count| count.total as f64))
}

/// Each cell is a renewal process of rate m = (lambda / K) / (1 + lambda D / K), independent of the
/// others, whose pulse of width w <= D is high for a share q = m w of the time. The level of M
/// overlapping pulses rises where one begins while M - 1 of the other K - 1 are high. That of an odd
/// number rises where a pulse begins while an even number of others is high, and where one ends while
/// an odd number is: as often as all cells fire.
#[test]
fn constant_light_gives_the_rates_of_independent_renewal_processes() {
    for (cells, rate) in [(4, 1e4), (4, 20e6), (4, 200e6), (16, 200e6), (16, 1e9), (2, 50e6)] {
        for (combination, coincidence) in [
            (Combination::Or, 1),
            (Combination::Or, 2),
            (Combination::Xor, 1),
            (Combination::Adder, 1),
        ] {
            let scene = constant_light(rate, |spad| {
                (spad.cells, spad.combination) = (cells, combination);
                spad.coincidence = coincidence;
            });
            let of_cell = rate / f64::from(cells) / (1.0 + rate / f64::from(cells) * 14e-9);
            let (all, high) = (of_cell * f64::from(cells), of_cell * 7e-9);
            let others = cells - 1;
            let expected = match (combination, coincidence) {
                (Combination::Xor | Combination::Adder, _) => all,
                (Combination::Or, 1) => all * (1.0 - high).powi(others as i32),
                (Combination::Or, _) => {
                    all * f64::from(others) * high * (1.0 - high).powi(others as i32 - 1)
                }
            };
            let found = totals(&scene, 31, repeated(250, 4_000));
            let told = format!("{cells} cells, {combination:?} of {coincidence}, {rate:e}");
            if expected * 8e-6 * found.count > 10.0 {
                // Pulses that overlap the start of a step are not known in it: one of some thousands.
                let edge = 2.0 * all * 7e-9 / (all * 8e-6);
                let slack = edge * expected * 8e-6 / found.standard_error();
                assert_within_standard_errors(found.z(expected * 8e-6), 4.0 + slack, &told);
            }
        }
    }
}

/// The cells of a scene's detector, each a detector of its own with its share of the light.
fn cells_of(scene: &Scene) -> Scene {
    let spad = &scene.detectors[0];
    let dark = &spad.cell_dark_count_rates_cps;
    let mut cells = scene.clone();
    (cells.detectors, cells.paths) = (0..spad.cells as usize)
        .map(|number| {
            let mut cell = spad.clone();
            cell.photon_detection_probability /= f64::from(spad.cells);
            cell.dark_count_rate_cps = dark[number];
            cell.crosstalk = spad.cell_crosstalk;
            (cell, Path { detector: DetectorIndex(number), ..scene.paths[0].clone() })
        })
        .unzip();
    cells
}

/// Registered times of every cell in chips.
fn naive_cells(cells: &Scene, rng: &mut StdRng, chips: f64) -> Vec<Vec<f64>> {
    let number = cells.detectors.len();
    let Some(talk) = cells.detectors[0].crosstalk else {
        let of_cell = |cell| naive::detections(cells, cell, rng, chips, WARM_UP_CHIPS);
        return (0..number).map(of_cell).collect();
    };
    let one_of_others = |rng: &mut StdRng, of: usize| match rng.random::<f64>() < talk.probability {
        true => vec![(of + rng.random_range(1..number)) % number],
        false => Vec::new(),
    };
    naive::coupled_detections(cells, rng, chips, WARM_UP_CHIPS, &one_of_others)
}

#[test]
fn modulated_light_is_counted_as_by_a_simulator_of_all_edges() {
    agrees_with_a_simulator_of_all_edges(1.2e6);
}

#[test]
#[ignore = "a hundred million photons; some minutes"]
fn modulated_light_is_counted_as_by_a_simulator_of_all_edges_over_10_to_the_8_photons() {
    agrees_with_a_simulator_of_all_edges(1e8);
}

/// Modulated light, dead time and afterpulses, a hot cell, or crosstalk between cells; so many primary
/// detections in all, of 4 and 16 cells, at rates of 10^4 to 10^9 a second. Rising edges in continuous time, by eighth of a chip of the code period,
/// and all of them, and those at the samples.
fn agrees_with_a_simulator_of_all_edges(photons: f64) {
    let laws = [
        (Combination::Or, 1, 0.0),
        (Combination::Or, 2, 0.0),
        (Combination::Xor, 1, 0.0),
        (Combination::Adder, 1, 0.0),
        (Combination::Or, 1, 0.2),
    ];
    let cases = laws.into_iter().flat_map(|law| {
        [4, 16].into_iter().flat_map(move |cells| [1e4, 40e6, 1e9].map(|rate| (law, cells, rate)))
    });
    let cases: Vec<_> = cases.enumerate().collect();
    let compared = cases.into_par_iter().map(|(number, case)| {
        let [plain, fast, theirs] = tallies_of_all_edges(300 + number as u64, case, photons / 30.0);
        let mut compared = Comparisons::default();
        for (engine, ours) in [("plain", plain), ("fast", fast)] {
            compared.add([&ours, &theirs], &|column| format!("{engine}, column {column}"));
        }
        (format!("{case:?}"), compared)
    });
    // Both engines are held against the same counts.
    assert_chance("macropixels", compared.collect(), 2.0);
}

/// Of the product's engines, and of the simulator of all edges.
fn tallies_of_all_edges(
    seed: u64,
    ((combination, coincidence, talk), cells, rate): ((Combination, u32, f64), u32, f64),
    photons: f64,
) -> [Tally; 3] {
    let (chips, steps) = steps_of_photons(photons, rate, 7);
    let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), rate, chips);
    let spad = &mut scene.detectors[0];
    spad.jitter_ps.clear();
    (spad.cells, spad.combination, spad.coincidence) = (cells, combination, coincidence);
    if combination == Combination::Adder {
        spad.cell_outputs = CellOutputs::Separate;
    }
    // Longer than the dead time: a cell's own pulses overlap, too.
    spad.pulse_width_ps = if (cells, coincidence) == (4, 2) { 17e3 } else { 5e3 };
    spad.cell_dark_count_rates_cps = vec![1e-3 * rate; cells as usize];
    spad.cell_dark_count_rates_cps[1] = 0.1 * rate;
    if talk > 0.0 {
        spad.afterpulsing_probability = 0.0;
        spad.cell_crosstalk = Some(Crosstalk { probability: talk, delay_ps: 300.0 });
    }
    let width = spad.pulse_width_ps / 8e3;
    let is_high = |high: usize| match combination {
        Combination::Or | Combination::Adder => high >= coincidence as usize,
        Combination::Xor => high % 2 == 1,
    };
    let (model, law, of_cells) = (model(&scene), Cells::of(&scene.detectors[0]), cells_of(&scene));
    let mut by_lanes = PulseStream::new(&model, 5, 0);
    let mut by_plain_loop = PulseStream::of_plain_loop(&model, 5, 0);
    let mut rng = StdRng::seed_from_u64(seed);
    // Columns: edges by eighth of a chip of the code, all of them, and sampled ones.
    let samples = 7 * 8;
    let columns = |edges: &[f64], sampled: usize| {
        let mut columns = columns_of_times(edges, 7, 8);
        columns.resize(columns.len() + sampled, samples + 1);
        columns
    };
    let [mut fast, mut plain, mut theirs] = [(); 3].map(|()| Tally::new(samples + 2));
    for step in 0..steps {
        let edges = plain_times(&model, 5, 0, Group(step));
        let sampled = sampled_hits(&mut by_plain_loop, &law, step, chips * 8).len();
        plain.take(&columns(&edges, sampled));

        let cells = naive_cells(&of_cells, &mut rng, chips as f64);
        let level = |cells: &[Vec<f64>]| naive::level_of_cells(cells, width, &is_high);
        let sampled = |pulses: &[[f64; 2]]| naive::sampled_rises(pulses, 8.0, chips as f64);
        theirs.take(&if combination == Combination::Adder {
            let of_cell = |cell| sampled(&level(std::slice::from_ref(cell)));
            columns(&cells.concat(), cells.iter().map(of_cell).sum())
        } else {
            let pulses = level(&cells);
            let edges: Vec<f64> = pulses.iter().map(|[rise, _]| *rise).collect();
            columns(&edges, sampled(&pulses))
        });
    }
    let recorder = Recorder::new(&model);
    let at_once = recorder.groups_at_once().expect("the lanes must be used");
    let groups: Vec<_> = (0..steps).map(|step| (0, Group(step))).collect();
    let lists = groups.chunks(at_once).flat_map(|groups| recorder.record(6, groups));
    for (step, list) in (0..).zip(lists) {
        let sampled = sampled_hits(&mut by_lanes, &law, step, chips * 8).len();
        fast.take(&columns(&recorded_times(&list), sampled));
    }
    [plain, fast, theirs]
}

/// Samples of the next step of a stream, its `step`-th, at which the level rises, or, of separate outputs, their
/// combined samples. Pulses of the step before are not known in it.
fn sampled_hits(stream: &mut PulseStream, law: &Cells, step: u64, samples: u64) -> Vec<u64> {
    let start = step * samples;
    let mut pulses = vec![Vec::new(); stream.inputs()];
    stream.advance_inputs(Sample(start + samples), &mut pulses);
    for pulses in &mut pulses {
        // One that begins behind the last sample shows at the next step's first one.
        pulses.retain(|pulse: &Pulse| step == 0 || pulse.first.0 > start);
        for pulse in pulses {
            *pulse =
                Pulse { first: Sample(pulse.first.0 - start), end: Sample(pulse.end.0 - start) };
        }
    }
    if let [pulses] = &mut pulses[..] {
        let mut level = Level::default();
        pulses.retain(|pulse| level.rises(pulse));
        return pulses.iter().map(|pulse| pulse.first.0).collect();
    }
    assert_eq!(pulses.len(), law.count as usize);
    let mut changes = Vec::new();
    CellLevels::new(law.count).advance(&pulses, Sample(samples), &mut changes);
    let of_change = |change: &CellChange| vec![change.sample.0; change.hits(law) as usize];
    changes.iter().flat_map(of_change).collect()
}

/// The chance that the level of independent cells is low at one sample and high at the next: of each cell
/// that it has a pulse at both, at the first alone, at the second alone.
fn chance_of_rise(cells: i32, both: f64, alone: f64, is_high: impl Fn(i32) -> bool) -> f64 {
    let neither = 1.0 - both - 2.0 * alone;
    let mut sum = 0.0;
    for stay in 0..=cells {
        for fall in 0..=cells - stay {
            for rise in 0..=cells - stay - fall {
                let rest = cells - stay - fall - rise;
                if !is_high(stay + fall) && is_high(stay + rise) {
                    let ways = factorial(cells)
                        / [stay, fall, rise, rest].into_iter().map(factorial).product::<f64>();
                    sum += ways * both.powi(stay) * alone.powi(fall + rise) * neither.powi(rest);
                }
            }
        }
    }
    sum
}

fn factorial(n: i32) -> f64 {
    (1..=n).map(f64::from).product()
}

/// Separate outputs under constant light. Of a cell that fires at a rate m, blind for D, with pulses of w, a
/// sample each T with T <= w and w + T <= D: it has a pulse at two neighbouring samples with the chance
/// m (w - T), and at one of them alone with m T for each. The level that samples are combined to is that of
/// so many such cells.
#[test]
fn samples_of_separate_outputs_rise_as_those_of_independent_cells() {
    for (cells, rate, width_ps) in
        [(4, 20e6, 4e3), (4, 200e6, 7e3), (2, 300e6, 2.5e3), (16, 500e6, 1e3)]
    {
        for (combination, coincidence) in [
            (Combination::Or, 1),
            (Combination::Or, 2),
            (Combination::Or, cells),
            (Combination::Xor, 1),
            (Combination::Adder, 1),
        ] {
            let scene = constant_light(rate, |spad| {
                (spad.cells, spad.cell_outputs) = (cells, CellOutputs::Separate);
                (spad.combination, spad.coincidence) = (combination, coincidence);
                spad.pulse_width_ps = width_ps;
            });
            let (model, law) = (model(&scene), Cells::of(&scene.detectors[0]));
            let mut stream = PulseStream::new(&model, 5, 0);
            let per_cell = rate / f64::from(cells);
            let of_cell = per_cell / (1.0 + per_cell * 14e-9);
            let is_high = |high: i32| match combination {
                Combination::Or => high >= coincidence as i32,
                Combination::Xor => high % 2 == 1,
                Combination::Adder => high > 0,
            };
            let (both, alone) = (of_cell * (width_ps - 1e3) * 1e-12, of_cell * 1e-9);
            let expected = match combination {
                // Every cell's edges: as many as it has detections.
                Combination::Adder => f64::from(cells) * alone,
                _ => chance_of_rise(cells as i32, both, alone, is_high),
            };
            let (from, samples) = (8, 8_000);
            let counted = (0..repeated(60, 3_000)).map(|step| {
                let hits = sampled_hits(&mut stream, &law, step, samples);
                hits.iter().filter(|&&sample| sample > from).count() as f64
            });
            let found = Moments::of(counted);
            let expected = expected * (samples - from - 1) as f64;
            let told = format!("{cells} cells, {combination:?} of {coincidence}, {rate:e}");
            match expected * found.count > 10.0 {
                true => assert_within_standard_errors(found.z(expected), 4.0, &told),
                false => assert!(found.mean * found.count < 30.0, "{told}: {}", found.mean),
            }
        }
    }
}

/// Separate outputs under modulated light, with dead time, a hot cell, and afterpulses or crosstalk: rising edges by
/// sample of the code period, by lanes and plain loop, are those of a simulator that looks at every cell at every sample.
#[test]
fn samples_of_separate_outputs_are_those_of_a_simulator_that_looks_at_each_cell() {
    let (chips, period) = (7 * 40, 7 * 8);
    for (number, (cells, rate, combination, coincidence, talk)) in [
        (4, 160e6, Combination::Or, 2, 0.0),
        (4, 160e6, Combination::Xor, 1, 0.0),
        (16, 1e9, Combination::Or, 3, 0.0),
        (4, 160e6, Combination::Adder, 1, 0.0),
        (16, 1e9, Combination::Adder, 1, 0.0),
        (4, 40e6, Combination::Or, 1, 0.3),
        (3, 40e6, Combination::Xor, 1, 0.5),
        (16, 300e6, Combination::Or, 2, 0.3),
        (4, 40e6, Combination::Adder, 1, 0.3),
    ]
    .into_iter()
    .enumerate()
    {
        let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), rate, chips);
        let spad = &mut scene.detectors[0];
        spad.jitter_ps.clear();
        (spad.cells, spad.cell_outputs) = (cells, CellOutputs::Separate);
        (spad.combination, spad.coincidence) = (combination, coincidence);
        spad.pulse_width_ps = 3.3e3;
        spad.cell_dark_count_rates_cps = vec![10e3; cells as usize];
        spad.cell_dark_count_rates_cps[1] = 2e6;
        if talk > 0.0 {
            spad.afterpulsing_probability = 0.0;
            spad.cell_crosstalk = Some(Crosstalk { probability: talk, delay_ps: 300.0 });
        }
        let (model, law) = (model(&scene), Cells::of(&scene.detectors[0]));
        let of_cells = cells_of(&scene);
        assert!(Recorder::new(&model).groups_at_once().is_some());
        let mut by_lanes = PulseStream::new(&model, 5, 0);
        let mut by_plain_loop = PulseStream::of_plain_loop(&model, 6, 0);
        let mut rng = StdRng::seed_from_u64(700 + number as u64);
        let samples = chips * 8;
        let [mut fast, mut plain, mut theirs] = [(); 3].map(|()| Vec::<Vec<f64>>::new());
        for step in 0..repeated(160, 20_000) {
            for (rows, stream) in [(&mut fast, &mut by_lanes), (&mut plain, &mut by_plain_loop)] {
                let mut row = vec![0.0; period];
                for hit in sampled_hits(stream, &law, step, samples) {
                    row[hit as usize % period] += 1.0;
                }
                rows.push(row);
            }
            let mut row = vec![0.0; period];
            let mut pulses = vec![0; samples as usize];
            let cells = naive_cells(&of_cells, &mut rng, chips as f64);
            for (cell, registered) in cells.into_iter().enumerate() {
                let mut next = 0;
                let mut until = f64::NEG_INFINITY;
                for (sample, pulses) in pulses.iter_mut().enumerate() {
                    let instant = sample as f64 / 8.0;
                    while registered.get(next).is_some_and(|&time| time <= instant) {
                        until = registered[next] + 3.3 / 8.0;
                        next += 1;
                    }
                    *pulses |= u32::from(instant < until) << cell;
                }
            }
            let is_high = |pulses: u32| match combination {
                Combination::Or | Combination::Adder => pulses.count_ones() >= coincidence,
                Combination::Xor => pulses.count_ones() % 2 == 1,
            };
            let mut before = 0;
            for (sample, &pulses) in pulses.iter().enumerate() {
                let hits = match combination {
                    Combination::Adder => (pulses & !before).count_ones(),
                    _ => u32::from(is_high(pulses) && !is_high(before)),
                };
                row[sample % period] += f64::from(hits);
                before = pulses;
            }
            theirs.push(row);
        }
        for (engine, ours) in [("lanes", &fast), ("plain loop", &plain)] {
            let told = format!("{cells} cells, {combination:?} of {coincidence}, {engine}");
            let apart = |of: &dyn Fn(&Vec<f64>) -> f64| {
                let [a, b] = [ours, &theirs].map(|rows| Moments::of(rows.iter().map(of)));
                (a.mean - b.mean) / a.standard_error().hypot(b.standard_error())
            };
            let of_all = apart(&|row| row.iter().sum());
            assert_within_standard_errors(of_all, 4.5, &format!("{told}: all samples"));
            let mut squares = Vec::new();
            for column in 0..period {
                let z = apart(&|row| row[column]);
                assert_within_standard_errors(z, 4.5, &format!("{told}: sample {column}"));
                squares.push(z * z);
            }
            let z = Moments::of(squares);
            assert_within_standard_errors((z.mean - 1.0) / (2.0 / z.count).sqrt(), 4.5, &told);
        }
    }
}

/// Means and variances of counts that cells add up, with dead time, afterpulses and jitter, and the hits of
/// each sample of the code period: as photons give them, and as many times as large as those of one
/// cell, which is a detector with as large a share of the light.
#[test]
fn added_cells_are_expected_to_count_as_so_many_detectors() {
    let (chips, period) = (7 * 40, 7 * 8);
    for (cells, rate) in [(4, 1e6), (4, 160e6), (16, 1e9)] {
        let told = format!("{cells} cells, {rate:e}");
        let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), rate, chips);
        scene.detectors[0].pulse_width_ps = 5e3;
        let mut one = scene.clone();
        one.detectors[0].cells = cells;
        one.detectors[0] = one.detectors[0].cell(0);
        let spad = &mut scene.detectors[0];
        (spad.cells, spad.cell_outputs) = (cells, CellOutputs::Separate);
        spad.combination = Combination::Adder;
        let (model, of_cell) = (model(&scene), model(&one));

        let moments = |model: &DetectorModel| {
            let response = MeanResponse::of_tier(model, CountingTier::Events).unwrap();
            SecondMoments::new(&response).unwrap().of_step(Step(0))
        };
        let (expected, times) = (moments(&model), moments(&of_cell).in_times(cells.into()));
        for (all, one) in [
            (expected.signed_mean, times.signed_mean),
            (expected.total_mean, times.total_mean),
            (expected.signed_variance, times.signed_variance),
            (expected.total_variance, times.total_variance),
            (expected.covariance, times.covariance),
        ] {
            assert!((all - one).abs() < 1e-9 * expected.total_mean, "{told}: {all} {one}");
        }
        let counter = StepCounter::new(&model);
        let repetitions = repeated(3_000, 30_000);
        let mut counts = vec![StepCount::ZERO; repetitions as usize];
        counter.count(11, 0..repetitions, 0..1, &mut counts);
        let signed = Moments::of(counts.iter().map(|count| count.signed as f64));
        let total = Moments::of(counts.iter().map(|count| count.total as f64));
        let all = total.mean;
        for (found, mean, variance) in [
            (signed, expected.signed_mean, expected.signed_variance),
            (total, expected.total_mean, expected.total_variance),
        ] {
            assert_within_standard_errors(found.z(mean), 4.0, &told);
            // Of few counts the fourth moment is larger than that of normal numbers.
            let error = (2.0 / found.count + 1.0 / (found.count * all)).sqrt();
            assert_within_standard_errors((found.variance / variance).ln() / error, 4.0, &told);
        }

        let sampled = MeanResponse::new(&model).unwrap().hits_per_sample();
        let (law, mut stream) = (Cells::of(&scene.detectors[0]), PulseStream::new(&model, 5, 0));
        let mut rows = Vec::new();
        for step in 0..repeated(300, 10_000) {
            let mut row = vec![0.0; period];
            for hit in sampled_hits(&mut stream, &law, step, chips * 8) {
                row[hit as usize % period] += 1.0;
            }
            rows.push(row);
        }
        for (column, expected) in sampled.iter().enumerate() {
            let found = Moments::of(rows.iter().map(|row| row[column]));
            if found.mean * found.count > 20.0 {
                let z = found.z(expected * 40.0);
                assert_within_standard_errors(z, 4.5, &format!("{told}: sample {column}"));
            }
        }
    }
}

/// Two cells that fire one another at once and surely are one SPAD in the light of both, whose pulses
/// come in pairs that an OR makes one: lambda / (1 + lambda D). A coincidence of both has as many, an
/// XOR sees none.
#[test]
fn certain_crosstalk_between_two_cells_makes_them_one() {
    for rate in [5e6, 40e6, 300e6] {
        for (combination, coincidence, share) in
            [(Combination::Or, 1, 1.0), (Combination::Or, 2, 1.0), (Combination::Xor, 1, 0.0)]
        {
            let scene = constant_light(rate, |spad| {
                (spad.cells, spad.combination) = (2, combination);
                spad.coincidence = coincidence;
                spad.cell_crosstalk = Some(Crosstalk { probability: 1.0, delay_ps: 0.0 });
            });
            let found = totals(&scene, 17, repeated(250, 4_000));
            let expected = share * rate / (1.0 + rate * 14e-9) * 8e-6;
            if share > 0.0 {
                assert_within_standard_errors(found.z(expected), 4.0, &format!("{rate:e}"));
            } else {
                assert_eq!(found.mean, 0.0, "{rate:e}");
            }
        }
    }
}

/// At low light each avalanche has p further ones, 300 ps later at another cell. Pulses of 100 ps do not
/// overlap, so that all are counted; p + p^2 + p^3 of each as every one of them may cause another.
#[test]
fn crosstalk_between_cells_adds_its_probability() {
    let scene = constant_light(1e6, |spad| {
        (spad.cells, spad.pulse_width_ps) = (16, 100.0);
        spad.cell_crosstalk = Some(Crosstalk { probability: 0.1, delay_ps: 300.0 });
    });
    let found = totals(&scene, 23, repeated(20_000, 400_000));
    // One of 15 others is the one that fired, which is blind: 0.1 less 0.1 / 15 from the second on.
    let (first, more) = (0.1, 0.1 * 14.0 / 15.0);
    let clusters = 1e6 * 8e-6 / (1.0 + 1e6 / 16.0 * 14e-9 * (1.0 + first));
    let expected = clusters * (1.0 + first / (1.0 - more));
    // What is within 0.1 % of the rate: cells that are blind by chance.
    let slack = 1e-3 * expected / found.standard_error();
    assert_within_standard_errors(found.z(expected), 3.0 + slack, "counts with crosstalk");
}

#[test]
fn one_cell_is_a_detector_as_ever() {
    let scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), 40e6, 2_800);
    let with = |change: fn(&mut Detector)| {
        let mut scene = scene.clone();
        change(&mut scene.detectors[0]);
        let counted: Vec<_> = model(&scene).step(3, 0, Group(2)).collect();
        assert!(!counted.is_empty());
        counted
    };
    let plain = with(|_| {});
    assert_eq!(plain, with(|spad| spad.cells = 1));
    assert_ne!(plain, with(|spad| spad.cells = 2));
}

#[test]
fn what_rests_on_one_spad_refuses_cells_by_name() {
    let mut scene = table_i_scene(code(&[1, 1, 1, 0, 1, 0, 0]), 8e6, 2_800);
    scene.detectors[0].cells = 4;
    let model = model(&scene);
    assert_eq!(MeanResponse::new(&model).map(|_| ()), Err(MeanResponseError::Cells));
    assert_eq!(StepCounter::new(&model).outside_domain(), None);
    assert_eq!(dead_time(&Sensor::new(&scene), SPAD).map(|_| ()), Err(Uncorrected::Cells));
    // Cells that are added up have expectations if they are alike.
    let spad = &mut scene.detectors[0];
    (spad.cell_outputs, spad.combination) = (CellOutputs::Separate, Combination::Adder);
    let hot = DetectorModel::new(&Sensor::new(&scene), SPAD);
    assert!(MeanResponse::new(&hot).is_ok());
    scene.detectors[0].cell_dark_count_rates_cps = vec![1e3, 1e3, 2e6, 1e3];
    let hot = DetectorModel::new(&Sensor::new(&scene), SPAD);
    assert_eq!(MeanResponse::new(&hot).err(), Some(MeanResponseError::UnlikeCells));
    let spad = &mut scene.detectors[0];
    spad.cell_dark_count_rates_cps.clear();
    spad.cell_crosstalk = Some(Crosstalk { probability: 0.01, delay_ps: 0.0 });
    let talking = DetectorModel::new(&Sensor::new(&scene), SPAD);
    assert_eq!(MeanResponse::new(&talking).err(), Some(MeanResponseError::CrosstalkBetweenCells));
}

#[test]
fn what_does_not_hold_together_is_told_in_the_scene() {
    let quick = std::fs::read_to_string("scenes/quick.toml").unwrap();
    for (keys, told) in [
        ("cells = 65", "outside"),
        ("cells = 2\ncoincidence = 3", "no 3 pulses overlap of cells = 2"),
        ("coincidence = 2", "no 2 pulses overlap of cells = 1"),
        ("cells = 4\ncombination = \"xor\"\ncoincidence = 2", "an odd number of pulses"),
        ("cells = 4\ncombination = \"and\"", "not known"),
        ("cell_outputs = \"separate\"", "cells = 1 has one output"),
        ("cells = 4\ncombination = \"adder\"", "write cell_outputs = \"separate\""),
        (
            "cells = 4\ncombination = \"adder\"\ncell_outputs = \"separate\"\ncoincidence = 2",
            "\"adder\" counts every pulse",
        ),
        ("cells = 2\ncell_dark_count_rates = [\"1 kcps\"]", "1 rates for cells = 2"),
        (
            "cells = 2\ncell_dark_count_rates = [\"1 kcps\", \"2 kcps\"]",
            "dark_count_rate is given, too",
        ),
        ("cell_crosstalk = { probability = 0.1 }", "no other cell"),
        (
            "cells = 2\nrecharge = \"passive\"\ncell_crosstalk = { probability = 0.1 }",
            "recharge = \"active\" alone",
        ),
    ] {
        let text = quick.replace("[[detector]]", &format!("[[detector]]\n{keys}"));
        let error = scene::parse("x.toml", &text).expect_err(told).to_string();
        assert!(error.contains(told), "{told}: {error}");
    }
}
