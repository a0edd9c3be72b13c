//! The folder of a sweep: what it is, and the points that are done.

use std::collections::BTreeSet;
use std::path::Path;

use super::points::SweepOptions;
use crate::document::Document;
use crate::files::{FileError, OutputFolder, read_regular};
use crate::printable::printable_path;

/// Its folder of points that are done.
const POINTS: &str = "points";
/// What the sweep of a folder is.
const DEFINITION: &str = "sweep.json";
/// Largest file that is read back.
const MOST_BYTES: u64 = 64 << 20;

/// Why a folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// What is there cannot be read.
    #[error(
        "{path}: cannot read what the sweep left there: {reason}; remove the folder, or name another"
    )]
    Unreadable {
        /// The file.
        path: String,
        /// Why not.
        reason: String,
    },
    /// Another sweep's points are there.
    #[error(
        "{path} has the points of another sweep: {differences}; name another folder with --out, or \
         remove this one to begin anew"
    )]
    Other {
        /// The folder.
        path: String,
        /// What differs.
        differences: String,
    },
}

/// What of a sweep differs from another, in words.
fn differences(this: &Document<SweepOptions>, other: &Document<SweepOptions>) -> String {
    let settings = |document: &Document<SweepOptions>| {
        let scene = document.scene.as_ref();
        scene.map_or_else(Vec::new, |scene| scene.settings.clone())
    };
    let list = |texts: &[String]| match texts {
        [] => "none".to_owned(),
        _ => texts.join(" "),
    };
    let pairs = |document: &Document<SweepOptions>| {
        let SweepOptions { over, repetitions, fidelity, estimator, seed } = &document.body;
        let over: Vec<String> = over.iter().map(|axis| axis.text.clone()).collect();
        let estimator = estimator.map_or_else(|| "the scene's".to_owned(), |e| e.to_string());
        [
            ("version", document.goldtof.to_string()),
            ("--set", list(&settings(document))),
            ("--over", list(&over)),
            ("--repeat", repetitions.to_string()),
            ("--fidelity", fidelity.to_string()),
            ("--estimator", estimator),
            ("--seed", seed.to_string()),
        ]
    };
    let pairs = pairs(this).into_iter().zip(pairs(other));
    let differing = pairs.filter(|(here, there)| here != there);
    let mut differences: Vec<String> = differing
        .map(|((what, here), (_, there))| format!("{what} was {there}, now {here}"))
        .collect();
    let text =
        |document: &Document<SweepOptions>| document.scene.as_ref().map(|s| s.sha256.clone());
    if text(this) != text(other) {
        differences.push("the scene's file has changed since".to_owned());
    }
    differences.join("; ")
}

/// The folder of a sweep.
pub struct Store {
    points: OutputFolder,
}

impl Store {
    /// Takes a folder for a sweep: an empty one, or one with its points. `on_wait` is told
    /// when another run holds them, before this one waits for that run's end.
    ///
    /// # Errors
    /// When it has another sweep's, or a file cannot be read or written.
    pub fn open(
        folder: &OutputFolder,
        definition: &Document<SweepOptions>,
        on_wait: impl FnOnce(&Path),
    ) -> Result<Store, StoreError> {
        let points = folder.subfolder(POINTS, on_wait)?;
        let path = folder.join(DEFINITION);
        if path.exists() {
            let text = read(&path)?;
            let there: Document<SweepOptions> =
                serde_json::from_str(&text).map_err(|reason| unreadable(&path, &reason))?;
            let differences = differences(definition, &there);
            if !differences.is_empty() {
                return Err(StoreError::Other { path: printable_path(folder.path()), differences });
            }
        } else {
            let text = serde_json::to_string_pretty(definition)
                .map_err(|reason| unreadable(&path, &reason))?;
            // Points of nobody knows what.
            for number in numbers(&points)? {
                points.remove(&name(number))?;
            }
            points.sync()?;
            folder.write(DEFINITION, &(text + "\n"))?;
        }
        Ok(Store { points })
    }

    /// The points that are done.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn done(&self) -> Result<BTreeSet<usize>, StoreError> {
        numbers(&self.points)
    }

    /// Keeps a finished point: when this returns it is on the disk, whole.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn keep(&self, number: usize, text: &str) -> Result<(), StoreError> {
        Ok(self.points.write(&name(number), text)?)
    }

    /// Removes all that a sweep has in `folder`, if it has anything: the points stand
    /// elsewhere.
    ///
    /// # Errors
    /// When a file cannot be removed.
    pub fn clear(folder: &OutputFolder) -> Result<(), StoreError> {
        if folder.join(POINTS).is_dir() {
            let points = folder.subfolder(POINTS, |_| ())?;
            for number in numbers(&points)? {
                points.remove(&name(number))?;
            }
            points.discard();
        }
        Ok(folder.remove(DEFINITION)?)
    }

    /// A point that is done.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn point(&self, number: usize) -> Result<String, StoreError> {
        read(&self.points.join(&name(number)))
    }
}

fn name(number: usize) -> String {
    format!("{number:06}.csv")
}

/// Numbers of the points in a folder. Files that are written at the moment have other
/// names.
fn numbers(points: &OutputFolder) -> Result<BTreeSet<usize>, StoreError> {
    let entries =
        std::fs::read_dir(points.path()).map_err(|reason| unreadable(points.path(), &reason))?;
    let number = |entry: std::io::Result<std::fs::DirEntry>| {
        let file = entry.ok()?.file_name();
        let found: usize = file.to_str()?.strip_suffix(".csv")?.parse().ok()?;
        (file.to_str()? == name(found)).then_some(found)
    };
    Ok(entries.filter_map(number).collect())
}

fn read(path: &Path) -> Result<String, StoreError> {
    read_regular(path, MOST_BYTES).map_err(|reason| unreadable(path, &reason))
}

fn unreadable(path: &Path, reason: &impl ToString) -> StoreError {
    StoreError::Unreadable { path: printable_path(path), reason: reason.to_string() }
}
