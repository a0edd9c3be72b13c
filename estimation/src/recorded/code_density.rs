//! Widths of the samples' bins from dark counts: the code-density test.
//!
//! Avalanches without light come at any time alike, and know nothing of the clock. Where each of them
//! is one rising edge, the share of the rising edges at sample k of a chip is the width of its bin,
//! whatever the rate, the dead time and the afterpulses: all of these shift along with time. N rising
//! edges divide among samples as multinomial numbers, so a width is known to 1 / sqrt(N width) of
//! itself. (J. Doernberg, H.-S. Lee, D. A. Hodges, "Full-speed testing of A/D converters", IEEE J.
//! Solid-State Circuits 19 (1984) 820 to 827, has the test for converters.)
//!
//! Light that follows the clock would pass for widths. What follows the code, or comes and goes, shows
//! where counts of single chips, or of several recordings, are there: they have to agree.

use std::fmt::Write as _;

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF as _};

use crate::estimate::distance_m;
use crate::histogram::correlation::HistogramCorrelator;
use crate::math::share_interval;
use crate::photons::DetectorModel;
use crate::response::{Light, merged_share};
use crate::scan::Sampler;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Fewest counts at a sample, on average: each width is known to 5 % then.
const LEAST_COUNTS_OF_A_SAMPLE: f64 = 400.0;
/// The precision for which the required counts are reported.
const PRECISE: f64 = 0.01;
/// Scenes do not accept narrower bins, in sample periods.
const NARROWEST: f64 = 0.01;
/// Standard deviations by which parts of the counts may differ, and by which a code may show in them: 3
/// in 100,000 sound recordings are refused for the one, and fewer than 1 in 1,000 for the other, which is
/// the largest of all phase steps.
const MOST_DISAGREEMENT: f64 = 4.0;
const MOST_CODE: f64 = 5.5;
/// The largest counts are those of full counters if chance makes them so more seldom: of counts that are the same, and
/// of ones at which a binary counter ends.
const FULL_BY_CHANCE: f64 = 1e-2;
const SAME_BY_CHANCE: f64 = 1e-5;
/// A larger share of rising edges that are those of two avalanches would move widths.
const MOST_MERGED: f64 = 1e-3;

/// The parts in which dark counts are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DarkParts {
    /// The chips of the code period.
    Chips,
    /// Recordings of different length.
    Runs,
}

/// Dark counts of one detector by sample of a chip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DarkCounts {
    /// Index of the detector in the scene.
    pub detector: DetectorIndex,
    /// What the parts are.
    pub parts: DarkParts,
    /// Rising edges at each sample of a chip, part by part.
    pub counts: Vec<u64>,
}

