//! The mean response of one detector to one light.

use std::sync::Arc;

use rayon::prelude::*;

use super::MeanResponseError;
use super::avalanches::detections;
use super::correlator::{MeanCount, ResponseTables, TableSource};
use super::domain::check_stillness;
use super::forward::AllAndMerged;
use super::grid::{Grid, Kinks, SampleInstants, frame_chips};
use super::heard::Heard;
use super::light::Light;
use super::sampling::{self, DetectionSampling};
use super::tier::{CountingTier, EdgeTiming};
use crate::photons::DetectorModel;
use crate::scan::Step;

/// From this many steps on, all steps of the code period by FFT cost less.
const STEPS_FOR_FFT: u64 = 200;
/// Steps, some 30 ns each, that are fewer than a thread is woken for.
const STEPS_OF_A_THREAD: usize = 1024;

/// Expected counts of one detector.
#[derive(Debug, Clone)]
pub struct MeanResponse<'m> {
    pub(super) model: &'m DetectorModel,
    /// Of one cell, where hits of cells are added up.
    pub(super) light: Light,
    /// What fires it beside its light.
    pub(super) heard: Option<Arc<Heard>>,
    pub(super) timing: EdgeTiming,
    pub(super) grid: Arc<Grid>,
    pub(super) sampling: Option<DetectionSampling>,
    pub(super) detections: Arc<AllAndMerged>,
    pub(super) correlator: Arc<ResponseTables>,
    /// Added to every path's time of flight.
    pub(super) delay_chips: f64,
}

impl<'m> MeanResponse<'m> {
    /// The response of the sampled correlator to the scene's own light.
    pub fn new(model: &'m DetectorModel) -> Result<MeanResponse<'m>, MeanResponseError> {
        MeanResponse::of_tier(model, CountingTier::Sampled)
    }

    /// The response of either correlator to the scene's own light.
    pub fn of_tier(
        model: &'m DetectorModel,
        tier: CountingTier,
    ) -> Result<MeanResponse<'m>, MeanResponseError> {
        MeanResponse::to_light(model, Light::of(model), tier)
    }

