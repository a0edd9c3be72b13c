//! Where a scene comes from, as documents name it.

use std::ffi::OsStr;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::setting::Setting;
use crate::digest::sha256;
use crate::printable::printable_path;

/// The text that a scene was read from. Empty for a scene that was made in a program.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Origin {
    /// Name of the file, without its folder.
    pub file: String,
    /// SHA-256 of its text, in hexadecimal digits.
    pub sha256: String,
    /// Overridden keys: `path.distance=5 m`.
    pub settings: Vec<String>,
}

impl Origin {
    fn of(file: &str, text: &str, settings: &[Setting]) -> Origin {
        let assignment = |setting: &Setting| setting.assignment().to_owned();
        Origin {
            file: file.to_owned(),
            sha256: sha256(text),
            settings: settings.iter().map(assignment).collect(),
        }
    }
}

/// The scene of a document. What is made of a scene does not depend on the folder that it
/// lies in, and so the folder is not named.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SceneReference {
    /// The file's stem.
    pub name: String,
    /// Name of the file, without its folder.
    pub file: String,
    /// SHA-256 of its text, in hexadecimal digits.
    pub sha256: String,
    /// Overridden keys: `path.distance=5 m`.
    pub settings: Vec<String>,
}

impl SceneReference {
    /// Of the text of the file `path`, whose stem names the scene.
    pub fn of_text(path: &str, text: &str, settings: &[Setting]) -> SceneReference {
        let path = Path::new(path);
        let shown = |part: Option<&OsStr>| {
            part.map_or_else(String::new, |part| printable_path(Path::new(part)))
        };
        let origin = Origin::of(&shown(path.file_name()), text, settings);
        SceneReference::new(&shown(path.file_stem()), &origin)
    }

    /// Of a scene with this name.
    pub(super) fn new(name: &str, origin: &Origin) -> SceneReference {
        SceneReference {
            name: name.to_owned(),
            file: origin.file.clone(),
            sha256: origin.sha256.clone(),
            settings: origin.settings.clone(),
        }
    }
}
