//! Fits of a scene with some of its values unknown to recorded counts.

use super::Cause;
use super::observed::{Agreement, ExpectedNumbers, Observed, Whitening, differences, response};
use crate::estimate::fit::FitError;
use crate::estimate::fit::normal::Normal;
use crate::estimate::fit::scoring::{Counts, Settling, Slopes, settle};
use crate::estimate::{TheoryEffort, Work};
use crate::photons::DetectorModel;
use crate::response::MeanResponse;
use crate::scene::{Detector, DetectorIndex, Scene};
use crate::sensor::Sensor;

/// Declares the values of a scene that may be wrong: each with its cause, its name, and the unit of its
/// values.
macro_rules! unknowns {
    ($($(#[$about:meta])* $Unknown:ident = $Cause:ident, $name:literal, $unit:literal;)*) => {
        /// A value of a scene that may be wrong.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum Unknown { $($(#[$about])* $Unknown,)* }

        impl Unknown {
            /// The cause that it stands for.
            pub fn cause(self) -> Cause {
                match self { $(Unknown::$Unknown => Cause::$Cause,)* }
            }

            /// Its name.
            pub fn name(self) -> &'static str {
                match self { $(Unknown::$Unknown => $name,)* }
            }

            /// Unit of its values.
            pub fn unit(self) -> &'static str {
                match self { $(Unknown::$Unknown => $unit,)* }
            }
        }
    };
}

unknowns! {
    /// All light comes later.
    Delay = Offset, "offset", "ns";
    /// All sources are brighter by a factor.
    Light = LightLevel, "light level", "of the scene's";
    /// More dark counts, or other background.
    Constant = ConstantLight, "background", "cps";
    /// The dead time is longer.
    DeadTime = DeadTime, "dead time", "ns";
    /// An avalanche causes an afterpulse more often, after the same time.
    Afterpulsing = Afterpulsing, "afterpulsing", "probability";
    /// A chip is longer, and the light stands at the same phase step all the same.
    ChipPeriod = ChipPeriod, "chip period", "ns";
    /// Steps count for longer, or several scans are added up.
    Integration = Integration, "integration time", "of the scene's";
    /// Light within the dead time prolongs it, or does not: one of two laws, which no fit moves to.
    Recharge = Recharge, "recharge", "";
}

/// The difference of each from the scene's: delay in ps, logarithm of the brightness, further constant
/// rate in counts per second, dead time in ps, probability of an afterpulse, logarithms of the chip period and of the
/// integration time, 1 for the other recharge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SceneChange([f64; 8]);

/// A scene fitted to counts.
#[derive(Clone)]
pub(super) struct SceneFit {
    pub change: SceneChange,
    /// The unknowns and their standard deviations.
    pub errors: Vec<(Unknown, f64)>,
    pub expected: ExpectedNumbers,
    pub agreement: Agreement,
    pub degrees: usize,
    pub p_value: Option<f64>,
}

/// Light is looked for within this many powers of e of the scene's.
const MOST_LN_LIGHT: f64 = 7.0;
/// A chip's period is looked for within this many powers of e of the scene's.
const MOST_LN_CHIP_PERIOD: f64 = 1.5;
/// Probabilities of an afterpulse are looked for up to this one, or to the scene's if that is higher.
const MOST_AFTERPULSING: f64 = 0.6;

/// Dark counts and background of a detector that counts as one constant rate, in counts per second.
pub(super) fn constant_cps(spad: &Detector) -> f64 {
    spad.background_rate_cps * spad.photon_detection_probability + spad.dark_count_rate_cps
}

/// Light is not tried whose response takes longer than this on one core, and so many times as long as
/// the scene's own. Counts that no light explains, such as more than one in a dead time, lead to
/// ever brighter light, which a detector takes ever longer to forget.
const LONGEST_RESPONSE_S: f64 = 2e-3;
const MOST_TIMES_LONGER: f64 = 4.0;

impl Unknown {
    /// How far it moves for its derivative, and farthest in one step of a fit.
    fn reach(self, sensor: &Sensor, detector: DetectorIndex) -> [f64; 2] {
        let chip_ps = sensor.scene().chip_period_ps;
        match self {
            Unknown::Delay => [2e-3 * chip_ps, 0.5 * chip_ps],
            Unknown::Light | Unknown::Integration => [5e-3, 1.0],
            Unknown::ChipPeriod => [2e-3, 0.1],
            Unknown::Constant => {
                let model = DetectorModel::new(sensor, detector);
                let brightest = crate::response::Light::of(&model).brightest_per_chip();
                let cps = brightest.max(1e-6) / (chip_ps * 1e-12);
                [5e-3 * cps, cps]
            }
            Unknown::DeadTime => {
                let dead_time_ps = sensor.scene().detectors[detector].dead_time_ps;
                [5e-3 * dead_time_ps, 0.3 * dead_time_ps]
            }
            Unknown::Afterpulsing => [2e-3, 0.1],
            Unknown::Recharge => [0.0, 0.0],
        }
    }

