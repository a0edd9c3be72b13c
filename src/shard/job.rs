//! A job: everything that its numbers depend on.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::part::JobPart;
use crate::differences::differences;
use crate::grade::{GradeOptions, Graded};
use crate::image::{ImageOptions, PixelRow};
use crate::scene::SceneText;
use crate::simulate::SimulateOptions;
use crate::simulate::repeat::Gathered;
use crate::study::reproduce::{MadeFigure, ReproduceOptions};
use crate::study::stress::{CaseReport, StressOptions};
use crate::study::sweep::Sweep;

/// Declares the jobs: their command, what is done, and what a shard of it gives.
macro_rules! jobs {
    ($($of:literal $name:ident: $what:literal, $job:ty; $found:literal, $results:ty;)*) => {
        /// A job in shards. Two shards belong together if their jobs are equal.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum Job { $(#[doc = $of] $name(#[doc = $what] $job),)* }

        /// Results of a shard.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum Results { $(#[doc = $of] $name(#[doc = $found] $results),)* }
    };
}

jobs! {
    "Of `goldtof simulate`."
    Simulate: "The scans.", SimulateJob; "Statistics of its scans.", Gathered;
    "Of `goldtof sweep`."
    Sweep: "The points.", SweepJob; "Its points.", Vec<PointRows>;
    "Of `goldtof reproduce`."
    Reproduce: "The figures.", ReproduceOptions; "Its figures.", Vec<MadeFigure>;
    "Of `goldtof stress`."
    Stress: "The cases.", StressOptions; "Its cases.", Vec<CaseReport>;
    "Of `goldtof grade`."
    Grade: "The faults and mutants.", GradeJob; "Its faults and mutants.", Graded;
    "Of `goldtof image`."
    Image: "The rows of pixels.", ImageJob; "Its rows of pixels.", Vec<PixelRow>;
}

/// Results of some shards, each with its part of the job.
pub type PartResults = Vec<(JobPart, Results)>;

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
    /// The sweep, with the points of all shards.
    #[serde(flatten)]
    pub sweep: Sweep,
    /// Whether the exit status says if scans are as expected.
    pub check: bool,
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

/// Rows of an array's pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ImageJob {
    /// The scene.
    pub scene: SceneText,
    /// How its pixels are simulated.
    #[serde(flatten)]
    pub options: ImageOptions,
}

/// A point of a sweep that is done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PointRows {
    /// Its number, from 0.
    pub point: u64,
    /// Its rows of the table as CSV, with their heading.
    pub rows_csv: String,
}

impl Job {
    /// The scene that it is of, if it is of one.
    pub fn scene(&self) -> Option<&SceneText> {
        match self {
            Job::Simulate(job) => Some(&job.scene),
            Job::Sweep(job) => Some(&job.sweep.scene),
            Job::Grade(job) => Some(&job.scene),
            Job::Image(job) => Some(&job.scene),
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
