//! A scene as it was read.

use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::de::DeTable;

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

    /// The same with another chip period, which a clock has that is made of another one: in the
    /// text, so that it is that of the scene for whoever reads it, in place of settings of that key.
    #[must_use]
    pub fn with_chip_period(mut self, value: &str) -> SceneText {
        const KEY: &str = "clock.chip_period";
        self.settings.retain(|setting| setting.key_and_value().0 != KEY);
        match chip_period_place(&self.text) {
            Some(place) => self.text.replace_range(place, &format!("\"{value}\"")),
            None => self.settings.extend(Setting::of(KEY, value, "--set")),
        }
        self
    }

    /// What documents name it by.
    pub fn reference(&self) -> SceneReference {
        SceneReference::of_text(&self.file, &self.text, &self.settings)
    }
}

/// Where a scene's text has the value of `clock.chip_period`.
fn chip_period_place(text: &str) -> Option<Range<usize>> {
    let root = DeTable::parse(text).ok()?;
    let clock = root.get_ref().get("clock")?.get_ref().as_table()?;
    clock.get("chip_period").map(toml::Spanned::span)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(text: &str, settings: &[&str]) -> SceneText {
        let settings = settings.iter().map(|set| set.parse().expect("a setting")).collect();
        SceneText { file: "test.toml".to_owned(), text: text.to_owned(), settings }
    }

    #[test]
    fn another_chip_period_leaves_all_else_as_it_is() {
        let text =
            "# of the board\n[clock]\nchip_period = '8 ns' # asked for\nsamples_per_chip = 8\n";
        assert_eq!(
            scene(text, &[]).with_chip_period("8.008 ns").text,
            "# of the board\n[clock]\nchip_period = \"8.008 ns\" # asked for\nsamples_per_chip = 8\n"
        );
        let inline = "clock = { chip_period = \"8 ns\" }\n";
        assert_eq!(
            scene(inline, &[]).with_chip_period("9 ns").text,
            "clock = { chip_period = \"9 ns\" }\n"
        );
    }

    #[test]
    fn a_setting_gives_way_to_the_text() {
        let text = "[clock]\nchip_period = \"8 ns\"\n";
        let set = ["clock.chip_period=10 ns", "path.distance=5 m"];
        let changed = scene(text, &set).with_chip_period("10.01 ns");
        assert_eq!(changed.text, "[clock]\nchip_period = \"10.01 ns\"\n");
        let values: Vec<_> = changed.settings.iter().map(Setting::key_and_value).collect();
        assert_eq!(values, [("path.distance", "5 m")]);
    }

    #[test]
    fn a_text_without_a_chip_period_gets_a_setting() {
        let changed = scene("[clock]\nsamples_per_chip = 8\n", &[]).with_chip_period("8.008 ns");
        let values: Vec<_> = changed.settings.iter().map(Setting::key_and_value).collect();
        assert_eq!(values, [("clock.chip_period", "8.008 ns")]);
    }
}