    /// The least and the most change that leave a rate or a probability what it is: neither is less than none.
    fn bounds(self, spad: &Detector) -> [f64; 2] {
        let probability = spad.afterpulsing_probability;
        match self {
            Unknown::Constant => [-constant_cps(spad), f64::INFINITY],
            Unknown::Afterpulsing => [-probability, (MOST_AFTERPULSING - probability).max(0.0)],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }
}

impl SceneChange {
    /// All light later.
    pub fn later(delay_ps: f64) -> SceneChange {
        SceneChange::default().by(Unknown::Delay, delay_ps)
    }

    /// The difference of an unknown from the scene's.
    pub fn value(self, unknown: Unknown) -> f64 {
        self.0[unknown as usize]
    }

    /// The same without a delay.
    fn undelayed(mut self) -> SceneChange {
        self.0[Unknown::Delay as usize] = 0.0;
        self
    }

    /// The same with one unknown moved further.
    pub fn by(mut self, unknown: Unknown, by: f64) -> SceneChange {
        self.0[unknown as usize] += by;
        self
    }

    /// How many times the scene's a chip is.
    fn longer(&self) -> f64 {
        self.value(Unknown::ChipPeriod).clamp(-MOST_LN_CHIP_PERIOD, MOST_LN_CHIP_PERIOD).exp()
    }

    /// The sensor with this change, but for the delay.
    fn applied(&self, sensor: &Sensor, detector: DetectorIndex) -> Sensor {
        sensor.with(|scene| {
            for source in &mut scene.sources {
                source.mean_power_w *=
                    self.value(Unknown::Light).clamp(-MOST_LN_LIGHT, MOST_LN_LIGHT).exp();
            }
            let spad = &mut scene.detectors[detector];
            if self.value(Unknown::Recharge) > 0.0 {
                spad.recharge = spad.recharge.other();
            }
            // All of it as dark counts: both are one constant rate.
            let within = |unknown: Unknown, spad: &Detector| {
                let [least, most] = unknown.bounds(spad);
                self.value(unknown).clamp(least, most)
            };
            let further_cps = within(Unknown::Constant, spad);
            spad.dark_count_rate_cps = (constant_cps(spad) + further_cps).max(0.0);
            spad.background_rate_cps = 0.0;
            spad.afterpulsing_probability += within(Unknown::Afterpulsing, spad);
            if spad.afterpulsing_time_constant_ps == 0.0 {
                // Of a scene without afterpulsing it is not known: traps empty within a dead time, for the most part.
                spad.afterpulsing_time_constant_ps = 0.5 * spad.dead_time_ps;
            }
            // Not so short that pulses merge where they did not.
            let least_ps = spad.pulse_width_ps.min(spad.dead_time_ps);
            let most_ps = 4.0 * spad.dead_time_ps;
            spad.dead_time_ps =
                (spad.dead_time_ps + self.value(Unknown::DeadTime)).clamp(least_ps, most_ps);
            let longer = self.longer();
            scene.chip_period_ps *= longer;
            spad.delay_ps *= longer;
            for path in &mut scene.paths {
                path.delay_ps *= longer;
            }
        })
    }

    /// How many times as long as the scene's steps count.
    fn times(&self) -> f64 {
        self.value(Unknown::Integration).clamp(-MOST_LN_LIGHT, MOST_LN_LIGHT).exp()
    }

    /// A fit's start.
    pub fn start(self, sensor: &Sensor, observed: Observed) -> Result<ExpectedChange, FitError> {
        Ok(ExpectedChange { change: self, expected: self.expected(sensor, observed)? })
    }

    fn expected(&self, sensor: &Sensor, observed: Observed) -> Result<ExpectedNumbers, FitError> {
        let applied = self.applied(sensor, observed.detector());
        Ok(observed.expected(&applied, self.value(Unknown::Delay))?.in_times(self.times()))
    }
}

impl SceneFit {
    /// Where it ended, for a fit that goes on from there.
    pub fn end(&self) -> ExpectedChange {
        ExpectedChange { change: self.change, expected: self.expected.clone() }
    }

    /// Standard deviation of an unknown.
    pub fn std_of(&self, unknown: Unknown) -> Option<f64> {
        self.errors.iter().find(|(of, _)| *of == unknown).map(|(_, std)| *std)
    }

