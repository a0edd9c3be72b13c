//! Photons that an instrument recorded, in place of simulated ones: into a histogram and its estimates,
//! into the counts of a scan, and into the samples that drive Verilog.
//!
//! A recording has a mark at each epoch of the code (or at each so many), by which its clock is fitted to
//! the sensor's: a photon's place in the code follows, and with it the sample at which its pulse rises, as
//! the sampler of the hardware sees it.

mod epochs;
mod folding;

use std::io::Read;
use std::sync::Arc;

use goldtof_tags::{Channel, TagError, TagReader};
use serde::Serialize;

pub use self::epochs::Epochs;
use self::epochs::{EPOCHS_OF_A_LINE, EpochClock, EpochLine, MOST_OFFSET};
use self::folding::{EpochSamples, Folding};
use crate::histogram::{Histogram, HistogramError};
use crate::photons::{Pulse, StepCount};
use crate::recorded::{Assessment, RecordedHistogram, RecordedScan, assess, assess_histogram};
use crate::reference::blocks;
use crate::reference::photons::RecordedPulses;
use crate::reference::predictor::{ReferenceError, ReferenceModel};
use crate::reference::stimulus::clocks_for_scans;
use crate::scene::{Architecture, Detector, DetectorIndex, EstimatorKind, Scene};
use crate::sensor::Sensor;

/// Which channels of a recording are which.
#[derive(Debug, Clone)]
pub struct ReplayOptions {
    /// Channel of each detector, in their order.
    pub photons: Vec<Channel>,
    /// Channel of the marks at the code's epochs.
    pub epoch: Channel,
    /// Code periods from one mark to the next.
    pub epoch_periods: u64,
}

impl ReplayOptions {
    /// With channels as texts: `left=1` of the detector `left`, or `1` of a scene with one.
    ///
    /// # Errors
    /// When a text is not a channel, or not every detector has one.
    pub fn named(
        scene: &Scene,
        photons: &[String],
        epoch: Channel,
        epoch_periods: u64,
    ) -> Result<ReplayOptions, ReplayError> {
        let told = |text: &str, what: String| {
            Err(ReplayError::Channels(format!("photons {text}: {what}")))
        };
        let mut channels: Vec<Option<Channel>> = vec![None; scene.detectors.len()];
        for text in photons {
            let (name, channel) = match text.rsplit_once('=') {
                Some((name, channel)) => (Some(name), channel),
                None => (None, text.as_str()),
            };
            let channel: Channel = match channel.parse() {
                Ok(channel) if channel == epoch => {
                    return told(text, format!("channel {channel} is that of the epochs"));
                }
                Ok(channel) => channel,
                Err(what) => return told(text, what),
            };
            let which = match name {
                Some(name) => scene.detectors.iter().position(|d| d.name == name),
                None => (scene.detectors.len() == 1).then_some(0),
            };
            let Some(which) = which else {
                let right = scene.detectors.iter().map(|d| format!("{}={channel}", d.name));
                let right = right.collect::<Vec<_>>().join(" or ");
                return told(text, format!("it names no detector of the scene: write {right}"));
            };
            channels[which] = Some(channel);
        }
        let mut detectors = scene.detectors.iter().zip(&channels);
        if let Some((detector, _)) = detectors.find(|(_, channel)| channel.is_none()) {
            let name = &detector.name;
            return Err(ReplayError::Channels(format!(
                "detector \"{name}\" has no channel: name it as photons {name}=1, or with another number"
            )));
        }
        Ok(ReplayOptions {
            photons: channels.into_iter().flatten().collect(),
            epoch,
            epoch_periods,
        })
    }
}

/// What was read of a file.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct RecordingFile {
    /// Instrument and mode.
    pub kind: &'static str,
    /// A tick of its times.
    pub tick_s: f64,
    /// Records, overflows of the time among them.
    pub records: u64,
    /// Records that the header says there are.
    pub announced_records: Option<u64>,
    /// Bytes of a last record that is not whole.
    pub torn_bytes: u64,
    /// Records that are earlier than one before them.
    pub disordered: u64,
    /// Records of channels that nobody asked for.
    pub of_other_channels: u64,
    /// Marks of the code's epochs.
    pub epochs: Epochs,
}

