//! What a co-simulation exercised: a match says no more than that.

use crate::scene::DetectorIndex;
use serde::{Deserialize, Serialize};

use super::StimulusKind;
use crate::reference::coverage::signs_reached;
use crate::reference::exercise::Exercise;
use crate::reference::stimulus::RESET_CLOCKS;
use crate::sensor::interface::Interface;

/// What the compared outputs have shown.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Exercised {
    /// Detector by detector.
    pub detectors: Vec<DetectorExercised>,
    /// Phase steps whose integration ended.
    pub phase_steps: u64,
    /// Results that the receiver took.
    pub results_taken: u64,
    /// Last results of a scan.
    pub scan_ends: u64,
    /// Resets, that at the start included.
    pub resets: u64,
    /// Results that the receiver left standing for a clock or more.
    pub stalls: u64,
    /// Groups of results that were lost behind one that still stood.
    pub overruns: u64,
    /// Groups of results of which one was saturated.
    pub saturations: u64,
}

/// What the results of one detector have shown.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct DetectorExercised {
    /// The detector's name.
    pub detector: String,
    /// Results that stood on the stream.
    pub results: u64,
    /// Hits that they counted up, each once for every phase step that saw it.
    pub hits_up: u64,
    /// Hits that they counted down.
    pub hits_down: u64,
}

impl Exercised {
    /// Names the detectors of an exercise, in their order.
    pub fn new<'a>(exercise: &Exercise, names: impl Iterator<Item = &'a str>) -> Exercised {
        let detectors = exercise.detectors.iter().zip(names);
        Exercised {
            detectors: detectors
                .map(|(detector, name)| DetectorExercised {
                    detector: name.to_owned(),
                    results: detector.results,
                    hits_up: detector.hits_up,
                    hits_down: detector.hits_down,
                })
                .collect(),
            phase_steps: exercise.phase_steps,
            results_taken: exercise.results_taken,
            scan_ends: exercise.scan_ends,
            resets: exercise.resets,
            stalls: exercise.results_held,
            overruns: exercise.groups_lost,
            saturations: exercise.groups_saturated,
        }
    }

    /// Takes what other clocks of the same sensor have shown.
    pub fn append(&mut self, other: &Exercised) {
        for (detector, more) in self.detectors.iter_mut().zip(&other.detectors) {
            detector.results += more.results;
            detector.hits_up += more.hits_up;
            detector.hits_down += more.hits_down;
        }
        self.phase_steps += other.phase_steps;
        self.results_taken += other.results_taken;
        self.scan_ends += other.scan_ends;
        self.resets += other.resets;
        self.stalls += other.stalls;
        self.overruns += other.overruns;
        self.saturations += other.saturations;
    }

    /// What was not exercised and without which equal outputs say nothing of the
    /// sensor, one sentence each with what would exercise it; none for a match. Without
    /// a stimulus of ours the clocks were somebody else's.
    pub fn missing(
        &self,
        interface: &Interface,
        stimulus: impl Into<Option<StimulusKind>>,
    ) -> Vec<String> {
        let stimulus = stimulus.into();
        let mut missing = Vec::new();
        for (number, detector) in self.detectors.iter().enumerate() {
            let name = &detector.detector;
            if detector.results == 0 {
                missing.push(format!(
                    "no result of detector {name} came to the stream: the first can stand there after \
                     {} clocks{}",
                    clocks_for_a_result(interface),
                    match stimulus {
                        Some(_) => " (--clocks)",
                        None => "",
                    }
                ));
                continue;
            }
            let [downs, ups] = signs_reached(interface, DetectorIndex(number));
            let counted =
                [(ups && detector.hits_up == 0, "up"), (downs && detector.hits_down == 0, "down")];
            let lacking: Vec<&str> =
                counted.iter().filter_map(|&(lacks, word)| lacks.then_some(word)).collect();
            if !lacking.is_empty() {
                missing.push(format!(
                    "no hit of detector {name} was counted {} in the results that came to the stream, \
                     so that Verilog which never does it looks the same: {}",
                    lacking.join(" or "),
                    match stimulus {
                        Some(StimulusKind::Photons) =>
                            "more light, more --clocks or `--stimulus adversarial` brings such hits",
                        Some(StimulusKind::Adversarial) => "more --clocks bring such hits",
                        None => "more clocks, with hits in all chips of the code, bring them",
                    }
                ));
            }
        }
        if missing.is_empty() && self.results_taken == 0 {
            let text = match stimulus {
                Some(_) => {
                    "the receiver took no result: more --clocks, or another --seed, bring it to do so"
                }
                None => "the receiver took no result: m_axis_tready was never high at one",
            };
            missing.push(text.to_owned());
        }
        missing
    }

    /// What else was not exercised, in a few words each: a match says nothing of it.
    pub fn not_reached(&self, interface: &Interface) -> Vec<&'static str> {
        let parts = [
            (self.scan_ends == 0, "the end of a scan"),
            (self.stalls == 0, "a receiver that stalls"),
            (self.overruns == 0, "a result that is lost"),
            (interface.saturates() && self.saturations == 0, "a count that saturates"),
            (self.resets < 2, "a reset after the start"),
        ];
        let lacking = parts.into_iter().filter(|(lacks, _)| *lacks);
        lacking.map(|(_, part)| part).collect()
    }

    /// One line: what was exercised, in numbers.
    pub fn text(&self) -> String {
        let mut parts: Vec<String> = self
            .detectors
            .iter()
            .map(|d| {
                format!(
                    "{}: {} results, hits counted {} up and {} down",
                    d.detector, d.results, d.hits_up, d.hits_down
                )
            })
            .collect();
        parts.push(format!(
            "{} phase steps, {} results taken, {} scan ends, {} resets, {} stalls, {} overruns, {} \
             saturations",
            self.phase_steps,
            self.results_taken,
            self.scan_ends,
            self.resets,
            self.stalls,
            self.overruns,
            self.saturations
        ));
        parts.join("; ")
    }
}

