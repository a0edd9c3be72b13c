//! Photons as an instrument records them: simulated detections, written as a PTU file by a writer of
//! this test's own, come out of `replay` as the histogram, the counts and the estimates that they are.

use std::io::Cursor;
use std::path::Path;

use goldtof::Jobs as _;
use goldtof::cosim::{CosimOptions, Verdict};
use goldtof::histogram::Histogram;
use goldtof::photons::DetectorModel;
use goldtof::recorded::{assess, assess_histogram};
use goldtof::replay::{
    Replay, ReplayError, ReplayOptions, as_histogram, counts_of, replay, report,
};
use goldtof::scan::{Group, Step};
use goldtof::scene::{self, DetectorIndex, Setting};
use goldtof::sensor::Sensor;
use goldtof_tags::{Channel, Format, TagReader};
use optics_support::recordings::{HYDRAHARP_2_T2, Hydraharp, header};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const FIRST: DetectorIndex = DetectorIndex(0);

fn quick(settings: &[&str]) -> Sensor {
    let settings: Vec<Setting> = settings.iter().map(|s| s.parse().unwrap()).collect();
    Sensor::new(&scene::load_with(Path::new("scenes/quick.toml"), &settings).unwrap())
}

/// The light of a scene for as long as `integration`: registered times in chips from an epoch on.
fn detections_chips(settings: &[&str], integration: &str) -> Vec<f64> {
    let integration = format!("scan.integration={integration}");
    let settings: Vec<&str> = settings.iter().copied().chain([integration.as_str()]).collect();
    let sensor = quick(&settings);
    let model = DetectorModel::new(&sensor, FIRST);
    model.step(3, 0, Group(0)).map(|one| one.chip as f64 + one.fraction).collect()
}

/// Times in ps, each with a channel: 0 and up are inputs, below 0 the marker of that number.
fn hydraharp(mut records: Vec<(f64, i32)>) -> Vec<u8> {
    records.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut file = Hydraharp::default();
    records.into_iter().for_each(|(ps, channel)| file.put(ps.round() as u64, channel));
    file.file()
}

/// A recording of detections whose clock is `offset` off, with marks at every `every` periods of 31
/// chips of 8 ns that jitter by up to 100 ps.
fn recording(detections: &[f64], offset: f64, every: usize) -> Vec<u8> {
    let jitter_ps = |mark: usize| ((mark * 7919) % 201) as f64 - 100.0;
    recording_with(detections, offset, every, jitter_ps)
}

fn recording_with(
    detections: &[f64],
    offset: f64,
    every: usize,
    mut jitter_ps: impl FnMut(usize) -> f64,
) -> Vec<u8> {
    let ps = |chips: f64| 5_000_000.0 + chips * 8000.0 * (1.0 + offset);
    let mut records: Vec<(f64, i32)> = detections.iter().map(|chips| (ps(*chips), 0)).collect();
    let last = detections.last().unwrap() / 31.0;
    for mark in (0..last as usize).step_by(every) {
        records.push((ps(mark as f64 * 31.0) + jitter_ps(mark), -1));
    }
    // A marker and an input that nobody asks for.
    records.push((ps(40.0), -2));
    records.push((ps(41.0), 5));
    hydraharp(records)
}

fn options(every: u64) -> ReplayOptions {
    ReplayOptions {
        photons: vec![Channel::Input(1)],
        epoch: Channel::Marker(1),
        epoch_periods: every,
    }
}

fn replayed(sensor: &Sensor, bytes: Vec<u8>, every: u64) -> Result<Replay, ReplayError> {
    let mut reader = TagReader::new(Cursor::new(bytes), "test.ptu", None)?;
    replay(sensor, &mut reader, &options(every), |_| ())
}

#[test]
fn a_recording_is_the_histogram_that_its_photons_are() {
    let sensor = quick(&[]);
    let detections = detections_chips(&[], "4 ms");
    let told = replayed(&sensor, recording(&detections, 50e-6, 16), 16).unwrap();
    assert_eq!((told.file.epochs.pauses, told.file.epochs.stray), (0, 0));
    assert_eq!(told.file.of_other_channels, 2);
    assert_eq!((told.file.torn_bytes, told.file.disordered), (0, 0));
    let error = told.file.epochs.period_error_fraction;
    assert!((error - 50e-6).abs() < 1e-7, "{error}");
    // Even over 201 steps of a picosecond: 58 ps.
    assert!((told.file.epochs.jitter_std_s * 1e12 - 58.0).abs() < 4.0, "{:?}", told.file.epochs);
    // The same photons by their own times; a pulse of 7 ns is over before the dead time of 14 ns is.
    let until = told.file.epochs.periods as f64 * 31.0;
    let mut bins = vec![0_i64; 248];
    let counted = detections.iter().filter(|chips| **chips < until);
    counted.for_each(|chips| bins[(chips * 8.0).ceil() as usize % 248] += 1);
    let moved: i64 = told.histograms[0]
        .histogram
        .bins()
        .iter()
        .zip(&bins)
        .map(|(replayed, own)| (*replayed as i64 - own).abs())
        .sum();
    let all: i64 = bins.iter().sum();
    // A tick, and what is left of the marks' jitter, moves a photon in a thousand over a border of 1 ns.
    assert!(all > 70_000 && moved < all / 200, "{moved} of {all}");
    // And it is what the scene lets one expect, at the scene's distance.
    let folded = as_histogram(&sensor, &told.file.epochs);
    let assessment = assess_histogram(&folded, &told.histograms[0]);
    assert!(assessment.diagnosis.unwrap().causes.is_empty());
    let (found_m, std_m) =
        (assessment.fitted_distance_m.unwrap(), assessment.fitted_distance_std_m.unwrap());
    assert!((found_m - 3.2).abs() < 4.0 * std_m && std_m < 0.01, "{found_m} {std_m}");
}

