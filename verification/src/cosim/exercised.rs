//! What a co-simulation exercised: a match says no more than that.

use crate::scene::DetectorIndex;

use super::StimulusKind;
use crate::reference::coverage::signs_reached;
use crate::reference::stimulus::RESET_CLOCKS;
use crate::sensor::interface::Interface;

pub use crate::reference::exercise::Exercised;

/// What was not exercised and without which equal outputs say nothing of the
/// sensor, one sentence each with what would exercise it; none for a match. Without
/// a stimulus of ours the clocks were somebody else's.
pub fn missing(
    exercised: &Exercised,
    interface: &Interface,
    stimulus: impl Into<Option<StimulusKind>>,
) -> Vec<String> {
    let stimulus = stimulus.into();
    let mut missing = Vec::new();
    for (number, detector) in exercised.detectors.iter().enumerate() {
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
    if missing.is_empty() && exercised.results_taken == 0 {
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

/// Clocks after which the first group's results can have been on the stream and
/// taken.
fn clocks_for_a_result(interface: &Interface) -> u64 {
    let beats = interface.beats_of_group();
    interface
        .timing
        .scan
        .integration_chips
        .saturating_add(u64::from(interface.result_latency_clocks) + RESET_CLOCKS + beats + 1)
        .saturating_add(interface.lead_clocks())
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
