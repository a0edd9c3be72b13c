//! What counts a scene lets one expect if something about it is otherwise, fitted to
//! counts that were recorded.

use crate::scene::{DetectorIndex, Scene};
use nalgebra::{DMatrix, DVector};

use super::no_fit::NoFit;
use super::observed::{Agreement, Expected, Observed, Weights, differences};
use crate::photons::DetectorModel;
use crate::sensor::Sensor;

/// Something about a scene that may be otherwise than it says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unknown {
    /// All light comes later.
    Delay,
    /// All sources are brighter by a factor.
    Light,
    /// More dark counts, or other background.
    Constant,
    /// The dead time is longer.
    DeadTime,
    /// A chip is longer, and the light stands at the same phase step all the same.
    ChipPeriod,
}

/// By how much: delay in ps, logarithm of the brightness, further constant rate in
/// counts per second, dead time in ps, logarithm of the chip period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Change {
    pub delay_ps: f64,
    pub ln_light: f64,
    pub constant_cps: f64,
    pub dead_time_ps: f64,
    pub ln_chip_period: f64,
}

/// A scene fitted to counts.
pub(super) struct Fitted {
    pub change: Change,
    /// The unknowns and their standard deviations.
    pub errors: Vec<(Unknown, f64)>,
    pub expected: Expected,
    pub agreement: Agreement,
    pub degrees: usize,
    pub p_value: Option<f64>,
}

/// Gauss-Newton steps at most; a fit to the right scene takes some four.
const MOST_ITERATIONS: usize = 25;
/// Light is looked for within this many powers of e of the scene's.
const MOST_LN_LIGHT: f64 = 7.0;
/// A chip's period is looked for within this many powers of e of the scene's.
const MOST_LN_CHIP_PERIOD: f64 = 1.5;
/// A fit has settled when no unknown moves by more standard deviations.
const SETTLED_SIGMAS: f64 = 1e-3;

impl Unknown {
    /// The change that moves this unknown alone.
    fn change(self, by: f64) -> Change {
        let mut change = Change::default();
        match self {
            Unknown::Delay => change.delay_ps = by,
            Unknown::Light => change.ln_light = by,
            Unknown::Constant => change.constant_cps = by,
            Unknown::DeadTime => change.dead_time_ps = by,
            Unknown::ChipPeriod => change.ln_chip_period = by,
        }
        change
    }

    pub fn of(self, change: &Change) -> f64 {
        match self {
            Unknown::Delay => change.delay_ps,
            Unknown::Light => change.ln_light,
            Unknown::Constant => change.constant_cps,
            Unknown::DeadTime => change.dead_time_ps,
            Unknown::ChipPeriod => change.ln_chip_period,
        }
    }

    /// A step for its derivative, and the farthest that one step of a fit goes.
    fn steps(self, sensor: &Sensor, detector: DetectorIndex) -> [f64; 2] {
        let chip_ps = sensor.scene().chip_period_ps;
        match self {
            Unknown::Delay => [2e-3 * chip_ps, 0.5 * chip_ps],
            Unknown::Light => [5e-3, 1.0],
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
        }
    }
}

impl Change {
    fn plus(&self, other: &Change) -> Change {
        Change {
            delay_ps: self.delay_ps + other.delay_ps,
            ln_light: self.ln_light + other.ln_light,
            constant_cps: self.constant_cps + other.constant_cps,
            dead_time_ps: self.dead_time_ps + other.dead_time_ps,
            ln_chip_period: self.ln_chip_period + other.ln_chip_period,
        }
    }

    /// How many times the scene's a chip is.
    fn longer(&self) -> f64 {
        self.ln_chip_period.clamp(-MOST_LN_CHIP_PERIOD, MOST_LN_CHIP_PERIOD).exp()
    }

    /// The sensor with this change, but for the delay.
    fn applied(&self, sensor: &Sensor, detector: DetectorIndex) -> Sensor {
        sensor.with(|scene| {
            for source in &mut scene.sources {
                source.mean_power_w *= self.ln_light.clamp(-MOST_LN_LIGHT, MOST_LN_LIGHT).exp();
            }
            let spad = &mut scene.detectors[detector];
            let photons_cps = spad.background_rate_cps * spad.photon_detection_probability;
            let constant = photons_cps + spad.dark_count_rate_cps + self.constant_cps;
            // All of it as dark counts: both are one constant rate.
            spad.background_rate_cps = 0.0;
            spad.dark_count_rate_cps = constant.max(0.0);
            // Not so short that pulses merge where they did not.
            let least_ps = spad.pulse_width_ps.min(spad.dead_time_ps);
            let most_ps = 4.0 * spad.dead_time_ps;
            spad.dead_time_ps = (spad.dead_time_ps + self.dead_time_ps).clamp(least_ps, most_ps);
            let longer = self.longer();
            scene.chip_period_ps *= longer;
            spad.delay_ps *= longer;
            for path in &mut scene.paths {
                path.delay_ps *= longer;
            }
        })
    }

    fn means(&self, sensor: &Sensor, observed: Observed) -> Result<Vec<f64>, NoFit> {
        let applied = self.applied(sensor, observed.detector());
        observed.means(&applied, self.delay_ps)
    }

    pub fn expected(&self, sensor: &Sensor, observed: Observed) -> Result<Expected, NoFit> {
        let applied = self.applied(sensor, observed.detector());
        observed.expected(&applied, self.delay_ps)
    }
}

