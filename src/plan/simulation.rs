//! Parts of the simulation, from the light to the estimate.

use std::fmt::Write as _;

use super::movement;
use super::{Part, Saving};
use crate::light::distance_m;
use crate::photons::DetectorModel;
use crate::response::{check_merging, second_order_share};
use crate::scan::Sampler;
use crate::scene::{
    CellOutputs, Combination, Detector, DetectorIndex, EstimatorKind, JitterTail, LaserResponse,
    Path, SourceIndex,
};
use crate::sensor::Sensor;
use goldtof_hardware::parts::{kept, labelled, left_out};

pub(super) fn parts(sensor: &Sensor) -> Vec<Part> {
    let mut parts = Vec::new();
    for source in SourceIndex::of(&sensor.scene().sources) {
        parts.extend(source_parts(sensor, source.0));
    }
    parts.push(movement::part(sensor));
    for detector in DetectorIndex::of(&sensor.scene().detectors) {
        parts.push(interference(sensor, detector.0));
        parts.push(multipath(sensor, detector.0));
        parts.extend(detector_parts(sensor, detector.0));
    }
    parts.push(counter_edges(sensor));
    parts.push(full_scan(sensor));
    parts.extend(estimator(sensor));
    parts
}

/// Paths of `detector` that carry light.
fn lit_paths(sensor: &Sensor, detector: DetectorIndex) -> impl Iterator<Item = &Path> {
    let scene = sensor.scene();
    scene.paths.iter().filter(move |path| path.detector == detector && scene.is_lit(path))
}

/// A laser's edges in words.
fn edges(response: &LaserResponse) -> String {
    match response {
        LaserResponse::Ideal => String::new(),
        LaserResponse::Edges { rise_time_ps, fall_time_ps } => {
            format!(", rising in {rise_time_ps} ps and falling in {fall_time_ps} ps")
        }
        LaserResponse::Stretched { rise_time_ps, fall_time_ps, longer_ps } => {
            format!(
                ", on for {longer_ps:+} ps longer than its chips, rising in {rise_time_ps} ps and \
                 falling in {fall_time_ps} ps"
            )
        }
        LaserResponse::Measured(curve) => {
            format!(", with a measured response of {} flashes", curve.points.len())
        }
    }
}

/// A source's light in its on-state and in its off-state.
fn source_parts(sensor: &Sensor, index: usize) -> [Part; 2] {
    let source = &sensor.scene().sources[index];
    let name = |part| labelled(part, &source.name, sensor.scene().sources.len() > 1);
    let (modulated, off_state) = (name("modulated_light"), name("off_state_light"));
    let reaches_any = DetectorIndex::of(&sensor.scene().detectors)
        .any(|detector| lit_paths(sensor, detector).any(|path| path.source == SourceIndex(index)));
    if !reaches_any {
        let reason = format!("no light of \"{}\" reaches a detector", source.name);
        return [left_out(modulated, reason.clone()), left_out(off_state, reason)];
    }
    let ratio = source.extinction_ratio;
    let modulated = if ratio > 1.0 {
        kept(
            modulated,
            format!(
                "mean power {} pW, keyed by a code of {} on-chips in {}{}",
                in_pico(source.mean_power_w),
                source.code.weight(),
                source.code.len(),
                edges(&source.response)
            ),
        )
    } else {
        left_out(
            modulated,
            "extinction_ratio = 1: the light carries no code and counts as constant",
        )
    };
    let off_state = if ratio.is_finite() {
        kept(
            off_state,
            format!("extinction_ratio = {ratio}: background of 1/{ratio} of the on-rate"),
        )
    } else {
        left_out(off_state, "extinction_ratio is infinite: dark in the off-state")
    };
    [modulated, off_state]
}

/// Light of codes other than the reference's.
fn interference(sensor: &Sensor, index: usize) -> Part {
    let detector = &sensor.scene().detectors[index];
    let part = labelled("interference", &detector.name, sensor.scene().detectors.len() > 1);
    let mut others: Vec<String> = lit_paths(sensor, DetectorIndex(index))
        .filter(|path| path.source != detector.reference)
        .map(|path| format!("\"{}\"", sensor.scene().sources[path.source].name))
        .collect();
    others.dedup();
    if others.is_empty() {
        left_out(part, "no light of any other source reaches the detector")
    } else {
        kept(part, format!("light of {} reaches the detector too", others.join(", ")))
    }
}

/// More than one path of the reference's own code.
fn multipath(sensor: &Sensor, index: usize) -> Part {
    let detector = &sensor.scene().detectors[index];
    let part = labelled("multipath", &detector.name, sensor.scene().detectors.len() > 1);
    let paths = lit_paths(sensor, DetectorIndex(index))
        .filter(|path| path.source == detector.reference)
        .count();
    match paths {
        0 => left_out(part, "no light of the reference's source reaches the detector"),
        1 => left_out(part, "one path leads from the reference's source to the detector"),
        _ => kept(part, format!("{paths} paths lead from the reference's source to the detector")),
    }
}

