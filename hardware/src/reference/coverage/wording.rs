//! Cover points in words, for people.

use super::{BinPoint, CoverPoint, PeakKind, Place, ResetState};

impl CoverPoint {
    /// In words, with the detectors' names.
    pub fn text(&self, names: &[String]) -> String {
        match self.detector() {
            Some(detector) => {
                let name = names.get(detector.0).map_or("?", String::as_str);
                let what = self.of_hits().or_else(|| self.of_counts());
                format!("{name}: {}", what.unwrap_or_default())
            }
            None => self.of_ports(),
        }
    }

    /// What single hits do, at a detector.
    fn of_hits(&self) -> Option<String> {
        use CoverPoint::*;
        Some(match *self {
            Hit { step, lane, up, .. } => {
                format!("a hit of lane {lane} counted {} in step {step} of a group", sign(up))
            }
            FullWord { up, .. } => format!("a word full of hits, all counted {}", sign(up)),
            FirstSample { .. } => "a hit on a scan's first sample".to_owned(),
            BeforeScan { .. } => "a hit on the last sample before a scan".to_owned(),
            StepBorder { first, .. } => {
                format!("a hit on the {} sample of a step", if first { "first" } else { "last" })
            }
            _ => return None,
        })
    }

    /// What counts do, at a detector.
    fn of_counts(&self) -> Option<String> {
        use CoverPoint::*;
        Some(match *self {
            Carry { step, bit, up, .. } => format!(
                "a {} out of bit {} of the total of step {step} of a group",
                if up { "carry" } else { "borrow" },
                bit - 1
            ),
            Borrow { step, bit, .. } => {
                format!("a count that borrows from bit {bit} in step {step} of a group")
            }
            TotalCarry { bit, borrow, .. } => format!(
                "a {} bit {bit} of the total of all hits",
                if borrow { "difference that borrows from" } else { "carry into" }
            ),
            Limit { step, up, .. } => {
                format!("the {} count, not saturated, in step {step} of a group", extreme(up))
            }
            Saturation { step, up, .. } => {
                format!("step {step} of a group alone saturated at the {} count", extreme(up))
            }
            LastSaturation { step, up, .. } => format!(
                "step {step} of a scan's last group alone saturated at the {} count",
                extreme(up)
            ),
            AbsentSaturation { step, up, .. } => format!(
                "step {step}, which a scan's last group has not, alone beyond the {} count",
                extreme(up)
            ),
            TotalSaturation { beyond, .. } => format!(
                "a total of hits {} its limit, no count saturated",
                if beyond { "beyond" } else { "at" }
            ),
            Peak { kind, .. } => kind.text(),
            Bin { point, .. } => point.text(),
            _ => return None,
        })
    }

    /// What the sensor does as a whole.
    fn of_ports(&self) -> String {
        use CoverPoint::*;
        match *self {
            Held { beat } => format!("beat {beat} of a group held by the receiver"),
            HeldAcross { beat } => format!("beat {beat} of a group held while a group is lost"),
            Lost { place } => format!("the {} group of a scan lost", place.text()),
            LastHeldAcross => "a scan's last beat held while a group is lost".to_owned(),
            BackToBack => "a group that arrives as the last beat before it is taken".to_owned(),
            TooLate => "a group lost by a single clock".to_owned(),
            Burst => "a group taken in successive clocks".to_owned(),
            AfterLost => "a frame behind one that was lost".to_owned(),
            FirstLost { beat } => format!("the first loss since reset at row {beat} of a frame"),
            ResetAge { age } => after_reset(age, "a group's last word"),
            ResetHit { age } => after_reset(age, "a lone hit"),
            PeakReset { age } => after_reset(age, "a scan's last word"),
            ResetAtRow { beat } => {
                format!("a reset of one clock while row {beat} of a frame stands")
            }
            Reset { state } => format!("a reset {}", state.text()),
            Result { place, later_scan } => {
                let scan = if later_scan { "a scan behind another" } else { "the first scan" };
                format!("a result of the {} group of {scan}", place.text())
            }
            WholeStep => "a step of its whole length".to_owned(),
            WholeScan => "a scan with all its steps".to_owned(),
            DelayWraps { period } => format!(
                "the delay grows past a whole {}",
                if period { "code period" } else { "chip" }
            ),
            CodeWraps { source } => format!("the code of source {source} begins anew"),
            _ => String::new(),
        }
    }
}

