//! The points of a sweep.

use super::axis::{Axis, Value};
use super::options::SweepOptions;
use crate::scene::{self, SceneErrors, SceneReference, Setting, TotalsMissing};
use crate::sensor::Sensor;

/// Most points of a sweep.
const MOST_POINTS: usize = 1_000_000;

/// What is simulated.
#[derive(Debug, Clone)]
pub struct Sweep {
    /// Name of the scene's file, for messages; its stem names the scene.
    pub file: String,
    /// The scene as it was read. It is read once: whoever changes the file meanwhile
    /// changes nothing here.
    pub text: String,
    /// Settings of all points.
    pub settings: Vec<Setting>,
    /// What differs from point to point, the last fastest, and how each is simulated.
    pub options: SweepOptions,
}

/// One of them.
#[derive(Debug, Clone)]
pub struct Point<'s> {
    /// Its number, from 0.
    pub number: usize,
    /// The value of each axis.
    pub values: Vec<(&'s Axis, &'s Value)>,
    /// The scene with these values.
    pub sensor: Sensor,
}

/// Why a sweep cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A point is no scene.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// The estimator needs what the hardware is told not to send.
    #[error(transparent)]
    Totals(#[from] TotalsMissing),
    /// A value is no setting.
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

    /// What documents name the scene by.
    pub fn scene(&self) -> SceneReference {
        SceneReference::of_text(&self.file, &self.text, &self.settings)
    }

    /// Whether the points can be numbered: there are not too many, and no key is swept
    /// twice.
    ///
    /// # Errors
    /// When it is not so.
    pub fn check_axes(&self) -> Result<(), SweepError> {
        let axes = &self.options.over;
        let points = axes.iter().map(|axis| axis.values.len() as u128);
        let points: u128 = points.product();
        if points > MOST_POINTS as u128 {
            return Err(SweepError::TooMany { points });
        }
        for (i, axis) in axes.iter().enumerate() {
            if axes[..i].iter().any(|other| other.key == axis.key) {
                return Err(SweepError::Twice(axis.text.clone()));
            }
        }
        Ok(())
    }

    /// A point.
    ///
    /// # Errors
    /// What is wrong with its scene.
    pub fn point(&self, number: usize) -> Result<Point<'_>, SweepError> {
        let mut rest = number;
        let mut values: Vec<(&Axis, &Value)> = Vec::new();
        for axis in self.options.over.iter().rev() {
            values.push((axis, &axis.values[rest % axis.values.len()]));
            rest /= axis.values.len();
        }
        values.reverse();
        let mut settings = self.settings.clone();
        for (axis, value) in &values {
            let setting = Setting::of(&axis.key, &value.text, "--over");
            settings.push(setting.map_err(SweepError::Setting)?);
        }
        let scene = scene::parse_with(&self.file, &self.text, &settings)?;
        Ok(Point {
            number,
            values,
            sensor: Sensor::new(&scene.with_estimator(self.options.estimator)?),
        })
    }
}
