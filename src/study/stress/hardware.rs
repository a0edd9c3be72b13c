//! The Verilog at its limits, beside the reference model and the definition.

use super::prelude::*;
use super::testbench::{CaseTestbench, StimulusScript};
use crate::photons::Pulse;
use crate::scan::Sample;
use crate::scene::{FpgaTarget, SourceIndex};
use crate::sensor::port::PortRole;

const BOTH_AGREE: &str = "Verilog and reference model are two constructions of one interface: every \
                          output port at every clock";

pub(super) const CASES: &[Case] = cases! {
    Hardware quick "counters-one-short-of-saturation":
        "wrong counts, flags and ports with 6 hits up and 7 down into 4 bits",
        "4 bits hold -8..7: nothing is saturated, the flag stays low",
        |_| counters([6, 7], [6, -7], false);
    Hardware quick "counters-at-saturation":
        "wrong counts, flags and ports with 7 hits up and 8 down into 4 bits",
        "4 bits hold -8..7: nothing is saturated, the flag stays low",
        |_| counters([7, 8], [7, -8], false);
    Hardware quick "counters-beyond-saturation-upwards":
        "wrong counts, flags and ports with 8 hits up and 8 down into 4 bits",
        "4 bits hold -8..7: the count up is saturated, never wrapped, and flagged",
        |_| counters([8, 8], [7, -8], true);
    Hardware quick "counters-beyond-saturation-downwards":
        "wrong counts, flags and ports with 7 hits up and 9 down into 4 bits",
        "4 bits hold -8..7: the count down is saturated, never wrapped, and flagged",
        |_| counters([7, 9], [7, -8], true);
    Hardware quick "counters-far-beyond-saturation":
        "wrong counts, flags and ports with 12 hits up and 16 down into 4 bits: every one there \
         can be",
        "4 bits hold -8..7: counts are saturated, never wrapped, and flagged",
        |_| counters([12, 16], [7, -8], true);
    Hardware quick "totals-at-saturation":
        "wrong totals, flags and ports with 15 hits, up and down, into 4 bits",
        "4 bits without a sign hold 15: nothing is saturated, the flag stays low",
        |_| totals(15, 15, false);
    Hardware quick "totals-beyond-saturation":
        "wrong totals, flags and ports with 16 hits, up and down, into 4 bits",
        "4 bits hold 15: the total is saturated and flagged, the signed count of -2 is not",
        |_| totals(16, 15, true);
    Hardware quick "totals-far-beyond-saturation":
        "wrong totals, flags and ports with 28 hits into 4 bits: every one there can be",
        "4 bits hold 15: the total is saturated, never wrapped, and flagged",
        |_| totals(28, 15, true);
    Hardware slow "hits-in-every-other-sample":
        "wrong counts and ports with the most hits there can be, either phase, 62 chips, S = 8",
        "S / 2 hits fall into every chip, so every step counts (D / L)(2 w - L) S / 2",
        |_| every_other_sample();
    Hardware quick "a-dump-on-every-clock":
        "clocks at which a port differs from the reference model, D = 1 chip, 50,000 hostile \
         clocks",
        BOTH_AGREE,
        dump_on_every_clock;
    Hardware quick "reset-in-the-middle-of-everything":
        "clocks at which a port differs from the reference model, reset after 1, 2, 3, ... 200 \
         clocks",
        "the model starts anew after every reset: so must every register",
        |_| reset_everywhere();
    Hardware quick "a-consumer-that-never-takes":
        "wrong clocks: overrun not raised, the first result not held, ports that differ",
        "AXI4-Stream: valid data stand until taken; what does not fit is dropped and flagged, as \
         the sensor cannot stall",
        |_| consumer_never_takes();
    Hardware slow "everything-at-once":
        "clocks at which a port differs: two detectors, five steps at once, nu = 2, 3-bit counts \
         and totals, 100,000 hostile clocks",
        BOTH_AGREE,
        everything_at_once;
    Hardware slow "degree-16-interleaved-four-times":
        "clocks at which a port differs over more than a code period of 1,048,560 chips",
        BOTH_AGREE,
        longest_code;
};

