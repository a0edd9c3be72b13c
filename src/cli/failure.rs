//! An error as a JSON document, with `--json`.

use serde::Serialize;

use crate::cosim::error::CosimError;
use crate::files::FileError;
use crate::printable::printable_path;
use crate::scene::{SceneError, SceneErrors};

/// The document of a command that failed.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(super) struct Failure {
    /// The error.
    pub error: FailureReport,
}

/// What went wrong.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Told")]
pub(super) struct FailureReport {
    /// What stderr says, without its "error: ".
    pub text: String,
    /// The exit status that goes with it.
    pub exit_status: u8,
    /// Where, as far as that is known.
    pub places: Vec<Location>,
}

/// A place that an error speaks of.
#[derive(Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub(super) struct Location {
    /// The file, or the setting of the command line.
    pub file: String,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Column in characters, from 1.
    pub column: Option<usize>,
    /// The scene's key, as its line has it.
    pub key: Option<String>,
    /// What is wrong there, and what would be right.
    pub message: Option<String>,
}

impl Failure {
    /// The document of an error whose words are `text`.
    pub fn new(error: &anyhow::Error, text: &str, exit_status: u8) -> Failure {
        Failure {
            error: FailureReport { text: text.to_owned(), exit_status, places: places(error) },
        }
    }

    /// The document of a command line that cannot be meant.
    pub fn of_usage(text: &str) -> Failure {
        let text = text.trim_end();
        Failure {
            error: FailureReport {
                text: text.strip_prefix("error: ").unwrap_or(text).to_owned(),
                exit_status: 2,
                places: Vec::new(),
            },
        }
    }
}

fn places(error: &anyhow::Error) -> Vec<Location> {
    // Whichever job the scene was for.
    match error.chain().find_map(|cause| cause.downcast_ref()) {
        Some(SceneErrors::Invalid { errors, .. }) => {
            return errors.iter().map(of_scene).collect();
        }
        Some(SceneErrors::Unreadable { file, .. }) => return vec![of_file(file.clone())],
        None => {}
    }
    if let Some(FileError { path, .. }) = error.downcast_ref() {
        return vec![of_file(printable_path(path))];
    }
    super::cosim_error(error).map_or_else(Vec::new, of_cosim)
}

fn of_file(file: String) -> Location {
    Location { file, ..Location::default() }
}

fn of_scene(error: &SceneError) -> Location {
    let known = |number: usize| (error.line > 0).then_some(number);
    let line = error.source_line.as_str();
    let key = line.split_once('=').map(|(key, _)| key.trim().to_owned());
    Location {
        file: error.file.clone(),
        line: known(error.line),
        column: known(error.column),
        key: key.filter(|key| !key.is_empty() && !key.starts_with(['#', '[', '{'])),
        message: Some(error.message.clone()),
    }
}

fn of_cosim(error: &CosimError) -> Vec<Location> {
    match error {
        CosimError::FileList { path, line, column, reason } => vec![Location {
            file: printable_path(path),
            line: Some(*line),
            column: Some(*column),
            key: None,
            message: Some(reason.clone()),
        }],
        CosimError::Rejected { output, .. } => output.lines().filter_map(of_verilator).collect(),
        CosimError::Ambiguous { first, second, .. } => {
            [first, second].map(|path| of_file(printable_path(path))).into()
        }
        CosimError::Manifest { path, .. }
        | CosimError::Unreadable { path, .. }
        | CosimError::Cache { path, .. }
        | CosimError::NoVerilog(path) => vec![of_file(printable_path(path))],
        _ => Vec::new(),
    }
}

/// `%Error: FILE:LINE:COLUMN: MESSAGE`, and `%Error-NAME: ...`.
fn of_verilator(line: &str) -> Option<Location> {
    let (_, rest) = line.strip_prefix("%Error")?.split_once(": ")?;
    let (place, message) = rest.split_once(": ")?;
    let mut parts = place.rsplitn(3, ':');
    let column = parts.next()?.parse().ok()?;
    let line = parts.next()?.parse().ok()?;
    Some(Location {
        file: parts.next()?.to_owned(),
        line: Some(line),
        column: Some(column),
        key: None,
        message: Some(message.to_owned()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verilators_errors_have_their_place() {
        let told = "%Error-MODDUP: my rtl/a.v:3:8: Duplicate declaration of module: 'x'";
        let place = of_verilator(told).unwrap();
        assert_eq!(place.file, "my rtl/a.v");
        assert_eq!((place.line, place.column), (Some(3), Some(8)));
        assert_eq!(place.message.unwrap(), "Duplicate declaration of module: 'x'");
        assert_eq!(of_verilator("%Error: Exiting due to 1 error(s)"), None);
        assert_eq!(of_verilator("    3 | module x"), None);
    }
}