    /// Counts the delay from where the scene has the light, where another chip period was fitted, and as well as the
    /// detector's own is known. The peak stands at a phase step: if `is_of_clock`, its time is told with the fitted chip
    /// period; otherwise with the scene's, since that one stands for faults of the detector.
    pub fn tell_times_of_scene(
        &mut self,
        scene: &Scene,
        detector: DetectorIndex,
        is_of_clock: bool,
    ) {
        let own = scene.paths.iter().find(|path| path.detector == detector);
        let scaled_ps = own.map_or(0.0, |path| path.delay_ps + scene.detectors[detector].delay_ps);
        let (longer, later_ps) = (self.change.longer(), self.change.value(Unknown::Delay));
        let of_clock = self.std_of(Unknown::ChipPeriod).unwrap_or(0.0);
        let (by_ps, of_clock_ps, scale) = match is_of_clock {
            true => ((longer - 1.0) * scaled_ps, of_clock * longer * scaled_ps, 1.0),
            false => ((1.0 / longer - 1.0) * later_ps, of_clock * later_ps / longer, 1.0 / longer),
        };
        self.change = self.change.by(Unknown::Delay, by_ps);
        for (_, std) in self.errors.iter_mut().filter(|(of, _)| *of == Unknown::Delay) {
            *std = (*std * scale).hypot(of_clock_ps).hypot(scene.detectors[detector].delay_std_ps);
        }
    }
}

/// A change, and what is expected with it.
#[derive(Clone)]
pub(super) struct ExpectedChange {
    pub change: SceneChange,
    pub expected: ExpectedNumbers,
}

impl ExpectedChange {
    /// The same change with another delay, nearly: the detector answers as `answer` has it without any.
    pub fn delayed(
        &self,
        answer: &MeanResponse,
        change: SceneChange,
    ) -> Result<ExpectedChange, FitError> {
        let delayed = answer.delayed(change.value(Unknown::Delay))?;
        Ok(ExpectedChange { change, expected: self.expected.delayed(&delayed, change.times())? })
    }
}

/// Fits the unknowns to what was recorded, from `start` on, with the recharge that `start` has.
pub(super) fn fit(
    sensor: &Sensor,
    observed: Observed,
    unknowns: &[Unknown],
    start: ExpectedChange,
) -> Result<SceneFit, FitError> {
    let of_numbers = unknowns.iter().copied().filter(|unknown| *unknown != Unknown::Recharge);
    let unknowns = &of_numbers.collect::<Vec<_>>()[..];
    let (errors, ExpectedChange { change, expected }) = match unknowns {
        [] => (Vec::new(), start),
        _ => {
            let (change, errors) = fit_unknowns(sensor, observed, unknowns, &start)?;
            (errors, change.start(sensor, observed)?)
        }
    };
    let agreement = expected.judge(&observed.values())?;
    let degrees = agreement.numbers.saturating_sub(unknowns.len());
    Ok(SceneFit {
        change,
        errors,
        expected,
        p_value: agreement.p_value(degrees),
        agreement,
        degrees,
    })
}

/// The change that fits best, with the standard deviation of each unknown, and not what is expected with it: its
/// second moments take longer than all else.
pub(super) fn fit_unknowns(
    sensor: &Sensor,
    observed: Observed,
    unknowns: &[Unknown],
    start: &ExpectedChange,
) -> Result<(SceneChange, Vec<(Unknown, f64)>), FitError> {
    let (values, detector) = (observed.values(), observed.detector());
    let own_s = TheoryEffort::of(sensor, detector)?.seconds(Work::Response);
    let limit_s = LONGEST_RESPONSE_S.max(MOST_TIMES_LONGER * own_s);
    let lit = |change: &SceneChange| {
        let lit = change.applied(sensor, detector);
        TheoryEffort::of(&lit, detector)?.check_within(Work::Response, limit_s)?;
        Ok::<_, FitError>(DetectorModel::new(&lit, detector))
    };
    let from = |start: &ExpectedChange, answer: &MeanResponse| {
        let ExpectedChange { change, expected } = start;
        let mut scene = SceneCounts {
            begun: (change.undelayed(), answer),
            whitening: expected.whitening(&expected.means)?,
            weighed_at: *change,
            reach: unknowns.iter().map(|u| u.reach(sensor, detector)).collect(),
            known: expected,
            sensor,
            observed,
            values: &values,
            unknowns,
            limit_s,
        };
        let start = Trial { change: *change, means: expected.means.clone() };
        let settled = settle(&mut scene, start, Settling::FINE)?;
        let change = scene.changed(&settled.place.change, &settled.step);
        let sigmas = settled.normal.standard_deviations();
        Ok::<_, FitError>((change, unknowns.iter().copied().zip(sigmas).collect()))
    };
    let model = lit(&start.change)?;
    let answer = response(&model)?;
    // Weights of where the fit began may be off: those of where it ended are not.
    let (change, _): (_, Vec<_>) = from(start, &answer)?;
    if change.undelayed() == start.change.undelayed() {
        return from(&start.delayed(&answer, change)?, &answer);
    }
    let model = lit(&change)?;
    from(&change.start(sensor, observed)?, &response(&model)?)
}

/// Recorded counts, and the unknowns of the scene.
struct SceneCounts<'p> {
    sensor: &'p Sensor,
    observed: Observed<'p>,
    values: &'p [f64],
    unknowns: &'p [Unknown],
    /// Of each unknown.
    reach: Vec<[f64; 2]>,
    /// What covariances are scaled from, to the light as it changes.
    known: &'p ExpectedNumbers,
    /// Where the fit began, but for the delay, and what the detector answers there: later light needs no other
    /// solution.
    begun: (SceneChange, &'p MeanResponse<'p>),
    whitening: Whitening,
    weighed_at: SceneChange,
    /// Longest that one response may take on one core.
    limit_s: f64,
}