/// What was recorded of a detector.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Replayed {
    /// The detector's name.
    pub detector: String,
    /// Photons between the first and the last epoch.
    pub photons: u64,
    /// Of these, those whose pulse began before the level was low again, or fell between two samples.
    pub unseen: u64,
    /// Photons a second.
    pub rate_cps: f64,
}

/// A recording, as a sensor would have seen it.
#[derive(Debug, Clone)]
pub struct Replay {
    /// The file.
    pub file: RecordingFile,
    /// Detector by detector.
    pub detectors: Vec<Replayed>,
    /// All whole code periods, folded.
    pub histograms: Vec<RecordedHistogram>,
    /// Pulses of the first scan, from the first epoch on: none if the recording pauses before its end.
    pub scan: Option<Arc<Vec<Vec<Pulse>>>>,
}

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file.
    #[error(transparent)]
    Tags(#[from] TagError),
    /// Its channels are not those that were named.
    #[error("{0}")]
    Channels(String),
    /// Its epochs are not the scene's.
    #[error("{0}")]
    Epochs(String),
    /// Its photons cannot be a sensor's.
    #[error("{0}")]
    Histogram(#[from] HistogramError),
    /// The hardware cannot be modelled.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
}

/// Most photons that are kept until the next epochs.
const MOST_WAITING: usize = 1 << 25;

/// Reads a recording and folds it by the sensor's code. `on_records` hears how many records have been read.
///
/// # Errors
/// When it cannot be read, or is not of this scene.
///
/// # Panics
/// If there is not one channel for each detector.
pub fn replay<R: Read>(
    sensor: &Sensor,
    reader: &mut TagReader<R>,
    options: &ReplayOptions,
    mut on_records: impl FnMut(u64),
) -> Result<Replay, ReplayError> {
    let scene = sensor.scene();
    assert_eq!(options.photons.len(), scene.detectors.len(), "a channel for each detector");
    if sensor.interface().input_cells.count > 1 {
        return Err(ReplayError::Channels(
            "a recording has a channel for each detector, and none for its cells: leave out \
             cell_outputs = \"separate\""
                .to_owned(),
        ));
    }
    let tick_s = reader.tick_ps() * 1e-12;
    let period_ps = sensor.timing().code_period_ps() * options.epoch_periods as f64;
    let mut clock = EpochClock::new(period_ps / reader.tick_ps(), tick_s);
    let sample_ps = sensor.clock().sample_period_ps();
    let bins = (sensor.timing().code_chips() * u64::from(sensor.clock().samples_per_chip)) as usize;
    let samples = EpochSamples {
        of_epoch: bins as u64 * options.epoch_periods,
        of_scan: sensor.timing().sampling().samples_of(sensor.interface().scan_clocks()),
    };
    let mut foldings: Vec<Folding> = scene
        .detectors
        .iter()
        .map(|detector| {
            Folding::new(detector.pulse_width_ps / sample_ps, detector.sampler.clone(), bins)
        })
        .collect();
    // Of each detector the photons that wait for the next line, and the marks.
    let channels: Vec<Channel> = options.photons.iter().copied().chain([options.epoch]).collect();
    let mut waiting: Vec<Vec<u64>> = vec![Vec::new(); channels.len()];
    let mut scan_is_whole = true;
    let mut fold = |line: EpochLine, waiting: &mut [Vec<u64>]| {
        // A pause within the scan leaves it without its photons.
        let reached = line.first() * samples.of_epoch;
        scan_is_whole &= !line.begins || reached == 0 || reached >= samples.of_scan;
        for (folding, waiting) in foldings.iter_mut().zip(waiting) {
            folding.fold(&line, waiting, &samples);
        }
    };
    while reader.read_channels(&channels, &mut waiting)? {
        let marks = waiting.last_mut().map(std::mem::take).unwrap_or_default();
        for ticks in marks {
            if let Some(line) = clock.mark(ticks) {
                fold(line, &mut waiting);
            }
        }
        if waiting.iter().map(Vec::len).sum::<usize>() > MOST_WAITING {
            return Err(ReplayError::Epochs(format!(
                "channel {} has no two epochs within {MOST_WAITING} photons: --epoch names the channel of \
                 the code's epochs",
                options.epoch
            )));
        }
        on_records(reader.records());
    }
    if let Some(line) = clock.end() {
        fold(line, &mut waiting);
    }
    let epochs = clock.found(options.epoch_periods);
    check_epochs(&epochs, options, sensor, period_ps)?;
    let seconds = epochs.periods as f64 * sensor.timing().code_period_ps() * 1e-12;
    let replayed = |(detector, folding): (&Detector, &Folding)| Replayed {
        detector: detector.name.clone(),
        photons: folding.photons,
        unseen: folding.unseen,
        rate_cps: folding.photons as f64 / seconds,
    };
    let detectors: Vec<Replayed> = scene.detectors.iter().zip(&foldings).map(replayed).collect();
    if let Some(number) = detectors.iter().position(|detector| detector.photons == 0) {
        return Err(ReplayError::Channels(format!(
            "channel {} has no photon between the first and the last epoch; {} records are of \
             channels that were not named",
            options.photons[number],
            reader.of_other_channels()
        )));
    }
    let is_whole = scan_is_whole && epochs.periods * bins as u64 >= samples.of_scan;
    let pulses = foldings.iter_mut().map(|folding| std::mem::take(&mut folding.pulses)).collect();
    let histogram = |(detector, folding): (DetectorIndex, &Folding)| {
        let samples_per_chip = sensor.clock().samples_per_chip;
        let histogram = Histogram::new(folding.bins(), samples_per_chip, epochs.periods)?;
        Ok(RecordedHistogram { detector, histogram })
    };
    let histograms = DetectorIndex::of(&scene.detectors).zip(&foldings).map(histogram);
    Ok(Replay {
        file: RecordingFile {
            kind: reader.kind(),
            tick_s,
            records: reader.records(),
            announced_records: reader.announced(),
            torn_bytes: reader.torn_bytes(),
            disordered: reader.disordered(),
            of_other_channels: reader.of_other_channels(),
            epochs,
        },
        detectors,
        scan: is_whole.then(|| Arc::new(pulses)),
        histograms: histograms.collect::<Result<_, HistogramError>>()?,
    })
}

/// Whether the marks are the epochs of the scene's code.
fn check_epochs(
    epochs: &Epochs,
    options: &ReplayOptions,
    sensor: &Sensor,
    period_ps: f64,
) -> Result<(), ReplayError> {
    let told = |what: String| Err(ReplayError::Epochs(what));
    let channel = options.epoch;
    if epochs.epochs + epochs.stray == 0 {
        return told(format!(
            "channel {channel} has no record: --epoch names the channel of the code's epochs"
        ));
    }
    if epochs.periods == 0 || epochs.stray > epochs.epochs {
        return told(format!(
            "the marks of channel {channel} are not {:.3} us apart, the scene's code period times {} \
             ({} of {} marks are); --epoch-periods says how many code periods lie between two marks",
            period_ps * 1e-6,
            options.epoch_periods,
            epochs.epochs,
            epochs.epochs + epochs.stray
        ));
    }
    if epochs.period_error_fraction.abs() > MOST_OFFSET {
        return told(format!(
            "the marks of channel {channel} say that a code period is {:+.3} % longer than the scene's; \
             clocks differ by less than {} %: is clock.chip_period right?",
            epochs.period_error_fraction * 1e2,
            MOST_OFFSET * 1e2
        ));
    }
    let chip_s = sensor.scene().chip_period_ps * 1e-12;
    if epochs.jitter_std_s > 0.5 * chip_s {
        return told(format!(
            "the marks of channel {channel} scatter by {:.3} ns, more than half a chip",
            epochs.jitter_std_s * 1e9
        ));
    }
    Ok(())
}

/// The sensor as one that keeps a histogram of a recording's code periods.
pub fn as_histogram(sensor: &Sensor, epochs: &Epochs) -> Sensor {
    timed_by(sensor, epochs, epochs.epochs).with(|scene| {
        scene.hardware.architecture = Architecture::Histogram;
        scene.hardware.parallel = 1;
        scene.hardware.counter_width = None;
        scene.hardware.peak_detector = false;
        scene.scan.first_step = 0;
        scene.scan.steps = scene.scan.steps_per_period;
        let code = &scene.sources[scene.detectors[DetectorIndex(0)].reference].code;
        scene.scan.integration_chips = epochs.periods * code.len();
    })
}

/// The sensor whose delays are known no better than `marks` of a recording's epochs tell the code's place: these
/// scatter about straight lines, all of whose photons are as far off as the line.
fn timed_by(sensor: &Sensor, epochs: &Epochs, marks: u64) -> Sensor {
    let of_marks_ps = epochs.jitter_std_s * 1e12 / (marks.max(1) as f64).sqrt();
    sensor.with(|scene| {
        for detector in &mut scene.detectors {
            detector.delay_std_ps = detector.delay_std_ps.hypot(of_marks_ps);
        }
    })
}

/// What a recording says: the JSON of `goldtof replay`.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct ReplayReport {
    /// The recording.
    pub file: RecordingFile,
    /// What was recorded of each detector.
    pub detectors: Vec<Replayed>,
    /// What all whole code periods say, as a histogram, detector by detector: by the phase, and by the
    /// model.
    pub histograms: Vec<Assessment>,
    /// What the counts say that the scene's hardware would have made of the first scan; none of a scene with
    /// a histogram, or of a recording that is shorter.
    pub scan: Vec<Assessment>,
}

