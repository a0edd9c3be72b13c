//! Counts of a real sensor: read from a file, compared with the expectation of its scene, and
//! diagnosed where they differ.
//!
//! `docs/recorded-counts.md` has the file's format and the tests with their measured
//! power.
//!
//! ```no_run
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! #     pub use goldtof_estimation::*;
//! # }
//! use std::path::Path;
//!
//! use goldtof::recorded::{RecordedCounts, assess, read_recorded};
//! use goldtof::sensor::Sensor;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let sensor = Sensor::new(&scene);
//! let RecordedCounts::Scans(scans) = read_recorded(Path::new("counts.csv"), &sensor)? else {
//!     return Ok(());
//! };
//! for scan in scans {
//!     let assessment = assess(&sensor, &scan);
//!     if let Some(diagnosis) = &assessment.diagnosis {
//!         println!("{}: {}", assessment.detector, diagnosis.sentence);
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod code_density;
mod codes;
mod csv_file;
mod diagnosis;
mod expected;
mod hypothesis;
mod observed;
mod report;

pub use csv_file::{CountsError, CountsFile, CsvColumn, Dialect};
pub use diagnosis::{Diagnosis, TestOutcome};
pub use expected::{expected_bins, expected_csv};
pub use observed::HITS_OF_A_SUM;
pub use report::{
    AsItIs, Assessment, BinResidual, StepResidual, against_scene, assess, assess_histogram,
    fit_distance_alone, histogram_against_scene,
};

use std::path::Path;

use serde::Serialize;

use crate::estimate::{ImpossibleScan, possible_scan};
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;

/// What may be wrong with a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// None of the own source's light arrives: the beam is blocked, the laser off, or the target out of
    /// reach.
    NoLight,
    /// The detector does not count at all, not even what it would in darkness.
    NoHits,
    /// The sources' power, the transmission, or the detection probability.
    LightLevel,
    /// Dark counts, background, or other light that is not modulated.
    ConstantLight,
    /// The dead time.
    DeadTime,
    /// Whether light within the dead time prolongs it.
    Recharge,
    /// The probability of an afterpulse.
    Afterpulsing,
    /// A constant delay: the detector's, a cable's, or another distance.
    Offset,
    /// The light, the reference or both carry another code.
    Code,
    /// The light is inverted, or counts up and down are swapped.
    Polarity,
    /// The clock's period.
    ChipPeriod,
    /// The integration time, or several scans that are added up.
    Integration,
    /// The residuals are larger than any of these explains.
    Unexplained,
    /// Counts scatter less than photons can.
    TooEven,
}

/// One scan of one detector, as a file has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedScan {
    /// Index of the detector in the scene.
    pub detector: DetectorIndex,
    /// Counts of the scan's steps, in order; totals are 0 where there are none.
    pub counts: Vec<StepCount>,
    /// Whether the file has total counts.
    pub has_totals: bool,
}

impl RecordedScan {
    /// The scan whose counts are `signed`, one of each phase step in their order; `totals` are
    /// the total ones, where the hardware sends them.
    ///
    /// # Errors
    /// If the scene's hardware cannot have counted them.
    pub fn new(
        scene: &Scene,
        detector: DetectorIndex,
        signed: &[i64],
        totals: Option<&[u64]>,
    ) -> Result<RecordedScan, ImpossibleScan> {
        if let Some(totals) = totals.filter(|totals| totals.len() != signed.len()) {
            let (found, steps) = (totals.len(), scene.scan.steps);
            return Err(ImpossibleScan::WrongNumber { found, steps });
        }
        let total = |step: usize| totals.map(|totals| totals[step]);
        let counts: Vec<_> =
            signed.iter().enumerate().map(|(step, &signed)| (signed, total(step))).collect();
        let counts = possible_scan(scene, &counts)?;
        Ok(RecordedScan { detector, counts, has_totals: totals.is_some() })
    }
}

/// What a file has of every detector that it names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordedCounts {
    /// Counts of the phase steps of a scan.
    Scans(Vec<RecordedScan>),
    /// Bins, of a sensor that keeps a histogram.
    Histograms(Vec<RecordedHistogram>),
}

/// Reads what was recorded with a scene: the counts of one scan, or the bins of one
/// histogram, as the heading says.
///
/// # Errors
/// If the file cannot be read, is not of the format, or is of another scene.
pub fn read_recorded(path: &Path, sensor: &Sensor) -> Result<RecordedCounts, CountsError> {
    CountsFile::read(path)?.recorded(sensor)
}

/// One histogram of one detector, as a file has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedHistogram {
    /// Index of the detector in the scene.
    pub detector: DetectorIndex,
    /// Its bins.
    pub histogram: Histogram,
}