impl Fitted {
    /// Counts the delay from where the scene's own clock has the light, where another one was
    /// fitted.
    pub fn tell_times_of_scene(&mut self, scene: &Scene, detector: DetectorIndex) {
        let own = scene.paths.iter().find(|path| path.detector == detector);
        let scaled_ps = own.map_or(0.0, |path| path.delay_ps + scene.detectors[detector].delay_ps);
        let longer = self.change.longer();
        self.change.delay_ps += (longer - 1.0) * scaled_ps;
        let of_clock = self.errors.iter().find(|(of, _)| *of == Unknown::ChipPeriod);
        let of_clock_ps = of_clock.map_or(0.0, |(_, std)| std * longer * scaled_ps);
        for (_, std) in self.errors.iter_mut().filter(|(of, _)| *of == Unknown::Delay) {
            *std = std.hypot(of_clock_ps);
        }
    }
}

/// Fits the unknowns to what was recorded, from `start` on.
pub(super) fn fit(
    sensor: &Sensor,
    observed: Observed,
    unknowns: &[Unknown],
    start: Change,
) -> Result<Fitted, NoFit> {
    let problem = Problem { sensor, observed, values: observed.values(), unknowns };
    let mut change = start;
    let mut expected = change.expected(sensor, observed)?;
    let mut errors = Vec::new();
    if !unknowns.is_empty() {
        // Weights of where the fit began may be off: those of where it ended are not.
        for _ in 0..2 {
            (change, errors) = problem.settle(change, &expected)?;
            expected = change.expected(sensor, observed)?;
        }
    }
    let agreement = expected.judge(&problem.values)?;
    let degrees = agreement.numbers.saturating_sub(unknowns.len());
    Ok(Fitted { change, errors, expected, p_value: agreement.p_value(degrees), agreement, degrees })
}

struct Problem<'p> {
    sensor: &'p Sensor,
    observed: Observed<'p>,
    values: Vec<f64>,
    unknowns: &'p [Unknown],
}

impl Problem<'_> {
    /// Gauss-Newton with weights from `known`, scaled to the light as it changes.
    fn settle(
        &self,
        start: Change,
        known: &Expected,
    ) -> Result<(Change, Vec<(Unknown, f64)>), NoFit> {
        let mut change = start;
        let mut errors = Vec::new();
        for _ in 0..MOST_ITERATIONS {
            let means = change.means(self.sensor, self.observed)?;
            let weights = known.weights(&means)?;
            let residuals = weights.whitened(&differences(&self.values, &means))?;
            let columns = self.columns(&change, &weights)?;
            let (step, sigmas) = solve(&columns, &residuals).ok_or(NoFit::Undetermined)?;
            let mut settled = true;
            let mut share: f64 = 1.0;
            for ((unknown, step), sigma) in self.unknowns.iter().zip(&step).zip(&sigmas) {
                let [_, farthest] = unknown.steps(self.sensor, self.observed.detector());
                share = share.min(farthest / step.abs().max(f64::MIN_POSITIVE));
                settled &= (step / sigma).abs() < SETTLED_SIGMAS;
            }
            for (unknown, step) in self.unknowns.iter().zip(&step) {
                change = change.plus(&unknown.change(share * step));
            }
            errors = self.unknowns.iter().copied().zip(sigmas).collect();
            if settled {
                break;
            }
        }
        Ok((change, errors))
    }

    /// Whitened derivatives of the expected counts by every unknown.
    fn columns(&self, change: &Change, weights: &Weights) -> Result<Vec<Vec<f64>>, NoFit> {
        let of_unknown = |unknown: &Unknown| {
            let [step, _] = unknown.steps(self.sensor, self.observed.detector());
            let at = |by: f64| {
                let changed = change.plus(&unknown.change(by));
                changed.means(self.sensor, self.observed)
            };
            // A rate cannot be less than none.
            let down = if *unknown == Unknown::Constant { 0.0 } else { step };
            let (below, above) = (at(-down)?, at(step)?);
            let slopes: Vec<f64> = differences(&above, &below)
                .into_iter()
                .map(|difference| difference / (step + down))
                .collect();
            weights.whitened(&slopes)
        };
        self.unknowns.iter().map(of_unknown).collect()
    }
}

/// The least squares step and the standard deviations; none if the columns are nearly
/// dependent.
fn solve(columns: &[Vec<f64>], residuals: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let size = columns.len();
    let scales: Vec<f64> = columns.iter().map(|c| 1.0 / dot(c, c).sqrt()).collect();
    let information =
        DMatrix::from_fn(size, size, |i, j| dot(&columns[i], &columns[j]) * scales[i] * scales[j]);
    let factor = nalgebra::Cholesky::new(information)?;
    if factor.l_dirty().diagonal().min() < 1e-5 {
        return None;
    }
    let gradient = DVector::from_fn(size, |i, _| dot(&columns[i], residuals) * scales[i]);
    let step = factor.solve(&gradient);
    let inverse = factor.inverse();
    let step: Vec<f64> = (0..size).map(|i| step[i] * scales[i]).collect();
    let sigmas: Vec<f64> = (0..size).map(|i| inverse[(i, i)].sqrt() * scales[i]).collect();
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    (finite(&step) && finite(&sigmas)).then_some((step, sigmas))
}