    /// Solves the detector's state equation over one code period of `light`.
    pub fn to_light(
        model: &'m DetectorModel,
        light: Light,
        tier: CountingTier,
    ) -> Result<MeanResponse<'m>, MeanResponseError> {
        light.check()?;
        // Cells whose hits are added up are as many detectors that know nothing of each other: what one is
        // expected to count is worked out, and its means and covariances are as many times as large.
        let light = light.of_cell(model);
        check_stillness(model)?;
        let timing = EdgeTiming::of(model, tier);
        let lag = (timing.rising - timing.falling).abs();
        if lag + 2.0 * timing.transition >= 1.0 {
            return Err(MeanResponseError::EdgesTooFarApart {
                apart_ps: model.timing.clock.ps(lag + 2.0 * timing.transition),
                chip_period_ps: model.timing.clock.chip_period_ps,
            });
        }
        let sampling = DetectionSampling::of(model, &light, tier)?;
        let heard = Heard::of(model)?.map(Arc::new);
        MeanResponse::solved(model, (light, heard), timing, sampling, 0.0)
    }

    fn solved(
        model: &'m DetectorModel,
        (light, heard): (Light, Option<Arc<Heard>>),
        timing: EdgeTiming,
        sampling: Option<DetectionSampling>,
        delay_chips: f64,
    ) -> Result<MeanResponse<'m>, MeanResponseError> {
        let frame_chips = frame_chips(&light) + delay_chips;
        let samples = SampleInstants {
            origin_chips: frame_chips + model.delay_chips,
            sampling: sampling.clone(),
        };
        let grid = Grid::new(model, &light, Kinks::Later, &samples)?;
        let grid = Heard::at(heard.as_deref(), grid, frame_chips);
        let detections = detections(model, &grid)?;
        let source = TableSource {
            grid: &grid,
            light: &light,
            detections: &detections,
            timing,
            sampling: sampling.as_ref(),
            delay_chips,
        };
        let correlator = Arc::new(ResponseTables::new(model, &source));
        Ok(MeanResponse {
            model,
            light,
            heard,
            timing,
            sampling,
            grid: Arc::new(grid),
            detections: Arc::new(detections),
            correlator,
            delay_chips,
        })
    }

    /// The response to the same light, every path `delay_ps` later. The state
    /// equation need not be solved again, unless pulses merge: which of them do
    /// depends on where samples are; nor unless others fire it, whose light stays where it is.
    ///
    /// # Errors
    /// As for the response itself.
    pub fn delayed(&self, delay_ps: f64) -> Result<MeanResponse<'m>, MeanResponseError> {
        let delay_chips = self.delay_chips + self.model.timing.clock.chips(delay_ps);
        if self.state_depends_on_delay() {
            return MeanResponse::solved(
                self.model,
                (self.light.clone(), self.heard.clone()),
                self.timing,
                self.sampling.clone(),
                delay_chips,
            );
        }
        let source = TableSource {
            grid: &self.grid,
            light: &self.light,
            detections: &self.detections,
            timing: self.timing,
            sampling: self.sampling.as_ref(),
            delay_chips,
        };
        Ok(MeanResponse {
            correlator: Arc::new(ResponseTables::new(self.model, &source)),
            delay_chips,
            grid: Arc::clone(&self.grid),
            detections: Arc::clone(&self.detections),
            light: self.light.clone(),
            heard: None,
            sampling: self.sampling.clone(),
            ..*self
        })
    }

    /// The response to the same light, counted for another integration time: of a `model` that
    /// differs in nothing else.
    pub fn counted_by<'n>(&self, model: &'n DetectorModel) -> MeanResponse<'n> {
        MeanResponse {
            model,
            light: self.light.clone(),
            heard: self.heard.clone(),
            timing: self.timing,
            grid: Arc::clone(&self.grid),
            sampling: self.sampling.clone(),
            detections: Arc::clone(&self.detections),
            correlator: Arc::clone(&self.correlator),
            delay_chips: self.delay_chips,
        }
    }

    /// Whether light that comes later leaves the detector in other states than the same ones later.
    pub(super) fn state_depends_on_delay(&self) -> bool {
        self.heard.is_some() || self.sampling.as_ref().is_some_and(DetectionSampling::merges)
    }

    /// Whether the tier leaves out pulses that begin too long before a sample.
    pub fn misses_pulses(&self) -> bool {
        self.sampling.as_ref().is_some_and(|sampling| !sampling.sees_all())
    }

    /// The detector.
    pub fn model(&self) -> &'m DetectorModel {
        self.model
    }

    /// Expected hits between consecutive sample instants of the common code
    /// period of all codes, S times as many as chips. For the sampled tier a
    /// detection is a hit at the first sample at or after its registered time, if
    /// that sees its pulse and the level was low before.
    pub fn hits_per_sample(&self) -> Vec<f64> {
        self.correlator.hits_per_sample()
    }

    /// Mean rate of detections that are counted.
    pub fn detection_rate_hz(&self) -> f64 {
        let seconds = self.model.timing.clock.ps(self.grid.period_chips as f64) * 1e-12;
        self.correlator.hits_per_period() / seconds
    }

    /// Expected counts of a step of the first scan. An ideal detector's
    /// are eqs. 12 and 14, which follow from eq. 26: the hits of half an on-chip
    /// times theta + 2 w - L, straight between chips; the background of eq. 18 adds its
    /// own times 2 w - L.
    pub fn mean_count(&self, step: Step) -> MeanCount {
        let phase_step = self.model.timing.scan.phase_step(step);
        let whole = self.correlator.signed_per_period(phase_step);
        self.with_partial_period(step, whole)
    }

    /// Expected counts of every step of the first scan.
    pub fn mean_counts(&self) -> Vec<MeanCount> {
        let steps = self.model.timing.scan.steps;
        if steps < STEPS_FOR_FFT {
            return Step::all(steps).map(|step| self.mean_count(step)).collect();
        }
        let whole = self.correlator.signed_per_period_of_all();
        // Those of one phase of a chip one after another: they read the same table.
        let phases = self.model.timing.clock.samples_per_chip as usize;
        let of_phase = |phase: usize| Step::all(steps).skip(phase).step_by(phases);
        let in_order: Vec<Step> = (0..phases).flat_map(of_phase).collect();
        let count = |&step: &Step| {
            let phase_step = self.model.timing.scan.phase_step(step) as usize;
            self.with_partial_period(step, whole[phase_step])
        };
        let counted = in_order.par_iter().with_min_len(STEPS_OF_A_THREAD).map(count);
        let counted: Vec<MeanCount> = counted.collect();
        let mut counts = vec![MeanCount { signed: 0.0, total: 0.0 }; steps as usize];
        for (step, count) in in_order.iter().zip(counted) {
            counts[step.index()] = count;
        }
        counts
    }

    /// The response less one to other light, by `times`: what derivatives of counts are read
    /// off. Of steps that count each of the two alike.
    #[must_use]
    pub fn less(&self, other: &MeanResponse, times: f64) -> MeanResponse<'m> {
        let correlator = Arc::new(self.correlator.less(&other.correlator, times));
        MeanResponse { correlator, ..self.clone() }
    }

    /// [`MeanResponse::mean_counts`] of a scan that began each step anywhere in the
    /// code period: what a step has beyond whole periods counts as the same share of
    /// one. No more than a few counts off, for a small part of the time.
    pub fn mean_counts_on_average(&self) -> Vec<MeanCount> {
        let steps = self.model.timing.scan.steps;
        if steps < STEPS_FOR_FFT {
            return self.mean_counts();
        }
        let whole = self.correlator.signed_per_period_of_all();
        let periods =
            self.model.timing.scan.integration_chips as f64 / self.grid.period_chips as f64;
        let total = periods * self.correlator.hits_per_period();
        Step::all(steps)
            .map(|step| MeanCount {
                signed: periods * whole[self.model.timing.scan.phase_step(step) as usize],
                total,
            })
            .collect()
    }

    /// Expected signed count of a step of the first scan.
    pub fn expected_count(&self, step: Step) -> f64 {
        self.mean_count(step).signed
    }

    /// The counts of a step whose phase step counts `whole` in a code period.
    fn with_partial_period(&self, step: Step, whole: f64) -> MeanCount {
        let (periods, first, rest) = self.chips_of(step);
        let phase_step = self.model.timing.scan.phase_step(step);
        let correlator = &self.correlator;
        let mut count =
            MeanCount { signed: periods * whole, total: periods * correlator.hits_per_period() };
        if rest > 0 {
            count.signed += correlator.signed_between(phase_step, first, rest, whole);
            count.total += correlator.hits_between(first, rest);
        }
        count
    }

    /// By how much the reference's edges come later in a phase step than without a delay, in chips
    /// of registered time.
    pub(super) fn phase_chips(&self, phase_step: u64) -> f64 {
        let samples = u64::from(self.model.timing.clock.samples_per_chip);
        let within = sampling::phase_chips(self.sampling.as_ref(), samples, phase_step % samples);
        (phase_step / samples) as f64 + within
    }

    /// Whole periods in a step, its first chip, and the chips left over.
    pub(super) fn chips_of(&self, step: Step) -> (f64, usize, usize) {
        let period = self.grid.period_chips as u64;
        let chips = self.model.timing.scan.integration_chips;
        let group = self.model.timing.grouping().group_of(step);
        let first = self.model.timing.first_chip(0, group).of_code(period);
        ((chips / period) as f64, first as usize, (chips % period) as usize)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::{DetectorIndex, load_with};
    use crate::sensor::Sensor;

    /// Counts of all steps at once, by transforms, are the sums of each: of codes whose length is a power of two, a prime, and
    /// a product, with an odd number of phases, and of edges that are late alike and not.
    #[test]
    fn counts_of_all_steps_are_those_of_each() {
        for settings in [
            &["source.code={ family = \"square\", interleave = 6 }"][..],
            &["source.code={ family = \"m-sequence\", degree = 7 }"],
            &[
                "source.code={ family = \"gold\", degree = 9, index = 2 }",
                "clock.samples_per_chip=1",
                "detector.counter={ rising_delay = \"350 ps\", falling_delay = \"350 ps\", transition = \"0 ps\" }",
            ],
        ] {
            let parsed = settings.iter().map(|setting| setting.parse().expect("a setting"));
            let parsed: Vec<_> = parsed.collect();
            let scene = load_with(Path::new("../scenes/quick.toml"), &parsed).expect("sound");
            let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
            for tier in [CountingTier::Sampled, CountingTier::Events] {
                let response = MeanResponse::of_tier(&model, tier).expect("solved");
                let all = response.mean_counts();
                assert!(all.len() as u64 >= STEPS_FOR_FFT, "{settings:?}");
                for (step, at_once) in Step::all(all.len() as u64).zip(&all) {
                    let alone = response.mean_count(step);
                    assert_eq!(alone.total, at_once.total, "{settings:?}, step {step:?}");
                    let off = (alone.signed - at_once.signed).abs();
                    assert!(off < 1e-11 * alone.total, "{settings:?}, step {step:?}: {off:e}");
                }
            }
        }
    }

    /// Light that is even is solved for one chip, and its counts need no sums over slots: they are those of light of which a
    /// billionth follows a code.
    #[test]
    fn even_light_counts_as_light_that_hardly_changes() {
        let part = ["scan.integration=1.3 us".parse().expect("a setting")];
        let scene = load_with(Path::new("../scenes/quick.toml"), &part).expect("sound");
        let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
        let mut light = Light::of(&model);
        let constant = light.brightest_per_chip();
        light.constant_per_chip = constant;
        light.paths.iter_mut().for_each(|path| path.rate_per_chip = 1e-9 * constant);
        let even = Light { paths: Vec::new(), ..light.clone() };
        for tier in [CountingTier::Sampled, CountingTier::Events] {
            let [even, nearly] = [&even, &light].map(|light| {
                let response = MeanResponse::to_light(&model, light.clone(), tier);
                response.expect("solved").mean_counts()
            });
            assert!(even.iter().any(|count| count.signed.abs() > 0.01 * count.total));
            for (even, nearly) in even.iter().zip(&nearly) {
                let off =
                    (even.signed - nearly.signed).abs().max((even.total - nearly.total).abs());
                assert!(off < 1e-7 * even.total, "{tier:?}: {even:?} {nearly:?}");
            }
        }
    }
}