/// Why dark counts do not give widths.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DensityError {
    /// There is one bin.
    #[error("one sample in a chip has the width of a chip; there is nothing to measure")]
    OneSample,
    /// Widths would be known too badly.
    #[error(
        "{counts} dark counts at {samples} samples are too few: widths would be off by {off:.0} % \
         and more; {LEAST_COUNTS_OF_A_SAMPLE} for each sample are 5 %, so count at least {needed}"
    )]
    TooFew {
        /// Counts in all.
        counts: u64,
        /// Samples of a chip.
        samples: usize,
        /// Standard deviation of a width, in per cent of it.
        off: f64,
        /// Counts that are enough.
        needed: u64,
    },
    /// Counters have come to their end.
    #[error(
        "{ties} of {numbers} numbers are the largest, {most}, which chance makes of {share:.0e} of recordings: \
         counters that stop there; record for less long, or count in wider numbers"
    )]
    Stopped {
        /// The largest number.
        most: u64,
        /// How many are as large.
        ties: usize,
        /// Of how many.
        numbers: usize,
        /// At most this share of recordings has so many by chance.
        share: f64,
    },
    /// A bin is hardly there.
    #[error(
        "sample {sample} has {count} of {counts} dark counts: a bin of {width:.4} sample periods is \
         too narrow for a real sampler; check that its pin is connected, and the order of the pins"
    )]
    NoWidth {
        /// The sample.
        sample: usize,
        /// Its counts.
        count: u64,
        /// Counts in all.
        counts: u64,
        /// What its width would be.
        width: f64,
    },
    /// Some pulses are between two samples.
    #[error(
        "pulses of {pulse_ps} ps fall between two samples that are {widest_ps:.0} ps apart and leave \
         no trace, so that shares of rising edges are not widths; make detector.pulse_width longer than \
         the widest bin"
    )]
    PulsesMissed {
        /// Width of a pulse.
        pulse_ps: f64,
        /// The widest bin, by its interval's end.
        widest_ps: f64,
    },
    /// Some rising edges are those of two avalanches.
    #[error(
        "up to {share:.4} of the avalanches without light follow so soon that the level is not low \
         again at a sample, so that shares of rising edges are not widths; make detector.pulse_width \
         shorter than the dead time by more than a sample"
    )]
    PulsesMerge {
        /// Their share.
        share: f64,
    },
    /// Chips, or recordings, differ.
    #[error(
        "the {parts} do not agree: their counts by sample differ by chi-square {chi_square:.1} for \
         {degrees} degrees of freedom, {z:.1} standard deviations; these are not dark counts alone, but \
         light that is correlated with the clock, or a sampler that changed: cover the detector and turn \
         off all lasers"
    )]
    PartsDiffer {
        /// What differs.
        parts: &'static str,
        /// By how much.
        chi_square: f64,
        /// What it would be on average.
        degrees: f64,
        /// In standard deviations of a normal number.
        z: f64,
    },
    /// The reference's code is in the counts.
    #[error(
        "the code of \"{source_name}\" is in the counts: at phase step {step} they follow it by {z:.1} \
         standard deviations; this is light that is correlated with the clock, not dark counts: cover \
         the detector and turn off all lasers"
    )]
    CodeShows {
        /// The source of the reference.
        source_name: String,
        /// Where it shows most.
        step: usize,
        /// How much, in standard deviations.
        z: f64,
    },
}

/// The bins of a sampler, measured by dark counts.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct CodeDensity {
    /// The detector's name.
    pub detector: String,
    /// Dark counts.
    pub counts: u64,
    /// Sample period of the scene.
    pub sample_period_ps: f64,
    /// Each sample of a chip, in order.
    pub samples: Vec<SampleWidth>,
    /// Chi-square of the counts for equally spaced samples.
    pub chi_square: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of a chi-square at least as large from equally spaced samples.
    pub p_value: f64,
    /// Shift of the mean arrival time relative to equally spaced samples.
    pub mean_arrival_ps: f64,
    /// Error of distances with a scene that lacks the sampler, averaged over delays.
    pub distance_error_m: f64,
    /// Disagreement between chips, or between recordings, in standard deviations; null for counts in one
    /// part.
    pub disagreement_in_std: Option<f64>,
    /// The largest correlation with the reference's code over all phase steps, less its mean, in standard
    /// deviations; null without counts by chip.
    pub code_in_std: Option<f64>,
}

/// A bin of a sampler.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct SampleWidth {
    /// Number of the sample in its chip.
    pub sample: usize,
    /// Its dark counts.
    pub count: u64,
    /// Width of its bin.
    pub width_ps: f64,
    /// The width's 95 % interval (Wilson 1927).
    pub width_ps_ci95: [f64; 2],
    /// How much later it is taken than an equally spaced sample; 0 for sample 0.
    pub late_ps: f64,
}

