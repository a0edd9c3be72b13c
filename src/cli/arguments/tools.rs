//! Options of the commands without a scene: codes, a first scene, completions, manual pages.

use std::path::PathBuf;

use clap::Args;

use crate::cli::values::Like;
use crate::code::Family;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof codes --degree 11 --index 3 --interleave 1")]
pub(in crate::cli) struct CodesArguments {
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

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof new my-sensor --like multipath")]
pub(in crate::cli) struct NewArguments {
    /// Name of the scene: the file is NAME.toml, and NAME may have a path
    pub name: PathBuf,
    /// The standard scene to copy in place of a minimal one
    #[arg(long, value_name = "SCENE", value_enum)]
    pub like: Option<Like>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof completions bash > \
    ~/.local/share/bash-completion/completions/goldtof")]
pub(in crate::cli) struct CompletionsArguments {
    /// Shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof man --out ~/.local/share/man/man1")]
pub(in crate::cli) struct ManArguments {
    /// Folder for goldtof.1 and a page for each command; made when missing, for example
    /// --out man
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}
