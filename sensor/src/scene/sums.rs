//! Scans that a board adds up before they leave (`hardware.accumulate`): of which scenes they can be, and
//! what a host gets.

use super::reader::Section;
use super::scan::MAX_SCAN_SAMPLES;
use super::{Architecture, Registers, Scene};
use crate::scan::Scan;

impl Scene {
    /// The scene of what a host gets where a board adds up M scans (`hardware.accumulate`): one scan whose
    /// steps are M times as long. Steps are whole code periods there, so that a step's counts do not depend on when
    /// it begins, and the sum of M of them has this scan's mean and scatter.
    #[must_use]
    pub fn summed(mut self) -> Scene {
        let scans = std::mem::replace(&mut self.hardware.accumulate, 1);
        self.scan.integration_chips *= u64::from(scans);
        self.scan.requested_integration_ps *= f64::from(scans);
        self
    }
}

/// Samples of a scan, no more than [`MAX_SCAN_SAMPLES`].
fn samples_of(scene: &Scene) -> u128 {
    let Scan { steps, integration_chips, .. } = scene.scan;
    u128::from(steps) * u128::from(integration_chips) * u128::from(scene.samples_per_chip)
}

/// Reports what does not go with sums of scans: they are of scans that are alike, and of counts as they are.
pub(super) fn check(root: &Section, scene: &Scene) {
    let scans = u64::from(scene.hardware.accumulate);
    if scans == 1 || scene.hardware.architecture == Architecture::Histogram {
        return;
    }
    let hardware = root.section_or_defaults("hardware");
    let refuse = |why: &str| hardware.report("accumulate", why);
    if scene.hardware.registers != Registers::None {
        refuse(
            "a host can change the scan between two that are added up; leave out this key, or the \
             registers",
        );
    } else if scene.hardware.counter_width.is_some() {
        refuse(
            "the sum of counts that were cut to counter_width says nothing of what was cut off; leave \
             out this key, or counter_width",
        );
    } else if u128::from(scans) * samples_of(scene) > MAX_SCAN_SAMPLES {
        refuse(
            "so many scans have more than 2^60 samples together; add up fewer, or integrate for less",
        );
    }
    let paths = root.sections("path", usize::MAX);
    for (section, _) in paths.iter().zip(&scene.paths).filter(|(_, path)| path.movement.is_some()) {
        let key = if section.get("velocity").is_some() { "velocity" } else { "fluctuation" };
        section.report(
            key,
            "hardware.accumulate adds up scans, in each of which the target is elsewhere; leave out \
             hardware.accumulate, or let the target stand still",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Scene, parse};

    /// The scene `quick`, 2,500 chips of a code of 31, with these lines under `[hardware]`.
    fn quick(hardware: &str) -> Result<Scene, String> {
        let text = std::fs::read_to_string("../scenes/quick.toml").expect("it is there");
        parse("x.toml", &format!("{text}\n[hardware]\n{hardware}\n")).map_err(|e| e.to_string())
    }

    #[test]
    fn scans_that_are_added_up_have_steps_of_whole_code_periods() {
        let one = quick("accumulate = 1").expect("it is sound");
        assert_eq!((one.scan.integration_chips, one.clone().summed().scan), (2500, one.scan));
        // 80.6 code periods are 81, of each of four scans; 80 us were asked for of them together.
        let four = quick("accumulate = 4").expect("it is sound");
        assert_eq!(four.scan.integration_chips, 81 * 31);
        let sum = four.summed();
        assert_eq!(sum.scan.integration_chips, 4 * 81 * 31);
        assert!((sum.scan.requested_integration_ps - 80e6).abs() < 1e-3);
        // It is the sum already.
        assert_eq!((sum.hardware.accumulate, sum.clone().summed().scan), (1, sum.scan));
    }

    #[test]
    fn what_does_not_go_with_sums_is_refused_by_its_key() {
        for (hardware, why) in [
            ("registers = \"axi4-lite\"", "hardware.accumulate: a host can change the scan"),
            ("counter_width = 8", "hardware.accumulate: the sum of counts that were cut"),
            ("architecture = \"histogram\"", "hardware.accumulate: a histogram adds up"),
        ] {
            let error = quick(&format!("accumulate = 2\n{hardware}")).expect_err(hardware);
            assert!(error.contains(why), "{error}");
        }
        let moving = std::fs::read_to_string("../scenes/moving.toml").expect("it is there");
        let moving = moving.replace("[hardware]", "[hardware]\naccumulate = 2");
        let error = parse("x.toml", &moving).expect_err("it moves").to_string();
        assert!(error.contains("hardware.accumulate adds up scans, in each of which"), "{error}");
    }
}
