//! For which scenes and questions each tier's answers hold.

use super::Tier;
use crate::estimate::coverage::{count_limit, most_counts, short_steps};
use crate::estimate::fit::shared_light;
use crate::estimate::report::SELDOM;
use crate::estimate::{Prediction, PredictionError};
use crate::photons::DetectorModel;
use crate::photons::memory::DetectorMemory;
use crate::response::{Light, MeanResponse, SecondMoments, merged_share};
use crate::scan::{Group, Step};
use crate::scene::{Architecture, DetectorIndex, EstimatorKind, PathIndex};
use crate::sensor::Sensor;

/// Shares of detections, or of a variance, that are too large to leave out.
const SHARE: f64 = 0.01;
/// The mean response is worked out over at most 10^5 dead times before a code
/// period, in which a detector forgets its start up to this product of light and
/// dead time: 3 s^2 = 10^5.
const MOST_SATURATION: f64 = 182.0;
/// The domain of a tier, in words.
pub fn of(tier: Tier, architecture: Architecture) -> &'static str {
    match architecture {
        Architecture::UpDown => of_counts(tier),
        Architecture::Histogram => of_histograms(tier),
    }
}

fn of_histograms(tier: Tier) -> &'static str {
    match tier {
        Tier::Expected => {
            "exact means of the sampled hardware's bins, but for saturated ones; the standard \
             deviation is linear in their errors, takes bins that dead time and afterpulses are \
             taken out of as independent, and is that of scans whose coarse stage finds the path"
        }
        Tier::Counts => {
            "bins of exact means, each drawn by what those before let one expect: a detection \
             keeps others away for the dead time and traps afterpulses, of which two pending at \
             once, saturated bins, and what the last bins say of the first are left out"
        }
        Tier::Events => {
            "every detection, in the bin of the first sample at or after it; the hardware's \
             sampling (pulses that merge or slip between samples, saturated bins) is left out"
        }
        Tier::Sampled => {
            "every detection and every sample: the rising edges that the hardware sees"
        }
        Tier::Rtl => "the Verilog itself, compared with the reference model at every clock",
    }
}

fn of_counts(tier: Tier) -> &'static str {
    match tier {
        Tier::Expected => {
            "exact means and covariances of the sampled hardware's counts, but for saturated ones; \
             the standard deviation is linear in the counts' errors and that of scans whose coarse stage finds \
             the path; the noise of the coarse stage itself, which can add a few tenths of a \
             millimetre to the bias, is left out"
        }
        Tier::Counts => {
            "counts with exact means, variances and covariances of the sampled hardware's, but \
             for saturated ones, drawn as normal numbers (small ones as binomial, Poisson or negative binomial, and \
             a covariance of counts upwards and downwards only where it is positive); those of \
             the first scan stand for all"
        }
        Tier::Events => {
            "every detection, exact for the article's continuous-time counter; the hardware's \
             sampling (pulses that merge or slip between samples, saturated counts) is left out"
        }
        Tier::Sampled => "every detection and every sample; bit for bit the hardware's counts",
        Tier::Rtl => "the Verilog itself, compared with the reference model at every clock",
    }
}

/// A path of the sensor, and what is expected of it.
pub type Predicted = (PathIndex, Result<Prediction, PredictionError>);

