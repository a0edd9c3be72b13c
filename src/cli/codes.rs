//! `goldtof codes`: a code and its correlation properties.

use super::arguments::CodesArguments;
use super::ending::Ending;
use super::output::Output;
use crate::code::{CodeSpec, parse_polynomials, parse_seeds, report};

pub(super) fn run(arguments: &CodesArguments, output: &mut Output) -> anyhow::Result<Ending> {
    let report = report(&spec(arguments)?)?;
    output.answer(None, &report, &report.to_text())?;
    Ok(Ending::Done)
}

fn spec(arguments: &CodesArguments) -> anyhow::Result<CodeSpec> {
    let mut spec = CodeSpec::new(arguments.family);
    spec.degree = arguments.degree;
    spec.index = arguments.index;
    spec.interleave = arguments.interleave;
    spec.polynomials = arguments.polynomials.as_deref().map(parse_polynomials).transpose()?;
    spec.seeds = arguments.seeds.as_deref().map(parse_seeds);
    spec.chips.clone_from(&arguments.chips);
    spec.allow_non_preferred = arguments.allow_non_preferred.then_some(true);
    Ok(spec)
}