fn detector_parts(sensor: &Sensor, index: usize) -> Vec<Part> {
    let detector = &sensor.scene().detectors[index];
    let several = sensor.scene().detectors.len() > 1;
    let name = |part| labelled(part, &detector.name, several);
    let crosstalk = (sensor.scene().hears_others(DetectorIndex(index)))
        .then(|| crosstalk(sensor, DetectorIndex(index), name("crosstalk")));
    let parts = vec![
        photon_detection(detector, name("photon_detection")),
        constant_rate(name("dark_counts"), "dark_count_rate", detector.dark_count_rate_cps),
        constant_rate(name("background"), "background_rate", detector.background_rate_cps),
        dead_time(detector, name("dead_time")),
        afterpulsing(detector, name("afterpulsing")),
        delay(detector, name("delay")),
        jitter(detector, name("jitter")),
        pulse_sampling(sensor, index, name("pulse_sampling")),
    ];
    let cells = (detector.cells > 1).then(|| cells(detector, name("cells")));
    parts.into_iter().chain(crosstalk).chain(cells).collect()
}

/// SPADs behind one input.
fn cells(detector: &Detector, part: String) -> Part {
    let rates = &detector.cell_dark_count_rates_cps;
    let talk = detector.cell_crosstalk.filter(|talk| talk.probability > 0.0);
    let is_expected = detector.combination == Combination::Adder
        && rates.iter().all(|rate| Some(rate) == rates.first())
        && talk.is_none();
    let combined = match (detector.combination, detector.coincidence) {
        (Combination::Adder, _) => "the hits of all of them added up".to_owned(),
        (Combination::Xor, _) => "the level high while an odd number of their pulses is".to_owned(),
        (Combination::Or, 1) => "the level high while any of their pulses is".to_owned(),
        (Combination::Or, most) => format!("the level high while {most} of their pulses overlap"),
    };
    let talk = talk.map_or_else(String::new, |talk| {
        format!("; {} % of avalanches fire another of them", 100.0 * talk.probability)
    });
    let inputs = match detector.cell_outputs {
        CellOutputs::Combined => "behind one input",
        CellOutputs::Separate => "with an input each",
    };
    kept(
        part,
        format!(
            "{} SPADs {inputs}, {combined}{talk}{}",
            detector.cells,
            match is_expected {
                true => "",
                false => "; no expectation, no bound and no fit: simulated photon by photon",
            }
        ),
    )
}

/// Avalanches that other detectors cause.
fn crosstalk(sensor: &Sensor, detector: DetectorIndex, part: String) -> Part {
    let scene = sensor.scene();
    let heard = scene.neighbours(detector).filter_map(|other| {
        let other = &scene.detectors[other];
        let talk = other.crosstalk()?;
        let delay_ns = in_nano(talk.delay_ps);
        Some(format!(
            "{} % of the avalanches of \"{}\", {delay_ns} ns later",
            100.0 * talk.probability,
            other.name
        ))
    });
    let heard = heard.collect::<Vec<_>>().join("; ");
    let law = match second_order_share(&DetectorModel::new(sensor, detector)) {
        Ok(share) => format!(
            "expected to first order in the probability, which leaves out about {:.2} % of the avalanches",
            100.0 * share
        ),
        Err(reason) => format!("no expectation, no bound and no fit: {reason}"),
    };
    kept(part, format!("fired by {heard}; {law}"))
}

/// Pulses that merge or fall between samples, and whether that can be expected.
fn pulse_sampling(sensor: &Sensor, index: usize, part: String) -> Part {
    let detector = &sensor.scene().detectors[index];
    let sample_ps = sensor.clock().sample_period_ps();
    let mut reason = format!(
        "pulses of {} ns are sampled every {} ns; those that merge count once",
        in_nano(detector.pulse_width_ps),
        in_nano(sample_ps)
    );
    let sampler = &detector.sampler;
    if detector.pulse_width_ps < sampler.widest() * sample_ps {
        reason += ", and those between two samples not at all";
    }
    if !sampler.is_even() {
        let [narrowest_ns, widest_ns] =
            [sampler.narrowest(), sampler.widest()].map(|samples| in_nano(samples * sample_ps));
        let late_ps = sampler.mean_lateness(f64::INFINITY) - Sampler::default().mean_lateness(1.0);
        let late_ps = late_ps * sample_ps;
        let _ = write!(
            reason,
            "; samples are {narrowest_ns:.3} to {widest_ns:.3} ns apart, which moves the mean arrival \
             by {late_ps:+.1} ps, {:+.2} mm; the calibration offset removes that as long as it does \
             not drift",
            distance_m(late_ps) * 1e3
        );
    }
    if let Err(obstacle) = check_merging(sensor, DetectorIndex(index)) {
        let _ = write!(reason, "; no expectation, no bound and no fit: {obstacle}");
    }
    kept(part, reason)
}