/// Widths of a detector's bins from dark counts, for its `sampler`.
///
/// # Errors
/// When the counts are too few, or are not of dark counts alone, or do not show widths.
///
/// # Panics
/// If there are not as many counts as samples of a chip for each part, or no such detector.
pub fn code_density(sensor: &Sensor, dark: &DarkCounts) -> Result<CodeDensity, DensityError> {
    let samples = sensor.clock().samples_per_chip as usize;
    assert!(!dark.counts.is_empty() && dark.counts.len().is_multiple_of(samples));
    if samples == 1 {
        return Err(DensityError::OneSample);
    }
    let of_samples = sums(&dark.counts, samples);
    let counts: u64 = of_samples.iter().sum();
    let mean = counts as f64 / samples as f64;
    if mean < LEAST_COUNTS_OF_A_SAMPLE {
        let needed = (LEAST_COUNTS_OF_A_SAMPLE * samples as f64).ceil() as u64;
        let off = 100.0 / mean.sqrt();
        return Err(DensityError::TooFew { counts, samples, off, needed });
    }
    check_stopped(&dark.counts)?;
    let code_in_std = code(sensor, dark)?;
    let disagreement = agreement(dark, &of_samples)?;
    let width = |count: u64| count as f64 / mean;
    if let Some(sample) = of_samples.iter().position(|&count| width(count) < NARROWEST) {
        let count = of_samples[sample];
        return Err(DensityError::NoWidth { sample, count, counts, width: width(count) });
    }
    let widths: Vec<f64> = of_samples.iter().map(|&count| width(count)).collect();
    let sampler = Sampler::of_widths(&widths);
    let sample_ps = sensor.clock().sample_period_ps();
    let bins: Vec<SampleWidth> = of_samples
        .iter()
        .enumerate()
        .map(|(sample, &count)| SampleWidth {
            sample,
            count,
            width_ps: sample_ps * width(count),
            width_ps_ci95: share_interval(count, counts)
                .map(|share| sample_ps * samples as f64 * share),
            late_ps: sample_ps * (sampler.instant(sample as i64) - sample as f64),
        })
        .collect();
    check_pulses(sensor, dark.detector, &bins)?;
    let chi_square: f64 = of_samples.iter().map(|&n| (n as f64 - mean).powi(2) / mean).sum();
    let degrees = samples - 1;
    let mean_arrival_ps = sample_ps * (sampler.mean_lateness(f64::INFINITY) - 0.5);
    Ok(CodeDensity {
        detector: sensor.scene().detectors[dark.detector].name.clone(),
        counts,
        sample_period_ps: sample_ps,
        samples: bins,
        chi_square,
        degrees_of_freedom: degrees,
        p_value: ChiSquared::new(degrees as f64).map_or(f64::NAN, |law| law.sf(chi_square)),
        mean_arrival_ps,
        distance_error_m: distance_m(mean_arrival_ps),
        disagreement_in_std: disagreement,
        code_in_std,
    })
}

/// Counts of each sample of a chip.
fn sums(counts: &[u64], samples: usize) -> Vec<u64> {
    (0..samples).map(|sample| counts.iter().skip(sample).step_by(samples).sum()).collect()
}

/// Whether counts have gone on counting: two Poisson numbers of mean m are the same in 1 / sqrt(4 pi m) of cases.
fn check_stopped(counts: &[u64]) -> Result<(), DensityError> {
    let most = counts.iter().copied().max().unwrap_or(0);
    let (numbers, ties) = (counts.len(), counts.iter().filter(|&&count| count == most).count());
    let same = 1.0 / (4.0 * std::f64::consts::PI * most as f64).sqrt();
    let ways = |other: usize| (numbers - other) as f64 / other as f64;
    let of_ties: f64 = (1..ties).map(|other| ways(other) * same).product();
    let is_full = (most + 1).is_power_of_two();
    // The largest is just the number at which a counter ends.
    let share = if is_full { of_ties * 0.5 / (most as f64).sqrt() } else { of_ties };
    match share < if is_full { FULL_BY_CHANCE } else { SAME_BY_CHANCE } {
        true => Err(DensityError::Stopped { most, ties, numbers, share }),
        false => Ok(()),
    }
}