fn sign(up: bool) -> &'static str {
    if up { "up" } else { "down" }
}

fn extreme(up: bool) -> &'static str {
    if up { "largest" } else { "smallest" }
}

fn after_reset(age: u32, of: &str) -> String {
    format!("a reset of one clock {age} clocks after {of}")
}

impl BinPoint {
    fn text(self) -> String {
        match self {
            BinPoint::Hit { lane, later } => format!(
                "a hit of lane {lane} counted in {} code period of a frame",
                if later { "a later" } else { "the first" }
            ),
            BinPoint::Emptied { lane } => {
                format!("a bin of lane {lane} that is 0 in a memory where it was not")
            }
            BinPoint::Carry { adder, bit } => {
                format!("a count of adder {adder} that comes to 2^{bit}")
            }
            BinPoint::Top { lane, memory } => {
                format!("a bin of lane {lane} with its top bit set, read out of memory {memory}")
            }
            BinPoint::FullRow => "a word with a hit at each adder".to_owned(),
            BinPoint::Extra { adder } => format!("several hits at adder {adder} in a word"),
            BinPoint::Border { first } => {
                format!("a hit on the {} sample of a frame", if first { "first" } else { "last" })
            }
            BinPoint::Full { lane } => format!("a bin of lane {lane} at its limit"),
            BinPoint::Clamped { adder } => {
                format!("a bin of adder {adder} alone beyond its limit")
            }
        }
    }
}

impl PeakKind {
    fn text(self) -> String {
        let text = match self {
            PeakKind::Negative => "a scan's largest count below zero",
            PeakKind::Positive => "a scan's largest count above zero",
            PeakKind::First => "the peak in a scan's first group",
            PeakKind::Last => "the peak in a scan's last group",
            PeakKind::Equal => "the first of equal peaks",
            PeakKind::Step(step) => return format!("the peak in step {step} of a group"),
        };
        text.to_owned()
    }
}

impl Place {
    fn text(self) -> &'static str {
        match self {
            Place::First => "first",
            Place::Middle => "middle",
            Place::Last => "last",
        }
    }
}

impl ResetState {
    fn text(self) -> &'static str {
        match self {
            ResetState::OneClock => "of one clock",
            ResetState::TwoClocks => "of two clocks",
            ResetState::Long => "longer than all pipelines",
            ResetState::Waiting => "while a result waits",
            ResetState::Stalled => {
                "while a result waits, with m_axis_tready low until the next one stands"
            }
            ResetState::Overrun => "while o_overrun is high",
            ResetState::Saturated => "while o_saturated is high",
            ResetState::Pause => "between two scans",
            ResetState::Hit => "of one clock with a hit in its word",
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use crate::reference::coverage::CoverTable;
    use crate::scene;
    use crate::sensor::Sensor;

    #[test]
    fn every_point_has_words_of_its_own() {
        let text = include_str!("../../../../tests/scenes/totals.toml");
        let mut scene = scene::parse("totals.toml", text).expect("it is sound");
        scene.hardware.peak_detector = true;
        scene.hardware.parallel = 4;
        let table = CoverTable::of(Sensor::new(&scene).interface());
        let names: Vec<String> = scene.detectors.iter().map(|d| d.name.clone()).collect();
        let unreachable = table.unreachable().iter().map(|(point, _)| point);
        let words: Vec<String> =
            table.points().iter().chain(unreachable).map(|p| p.text(&names)).collect();
        assert!(words.len() > 50, "{}", words.len());
        assert!(words.iter().all(|words| !words.ends_with(": ") && !words.is_empty()));
        assert_eq!(words.iter().collect::<HashSet<_>>().len(), words.len());
    }
}
