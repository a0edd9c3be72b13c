//! Histograms of whole integration times, one tier or another.

use std::ops::Range;

use rayon::prelude::*;

use super::effort::check_draws;
use super::run_up::{Wanted, begun_by};
use crate::estimate::histogram::{Uncorrected, dead_time};
use crate::histogram::correction::CorrectionError;
use crate::histogram::innovations::Innovations;
use crate::histogram::{Histogram, HistogramError};
use crate::photons::fast::Recorder;
use crate::photons::random::RandomStream;
use crate::photons::{CellLevels, Detection, DetectorModel, PulseStream};
use crate::response::{MeanResponse, MeanResponseError};
use crate::scan::{Group, Sample};

/// Histograms that are made at once.
const AT_ONCE: u64 = 64;

/// Why there are no histograms.
#[derive(Debug, thiserror::Error)]
pub enum HistogramsError {
    /// How bins go together cannot be told.
    #[error(
        "the tier counts draws bins by how often the detector was ready at each, but {0}; take \
         --fidelity sampled"
    )]
    NotDrawn(Uncorrected),
    /// The light is too bright for the dead time.
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    /// The expected histogram cannot be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// What was counted is not a histogram.
    #[error(transparent)]
    Histogram(#[from] HistogramError),
    /// Detections come closer together than samples.
    #[error(
        "the tier events counts every detection: {count} in bin {bin} of {periods} code periods, \
         where the hardware sees one rising edge per sample at most, since the dead time is \
         shorter than a sample; take --fidelity sampled"
    )]
    SharedSample {
        /// The first bin with more detections than samples.
        bin: usize,
        /// Its detections.
        count: u64,
        /// Its samples.
        periods: u64,
    },
}

/// Samples of a code period, and of a histogram.
fn samples(model: &DetectorModel) -> [u64; 2] {
    let timing = &model.timing;
    let sampling = timing.sampling();
    [timing.code_chips(), timing.scan.integration_chips].map(|chips| sampling.samples_of(chips))
}

pub(super) fn histogram(
    model: &DetectorModel,
    bins: Vec<u64>,
) -> Result<Histogram, HistogramError> {
    let [period, all] = samples(model);
    Histogram::new(bins, model.timing.clock.samples_per_chip, all / period)
}

/// Bins drawn one after the other, each by what those before let one expect.
pub(super) fn counts(
    wanted: &Wanted,
    on_histogram: &mut dyn FnMut(Histogram),
) -> Result<(), HistogramsError> {
    let &Wanted { sensor, detector, seed, .. } = wanted;
    let dead_time = dead_time(sensor, detector).map_err(HistogramsError::NotDrawn)?;
    check_draws(sensor, detector)?;
    let model = &wanted.model();
    let [period, all] = samples(model);
    let means = MeanResponse::new(model)?.mean_bins();
    let bins = Innovations::new(dead_time, &means, (all / period) as f64)?;
    let one = |repetition: u64| {
        let key = model.key(seed, repetition, Group(0));
        histogram(model, bins.draw(&mut key.stream(RandomStream::Counts)))
    };
    in_batches(&wanted.scans, 1, |some| some.map(one).collect(), on_histogram)
}

/// Every detection in the bin of the first sample at or after it.
pub(super) fn events(
    wanted: &Wanted,
    on_histogram: &mut dyn FnMut(Histogram),
) -> Result<(), HistogramsError> {
    let (model, seed) = (&wanted.model(), wanted.seed);
    let [period, _] = samples(model);
    let samples_per_chip = model.timing.clock.samples_per_chip;
    let of = |detections: &mut dyn Iterator<Item = Detection>| {
        let mut bins = vec![0; period as usize];
        for detection in detections {
            let into_chip = detection.fraction * f64::from(samples_per_chip);
            let into_chip = model.sampler.first_from(into_chip);
            let sample = detection.chip * u64::from(samples_per_chip) + into_chip;
            // What comes after the last sample counts at the next first one: in the same
            // bin as what came before this histogram's first sample.
            bins[(sample % period) as usize] += 1;
        }
        histogram(model, bins).map_err(|error| match error {
            HistogramError::TooMany { bin, count, periods } => {
                HistogramsError::SharedSample { bin, count, periods }
            }
            other => HistogramsError::Histogram(other),
        })
    };
    let recorder = Recorder::new(model);
    let Some(at_once) = recorder.groups_at_once() else {
        let one = |repetition| of(&mut model.step(seed, repetition, Group(0)));
        return in_batches(&wanted.scans, 1, |some| some.map(one).collect(), on_histogram);
    };
    let recorded = |some: Range<u64>| {
        let groups: Vec<_> = some.map(|repetition| (repetition, Group(0))).collect();
        let lists = recorder.record(seed, &groups).into_iter();
        lists.map(|list| of(&mut list.iter().map(|time| time.detection()))).collect()
    };
    in_batches(&wanted.scans, at_once as u64, recorded, on_histogram)
}

/// Makes histograms on all cores, `at_once` of them with a call of `some`; `on_histogram` gets
/// them in order.
fn in_batches<E: Into<HistogramsError> + Send>(
    numbers: &Range<u64>,
    at_once: u64,
    some: impl Fn(Range<u64>) -> Vec<Result<Histogram, E>> + Sync,
    on_histogram: &mut dyn FnMut(Histogram),
) -> Result<(), HistogramsError> {
    let calls = (AT_ONCE / at_once).max(rayon::current_num_threads() as u64);
    let mut first = numbers.start;
    while first < numbers.end {
        let start_of = |call: u64| first.saturating_add(call * at_once).min(numbers.end);
        let made: Vec<_> = (0..calls)
            .into_par_iter()
            .flat_map_iter(|call| some(start_of(call)..start_of(call + 1)))
            .collect();
        first = start_of(calls);
        for histogram in made {
            on_histogram(histogram.map_err(Into::into)?);
        }
    }
    Ok(())
}

/// Rising edges of the sampled level, without a gap from one histogram to the next.
pub(super) fn sampled(
    wanted: &Wanted,
    on_histogram: &mut dyn FnMut(Histogram),
) -> Result<(), HistogramsError> {
    let (model, numbers) = (&wanted.model(), &wanted.scans);
    let [period, all] = samples(model);
    // A bin that is too narrow stays at its largest count.
    let width = wanted.sensor.scene().hardware.counter_width;
    let most = width.filter(|&width| width < u64::BITS).map_or(u64::MAX, |width| (1 << width) - 1);
    let from = begun_by([model], numbers.start);
    let cells = wanted.sensor.interface().input_cells;
    let mut stream = PulseStream::new(model, wanted.seed, from);
    let mut levels = CellLevels::new(cells.count);
    let mut pulses = vec![Vec::new(); model.inputs()];
    let mut changes = Vec::new();
    for number in from..numbers.end {
        let until = Sample((number - from + 1) * all);
        pulses.iter_mut().for_each(Vec::clear);
        stream.advance_inputs(until, &mut pulses);
        changes.clear();
        levels.advance(&pulses, until, &mut changes);
        let mut bins = vec![0_u64; period as usize];
        for hit in changes.iter().filter(|change| change.hits(&cells) > 0) {
            let bin = &mut bins[(hit.sample.0 % period) as usize];
            *bin = (*bin + 1).min(most);
        }
        if numbers.contains(&number) {
            on_histogram(histogram(model, bins)?);
        }
    }
    Ok(())
}
