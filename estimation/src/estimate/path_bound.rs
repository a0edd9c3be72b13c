//! How precise an estimate can be, of each path.

use crate::scene::PathIndex;

/// What the counts of one scan can tell of distances.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// One entry per path that carries modulated light, in the scene's order.
    pub paths: Vec<PathBound>,
    /// Phase steps that take part: the whole scan, of a path that moves 3 S round its peak.
    pub steps: usize,
}

/// What the counts can tell of one path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathBound {
    /// Index of the path in the scene.
    pub path: PathIndex,
    /// Least standard deviation of its distance, with delay and strength of
    /// every path and the background unknown.
    pub bound_m: f64,
    /// Least standard deviation of its speed, of a path that moves: then that is unknown,
    /// too, and the distance that at the moment at which the scan comes by.
    pub velocity_bound_m_per_s: Option<f64>,
}

impl Bound {
    /// Standard deviation to expect of a fit that says `std_m` of the distance of path `path`:
    /// it weighs with derivatives and second moments of light near its own, and may be 1 %
    /// off, but none is better than the bound.
    pub fn at_least(&self, path: PathIndex, std_m: f64) -> f64 {
        self.of_path(path).map_or(std_m, |bound_m| bound_m.max(std_m))
    }

    /// What has to be known of it where it is not of all steps.
    pub fn remark(&self) -> Option<String> {
        let moves = |path: &PathBound| path.velocity_bound_m_per_s.is_some();
        self.paths.iter().any(moves).then(|| {
            format!(
                "the bound is of the {} phase steps round the peak, as the fit of a path that moves",
                self.steps
            )
        })
    }

    /// The bound of path `path` of the sensor, if it carries modulated light.
    pub fn of_path(&self, path: PathIndex) -> Option<f64> {
        let entry = self.paths.iter().find(|entry| entry.path == path)?;
        Some(entry.bound_m)
    }
}