fn photon_detection(detector: &Detector, part: String) -> Part {
    let probability = detector.photon_detection_probability;
    if probability < 1.0 {
        kept(
            part,
            format!(
                "photon_detection_probability = {probability}: scales the rates, no photon is \
                 drawn in vain"
            ),
        )
    } else {
        left_out(part, "every photon fires a ready detector")
    }
}

fn constant_rate(part: String, key: &str, rate_cps: f64) -> Part {
    if rate_cps > 0.0 {
        kept(part, format!("{key} = {} kcps, as background", rate_cps / 1e3))
    } else {
        left_out(part, format!("{key} = 0"))
    }
}

fn dead_time(detector: &Detector, part: String) -> Part {
    match detector.dead_time_ps {
        0.0 => left_out(part, "dead_time = 0: the detector is always ready"),
        time => {
            // To a femtosecond: a threshold's dead time has no end of digits.
            let ns = (time * 1e3).round() / 1e6;
            let after = match detector.is_paralyzable() {
                true => "the last arrival, counted or not",
                false => "an avalanche",
            };
            kept(part, format!("blind for {ns} ns after {after}"))
        }
    }
}

fn afterpulsing(detector: &Detector, part: String) -> Part {
    match detector.afterpulsing_probability {
        0.0 => left_out(part, "the probability of an afterpulse is 0"),
        probability => kept(
            part,
            format!(
                "probability {probability}, decaying with {} ns",
                in_nano(detector.afterpulsing_time_constant_ps)
            ),
        ),
    }
}

fn delay(detector: &Detector, part: String) -> Part {
    match detector.delay_ps {
        0.0 => left_out(part, "delay = 0"),
        delay => kept(
            part,
            format!(
                "detections are registered {} ns late; the calibration offset removes it",
                in_nano(delay)
            ),
        ),
    }
}

fn jitter(detector: &Detector, part: String) -> Part {
    let tail = match &detector.jitter_tail {
        JitterTail::None => String::new(),
        JitterTail::Exponential { share, time_constant_ps } => {
            format!(", a tail of {time_constant_ps:.1} ps for {:.1} %", 100.0 * share)
        }
        JitterTail::Measured(curve) => {
            format!(", a measured tail of mean {:.1} ps", curve.mean_ps())
        }
    };
    if detector.jitter_ps.is_empty() && tail.is_empty() {
        return left_out(part, "no jitter is given: registered times keep their order");
    }
    let variance: f64 = detector.jitter_ps.iter().map(|j| j * j).sum();
    kept(
        part,
        format!(
            "{} Gaussian part{} of {:.1} ps together{tail}",
            detector.jitter_ps.len(),
            if detector.jitter_ps.len() == 1 { "" } else { "s" },
            variance.sqrt(),
        ),
    )
}

fn counter_edges(sensor: &Sensor) -> Part {
    const PART: &str = "counter_edge_delays";
    let given = sensor.scene().detectors.iter().any(|detector| {
        let counter = detector.counter;
        counter.rising_delay_ps > 0.0
            || counter.falling_delay_ps > 0.0
            || counter.transition_ps > 0.0
    });
    if given {
        left_out(
            PART,
            "sampled hardware applies the sign to samples and has no such edges; \
             only the tier in continuous time (events) uses them",
        )
    } else {
        left_out(PART, "the counter's edge delays and transition are 0")
    }
}

fn full_scan(sensor: &Sensor) -> Part {
    const PART: &str = "full_scan";
    let scan = &sensor.timing().scan;
    let (steps, period) = (scan.steps, scan.steps_per_period);
    if scan.is_full() {
        return kept(PART, format!("the scan covers all {period} phase steps"));
    }
    let part = left_out(
        PART,
        format!(
            "the scan asks for {steps} of {period} phase steps, from step {} on",
            scan.first_step
        ),
    );
    Part {
        saving: Some(Saving {
            time_fraction: (period - steps) as f64 / period as f64,
            basis: "share of the phase steps: photons and clocks".to_owned(),
        }),
        ..part
    }
}

/// The coarse and the fine stage, or the fit in their place.
fn estimator(sensor: &Sensor) -> Vec<Part> {
    let fine = match sensor.clock().samples_per_chip {
        1 => left_out("fine_estimate", "S = 1: two samples of the peak give no phase"),
        samples => kept(
            "fine_estimate",
            format!("phase of the fundamental over {} phase steps", 2 * samples),
        ),
    };
    let coarse = kept("coarse_estimate", "the maximum over the scan");
    let fit = match sensor.scene().estimator {
        EstimatorKind::Fft => left_out("model_fit", "estimator = \"fft\""),
        EstimatorKind::Model => kept("model_fit", "estimator = \"model\""),
    };
    vec![coarse, fine, fit]
}

fn in_nano(picoseconds: f64) -> f64 {
    picoseconds / 1e3
}

fn in_pico(watts: f64) -> f64 {
    // Rounded to nine digits: a decimal power is not exact as a double.
    (watts * 1e21).round() / 1e9
}