/// A change of the scene, and the means that follow from it.
struct Trial {
    change: SceneChange,
    means: Vec<f64>,
}

impl SceneCounts<'_> {
    fn changed(&self, change: &SceneChange, step: &[f64]) -> SceneChange {
        let steps = self.unknowns.iter().zip(step);
        steps.fold(*change, |change, (unknown, by)| change.by(*unknown, *by))
    }

    /// How far down and up an unknown may still move, the first at most 0 and the second at least.
    fn room(&self, place: &Trial, unknown: Unknown) -> [f64; 2] {
        let spad = &self.sensor.scene().detectors[self.observed.detector()];
        let [least, most] = unknown.bounds(spad).map(|bound| bound - place.change.value(unknown));
        [least.min(0.0), most.max(0.0)]
    }

    fn means(&self, change: &SceneChange) -> Result<Vec<f64>, FitError> {
        let (detector, delay_ps) = (self.observed.detector(), change.value(Unknown::Delay));
        let (begun, answer) = &self.begun;
        let means = if change.undelayed() == *begun {
            self.observed.means(&answer.delayed(delay_ps)?)
        } else {
            let applied = change.applied(self.sensor, detector);
            TheoryEffort::of(&applied, detector)?.check_within(Work::Response, self.limit_s)?;
            let model = DetectorModel::new(&applied, detector);
            self.observed.means(&response(&model)?.delayed(delay_ps)?)
        };
        Ok(means.into_iter().map(|mean| mean * change.times()).collect())
    }
}

impl Counts for SceneCounts<'_> {
    type Point = Trial;
    type Error = FitError;

    fn residuals(&self, place: &Trial) -> Result<Vec<f64>, FitError> {
        self.whitening.whitened(&differences(self.values, &place.means))
    }

    fn slopes(&mut self, place: &Trial, _anew: bool) -> Result<Slopes, FitError> {
        let of_unknown = |(unknown, &[step, _]): (&Unknown, &[f64; 2])| {
            let at = |by: f64| self.means(&place.change.by(*unknown, by));
            let [down, up] = self.room(place, *unknown).map(|room| room.abs().min(step));
            let mut slopes = differences(&at(up)?, &at(-down)?);
            slopes.iter_mut().for_each(|difference| *difference /= up + down);
            self.whitening.whitened(&slopes)
        };
        let columns = self.unknowns.iter().zip(&self.reach).map(of_unknown);
        Ok(Slopes { columns: columns.collect::<Result<_, _>>()?, are_best: true })
    }

    fn step(&self, place: &Trial, normal: &Normal) -> Vec<f64> {
        let limits = self.unknowns.iter().zip(&self.reach).map(|(unknown, &[_, farthest])| {
            self.room(place, *unknown).map(|room| room.clamp(-farthest, farthest))
        });
        normal.solution_within(&limits.collect::<Vec<_>>())
    }

    fn moved(&self, place: &Trial, step: &[f64]) -> Result<Trial, FitError> {
        let change = self.changed(&place.change, step);
        Ok(Trial { means: self.means(&change)?, change })
    }

    fn weigh(&mut self, place: &Trial, _fall: f64) -> Result<bool, FitError> {
        if self.weighed_at == place.change {
            return Ok(false);
        }
        self.whitening = self.known.whitening(&place.means)?;
        self.weighed_at = place.change;
        Ok(true)
    }

    fn undetermined(&self, _place: &Trial) -> FitError {
        {
            let steps = self.observed.phase_steps();
            FitError::Undetermined { steps, unknowns: self.unknowns.len() }
        }
    }
}
