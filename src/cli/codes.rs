//! `goldtof codes`: a code and its correlation properties.

use super::command::Command;
use super::output::{Ending, Output};
use crate::code::{CodeSpec, report};

impl Command for CodeSpec {
    fn run(&self, _: u64, output: &Output) -> anyhow::Result<Ending> {
        let report = report(self)?;
        output.answer(None, &report, &report.to_text())
    }
}
