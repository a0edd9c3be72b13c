//! What the tests come to, in words.

use std::borrow::Borrow;

use super::super::Cause;
use super::super::codes::Candidate;
use super::super::hypothesis::{SceneFit, Unknown};
use super::{Diagnosis, Examination, TestOutcome, family};
use crate::estimate::distance_m;

/// What the best fit's distance rests on where the chip period alone explains the counts.
const OF_CLOCK: &str = "the best fit's distance is told with that chip period; a crystal is exact to ppm, so look \
     whether the scene has the clock's setting";

/// That the counts fit better if or with any of some.
fn any_of<W: Borrow<str>>(how: &str, words: &[W]) -> String {
    let tells = if words.len() == 1 { "" } else { "; they do not tell which" };
    format!("the counts fit better {how} {}{tells}", words.join(&format!(", also {how} ")))
}

impl Examination<'_> {
    /// The diagnosis, given `codes` that explain the counts better than the scene's, the best first.
    pub(super) fn conclude(mut self, codes: Vec<(Candidate, SceneFit)>) -> (Diagnosis, SceneFit) {
        let mut causes = Vec::new();
        let mut says = Vec::new();
        let words: Vec<&str> = codes.iter().map(|(code, _)| &*code.words).collect();
        if !words.is_empty() {
            says.push(any_of("if", &words));
        }
        for (code, _) in &codes {
            if !causes.contains(&code.cause) {
                causes.push(code.cause);
            }
        }
        match codes.into_iter().next() {
            Some((_, fitted)) => self.fitted = fitted,
            None => {
                for alike in &self.alike {
                    for cause in alike.iter().map(|unknown| unknown.cause()) {
                        if !causes.contains(&cause) {
                            causes.push(cause);
                        }
                    }
                    says.push(self.of_unknowns(alike));
                }
                let is_of_clock = self.is_of_clock();
                if is_of_clock {
                    says.push(OF_CLOCK.to_owned());
                }
                says.extend(self.offset(is_of_clock, &mut causes));
            }
        }
        says.extend(self.scatter(&mut causes));
        let sentence = match says.is_empty() {
            true => "the counts are as the scene says".to_owned(),
            false => says.join("; "),
        };
        let spad = self.spad();
        if let Some(reason) = self.no_other_recharge()
            && !self.alike.is_empty()
            && spad.dead_time_ps > 0.0
        {
            self.not_tested.push(format!("{}: {reason}", Unknown::Recharge.name()));
        }
        let Examination { tests, not_tested, fitted, .. } = self;
        (Diagnosis { causes, sentence, tests, not_tested }, fitted)
    }

    /// Whether the peak stands where the scene's path has it, by the fitted clock or by the scene's.
    fn offset(&mut self, is_of_clock: bool, causes: &mut Vec<Cause>) -> Option<String> {
        self.fitted = self.told(self.fitted.clone(), is_of_clock);
        let std_ps = self.fitted.std_of(Unknown::Delay)?;
        let by_ps = self.fitted.change.value(Unknown::Delay);
        let outcome = self.outcome(Unknown::Delay, (by_ps / std_ps).powi(2), &self.fitted);
        let rejects = outcome.rejects;
        self.tests.push(outcome);
        rejects.then(|| {
            causes.push(Cause::Offset);
            format!(
                "the peak stands {:.3} +- {:.3} ns {} than the scene's: the target is {:.4} m \
                 {}, or a constant delay (detector.delay, cables) differs by as much",
                by_ps.abs() * 1e-3,
                std_ps * 1e-3,
                if by_ps > 0.0 { "later" } else { "earlier" },
                distance_m(by_ps.abs()),
                if by_ps > 0.0 { "farther" } else { "nearer" },
            ) + match self.observed.tells_light() {
                true => "",
                false => "; without total counts another dead time or light level also fits",
            }
        })
    }

    /// Whether the residuals scatter as photons do.
    fn scatter(&mut self, causes: &mut Vec<Cause>) -> Option<String> {
        let p = self.fitted.p_value?;
        let rejects = p.min(1.0 - p) < 0.5 * family().level();
        let (cause, text) = match p < 0.5 {
            true => (
                Cause::Unexplained,
                "the residuals are larger than chance: something else is not as the scene says \
                 (other light, a path more, a detector of another kind)",
            ),
            false => (
                Cause::TooEven,
                "the counts scatter less than photons can: are they averages, or scaled?",
            ),
        };
        self.tests.push(TestOutcome {
            cause,
            statistic: self.fitted.agreement.chi_square,
            p_value: Some(p),
            rejects,
            scene_value: Some(self.fitted.degrees as f64),
            fitted_value: Some(self.fitted.agreement.chi_square),
            fitted_value_std: None,
            unit: "chi-square",
        });
        rejects.then(|| {
            causes.push(cause);
            text.to_owned()
        })
    }

    /// The freed parameters in words.
    fn of_unknowns(&self, alike: &[Unknown]) -> String {
        let spad = self.spad();
        let words = |unknown: &Unknown| {
            if *unknown == Unknown::Recharge {
                return Some(format!("recharge = \"{}\"", spad.recharge.other().name()));
            }
            let test = self.tests.iter().find(|test| test.cause == unknown.cause())?;
            let (value, scene) = (test.fitted_value?, test.scene_value?);
            let std = test.fitted_value_std.unwrap_or(0.0);
            Some(match unknown {
                Unknown::Light => format!("{value:.4} +- {std:.4} times the scene's light"),
                Unknown::Integration => format!(
                    "{value:.4} +- {std:.4} times the scene's integration time, or so many scans added up"
                ),
                Unknown::Constant => format!(
                    "background (dark counts, background) of {value:.4e} +- {std:.1e} cps in place \
                     of {scene:.4e}"
                ),
                Unknown::DeadTime | Unknown::ChipPeriod => format!(
                    "a {} of {value:.3} +- {std:.3} ns in place of {scene:.3}",
                    unknown.name()
                ),
                Unknown::Afterpulsing => format!(
                    "an afterpulsing probability of {value:.4} +- {std:.4} in place of {scene:.4}"
                ),
                Unknown::Delay | Unknown::Recharge => return None,
            })
        };
        any_of("with", &alike.iter().filter_map(words).collect::<Vec<_>>())
    }
}
