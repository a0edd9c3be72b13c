//! Where a scene comes from, as documents name it.

use std::ffi::OsStr;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::setting::Setting;
use crate::digest::sha256;
use crate::printable::printable_path;

/// The text that a scene was read from. Empty for a scene that was made in a program.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Origin {
    /// Name of the file, without its folder.
    pub file: String,
    /// SHA-256 of its text, in hexadecimal digits.
    pub sha256: String,
    /// Overridden keys: `path.distance=5 m`.
    pub settings: Vec<String>,
}

/// The scene of a document. What is made of a scene does not depend on the folder that it
/// lies in, and so the folder is not named.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SceneReference {
    /// The file's stem.
    pub name: String,
    /// The text that it was read from.
    #[serde(flatten)]
    pub origin: Origin,
}

impl SceneReference {
    /// Of the text of the file `path`, whose stem names the scene.
    pub fn of_text(path: &str, text: &str, settings: &[Setting]) -> SceneReference {
        let path = Path::new(path);
        let settings = settings.iter().map(|setting| setting.assignment().to_owned());
        SceneReference {
            name: shown(path.file_stem()),
            origin: Origin {
                file: shown(path.file_name()),
                sha256: sha256(text),
                settings: settings.collect(),
            },
        }
    }
}

/// Part of a path, as it may be written.
pub(super) fn shown(part: Option<&OsStr>) -> String {
    part.map_or_else(String::new, |part| printable_path(Path::new(part)))
}