/// What a recording says, and the counts of its first scan.
///
/// # Errors
/// When the hardware cannot be modelled.
pub fn report(
    sensor: &Sensor,
    replay: &Replay,
) -> Result<(ReplayReport, Vec<RecordedScan>), ReplayError> {
    let epochs = &replay.file.epochs;
    let folded = as_histogram(sensor, epochs);
    let by = |kind: EstimatorKind| Sensor::new(&folded.scene().estimated_by(kind));
    let estimators = [EstimatorKind::Fft, EstimatorKind::Model].map(by);
    let of_one =
        |one: &RecordedHistogram| estimators.each_ref().map(|sensor| assess_histogram(sensor, one));
    let scans = match &replay.scan {
        Some(pulses) if sensor.interface().histogram().is_none() => counts_of(sensor, pulses)?,
        _ => Vec::new(),
    };
    // The counts round the peak are of one straight line: at its ends it is twice as far off as on average.
    let of_scan = timed_by(sensor, epochs, epochs.epochs.min(EPOCHS_OF_A_LINE as u64) / 2);
    let report = ReplayReport {
        file: replay.file.clone(),
        detectors: replay.detectors.clone(),
        histograms: replay.histograms.iter().flat_map(of_one).collect(),
        scan: scans.iter().map(|scan| assess(&of_scan, scan)).collect(),
    };
    Ok((report, scans))
}

/// The counts of a scan that the sensor's hardware makes of pulses, by the bit-exact model: detector by
/// detector.
///
/// # Errors
/// When the hardware cannot be modelled.
///
/// # Panics
/// If the hardware keeps histograms.
pub fn counts_of(
    sensor: &Sensor,
    pulses: &Arc<Vec<Vec<Pulse>>>,
) -> Result<Vec<RecordedScan>, ReplayError> {
    let interface = sensor.interface();
    assert!(interface.histogram().is_none(), "bins are folded without the hardware");
    let of_detector = |detector| RecordedScan { detector, counts: Vec::new(), has_totals: true };
    let mut scans: Vec<RecordedScan> =
        DetectorIndex::of(&sensor.scene().detectors).map(of_detector).collect();
    let mut reference = ReferenceModel::new(interface.clone())?;
    let mut stimulus = RecordedPulses::new(Arc::clone(pulses), interface);
    blocks::results(&mut reference, &mut stimulus, clocks_for_scans(interface, 1), &mut |result| {
        if result.scan == 0 {
            let count = StepCount { signed: result.count, total: result.total };
            scans[result.detector.0].counts.push(count);
        }
    });
    Ok(scans)
}
