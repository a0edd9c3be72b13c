//! `goldtof codes`: a code and its correlation properties.

use clap::Args;

use super::ending::Ending;
use super::output::Output;
use crate::code::{CodeSpec, Family, parse_polynomials, parse_seeds, report};

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof codes --degree 11 --index 3 --interleave 1")]
pub(super) struct CodesArguments {
    /// Degree n of the polynomials, 2 to 20, for example --degree 11; the code has
    /// 2^n - 1 chips before interleaving
    #[arg(long, value_name = "N")]
    pub degree: Option<u32>,
    /// Family, for example --family m-sequence
    #[arg(long, value_name = "F", value_enum, default_value_t = Family::Gold)]
    pub family: Family,
    /// Exponents in descending order, the two polynomials of a Gold pair
    /// separated by a semicolon: --polynomials "11,2,0;11,8,5,2,0"
    /// [default: a preferred pair]
    #[arg(long, value_name = "LIST")]
    pub polynomials: Option<String>,
    /// First chips of each m-sequence, separated by a comma: --seeds
    /// 11111,11111 [default: all ones]
    #[arg(long, value_name = "A,B")]
    pub seeds: Option<String>,
    /// Index in the Gold set: -2 is u, -1 is v, i is u XOR v advanced by i chips,
    /// up to 2^n - 2, for example --index 3 [default: 0]
    #[arg(long, value_name = "I", allow_negative_numbers = true)]
    pub index: Option<i64>,
    /// Interleaving depth nu, 0 to 8, for example --interleave 1
    #[arg(long, value_name = "V", default_value_t = 0)]
    pub interleave: u32,
    /// Chips of family chips, first chip first: --chips 0110100
    #[arg(long, value_name = "BITS")]
    pub chips: Option<String>,
    /// Permit a Gold set from a pair that is not preferred
    #[arg(long)]
    pub allow_non_preferred: bool,
}

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
