//! The folder of a job's shards.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::ShardError;
use super::file::Shard;
use super::job::{Job, PartResults, Results};
use super::part::JobPart;
use crate::differences::other_version;
use crate::document::Document;
use crate::files::{self, OutputFolder, make_folder};
use crate::printable::printable_path;
use crate::scene::SceneReference;
use crate::version::VERSION;

/// Its name in the folder that the command writes to.
const NAME: &str = "shards";

/// The folder of a job's shards. It has no lock: each file is of one shard and appears whole, so
/// that runs on several machines are independent.
pub struct ShardFolder {
    path: PathBuf,
}

/// The shards that a folder has.
#[derive(Debug)]
pub struct Collected {
    /// The folder.
    path: PathBuf,
    /// The whole job.
    pub job: Job,
    /// The scene that it is of, if it is of one.
    pub scene: Option<SceneReference>,
    /// Number of shards of the job.
    pub of: u64,
    /// Those that are there, by their numbers from 1.
    pub results: BTreeMap<u64, Results>,
}

impl ShardFolder {
    /// That of a command which writes to `out`; created if missing.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn make(out: &Path) -> Result<ShardFolder, ShardError> {
        let path = out.join(NAME);
        make_folder(&path)?;
        Ok(ShardFolder { path })
    }

    /// Path of a shard's file.
    pub fn path_of(&self, part: JobPart) -> PathBuf {
        self.path.join(format!("{}.json", part.name()))
    }

    /// A folder for what a shard keeps on the way to its file.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn workplace(
        &self,
        part: JobPart,
        on_wait: impl FnOnce(&Path),
    ) -> Result<OutputFolder, ShardError> {
        Ok(OutputFolder::open(&self.path.join(part.name()), on_wait)?)
    }

    /// Whether there is one.
    pub fn has_workplace(&self, part: JobPart) -> bool {
        self.path.join(part.name()).is_dir()
    }

    /// Whether a part of a job is done already.
    ///
    /// # Errors
    /// When its file is one of another job, or cannot be read.
    pub fn has(&self, part: JobPart, job: &Job) -> Result<bool, ShardError> {
        let path = self.path_of(part);
        if !path.try_exists().unwrap_or(true) {
            return Ok(false);
        }
        let there = Shard::read(&path)?;
        let mut differences = job.differences(&there.body.job);
        differences.extend(other_version(VERSION, &there.goldtof));
        differences.extend(other_part(&path, &there.body));
        match differences.is_empty() {
            true => Ok(true),
            false => Err(ShardError::Taken {
                path: printable_path(&path),
                differences: differences.join("; "),
            }),
        }
    }

    /// Writes a shard's file, whole or not at all. Gives its path.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn keep(&self, part: JobPart, shard: &Document<Shard>) -> Result<PathBuf, ShardError> {
        let path = self.path_of(part);
        let text = serde_json::to_string(shard).map_err(|error| ShardError::Unreadable {
            path: printable_path(&path),
            reason: error.to_string(),
        })?;
        files::write(&path, &(text + "\n"))?;
        Ok(path)
    }

    /// Reads all shards of the folder of a command that wrote to `out`.
    ///
    /// # Errors
    /// When there are none, or one cannot be read, or they are not all of one job.
    pub fn collect(out: &Path) -> Result<Collected, ShardError> {
        let folder = out.join(NAME);
        let none = || ShardError::None { path: printable_path(&folder) };
        let unreadable = |error: io::Error| ShardError::Unreadable {
            path: printable_path(&folder),
            reason: error.to_string(),
        };
        let entries = match fs::read_dir(&folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(none()),
            entries => entries.map_err(unreadable)?,
        };
        let part = |entry: io::Result<fs::DirEntry>| {
            let file = entry.ok()?.file_name();
            JobPart::of_name(file.to_str()?.strip_suffix(".json")?)
        };
        let mut parts: Vec<JobPart> = entries.filter_map(part).collect();
        parts.sort_unstable_by_key(|part| (part.of(), part.number()));
        let folder = ShardFolder { path: folder.clone() };
        let (first, others) = parts.split_first().ok_or_else(none)?;
        let first_path = folder.path_of(*first);
        let document = Shard::read(&first_path)?;
        check_part(&first_path, &document.body)?;
        let mut results = BTreeMap::new();
        for part in others {
            let path = folder.path_of(*part);
            let other = Shard::read(&path)?;
            check_part(&path, &other.body)?;
            let differences = differences(&other, &document);
            if !differences.is_empty() {
                return Err(ShardError::Other {
                    path: printable_path(&path),
                    first: printable_path(&first_path),
                    differences: differences.join("; "),
                });
            }
            results.insert(part.number(), other.body.results);
        }
        results.insert(first.number(), document.body.results);
        Ok(Collected {
            path: folder.path,
            scene: document.scene,
            of: first.of(),
            job: document.body.job,
            results,
        })
    }
}

impl Collected {
    /// Numbers of the shards that are not there.
    pub fn missing(&self) -> Vec<u64> {
        let all = 1..=self.of;
        all.filter(|number| !self.results.contains_key(number)).collect()
    }

    /// What all shards have, in their order, each with its part.
    ///
    /// # Errors
    /// When some are missing.
    pub fn whole(self) -> Result<PartResults, ShardError> {
        let missing = self.missing();
        if !missing.is_empty() {
            return Err(ShardError::Missing {
                path: printable_path(&self.path),
                found: self.results.len(),
                of: self.of,
                missing: listed(&missing),
                example: missing[0],
            });
        }
        let of = self.of;
        let with_part =
            |(number, results)| JobPart::new(number, of).ok().map(|part| (part, results));
        Ok(self.results.into_iter().filter_map(with_part).collect())
    }
}

/// Numbers as Slurm takes those of tasks: `3,7-9`. They are in order.
pub fn listed(numbers: &[u64]) -> String {
    let stretches = numbers.chunk_by(|a, b| a + 1 == *b);
    let stretch = |stretch: &[u64]| match *stretch {
        [first, .., last] => format!("{first}-{last}"),
        [only] => only.to_string(),
        [] => String::new(),
    };
    stretches.map(stretch).collect::<Vec<_>>().join(",")
}

/// Differences between the files of two shards, but for their numbers and results.
fn differences(this: &Document<Shard>, that: &Document<Shard>) -> Vec<String> {
    let mut differences = this.body.job.differences(&that.body.job);
    differences.extend(other_version(&this.goldtof, &that.goldtof));
    if this.body.shards != that.body.shards {
        let (here, there) = (this.body.shards, that.body.shards);
        differences.push(format!("the job is cut into {here} shards, there into {there}"));
    }
    differences
}

/// The shard in a file, if it is not the one of the file's name.
fn other_part(path: &Path, shard: &Shard) -> Option<String> {
    let part = shard.part().ok()?;
    let is_named = path.file_stem().is_some_and(|stem| *stem == *part.name());
    (!is_named).then(|| format!("it holds shard {part}"))
}

/// A file holds the shard that its name says: else one shard would be there twice.
fn check_part(path: &Path, shard: &Shard) -> Result<(), ShardError> {
    other_part(path, shard).map_or(Ok(()), |other| {
        Err(ShardError::Unreadable {
            path: printable_path(path),
            reason: format!("{other}, and not the one of its name"),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::listed;

    #[test]
    fn numbers_are_listed_as_an_array_of_tasks_takes_them() {
        assert_eq!(listed(&[3, 7, 8, 9, 11]), "3,7-9,11");
        assert_eq!(listed(&[1]), "1");
        assert_eq!(listed(&[]), "");
    }
}