/// The same photons beside marks that scatter by 2 ns: distances differ by what so many marks leave, and say so, and
/// no cable is accused.
#[test]
fn marks_that_scatter_are_in_what_is_said() {
    let sensor = quick(&[]);
    let detections = detections_chips(&[], "4 ms");
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut found = Vec::new();
    for _ in 0..12 {
        let jitter_ps = |_| {
            2000.0 * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut random)
        };
        let told = replayed(&sensor, recording_with(&detections, 0.0, 16, jitter_ps), 16).unwrap();
        let (report, _) = report(&sensor, &told).unwrap();
        let model = &report.histograms[1];
        assert!(model.diagnosis.as_ref().is_some_and(|said| said.causes.is_empty()), "{model}");
        // 2 ns over the root of 1,000 marks, and the photons' own.
        let std_m = model.estimate.expected_std_m.unwrap();
        assert!((std_m / 9.5e-3 - 1.0).abs() < 0.1, "{std_m}");
        assert!(
            model.fitted_distance_std_m.is_some_and(|std_m| (std_m / 9.5e-3 - 1.0).abs() < 0.1)
        );
        found.push(model.fitted_distance_m.unwrap());
    }
    // The photons are the same in all: sqrt(chi-square / 11) of 11 degrees, within its 0.1 % quantiles.
    let mean = found.iter().sum::<f64>() / 12.0;
    let squares: f64 = found.iter().map(|distance_m| ((distance_m - mean) / 9.48e-3).powi(2)).sum();
    assert!((1.6..31.3).contains(&squares), "{squares}: {found:?}");
}

#[test]
fn a_scan_of_it_is_what_model_and_verilog_count() {
    let sensor = quick(&[]);
    let detections = detections_chips(&[], "6 ms");
    let told = replayed(&sensor, recording(&detections, -20e-6, 16), 16).unwrap();
    let pulses = told.scan.expect("a scan takes 4.96 ms");
    let scans = counts_of(&sensor, &pulses).unwrap();
    assert_eq!(scans[0].counts.len(), 248);
    // By the definition of a phase step: rising edges within it, up or down by the delayed code.
    let chips = &sensor.reference(FIRST).chips;
    let timing = sensor.timing();
    let samples_of_step = timing.scan.integration_chips * 8;
    let mut low_from = 0;
    let mut counts = vec![(0_i64, 0_u64); 248];
    for pulse in &pulses[0] {
        let rises = pulse.first.0 > low_from || low_from == 0;
        low_from = low_from.max(pulse.end.0);
        let step = (pulse.first.0 / samples_of_step) as usize;
        if !rises || step >= 248 {
            continue;
        }
        let delay = timing.scan.phase_step(Step(step as u64)) as i64;
        let chip = (pulse.first.0 as i64 - delay).div_euclid(8).rem_euclid(31) as usize;
        counts[step].0 += 2 * i64::from(chips[chip]) - 1;
        counts[step].1 += 1;
    }
    for (step, (counted, own)) in scans[0].counts.iter().zip(&counts).enumerate() {
        assert_eq!((counted.signed, counted.total), *own, "step {step}");
    }
    let assessment = assess(&sensor, &scans[0]);
    assert!(assessment.diagnosis.unwrap().causes.is_empty());
    // The emitted Verilog counts the same from the same photons.
    let options = CosimOptions { recorded: Some(pulses), ..Default::default() };
    let cosim = sensor.cosim(&options).unwrap();
    assert_eq!(cosim.report.verdict, Verdict::Match);
    let sent: Vec<i64> = cosim.counts[0].iter().map(|count| count.signed).collect();
    assert_eq!(sent, counts.iter().map(|count| count.0).collect::<Vec<_>>());
}

