//! Files that a scene names, in place of which it gets what is in them.

use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{Diagnostics, SceneError};
use super::sampler::widths_of_csv;
use super::setting::{Setting, with_settings};
use super::{SceneErrors, sampler};
use crate::files::read_text;
use crate::printable::printable_path;

/// The settings of the scene `text` in the file `path`, and behind them one for each file that it
/// names, with what is in it: so what is made of the scene needs no other file.
///
/// # Errors
/// If a file cannot be read, or what is wrong in it.
pub(super) fn settings(
    path: &Path,
    text: &str,
    settings: &[Setting],
) -> Result<Vec<Setting>, SceneErrors> {
    let mut all = settings.to_vec();
    let lines: Vec<String> = settings.iter().map(Setting::line).collect();
    let names_one = |text: &str| text.contains(sampler::FILE);
    if !names_one(text) && !settings.iter().any(|setting| names_one(setting.assignment())) {
        return Ok(all);
    }
    // What is not TOML, or not a setting, is told where the scene is read.
    let Ok(mut document) = DeTable::parse(text) else { return Ok(all) };
    with_settings(&mut document, settings.iter().zip(lines.iter().map(String::as_str)), |_, _| ());
    let detectors = document.get_ref().get("detector").and_then(|list| list.get_ref().as_array());
    for (number, detector) in detectors.into_iter().flat_map(|list| list.iter()).enumerate() {
        if let Some(file) = file_of(detector) {
            let file = path.parent().unwrap_or_else(|| Path::new("")).join(file);
            let widths: Vec<String> = widths(&file)?.iter().map(f64::to_string).collect();
            let value = format!("{{ widths = [{}] }}", widths.join(", "));
            let setting = Setting::of(&format!("detector[{number}].sampler"), &value, "--set");
            all.extend(setting);
        }
    }
    Ok(all)
}

/// The file of a detector's sampler, if that alone says what it is like.
fn file_of<'d>(detector: &'d Spanned<DeValue>) -> Option<&'d str> {
    let sampler = detector.get_ref().as_table()?.get("sampler")?.get_ref().as_table()?;
    let file = sampler.get(sampler::FILE).filter(|_| sampler.len() == 1)?;
    file.get_ref().as_str()
}

/// The widths in a file.
fn widths(path: &Path) -> Result<Vec<f64>, SceneErrors> {
    let file = printable_path(path);
    let text = read_text(path, sampler::MOST_FILE_BYTES).map_err(|error| SceneErrors::Invalid {
        errors: vec![SceneError::without_line(
            file.clone(),
            format!(
                "cannot read the widths of samples, as `goldtof calibrate` writes them: {error}"
            ),
        )],
        left_out: 0,
    })?;
    let diagnostics = Diagnostics::new(&file, &text);
    let widths =
        widths_of_csv(&text).map_err(|(place, message)| diagnostics.report(place, message));
    diagnostics.finish(widths.ok())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::{SceneText, load, load_with};

    const QUICK: &str = include_str!("../../../scenes/quick.toml");

    #[test]
    fn a_file_is_as_if_the_scene_had_its_widths() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("quick.toml");
        let name = "name = \"spad\"";
        let with = |keys: &str| QUICK.replacen(name, &format!("{name}\nsampler = {{ {keys} }}"), 1);
        fs::write(&path, with("file = \"pins.csv\"")).expect("written");
        let csv = "# measured\nsample,width_samples,low_samples\n1,0.5,0.4\n0,1.5,1.4\n2,1,1\n3,1,1\n\
                   4,1,1\n5,1,1\n6,1,1\n7,1,1\n";
        let pins = folder.path().join("pins.csv");
        let error = load(&path).expect_err("no file").to_string();
        assert!(error.contains("pins.csv: cannot read the widths of samples"), "{error}");
        fs::write(&pins, csv).expect("written");
        let found = load(&path).expect("it is sound");
        let text = SceneText::read(&path, &[]).expect("it can be read");
        fs::remove_file(&pins).expect("removed");
        // Read once: what is made of the text needs no file.
        assert_eq!(
            text.scene().expect("it is sound").detectors[0].sampler,
            found.detectors[0].sampler
        );
        let set = ["detector[0].sampler={ widths = [1.5, 0.5, 1, 1, 1, 1, 1, 1] }"];
        assert_eq!(found.origin.settings, set);
        fs::write(&path, QUICK).expect("written");
        let settings = [set[0].parse().expect("a setting")];
        let expected = load_with(&path, &settings).expect("it is sound");
        assert_eq!(expected.detectors[0].sampler, found.detectors[0].sampler);
        assert_eq!(found.detectors[0].sampler.instant(1), 0.5);
    }

    #[test]
    fn a_wrong_file_is_told_by_its_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("quick.toml");
        fs::write(&path, QUICK).expect("written");
        for (csv, complaint) in [
            ("", "pins.csv:1:1: the heading is \"\"; write sample,width_samples"),
            ("sample,width\n", "write sample,width_samples"),
            ("sample,width_samples\n0,1\n0,1\n", "pins.csv:3:1: sample 0 stands there already"),
            ("sample,width_samples\n0,1\n2,1\n", "sample 1 is missing"),
            ("sample,width_samples\n0,x\n", "pins.csv:2:1: \"x\" is not a width"),
            ("sample,width_samples\n0\n", "is not a width"),
            ("sample,width_samples\n-1,1\n", "\"-1\" is not a sample"),
            ("sample,width_samples\n64,1\n", "\"64\" is not a sample"),
            ("sample,width_samples\n0,1\n1,1\n", "2 widths for 8 samples of a chip"),
        ] {
            fs::write(folder.path().join("pins.csv"), csv).expect("written");
            let set = "detector.sampler={ file = \"pins.csv\" }".parse().expect("a setting");
            let error = load_with(&path, &[set]).expect_err(csv).to_string();
            assert!(error.contains(complaint), "{csv:?}: {error}");
        }
    }
}