/// What of a detector in a scene is outside a tier's domain, and what that does
/// to the answer. `predicted` is what the tier that draws nothing says of the
/// detector's paths.
pub fn warnings(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: Tier,
    predicted: &[Predicted],
) -> Vec<String> {
    let model = DetectorModel::new(sensor, detector);
    let light = Light::of(&model).of_cell(&model);
    let view =
        View { sensor, detector, model: &model, brightest_per_chip: light.brightest_per_chip() };
    let mut warnings = Vec::new();
    if tier == Tier::Events {
        warnings.extend(view.merged_pulses());
        warnings.extend(view.missed_pulses());
        warnings.extend(view.uneven_samples());
        warnings.extend(view.short_overlaps());
    }
    if tier <= Tier::Events {
        warnings.extend(view.saturated_counts());
    }
    if tier <= Tier::Counts {
        warnings.extend(view.saturation());
        warnings.extend(view.short_steps());
        warnings.extend(view.later_scans());
    }
    match tier {
        Tier::Expected => warnings.extend(view.scatter(predicted)),
        Tier::Counts => warnings.extend(match sensor.scene().hardware.architecture {
            Architecture::UpDown => view.small_counts(),
            Architecture::Histogram => view.short_period(),
        }),
        Tier::Events | Tier::Sampled | Tier::Rtl => {}
    }
    let is_updown = sensor.scene().hardware.architecture == Architecture::UpDown;
    if is_updown && sensor.scene().estimator == EstimatorKind::Model {
        warnings.extend(shared_light(sensor, detector));
    }
    let name = &sensor.scene().detectors[detector].name;
    for warning in &mut warnings {
        *warning = format!("{name}: {warning}");
    }
    warnings
}

/// One detector of a scene.
struct View<'a> {
    sensor: &'a Sensor,
    detector: DetectorIndex,
    model: &'a DetectorModel,
    brightest_per_chip: f64,
}

