//! From a scene file to a checked [`Scene`].

use std::fs;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path as FilePath;

use toml::de::DeTable;

use super::catalogue::TABLES;
use super::companions;
use super::error::Diagnostics;
use super::reader::Section;
use super::setting::{Setting, with_settings};
use super::whole::read_scene;
use super::wording::nearest;
use super::{Scene, SceneErrors, SceneReference};
use crate::files::read_text;
use crate::printable::printable_path;

/// Largest scene file that is read.
pub(super) const MOST_SCENE_BYTES: u64 = 2 << 20;
/// Most files of a folder among which a scene is looked for that may have been meant.
const MOST_NEIGHBOURS: usize = 1000;
/// Reads and checks the scene in the file `path`.
///
/// # Errors
/// If the file cannot be read, or everything that is wrong in it.
pub fn load(path: &FilePath) -> Result<Scene, SceneErrors> {
    load_with(path, &[])
}

/// [`load`], with some keys of the file overridden.
///
/// # Errors
/// As there; an error in a setting names the setting, not a line.
pub fn load_with(path: &FilePath, settings: &[Setting]) -> Result<Scene, SceneErrors> {
    let text = read(path)?;
    let settings = companions::settings(path, &text, settings)?;
    parse_with(&printable_path(path), &text, &settings)
}

/// The text of the scene in the file `path`.
///
/// # Errors
/// If it cannot be read.
pub fn read(path: &FilePath) -> Result<String, SceneErrors> {
    read_text(path, MOST_SCENE_BYTES).map_err(|source| SceneErrors::Unreadable {
        file: printable_path(path),
        similar: match source.kind() {
            ErrorKind::NotFound => similar(path),
            _ => None,
        },
        source,
    })
}

/// The scene in the folder of `path` that its name is most likely a slip for.
fn similar(path: &FilePath) -> Option<String> {
    let folder = match path.parent() {
        Some(folder) if folder != FilePath::new("") => folder,
        _ => FilePath::new("."),
    };
    let mut names: Vec<String> = fs::read_dir(folder)
        .ok()?
        .take(MOST_NEIGHBOURS)
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    names.sort();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let meant = nearest(path.file_name()?.to_str()?, &names)?;
    Some(printable_path(&path.with_file_name(meant)))
}

/// Reads and checks the scene `text`; `file_name` is for error messages, and
/// its stem names the scene.
///
/// # Errors
/// Everything that is wrong, in the order of the file; of errors in the TOML
/// itself only the first, because the others mostly follow from it.
pub fn parse(file_name: &str, text: &str) -> Result<Scene, SceneErrors> {
    parse_with(file_name, text, &[])
}

/// [`parse`], with some keys of the text overridden.
///
/// # Errors
/// As there.
pub fn parse_with(file_name: &str, text: &str, settings: &[Setting]) -> Result<Scene, SceneErrors> {
    let appended = Appended::to(text, settings);
    let diagnostics = Diagnostics::with_settings(file_name, &appended.text, appended.named());
    let mut document = match DeTable::parse(text) {
        Ok(document) => document,
        Err(error) => {
            let span = error.span().unwrap_or(0..0);
            let message = error.message().trim();
            diagnostics.report(span, format!("not TOML: {}", with_advice(message)));
            return diagnostics.finish(None);
        }
    };
    let lines = appended.settings.iter().map(|(setting, line, _)| (*setting, line.as_str()));
    with_settings(&mut document, lines, |index, message| {
        diagnostics.report(appended.settings[index].2.clone(), message);
    });
    let reference = SceneReference::of_text(file_name, text, settings);
    let root = Section::new(&diagnostics, &TABLES, document.get_ref(), 0..0, String::new());
    let scene = read_scene(&root, reference);
    root.finish();
    diagnostics.finish(scene)
}

/// A scene's text with settings behind it, a line each, so that each of their values has
/// a place.
struct Appended<'s> {
    text: String,
    /// Each setting, its line behind as many blanks as there is text before it, and
    /// where it stands.
    settings: Vec<(&'s Setting, String, Range<usize>)>,
}

impl<'s> Appended<'s> {
    fn to(text: &str, settings: &'s [Setting]) -> Appended<'s> {
        let mut whole = text.to_owned();
        let with_places = settings.iter().map(|setting| {
            whole.push('\n');
            let start = whole.len();
            whole += &setting.line();
            let line = " ".repeat(start) + &setting.line();
            (setting, line, start..whole.len() + 1)
        });
        Appended { settings: with_places.collect(), text: whole }
    }

    fn named(&self) -> Vec<(Range<usize>, String)> {
        let settings = self.settings.iter();
        settings.map(|(setting, _, place)| (place.clone(), setting.origin().to_owned())).collect()
    }
}

/// The parser's complaint, with what would be right where it does not say so.
fn with_advice(message: &str) -> String {
    let advice = match message {
        "duplicate key" => "a key or table may stand only once; leave one of them out",
        _ if message.starts_with("string values must be quoted") => {
            return "here a value is needed: a number, true or false, or text or a quantity in \
                    quotation marks"
                .to_owned();
        }
        _ if message.starts_with("unexpected leading zero") => {
            return "a number may not begin with 0; leave the zero out".to_owned();
        }
        _ => return message.to_owned(),
    };
    format!("{message}: {advice}")
}
