//! Parameters of the scene that are freed, one after another, and what the counts say of each.

use super::super::hypothesis::{SceneFit, Unknown, constant_cps, fit};
use super::{Examination, TestOutcome, chance, critical};

impl Examination<'_> {
    /// The same with every parameter freed that raises the likelihood significantly. The chip period is a cause by itself,
    /// or beside others where the counts have no explanation without it.
    pub(super) fn with_causes(mut self) -> Self {
        let mut found = self.clone();
        while found.take_in_best() {}
        if found.unknowns.contains(&Unknown::ChipPeriod) && !found.is_of_clock() {
            self.has_right_clock = true;
            while self.take_in_best() {}
            if self.is_explained() || !found.is_explained() {
                return self;
            }
        }
        found
    }

    /// Whether another chip period is all that the counts tell.
    pub(super) fn is_of_clock(&self) -> bool {
        self.alike == [[Unknown::ChipPeriod]] && self.is_explained()
    }

    /// Why counts of the other recharge are not known, if they are not.
    pub(super) fn no_other_recharge(&self) -> Option<&'static str> {
        let spad = self.spad();
        let has_crosstalk = self.scene.detectors.iter().any(|spad| spad.crosstalk().is_some());
        if spad.afterpulsing_probability > 0.0 {
            Some(
                "afterpulses within a dead time would prolong it, and what is then counted is not known",
            )
        } else if has_crosstalk {
            Some("passive recharge beside crosstalk is not simulated")
        } else {
            None
        }
    }

    /// Frees the parameter that raises the likelihood most, if significantly; the chip period only if no other does about
    /// as well.
    fn take_in_best(&mut self) -> bool {
        let spad = self.spad();
        let mut candidates = vec![Unknown::Light, Unknown::Constant, Unknown::Integration];
        if !self.has_right_clock {
            candidates.push(Unknown::ChipPeriod);
        }
        if spad.dead_time_ps > 0.0 {
            candidates.extend([Unknown::DeadTime, Unknown::Afterpulsing]);
            candidates.extend(self.no_other_recharge().is_none().then_some(Unknown::Recharge));
        }
        candidates.retain(|unknown| !self.unknowns.contains(unknown));
        // Tests that failed with fewer unknowns are repeated.
        self.not_tested.clear();
        let mut gains: Vec<(f64, Unknown, SceneFit)> = Vec::new();
        for unknown in candidates {
            let mut unknowns = self.unknowns.clone();
            unknowns.push(unknown);
            let start = match unknown {
                Unknown::Recharge => {
                    self.fitted.change.by(unknown, 1.0).start(self.sensor, self.observed)
                }
                _ => Ok(self.fitted.end()),
            };
            match start.and_then(|start| fit(self.sensor, self.observed, &unknowns, start)) {
                Ok(fitted) => {
                    let gain = self.fitted.agreement.deviance - fitted.agreement.deviance;
                    self.tests.retain(|test| test.cause != unknown.cause());
                    self.tests.push(self.outcome(unknown, gain, &fitted));
                    gains.push((gain, unknown, fitted));
                }
                Err(reason) => {
                    self.not_tested.push(format!("{}: {reason}", unknown.name()));
                }
            }
        }
        let most = gains.iter().map(|(gain, ..)| *gain).fold(0.0, f64::max);
        if most <= critical() {
            return false;
        }
        gains.retain(|(gain, ..)| *gain > most - critical());
        gains.sort_by(|a, b| b.0.total_cmp(&a.0));
        // The chip period alone where the peak stands at the scene's path by no other; otherwise last, and not at all where
        // times of the detector are as good.
        let is_clock = |(_, unknown, _): &(f64, Unknown, SceneFit)| *unknown == Unknown::ChipPeriod;
        let is_of_detector = |(_, unknown, _): &(f64, Unknown, SceneFit)| {
            matches!(unknown, Unknown::DeadTime | Unknown::Afterpulsing | Unknown::Recharge)
        };
        if self.is_path_by_clock_alone(&gains) {
            gains.retain(is_clock);
        } else if gains.iter().any(is_of_detector) {
            gains.retain(|found| !is_clock(found));
        }
        gains.sort_by_key(is_clock);
        self.alike.push(gains.iter().map(|(_, unknown, _)| *unknown).collect());
        let Some((_, unknown, fitted)) = gains.into_iter().next() else { return false };
        self.unknowns.push(unknown);
        self.fitted = fitted;
        true
    }

    pub(super) fn outcome(
        &self,
        unknown: Unknown,
        statistic: f64,
        fitted: &SceneFit,
    ) -> TestOutcome {
        let spad = self.spad();
        let (value, std) = (fitted.change.value(unknown), fitted.std_of(unknown));
        // The scene's value, the fitted one, and the factor from the change to its standard deviation.
        let constant_cps = constant_cps(spad);
        let probability = spad.afterpulsing_probability;
        let (scene_value, fitted_value, of_change) = match unknown {
            Unknown::Light | Unknown::Integration => (1.0, value.exp(), value.exp()),
            Unknown::Constant => (constant_cps, constant_cps + value, 1.0),
            Unknown::Afterpulsing => (probability, probability + value, 1.0),
            Unknown::DeadTime => {
                let ns = spad.dead_time_ps * 1e-3;
                (ns, ns + value * 1e-3, 1e-3)
            }
            Unknown::ChipPeriod => {
                let ns = self.scene.chip_period_ps * 1e-3;
                (ns, ns * value.exp(), ns * value.exp())
            }
            Unknown::Delay => (0.0, value * 1e-3, 1e-3),
            Unknown::Recharge => (0.0, 0.0, 0.0),
        };
        let is_number = unknown != Unknown::Recharge;
        TestOutcome {
            cause: unknown.cause(),
            statistic,
            p_value: Some(chance(statistic)),
            rejects: statistic > critical(),
            scene_value: is_number.then_some(scene_value),
            fitted_value: is_number.then_some(fitted_value),
            fitted_value_std: std.map(|std| std * of_change),
            unit: unknown.unit(),
        }
    }

    /// Counts a fit's delay from the scene's path, by the fitted clock or by the scene's, in less than a code period.
    pub(super) fn told(&self, mut fitted: SceneFit, is_of_clock: bool) -> SceneFit {
        fitted.tell_times_of_scene(self.scene, self.observed.detector(), is_of_clock);
        let code = &self.scene.sources[self.own()].code;
        let period_ps = self.scene.clock().ps(code.len() as f64);
        let turns = (fitted.change.value(Unknown::Delay) / period_ps).round();
        fitted.change = fitted.change.by(Unknown::Delay, -turns * period_ps);
        fitted
    }

    /// Whether the peak stands at the scene's path by another chip period, of which it is known well enough, and by no other
    /// of some freed parameters.
    fn is_path_by_clock_alone(&self, gains: &[(f64, Unknown, SceneFit)]) -> bool {
        let (mut by_clock, mut by_others) = (None, Vec::new());
        for (_, unknown, fitted) in gains {
            let is_clock = *unknown == Unknown::ChipPeriod;
            let told = self.told(fitted.clone(), is_clock);
            let Some(std_ps) = told.std_of(Unknown::Delay) else { return false };
            let peak = (told.change.value(Unknown::Delay), std_ps);
            if is_clock {
                by_clock = Some(peak);
            } else {
                by_others.push(peak);
            }
        }
        let is_at_path = |later_ps: f64, std_ps: f64| (later_ps / std_ps).powi(2) <= critical();
        by_clock.is_some_and(|(later_ps, clock_ps)| {
            is_at_path(later_ps, clock_ps)
                && by_others
                    .iter()
                    .all(|(later_ps, std_ps)| !is_at_path(*later_ps, std_ps.hypot(clock_ps)))
        })
    }
}
