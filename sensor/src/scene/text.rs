//! A scene as it was read.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::origin::shown;
use super::setting::Setting;
use super::{Scene, SceneErrors, SceneReference, companions, read};
use crate::printable::printable_path;

/// A scene as it was read, so that what is made of it needs no other file. It is read once:
/// whoever changes the file meanwhile changes nothing here.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SceneText {
    /// Name of the file, without its folder.
    pub file: String,
    /// Its text.
    pub text: String,
    /// Overridden keys: `path.distance=5 m`.
    pub settings: Vec<Setting>,
}

impl SceneText {
    /// That of the file `path`, with some of its keys overridden, and with what is in the files
    /// that it names. Its name has the folder, for messages.
    ///
    /// # Errors
    /// If it, or a file that it names, cannot be read.
    pub fn read(path: &Path, settings: &[Setting]) -> Result<SceneText, SceneErrors> {
        let text = read::read(path)?;
        let settings = companions::settings(path, &text, settings)?;
        Ok(SceneText { file: printable_path(path), text, settings })
    }

    /// The same without the folder in its name, on which nothing may depend.
    pub fn without_folder(&self) -> SceneText {
        SceneText { file: shown(Path::new(&self.file).file_name()), ..self.clone() }
    }

    /// The scene.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn scene(&self) -> Result<Scene, SceneErrors> {
        read::parse_with(&self.file, &self.text, &self.settings)
    }

    /// What documents name it by.
    pub fn reference(&self) -> SceneReference {
        SceneReference::of_text(&self.file, &self.text, &self.settings)
    }
}