/// 7 chips of weight 3, S = 4, D = 14 chips, two steps, 4 bits.
fn small_sensor() -> Result<Scene, CaseError> {
    let mut scene = ideal(r#"{ family = "chips", chips = "0110100" }"#, 4, 0.0, 14)?;
    window(&mut scene, 5, 2);
    scene.hardware.counter_width = Some(4);
    Ok(scene)
}

/// Single-sample pulses in step number `step` of the first scan: the first
/// `number` hits that the definition counts with the sign `up`.
fn one_sided(testbench: &CaseTestbench, step: u64, up: bool, number: usize) -> Vec<Pulse> {
    let interface = &testbench.interface;
    let lanes = u64::from(interface.lanes());
    let code = &interface.reference_codes[0];
    let first_clock = testbench.first_clock();
    let delay = interface.timing.scan.phase_step(Step(step));
    let integration = interface.timing.scan.integration_chips;
    let mut pulses: Vec<Pulse> = Vec::new();
    for sample in step * integration * lanes..(step + 1) * integration * lanes {
        let period = code.len() * lanes;
        let chip = (sample + period - delay % period) % period / lanes;
        let first = interface.timing.sampling().first_sample(first_clock) + sample;
        let is_apart = pulses.last().is_none_or(|pulse| pulse.end < first);
        if pulses.len() < number && is_apart && (code.chips[chip as usize] == 1) == up {
            pulses.push(Pulse::of_one(first));
        }
    }
    pulses
}

fn counters(
    hits: [usize; 2],
    expected: [i64; 2],
    flagged: bool,
) -> Result<CaseMeasurement, CaseError> {
    let mut testbench = CaseTestbench::new(&small_sensor()?)?;
    let mut pulses = one_sided(&testbench, 0, true, hits[0]);
    pulses.extend(one_sided(&testbench, 1, false, hits[1]));
    ensure!(pulses.len() == hits[0] + hits[1], "too few places for hits");
    let run = testbench.play(&StimulusScript::new(pulses), 60)?;
    let counts: Vec<i64> = run.results.iter().take(2).map(|r| r.count).collect();
    let is_flagged = testbench.port(&run, PortRole::Saturated).last() == Some(1);
    // What the Verilog sends, as signed bytes.
    let data = testbench.port(&run, PortRole::Data);
    let sent = data.zip(testbench.port(&run, PortRole::Valid));
    let sent: Vec<i64> = sent
        .filter(|&(_, valid)| valid == 1)
        .map(|(data, _)| i64::from(data as u8 as i8))
        .collect();
    let wrong = usize::from(counts != expected)
        + usize::from(sent.get(..2) != Some(&expected[..]))
        + usize::from(is_flagged != flagged);
    CaseMeasurement::none(wrong + run.mismatches as usize, run.results.len(), "wrong values")
}

/// A hit in every other sample, `hits` of them in the first step.
fn totals(hits: u64, expected: u64, flagged: bool) -> Result<CaseMeasurement, CaseError> {
    let mut scene = small_sensor()?;
    scene.hardware.total_counts = Some(true);
    let mut testbench = CaseTestbench::new(&scene)?;
    let sampling = testbench.interface.timing.sampling();
    let first = sampling.first_sample(testbench.first_clock());
    let pulses = (0..hits).map(|hit| Pulse::of_one(first + 2 * hit));
    let run = testbench.play(&StimulusScript::new(pulses.collect()), 60)?;
    // Hit i is in chip (2 i - k) / 4 of the reference, k the phase step.
    let (code, step) = (
        &testbench.interface.reference_codes[0],
        testbench.interface.timing.scan.phase_step(Step(0)),
    );
    let sign = |hit: u64| {
        let delayed = (2 * hit + 4 * code.len() - step) / 4;
        2 * i64::from(code.chips[(delayed % code.len()) as usize]) - 1
    };
    let signed: i64 = (0..hits).map(sign).sum();
    let result = run.results.first().map(|r| (r.count, r.total));
    let is_flagged = testbench.port(&run, PortRole::Saturated).last() == Some(1);
    // What the Verilog sends first: a signed byte, and the total in the byte above.
    let data = testbench.port(&run, PortRole::Data);
    let mut sent = data.zip(testbench.port(&run, PortRole::Valid));
    let sent = sent
        .find(|&(_, valid)| valid == 1)
        .map(|(data, _)| (i64::from(data as u8 as i8), data >> 8));
    let wrong = usize::from(result != Some((signed, expected)))
        + usize::from(sent != Some((signed, expected)))
        + usize::from(is_flagged != flagged);
    CaseMeasurement::none(wrong + run.mismatches as usize, run.results.len(), "wrong values")
}

fn every_other_sample() -> Result<CaseMeasurement, CaseError> {
    let scene = ideal(r#"{ family = "gold", degree = 5 }"#, 8, 0.0, 62)?;
    let code = scene.sources[0].code.clone();
    let expected = 2 * (2 * code.weight() as i64 - code.len() as i64) * 4;
    let mut testbench = CaseTestbench::new(&scene)?;
    let clocks = 20_000;
    let mut wrong = 0;
    for odd in [0, 1] {
        let pulses = (odd..clocks * 8).step_by(2).map(|first| Pulse::of_one(Sample(first)));
        let run = testbench.play(&StimulusScript::new(pulses.collect()), clocks)?;
        ensure!(run.results.len() > 248, "the run is too short");
        wrong += run.results.iter().filter(|r| r.count != expected || r.total != 248).count();
        wrong += run.mismatches as usize;
    }
    CaseMeasurement::none(wrong, clocks as usize, "wrong values")
}

fn dump_on_every_clock(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene = ideal(r#"{ family = "gold", degree = 3 }"#, 4, 0.0, 1)?;
    window(&mut scene, 3, 20);
    let run = CaseTestbench::new(&scene)?.attack(seed, 50_000)?;
    ensure!(run.results.len() > 1_000, "the run is too short");
    CaseMeasurement::none(run.mismatches as usize, run.results.len(), "clocks")
}

fn reset_everywhere() -> Result<CaseMeasurement, CaseError> {
    let mut testbench = CaseTestbench::new(&small_sensor()?)?;
    let mut script = StimulusScript::new(Vec::new());
    let mut clock = testbench.first_clock() - 1;
    for run in 1..=200 {
        clock += run;
        script.resets.push(clock..clock + 1 + run % 3);
        clock += 1 + run % 3;
    }
    // Hits that follow no pattern of the code: every third, then fifth sample.
    let mut first = 1;
    while first < clock * 4 {
        script.pulses[0].push(Pulse::of_one(Sample(first)));
        first += 3 + 2 * (first / 64 % 2);
    }
    let run = testbench.play(&script, clock)?;
    ensure!(run.results.len() > 300, "the run is too short");
    CaseMeasurement::none(run.mismatches as usize, run.results.len(), "clocks")
}

fn consumer_never_takes() -> Result<CaseMeasurement, CaseError> {
    let mut testbench = CaseTestbench::new(&small_sensor()?)?;
    let mut script = StimulusScript::new(one_sided(&testbench, 0, true, 5));
    let clocks = 400;
    script.stalls.push(0..clocks);
    let run = testbench.play(&script, clocks)?;
    let integration = testbench.interface.timing.scan.integration_chips;
    // The first result shows when its latency is over, the second overruns.
    let latency = u64::from(testbench.interface.result_latency_clocks);
    let shows = testbench.first_clock() - 1 + integration + latency;
    let overruns = shows + integration;
    let ports = testbench
        .port(&run, PortRole::Valid)
        .zip(testbench.port(&run, PortRole::Data))
        .zip(testbench.port(&run, PortRole::Overrun));
    let wrong = ports
        .zip(0..clocks)
        .filter(|&(((valid, data), overrun), clock)| {
            let expected = if clock < shows { (0, 0) } else { (1, 5) };
            (valid, data) != expected || overrun != u64::from(clock >= overruns)
        })
        .count();
    CaseMeasurement::none(wrong + run.mismatches as usize, clocks as usize, "clocks")
}

fn everything_at_once(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let code = r#"{ family = "gold", degree = 3, interleave = 2 }"#;
    let mut scene = ideal(code, 8, 0.0, 9)?;
    let mut other = scene.sources[0].clone();
    other.name = "other".to_owned();
    other.code = ideal(&code.replace("degree = 3,", "degree = 3, index = 2,"), 8, 0.0, 9)?.sources
        [0]
    .code
    .clone();
    scene.sources.push(other);
    let mut spad = scene.detectors[0].clone();
    spad.name = "other".to_owned();
    spad.reference = SourceIndex(1);
    scene.detectors.push(spad);
    window(&mut scene, 211, 43);
    scene.hardware.parallel = 5;
    scene.hardware.counter_width = Some(3);
    scene.hardware.total_counts = Some(true);
    scene.hardware.target = FpgaTarget::Ice40Hx8k;
    let run = CaseTestbench::new(&scene)?.attack(seed, 100_000)?;
    CaseMeasurement::none(run.mismatches as usize, run.results.len(), "clocks")
}

fn longest_code(seed: u64) -> Result<CaseMeasurement, CaseError> {
    // Degree 16 has no preferred pair of its own.
    let code = r#"{ family = "m-sequence", degree = 16, interleave = 4 }"#;
    let mut scene = ideal(code, 16, 0.0, 1_000)?;
    window(&mut scene, 16_776_950, 20);
    let run = CaseTestbench::new(&scene)?.attack(seed, 1_100_000)?;
    CaseMeasurement::none(run.mismatches as usize, run.results.len(), "clocks")
}
