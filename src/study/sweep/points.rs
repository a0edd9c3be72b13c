//! The points of a sweep.

use serde::{Deserialize, Serialize};

use super::axis::{AxisValue, SweepAxis};
use crate::document::Document;
use crate::scene::{EstimatorKind, SceneErrors, SceneText, Setting, TotalsMissing};
use crate::sensor::Sensor;
use crate::simulate::{SimulateOptions, Tier};

/// Most points of a sweep.
const MOST_POINTS: usize = 1_000_000;

/// What is simulated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Sweep {
    /// The scene.
    pub scene: SceneText,
    /// What differs from point to point, and how each is simulated.
    #[serde(flatten)]
    pub options: SweepOptions,
}

/// What a sweep's numbers depend on beside the scene: the command line's options, the library's,
/// and those of a shard and of the folder.
// `source[0]` of the help text is not a link.
#[allow(rustdoc::broken_intra_doc_links)]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema, clap::Args)]
pub struct SweepOptions {
    /// A key and its values: a list, as --over 'path.distance=1 m, 2 m, 5 m'; values spaced evenly
    /// by ratio, 'source[0].mean_power=1 pW..64 pW x7'; or by difference,
    /// 'path.distance=1 m..10 m +10'. May be repeated, for every combination
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub over: Vec<SweepAxis>,
    /// Scans of each point, 1 to 1000000, for example --repeat 1000
    #[arg(long = "repeat", value_name = "R", default_value_t = SweepOptions::default().repetitions,
          value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub repetitions: u64,
    /// Tier of simulation
    #[arg(long, value_name = "T", value_enum, default_value_t = SweepOptions::default().fidelity)]
    pub fidelity: Tier,
    /// Estimator [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Seed of every point
    #[arg(skip)]
    pub seed: u64,
}

impl Default for SweepOptions {
    fn default() -> SweepOptions {
        let SimulateOptions { repetitions, fidelity, estimator, seed, .. } = Default::default();
        SweepOptions { over: Vec::new(), repetitions, fidelity, estimator, seed }
    }
}

/// One of them.
#[derive(Debug, Clone)]
pub struct SweepPoint<'s> {
    /// Its number, from 0.
    pub number: usize,
    /// The value of each axis.
    pub values: Vec<(&'s SweepAxis, &'s AxisValue)>,
    /// The scene with these values.
    pub sensor: Sensor,
}

/// Why a sweep cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The scene of a point is invalid.
    #[error("{0}")]
    Scene(#[from] SceneErrors),
    /// The estimator needs what the hardware is told not to send.
    #[error(transparent)]
    Totals(#[from] TotalsMissing),
    /// A value is not a setting.
    #[error("--over {0}")]
    Setting(String),
    /// Two axes set one key.
    #[error("--over {0}: the key is swept twice; give it once")]
    Twice(String),
    /// More points than anybody waits for.
    #[error("{points} points are more than {MOST_POINTS}; take fewer values")]
    TooMany {
        /// Points asked for.
        points: u128,
    },
}

impl Sweep {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.options.over.iter().map(|axis| axis.values.len()).product()
    }

    /// A sweep has at least one point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What its numbers depend on, with version and scene in the head. `command` is that of the run
    /// that begins the sweep.
    pub fn definition(&self, command: &str) -> Document<SweepOptions> {
        let document = Document::new(self.options.clone(), command, None);
        Document { scene: Some(self.scene.reference()), ..document }
    }

    /// Whether the points can be numbered: there are not too many, and no key is swept
    /// twice.
    ///
    /// # Errors
    /// When it is not so.
    pub fn check_axes(&self) -> Result<(), SweepError> {
        let points = self.options.over.iter().map(|axis| axis.values.len() as u128);
        let points: u128 = points.product();
        if points > MOST_POINTS as u128 {
            return Err(SweepError::TooMany { points });
        }
        for (i, axis) in self.options.over.iter().enumerate() {
            if self.options.over[..i].iter().any(|other| other.key == axis.key) {
                return Err(SweepError::Twice(axis.text.clone()));
            }
        }
        Ok(())
    }

    /// A point.
    ///
    /// # Errors
    /// What is wrong with its scene.
    pub fn point(&self, number: usize) -> Result<SweepPoint<'_>, SweepError> {
        let mut rest = number;
        let mut values: Vec<(&SweepAxis, &AxisValue)> = Vec::new();
        for axis in self.options.over.iter().rev() {
            values.push((axis, &axis.values[rest % axis.values.len()]));
            rest /= axis.values.len();
        }
        values.reverse();
        let mut scene = self.scene.clone();
        for (axis, value) in &values {
            let setting = Setting::of(&axis.key, &value.text, "--over");
            scene.settings.push(setting.map_err(SweepError::Setting)?);
        }
        Ok(SweepPoint {
            number,
            values,
            sensor: Sensor::new(&scene.scene()?.with_estimator(self.options.estimator)?.summed()),
        })
    }
}
