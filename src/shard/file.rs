//! A shard's file.

use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::ShardError;
use super::job::{Job, Results};
use super::part::Part;
use crate::document::{Body, Document};
use crate::files::read_regular;
use crate::printable::printable_path;

/// Largest file that is read back: a million scans with several paths.
const MOST_BYTES: u64 = 1 << 30;

/// One of the parts of a job that is done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Shard {
    /// Which part it is, from 1.
    pub shard: u64,
    /// How many parts there are.
    pub shards: u64,
    /// What it is a part of.
    pub job: Job,
    /// What it has of it.
    pub results: Results,
    /// SHA-256 of all that, in hexadecimal digits: of the JSON array of the four, without
    /// blanks.
    pub sha256: String,
}

impl Body for Shard {
    const NAME: &'static str = "shard";
}

impl Shard {
    /// A part that is done.
    pub fn new(part: Part, job: Job, results: Results) -> Shard {
        let mut shard =
            Shard { shard: part.number(), shards: part.of(), job, results, sha256: String::new() };
        shard.sha256 = shard.digest();
        shard
    }

    fn digest(&self) -> String {
        let all = (self.shard, self.shards, &self.job, &self.results);
        // What was read from JSON, or is to be written, is always JSON.
        let text = serde_json::to_vec(&all).unwrap_or_default();
        let digest = Sha256::digest(text);
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Which part it is.
    ///
    /// # Errors
    /// When there is none of its number.
    pub fn part(&self) -> Result<Part, String> {
        Part::new(self.shard, self.shards)
    }

    /// The shard in a file.
    ///
    /// # Errors
    /// When it cannot be read, or is not what was written.
    pub fn read(path: &Path) -> Result<Document<Shard>, ShardError> {
        let unreadable =
            |reason: String| ShardError::Unreadable { path: printable_path(path), reason };
        let text = read_regular(path, MOST_BYTES).map_err(|error| unreadable(error.to_string()))?;
        let document: Document<Shard> =
            serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
        let shard = &document.body;
        if document.document != Shard::NAME {
            let found = format!("it is a document \"{}\", and no shard", document.document);
            return Err(unreadable(found));
        }
        if shard.sha256 != shard.digest() {
            let changed = "it is not what was written: its SHA-256 is another";
            return Err(unreadable(changed.to_owned()));
        }
        shard.part().map_err(unreadable)?;
        Ok(document)
    }
}