#[test]
fn pauses_and_torn_ends_are_told_and_left_out() {
    let sensor = quick(&[]);
    let detections = detections_chips(&[], "4 ms");
    // Without the second quarter, in photons and marks.
    let paused: Vec<f64> =
        detections.iter().copied().filter(|chips| !(125e3..250e3).contains(chips)).collect();
    let ps = |chips: f64| chips * 8000.0;
    let mut records: Vec<(f64, i32)> = paused.iter().map(|chips| (ps(*chips), 0)).collect();
    let marks = (0..16_000).step_by(16).map(|mark| f64::from(mark) * 31.0);
    records.extend(marks.filter(|chips| !(125e3..250e3).contains(chips)).map(|at| (ps(at), -1)));
    let mut bytes = hydraharp(records);
    bytes.truncate(bytes.len() - 3);
    let told = replayed(&sensor, bytes, 16).unwrap();
    assert_eq!((told.file.torn_bytes, told.file.epochs.pauses), (1, 1));
    assert!(told.scan.is_none());
    let periods = told.file.epochs.periods as f64;
    // Marks are 16 periods apart, and each side of the pause loses what is beyond its last one.
    assert!((periods - 0.75 * 16_000.0).abs() <= 64.0, "{periods}");
    let folded = as_histogram(&sensor, &told.file.epochs);
    let assessment = assess_histogram(&folded, &told.histograms[0]);
    assert!(assessment.diagnosis.unwrap().causes.is_empty());
}

#[test]
fn pairs_are_read_as_well() {
    let sensor = quick(&[]);
    let detections = detections_chips(&[], "1 ms");
    let mut pairs: Vec<(u64, u64)> =
        detections.iter().map(|chips| ((chips * 8000.0).round() as u64 + 50, 7)).collect();
    pairs.extend((0..4000).step_by(16).map(|mark| (mark * 248_000 + 50, 2)));
    pairs.sort_unstable();
    let bytes: Vec<u8> = pairs
        .iter()
        .flat_map(|(ps, channel)| [ps.to_le_bytes(), channel.to_le_bytes()].concat())
        .collect();
    let mut reader = TagReader::new(Cursor::new(bytes), "pairs.bin", Some(Format::Pairs)).unwrap();
    let options = ReplayOptions {
        photons: vec![Channel::Input(7)],
        epoch: Channel::Input(2),
        epoch_periods: 16,
    };
    let told = replay(&sensor, &mut reader, &options, |_| ()).unwrap();
    let histogram: &Histogram = &told.histograms[0].histogram;
    assert_eq!(told.file.epochs.jitter_std_s, 0.0);
    assert_eq!(histogram.periods(), 3984);
    assert_eq!(histogram.total() + told.detectors[0].unseen, told.detectors[0].photons);
}

#[test]
fn what_is_no_recording_of_the_scene_is_told_by_what_would_be() {
    let sensor = quick(&[]);
    let detections = detections_chips(&[], "400 us");
    let sound = || recording(&detections, 0.0, 16);
    let error = |sensor: &Sensor, bytes: Vec<u8>, options: &ReplayOptions| {
        let told = TagReader::new(Cursor::new(bytes), "test.ptu", None)
            .map_err(ReplayError::from)
            .and_then(|mut reader| replay(sensor, &mut reader, options, |_| ()));
        told.expect_err("it is refused").to_string()
    };
    let of = |photons: u16, epoch: u8, epoch_periods: u64| ReplayOptions {
        photons: vec![Channel::Input(photons)],
        epoch: Channel::Marker(epoch),
        epoch_periods,
    };
    assert!(replayed(&sensor, sound(), 16).is_ok());
    for (told, options) in [
        ("channel 3 has no photon", of(3, 1, 16)),
        ("channel m3 has no record", of(1, 3, 16)),
        ("are not 0.248 us apart", of(1, 2, 1)),
    ] {
        let error = error(&sensor, sound(), &options);
        assert!(error.contains(told), "{error}");
    }
    // Chips that are half a per cent longer than the laser's.
    let slow = error(&quick(&["clock.chip_period=8.04 ns"]), sound(), &of(1, 1, 16));
    assert!(slow.contains("is clock.chip_period right?"), "{slow}");
    let t3 = header(0x0101_0304, 1e-12, 0);
    let at = t3.windows(4).position(|word| word == [0x04, 0x03, 0x01, 0x01]).unwrap();
    for (bytes, byte, told) in [
        (t3, at, "HydraHarp 400 version 2 T3, times since a sync pulse; record in T2 mode"),
        (header(0x77, 1e-12, 0), at, "records of type 0x00000077 are not known"),
        (header(HYDRAHARP_2_T2, 1.0, 0), 16 + 48 + 16 + 40, "MeasDesc_GlobalResolution is 1e0 s"),
        (sound()[..100].to_vec(), 100, "the file ends within its header"),
        ([3_u64, 1 << 40].map(u64::to_le_bytes).concat(), 8, "channel 1099511627776"),
    ] {
        let error = error(&sensor, bytes, &of(1, 1, 16));
        assert!(error.starts_with(&format!("test.ptu, byte {byte}: ")), "{error}");
        assert!(error.contains(told), "{error}");
    }
}
