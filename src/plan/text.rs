//! The plan in words.

use std::fmt::Write as _;

use super::part::{Part, Plan};

impl Plan {
    /// The plan for people: one line per part.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let parts = || self.hardware.iter().chain(&self.simulation);
        let width = parts()
            .map(|part| part.part.chars().count())
            .max()
            .unwrap_or(0);
        for (title, parts) in [
            ("Hardware", &self.hardware),
            ("Simulation", &self.simulation),
        ] {
            let _ = writeln!(text, "{title}");
            for part in parts {
                let Part {
                    part,
                    kept,
                    reason,
                    saving,
                } = part;
                let mark = if *kept { "kept    " } else { "left out" };
                let saving = saving.as_ref().map_or(String::new(), |saving| {
                    format!(
                        "; saves {:.1} % of the time ({})",
                        saving.share * 100.0,
                        saving.basis
                    )
                });
                let _ = writeln!(text, "  {mark}  {part:width$}  {reason}{saving}");
            }
        }
        if self.not_measured > 0 {
            let _ = writeln!(
                text,
                "what {} of the parts left out save was not measured: it would take too long",
                self.not_measured
            );
        }
        text
    }
}