/// Clocks after which the first group's results can have been on the stream and
/// taken.
fn clocks_for_a_result(interface: &Interface) -> u64 {
    let beats = interface.beats_of_group();
    interface
        .timing
        .scan
        .integration_chips
        .saturating_add(u64::from(interface.result_latency_clocks) + RESET_CLOCKS + beats + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Step;
    use crate::scene;

    /// A scene of one m-sequence with `parallel` steps at once.
    fn interface(
        chips: &str,
        samples: u32,
        integration_chips: u32,
        window: &str,
        parallel: u32,
    ) -> Interface {
        let text = format!(
            r#"
            clock = {{ chip_period = "8 ns", samples_per_chip = {samples} }}
            source = [{{ name = "laser", code = {{ family = "chips", chips = "{chips}" }}, wavelength = "783 nm", mean_power = "20 pW", extinction_ratio = 10 }}]
            detector = [{{ name = "spad", reference = "laser", photon_detection_probability = 0.3, dead_time = "14 ns", pulse_width = "7 ns" }}]
            scan = {{ steps = {window}, integration = "{} ns" }}
            hardware = {{ parallel = {parallel} }}
            "#,
            8 * integration_chips
        );
        let scene = scene::parse("test.toml", &text);
        Interface::of(&scene.unwrap_or_else(|error| panic!("{error}")))
    }

    /// The definition (eq. 11): sample by sample, step by step.
    fn by_definition(interface: &Interface) -> [bool; 2] {
        let code = &interface.reference_codes[0];
        let lanes = u64::from(interface.lanes());
        let period = code.len() * lanes;
        let mut reached = [false; 2];
        for number in 0..interface.timing.scan.steps {
            let group = number / u64::from(interface.parallel());
            let integration = interface.timing.scan.integration_chips;
            for sample in group * integration * lanes..(group + 1) * integration * lanes {
                let delayed =
                    sample + period - interface.timing.scan.phase_step(Step(number)) % period;
                let chip = code.chips[(delayed % period / lanes) as usize];
                reached[usize::from(chip == 1)] = true;
            }
        }
        reached
    }

    #[test]
    fn signs_that_no_step_has_are_not_asked_for() {
        let mut kinds = std::collections::HashSet::new();
        for chips in ["0110100", "11100010", "1111111100000000"] {
            for samples in [1, 2, 8] {
                for integration in [1, 3, 5, 7, 20] {
                    for (first, steps, parallel) in [(0, 1, 1), (2, 3, 1), (5, 2, 2)] {
                        if integration * samples < parallel {
                            continue;
                        }
                        let window = format!("{{ first = {first}, count = {steps} }}");
                        let interface = interface(chips, samples, integration, &window, parallel);
                        let reached = signs_reached(&interface, DetectorIndex(0));
                        assert_eq!(
                            reached,
                            by_definition(&interface),
                            "{chips} {samples} {integration} {window}"
                        );
                        kinds.insert(reached);
                    }
                }
            }
        }
        assert_eq!(kinds.len(), 3);
    }
}