/// How far the parts differ from what they have in common; none of one part.
fn agreement(dark: &DarkCounts, of_samples: &[u64]) -> Result<Option<f64>, DensityError> {
    let parts = dark.counts.chunks_exact(of_samples.len());
    let (number, all) = (parts.len() as f64, of_samples.iter().sum::<u64>() as f64);
    if number < 2.0 {
        return Ok(None);
    }
    let (mut chi_square, mut inverse_means) = (0.0, 0.0);
    for part in parts {
        let share = match dark.parts {
            // Chips last equally long.
            DarkParts::Chips => 1.0 / number,
            DarkParts::Runs => part.iter().sum::<u64>() as f64 / all,
        };
        for (&count, &of_sample) in part.iter().zip(of_samples) {
            let mean = share * of_sample as f64;
            if mean > 0.0 {
                chi_square += (count as f64 - mean).powi(2) / mean;
                inverse_means += 1.0 / mean;
            }
        }
    }
    let (degrees, name) = match dark.parts {
        DarkParts::Chips => (of_samples.len() as f64 * (number - 1.0), "chips of the code period"),
        DarkParts::Runs => ((of_samples.len() as f64 - 1.0) * (number - 1.0), "recordings"),
    };
    // Small counts make chi-square scatter more: its variance is that of so many degrees of freedom
    // of another unit. Then as a normal number (Wilson and Hilferty 1931).
    let freedom = 2.0 * degrees * degrees / (2.0 * degrees + inverse_means);
    let ninth = 2.0 / (9.0 * freedom);
    let z = ((chi_square / degrees).cbrt() - (1.0 - ninth)) / ninth.sqrt();
    match z > MOST_DISAGREEMENT {
        true => Err(DensityError::PartsDiffer { parts: name, chi_square, degrees, z }),
        false => Ok(Some(z)),
    }
}

/// How much the counts follow the reference's code at the phase step at which they do most, in
/// standard deviations. A slot of a chip has each bin once, so widths do not matter.
fn code(sensor: &Sensor, dark: &DarkCounts) -> Result<Option<f64>, DensityError> {
    if dark.parts != DarkParts::Chips {
        return Ok(None);
    }
    let code = sensor.reference(dark.detector);
    let balance = 2.0 * code.weight() as f64 / code.len() as f64 - 1.0;
    let bins: Vec<f64> = dark.counts.iter().map(|&count| count as f64).collect();
    let all: f64 = bins.iter().sum();
    let spread = (all * (1.0 - balance * balance)).sqrt();
    if spread == 0.0 {
        return Ok(None);
    }
    let correlator = HistogramCorrelator::new(code, sensor.clock().samples_per_chip);
    let signed = correlator.correlate(&bins).into_iter();
    let follows = signed.map(|signed| (signed - all * balance) / spread).enumerate();
    let Some((step, z)) = follows.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs())) else {
        return Ok(None);
    };
    match z.abs() > MOST_CODE {
        true => {
            let scene = sensor.scene();
            let source = &scene.sources[scene.detectors[dark.detector].reference];
            Err(DensityError::CodeShows { source_name: source.name.clone(), step, z })
        }
        false => Ok(Some(z)),
    }
}

/// Whether each avalanche is one rising edge.
fn check_pulses(
    sensor: &Sensor,
    detector: DetectorIndex,
    bins: &[SampleWidth],
) -> Result<(), DensityError> {
    let pulse_ps = sensor.scene().detectors[detector].pulse_width_ps;
    let widest_ps = bins.iter().map(|bin| bin.width_ps_ci95[1]).fold(0.0, f64::max);
    if pulse_ps < widest_ps {
        return Err(DensityError::PulsesMissed { pulse_ps, widest_ps });
    }
    let mut dark = sensor.scene().clone();
    dark.paths.clear();
    dark.detectors[detector].background_rate_cps = 0.0;
    let widths: Vec<f64> = bins.iter().map(|bin| bin.width_ps).collect();
    dark.detectors[detector].sampler = Sampler::of_widths(&widths);
    let model = DetectorModel::new(&Sensor::new(&dark), detector);
    let share = merged_share(&model, &Light::of(&model).of_cell(&model));
    match share > MOST_MERGED {
        true => Err(DensityError::PulsesMerge { share }),
        false => Ok(()),
    }
}

