//! The command line: arguments, exit codes, and who prints what.
//!
//! With `--json` one JSON document goes to stdout and nothing else; progress
//! and summaries go to stderr.
//!
//! ```no_run
//! fn main() -> std::process::ExitCode {
//!     goldtof::cli::main()
//! }
//! ```

mod arguments;
pub mod calibrate;
mod common;
mod compare_architectures;
mod cosim;
#[doc(hidden)]
pub mod documents;
mod emit;
mod estimate;
mod explain;
mod failure;
mod fidelity;
mod forecast;
mod grade;
mod image;
mod junit;
mod manual;
mod new;
mod output;
mod prelude;
mod provenance;
mod pulses;
mod replay;
mod reproduce;
mod run;
mod shards;
mod simulate;
mod stress;
mod sweep;
mod target_maps;

use std::process::ExitCode;

use clap::Parser as _;

use self::arguments::Cli;
use self::common::Command as _;
use self::failure::Failure;
use self::output::{CommandOutput, Ending};
use crate::cosim::build::set_cache_dir;
use crate::cosim::error::CosimError;
use crate::interrupt;
use crate::printable::printable_lines;
use crate::programs;

/// Parses the command line, runs the command, and says how it ended.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are answers, not errors.
            let status = if error.use_stderr() { 2 } else { 0 };
            print_usage(&error);
            let asks = |argument: std::ffi::OsString| argument == "--json";
            if status == 2 && std::env::args_os().any(asks) {
                output::failure(&Failure::of_usage(&error.render().to_string()));
            }
            return ExitCode::from(status);
        }
    };
    let output = CommandOutput::new(cli.json, cli.quiet);
    if let Err(error) = interrupt::watch() {
        output.note(&format!("signals are not watched: {error}"));
    }
    programs::set_time_limit(cli.tool_timeout);
    if let Some(cache) = cli.cache {
        set_cache_dir(cache);
    }
    match cli.command.run(cli.seed, &output) {
        Ok(Ending::Done) => ExitCode::SUCCESS,
        Ok(Ending::DoesNotHold) => ExitCode::from(1),
        Ok(Ending::BelowThreshold) => ExitCode::from(4),
        Err(error) => {
            let status = status_of(&error);
            output.error(&error, status);
            ExitCode::from(status)
        }
    }
}

/// What is wrong with the command line, or its help; in colour unless it quotes
/// what would command the terminal.
fn print_usage(error: &clap::Error) {
    let text = error.render().to_string();
    if printable_lines(&text) == text {
        let _ = error.print();
    } else {
        output::to_stderr(text.trim_end());
    }
}

/// 3 for a missing or failing external tool and for lanes without a verdict, 1 for Verilog that ends its own
/// simulation, or differs where it was to be graded, and so is not the sensor, 2 for
/// everything else.
fn status_of(error: &anyhow::Error) -> u8 {
    match cosim_error(error) {
        Some(error) if error.is_tool() => 3,
        Some(CosimError::NoVerdict(_)) => 3,
        Some(CosimError::Halted { .. } | CosimError::Differs { .. }) => 1,
        _ => 2,
    }
}

/// What went wrong with Verilog or tools, whichever job they were for.
fn cosim_error(error: &anyhow::Error) -> Option<&CosimError> {
    error.chain().find_map(|cause| cause.downcast_ref())
}
