//! The program, as the tests of this folder start it.

use std::process::{Command, Output};

use serde_json::Value;

/// The scene that is done within a second.
pub const QUICK: &str = "scenes/quick.toml";

/// The program with some arguments, not yet started.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_goldtof"));
    command.args(arguments);
    command
}

/// Runs it to its end.
pub fn goldtof(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

/// What it said on stderr.
pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The JSON of a command that ends well; `--json` is among its arguments.
pub fn json(arguments: &[&str]) -> Value {
    let output = goldtof(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}
