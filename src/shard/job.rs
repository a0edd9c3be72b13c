//! A job: everything that its numbers depend on.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::ShardError;
use crate::differences::differences;
use crate::grade::{GradeOptions, Graded};
use crate::scene::{self, Scene, SceneErrors, SceneReference, Setting};
use crate::simulate::SimulateOptions;
use crate::simulate::repeat::Gathered;
use crate::study::reproduce::{MadeFigure, ReproduceOptions};
use crate::study::stress::CaseReport;
use crate::study::sweep::{Sweep, SweepOptions};

/// A job in shards. Two shards belong together if their jobs are equal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Job {
    /// Of `goldtof simulate`.
    Simulate(
        /// The scans.
        SimulateJob,
    ),
    /// Of `goldtof sweep`.
    Sweep(
        /// The points.
        SweepJob,
    ),
    /// Of `goldtof reproduce`.
    Reproduce(
        /// The figures.
        ReproduceOptions,
    ),
    /// Of `goldtof stress`.
    Stress(
        /// The cases.
        StressJob,
    ),
    /// Of `goldtof grade`.
    Grade(
        /// The faults and mutants.
        GradeJob,
    ),
}

/// Results of a shard.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Results {
    /// Of `goldtof simulate`.
    Simulate(
        /// Statistics of its scans.
        Gathered,
    ),
    /// Of `goldtof sweep`.
    Sweep(
        /// Its points.
        Vec<PointRows>,
    ),
    /// Of `goldtof reproduce`.
    Reproduce(
        /// Its figures.
        Vec<MadeFigure>,
    ),
    /// Of `goldtof stress`.
    Stress(
        /// Its cases.
        Vec<CaseReport>,
    ),
    /// Of `goldtof grade`.
    Grade(
        /// Its faults and mutants.
        Graded,
    ),
}

/// A scene as it was read, so that what is made of shards needs no other file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SceneText {
    /// Name of the file, without its folder.
    pub file: String,
    /// Its text.
    pub text: String,
    /// Overridden keys: `path.distance=5 m`.
    pub settings: Vec<String>,
}

/// Scans of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SimulateJob {
    /// The scene.
    pub scene: SceneText,
    /// Its scans, those of all shards.
    #[serde(flatten)]
    pub options: SimulateOptions,
    /// Whether the exit status says if scans are as expected.
    pub check: bool,
}

/// Points of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SweepJob {
    /// The scene.
    pub scene: SceneText,
    /// Its points, those of all shards.
    #[serde(flatten)]
    pub options: SweepOptions,
    /// Whether the exit status says if scans are as expected.
    pub check: bool,
}

/// Stress cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct StressJob {
    /// Names of all cases.
    pub cases: Vec<String>,
    /// Seed of each case.
    pub seed: u64,
}

/// Faults and mutants of a design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct GradeJob {
    /// The scene.
    pub scene: SceneText,
    /// SHA-256 of the design's files, in hexadecimal digits.
    pub verilog_sha256: String,
    /// What is graded.
    #[serde(flatten)]
    pub options: GradeOptions,
}

/// A point of a sweep that is done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PointRows {
    /// Its number, from 0.
    pub point: u64,
    /// Its rows of the table as CSV, with their heading.
    pub rows_csv: String,
}

impl SceneText {
    /// The scene of the file `path`, whose text it is.
    pub fn new(path: &str, text: String, settings: &[Setting]) -> SceneText {
        let SceneReference { file, settings, .. } = SceneReference::of_text(path, &text, settings);
        SceneText { file, text, settings }
    }

    /// The settings.
    ///
    /// # Errors
    /// When one is none.
    pub fn settings(&self) -> Result<Vec<Setting>, String> {
        self.settings.iter().map(|text| text.parse()).collect()
    }

    /// The scene.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn scene(&self) -> Result<Scene, SceneErrors> {
        // What is not a setting was none when it was written.
        let settings = self.settings().unwrap_or_default();
        scene::parse_with(&self.file, &self.text, &settings)
    }

    /// What documents name it by.
    pub fn reference(&self) -> SceneReference {
        SceneReference::of_text(&self.file, &self.text, &self.settings().unwrap_or_default())
    }
}

impl SweepJob {
    /// The sweep that it is.
    ///
    /// # Errors
    /// When a setting is none.
    pub fn sweep(&self) -> Result<Sweep, ShardError> {
        Ok(Sweep {
            file: self.scene.file.clone(),
            text: self.scene.text.clone(),
            settings: self.scene.settings().map_err(|reason| ShardError::NoJob { reason })?,
            options: self.options.clone(),
        })
    }
}

impl Job {
    /// The scene that it is of, if it is of one.
    pub fn scene(&self) -> Option<&SceneText> {
        match self {
            Job::Simulate(job) => Some(&job.scene),
            Job::Sweep(job) => Some(&job.scene),
            Job::Grade(job) => Some(&job.scene),
            Job::Reproduce(_) | Job::Stress(_) => None,
        }
    }

    /// Differences of another job, in words.
    pub fn differences(&self, other: &Job) -> Vec<String> {
        let [(here, job), (there, other)] = [self, other].map(Job::parts);
        match here == there {
            true => differences(&job, &other),
            false => vec![format!("the command is {here}, there {there}")],
        }
    }

    /// The command that it is of, and what that is to do.
    fn parts(&self) -> (String, Value) {
        match serde_json::to_value(self) {
            // An object of one field.
            Ok(Value::Object(job)) => job.into_iter().next().unwrap_or_default(),
            _ => Default::default(),
        }
    }
}
