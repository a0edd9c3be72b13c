//! `goldtof codes`: a code and its correlation properties.

use super::ending::Ending;
use super::output::Output;
use crate::code::{CodeSpec, report};

pub(super) fn run(spec: &CodeSpec, output: &mut Output) -> anyhow::Result<Ending> {
    let report = report(spec)?;
    output.answer(None, &report, &report.to_text())?;
    Ok(Ending::Done)
}