impl View<'_> {
    fn memory(&self) -> DetectorMemory {
        self.model.memory_under(self.brightest_per_chip)
    }

    /// Two detections are one rising edge if the level does not fall between two
    /// samples: if they are less than pulse width and sample period apart.
    fn merged_pulses(&self) -> Option<String> {
        let spad = &self.sensor.scene().detectors[self.detector];
        let share = merged_share(self.model, &Light::of(self.model).of_cell(self.model));
        (share > SHARE).then(|| {
            format!(
                "pulses of {} ns, {} ns of dead time and a sample every {:.3} ns leave no low sample \
                 between some detections: up to {:.1} % of them merge with the one before in the \
                 sampled hardware, and are counted here",
                spad.pulse_width_ps / 1e3,
                spad.dead_time_ps / 1e3,
                self.sensor.clock().sample_period_ps() / 1e3,
                share * 100.0
            )
        })
    }

    /// A pulse that is shorter than a sample period may lie between samples.
    fn missed_pulses(&self) -> Option<String> {
        let spad = &self.sensor.scene().detectors[self.detector];
        let sample_ps = self.sensor.clock().sample_period_ps();
        let missed = 1.0 - spad.sampler.seen_share(spad.pulse_width_ps / sample_ps);
        (missed > 0.0).then(|| {
            format!(
                "pulses of {} ns are shorter than the sample period of {} ns: the sampled \
                 hardware misses {:.1} % of them, and here they all count",
                spad.pulse_width_ps / 1e3,
                sample_ps / 1e3,
                missed * 100.0
            )
        })
    }

    /// A counter in continuous time takes no samples.
    fn uneven_samples(&self) -> Option<String> {
        let scene = self.sensor.scene();
        let is_uneven = !scene.detectors[self.detector].sampler.is_even();
        (is_uneven && scene.hardware.architecture == Architecture::UpDown).then(|| {
            "the sampled hardware's samples are not equally far apart; the counter in continuous \
             time takes none, and what they cost is left out"
                .to_owned()
        })
    }

    /// Of pulses that overlap for less than a sample period some do so between samples.
    fn short_overlaps(&self) -> Option<String> {
        let spad = &self.sensor.scene().detectors[self.detector];
        (spad.coincidence > 1).then(|| {
            format!(
                "pulses of {} cells that overlap for less than the sample period of {} ns count \
                 here; the sampled hardware misses those between two samples",
                spad.coincidence,
                self.sensor.clock().sample_period_ps() / 1e3,
            )
        })
    }

    fn saturated_counts(&self) -> Option<String> {
        let width = self.sensor.scene().hardware.counter_width?;
        let (limit, most) = (count_limit(self.sensor)?, most_counts(self.sensor, self.model));
        (most > limit).then(|| {
            format!(
                "counter_width = {width} clamps the hardware's counts at {limit}; here they are \
                 not saturated, and may come to {most:.0}"
            )
        })
    }

    fn saturation(&self) -> Option<String> {
        let saturation = self.memory().saturation();
        (saturation > MOST_SATURATION).then(|| {
            format!(
                "light of {saturation:.0} primary detections per dead time: the detector fires \
                 like a clock for longer than the 100,000 dead times over which its response is \
                 worked out, so expected counts still know how it started"
            )
        })
    }

    fn short_steps(&self) -> Option<String> {
        let short = short_steps(self.model).check().err()?;
        Some(format!("{short}: variances hold within 3 % for longer ones"))
    }

    /// The moments are those of the first scan.
    fn later_scans(&self) -> Option<String> {
        let next_scan = self.model.timing.first_chip(1, Group(0));
        let scene = self.sensor.scene();
        let apart: Vec<&str> = scene
            .paths
            .iter()
            .filter(|path| path.detector == self.detector)
            .map(|path| &scene.sources[path.source])
            .chain([&scene.sources[scene.detectors[self.detector].reference]])
            .filter(|source| next_scan.of_code(source.code.len()) != 0)
            .map(|source| source.name.as_str())
            .collect();
        let first = apart.first()?;
        Some(format!(
            "later scans start at another chip of the code of \"{first}\" than the first one, \
             whose counts stand for all"
        ))
    }

    fn scatter(&self, predicted: &[Predicted]) -> Vec<String> {
        let own: Vec<PathIndex> = self.sensor.scene().own_paths(self.detector).collect();
        let expected = predicted.iter().filter(|(path, _)| own.contains(path));
        expected
            .filter_map(|(path, predicted)| Some((path, predicted.ok()?)))
            .flat_map(|(path, expected)| {
                let missed = expected.missed_fraction;
                let coarse = missed.filter(|missed| *missed > SELDOM).map(|missed| {
                    format!(
                        "path {path}: {:.2} % of the scans are expected to miss the peak; bias and \
                         standard deviation are those of the other scans",
                        missed * 100.0
                    )
                });
                let linear = (!expected.is_drawn && !expected.is_linear()).then(|| {
                    format!(
                        "path {path}: the phase scatters by {:.2} rad, and the estimates round phase \
                         steps that count nearly as much as the largest by {:.1} mm (standard \
                         deviation); bias and standard deviation are linear in the one and leave \
                         the other out, which can raise them by a fifth",
                        expected.phase_std_rad,
                        expected.coarse_spread_m * 1e3
                    )
                });
                coarse.into_iter().chain(linear)
            })
            .collect()
    }

    /// The bins of a drawn histogram that do not follow its own last ones.
    fn short_period(&self) -> Option<String> {
        let timing = &self.model.timing;
        let period_chips = timing.scan.steps_per_period / u64::from(timing.clock.samples_per_chip);
        let memory = self.memory().scale_chips();
        let share = memory / period_chips as f64;
        (share > SHARE).then(|| {
            format!(
                "the detector's memory of {memory:.1} chips is {:.0} % of the code period: drawn \
                 first bins do not follow the last ones of the period before, whose covariances \
                 are about as large a share of all",
                share * 100.0
            )
        })
    }

    fn small_counts(&self) -> Option<String> {
        // Without a mean response there is no answer to warn about.
        let response =
            MeanResponse::of_tier(self.model, Tier::Counts.counting(self.sensor)).ok()?;
        let means = response.mean_counts();
        let (peak, _) = (0..).map(Step).zip(&means).max_by(|(_, a), (_, b)| {
            let [a, b] = [a, b].map(|mean| mean.signed.abs());
            a.total_cmp(&b)
        })?;
        let moments = SecondMoments::new(&response).ok()?.of_step(peak);
        let least = 0.5 * (moments.total_mean - moments.signed_mean.abs());
        let shared = 0.5 * (moments.total_variance / moments.signed_variance - 1.0);
        (least < 25.0 && shared < -SHARE).then(|| {
            format!(
                "about {least:.1} counts in one direction are too few to be normal: their \
                 negative covariance with the others is left out, which changes the variance of \
                 the difference by {:+.1} %",
                shared * 100.0
            )
        })
    }
}
