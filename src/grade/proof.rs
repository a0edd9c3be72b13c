//! Yosys's ABC: whether two designs are equal at every clock, whatever comes.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::aiger::{Started, miter};
use crate::cosim::error::CosimError;
use crate::cosim::lanes::netlist::Netlist;
use crate::cosim::tools::Tool;

/// What the model checker says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Answer {
    /// No stimulus shows a difference.
    Equivalent,
    /// One that shows it so many clocks after reset.
    ShownAfter(u64),
    /// It did not come to an end.
    Undecided,
}

impl Answer {
    /// What would have to happen for the difference to be seen.
    pub(super) fn needs(self, limit_s: u32) -> String {
        match self {
            Answer::Equivalent => "nothing shows it".to_owned(),
            Answer::ShownAfter(clocks) => {
                format!("inputs that show it {clocks} clocks after reset exist")
            }
            Answer::Undecided => format!("not decided within {limit_s} s"),
        }
    }
}

/// What variants are compared with, and how.
#[derive(Debug, Clone, Copy)]
pub(super) struct Question<'a> {
    /// The good design.
    pub(super) good: &'a Netlist,
    /// Its registers after reset.
    pub(super) good_values: &'a [bool],
    /// Whether only what the result stream shows with `m_axis_tvalid` counts.
    pub(super) ignores_idle_payload: bool,
    /// Longest time for each, in seconds.
    pub(super) limit_s: u32,
}

impl Question<'_> {
    /// Compares variants, each with its registers after reset.
    ///
    /// # Errors
    /// When ABC is missing or fails.
    pub(super) fn prove(
        &self,
        variants: &[(Netlist, Vec<bool>)],
    ) -> Result<Vec<Answer>, CosimError> {
        let Question { limit_s, .. } = *self;
        if variants.is_empty() {
            return Ok(Vec::new());
        }
        let folder = tempfile::tempdir().map_err(CosimError::cache(std::env::temp_dir()))?;
        let good = Started {
            netlist: self.good,
            values: self.good_values,
        };
        let mut script = String::new();
        for (number, (netlist, values)) in variants.iter().enumerate() {
            let bytes = miter(good, Started { netlist, values }, self.ignores_idle_payload);
            let path = folder.path().join(format!("{number}.aig"));
            fs::write(&path, bytes).map_err(CosimError::cache(&path))?;
            let _ = write!(
                script,
                "echo variant {number}; read_aiger {number}.aig; strash; scorr; pdr -T {limit_s}; "
            );
        }
        let said = ask(folder.path(), &script)?;
        Ok(answers(&said, variants.len()))
    }
}

fn ask(folder: &Path, script: &str) -> Result<String, CosimError> {
    let file = folder.join("script.abc");
    fs::write(&file, script.replace("; ", "\n")).map_err(CosimError::cache(&file))?;
    Tool::abc().run(|command| {
        command
            .current_dir(folder)
            .args(["-q", "source script.abc"])
    })
}

fn answers(said: &str, count: usize) -> Vec<Answer> {
    let mut answers = vec![Answer::Undecided; count];
    let mut present = None;
    for line in said.lines() {
        if let Some(number) = line.trim().strip_prefix("variant ") {
            present = number.trim().parse::<usize>().ok();
        }
        let Some(answer) = present.and_then(|number| answers.get_mut(number)) else {
            continue;
        };
        if line.contains("Property proved") {
            *answer = Answer::Equivalent;
        } else if let Some((_, frame)) = line.split_once("was asserted in frame ") {
            let digits: String = frame.chars().take_while(char::is_ascii_digit).collect();
            if let Ok(frame) = digits.parse() {
                *answer = Answer::ShownAfter(frame);
            }
        }
    }
    answers
}
