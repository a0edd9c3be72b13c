//! The `goldtof` program; everything is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    goldtof::cli::main()
}
