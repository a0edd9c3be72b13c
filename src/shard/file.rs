//! A shard's file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::ShardError;
use super::job::{Job, Results};
use super::part::JobPart;
use crate::digest::sha256;
use crate::document::{Body, Document};
use crate::files::read_regular;
use crate::printable::printable_path;
use crate::scene::SceneText;

/// Largest file that is read back: a million scans with several paths.
const MOST_BYTES: u64 = 1 << 30;

/// A finished part of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Shard {
    /// Which part it is, from 1.
    pub shard: u64,
    /// How many parts there are.
    pub shards: u64,
    /// The whole job.
    pub job: Job,
    /// Results of this part.
    pub results: Results,
    /// SHA-256 in hexadecimal digits: of the whole document, without blanks and with this
    /// field empty.
    pub sha256: String,
}

impl Shard {
    /// The document of a part that is done by `command`.
    pub fn sealed(part: JobPart, job: Job, results: Results, command: String) -> Document<Shard> {
        let scene = job.scene().map(SceneText::reference);
        let (shard, shards) = (part.number(), part.of());
        let body = Shard { shard, shards, job, results, sha256: String::new() };
        let mut document = Document { scene, ..Document::new(body, command, None) };
        document.body.sha256 = digest(&document);
        document
    }

    /// Which part it is.
    ///
    /// # Errors
    /// When there is none of its number.
    pub fn part(&self) -> Result<JobPart, String> {
        JobPart::new(self.shard, self.shards)
    }

    /// The shard in a file.
    ///
    /// # Errors
    /// When it cannot be read, or is not what was written.
    pub fn read(path: &Path) -> Result<Document<Shard>, ShardError> {
        let unreadable =
            |reason: String| ShardError::Unreadable { path: printable_path(path), reason };
        let text = read_regular(path, MOST_BYTES).map_err(|error| unreadable(error.to_string()))?;
        let mut document: Document<Shard> =
            serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
        if document.document != Shard::NAME {
            let found = format!("it is a document \"{}\", and no shard", document.document);
            return Err(unreadable(found));
        }
        let told = std::mem::take(&mut document.body.sha256);
        if told != digest(&document) {
            let changed = "it is not what was written: its SHA-256 is another";
            return Err(unreadable(changed.to_owned()));
        }
        document.body.sha256 = told;
        document.body.part().map_err(unreadable)?;
        Ok(document)
    }
}

/// The [`Shard::sha256`] of a document in which it is empty.
fn digest(document: &Document<Shard>) -> String {
    // What was read from JSON, or is to be written, is always JSON.
    let text = serde_json::to_vec(document).unwrap_or_default();
    sha256(text)
}