impl CodeDensity {
    /// The file that `detector.sampler.file` names.
    pub fn csv(&self) -> String {
        let mut text = format!(
            "# widths of the samples' bins of detector {:?}, in sample periods, by {} dark counts\n\
             sample,width_samples,low_samples,high_samples,count\n",
            self.detector, self.counts
        );
        for bin in &self.samples {
            let [low, high] = bin.width_ps_ci95.map(|width_ps| width_ps / self.sample_period_ps);
            let width = bin.width_ps / self.sample_period_ps;
            let _ = writeln!(text, "{},{width:.6},{low:.6},{high:.6},{}", bin.sample, bin.count);
        }
        text
    }

    /// Dark counts after which a width is known to 1 %, and how long they take at a rate; none
    /// where there are that many.
    fn missing(&self, dark_count_rate_cps: f64) -> Option<(u64, f64)> {
        let needed = self.samples.len() as f64 / (PRECISE * PRECISE);
        (needed > self.counts as f64).then(|| (needed as u64, needed / dark_count_rate_cps))
    }

    /// In words, for a detector with so many dark counts.
    pub fn text(&self, dark_count_rate_cps: f64) -> String {
        let mut text = format!(
            "{}: {} dark counts at {} samples of a chip, {} ps apart\n  \
             sample     counts  width / ps  95 % interval / ps    late / ps\n",
            self.detector,
            self.counts,
            self.samples.len(),
            self.sample_period_ps
        );
        for bin in &self.samples {
            let [low, high] = bin.width_ps_ci95;
            let interval = format!("{low:.1} to {high:.1}");
            let SampleWidth { sample, count, width_ps, late_ps, .. } = bin;
            let _ = writeln!(
                text,
                "  {sample:6} {count:10}  {width_ps:10.1}  {interval:>19} {late_ps:+12.1}"
            );
        }
        let differ = match self.p_value < 0.05 {
            true => "they are not equally far apart",
            false => "no difference from samples that are equally far apart",
        };
        let _ = writeln!(
            text,
            "chi-square against equal widths {:.1} for {} degrees of freedom, chance {:.2e}: {differ}",
            self.chi_square, self.degrees_of_freedom, self.p_value
        );
        let _ = writeln!(
            text,
            "mean arrival moved by {:+.1} ps: distances of a scene without the sampler are off by {:+.2} mm",
            self.mean_arrival_ps,
            self.distance_error_m * 1e3
        );
        let clock = match (self.disagreement_in_std, self.code_in_std) {
            (None, _) => {
                "not known whether light follows the clock: write bins of the code period, or \
                          several runs"
                    .to_owned()
            }
            (Some(z), None) => {
                format!(
                    "recordings agree ({z:+.1} standard deviations): no light that comes and goes"
                )
            }
            (Some(z), Some(code)) => format!(
                "chips agree ({z:+.1} standard deviations), and the code shows by {code:+.1} at most: no \
                 light that follows it"
            ),
        };
        let _ = writeln!(text, "{clock}");
        if let Some((needed, seconds)) = self.missing(dark_count_rate_cps) {
            let _ = write!(text, "for widths to 1 % count {needed}");
            match seconds.is_finite() {
                true => writeln!(text, ", {seconds:.1} s at {:.1} kcps", dark_count_rate_cps / 1e3),
                false => writeln!(text),
            }
            .unwrap_or_default();
        }
        text
    }
}
