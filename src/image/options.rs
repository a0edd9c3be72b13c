//! What image is asked for.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::ImageError;
use crate::scene::{EstimatorKind, Lens};
use crate::simulate::Tier;

/// How an image is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema, clap::Args)]
pub struct ImageOptions {
    /// Where every pixel's errors come from: `expected` draws them from the exact theory, any
    /// other tier simulates scans of every pixel
    #[arg(long, value_name = "T", value_enum, default_value_t = ImageOptions::default().fidelity)]
    pub fidelity: Tier,
    /// Frames: scans of each pixel, 1 to 10000, for example --repeat 20; maps of bias and scatter
    /// need several, except from theory
    #[arg(long = "repeat", value_name = "R", default_value_t = ImageOptions::default().repetitions,
        value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repetitions: u32,
    /// Estimator [default: the scene's]
    #[arg(long, value_name = "E", value_enum)]
    pub estimator: Option<EstimatorKind>,
    /// Simulate this many pixels photon by photon, and hold them against theory, for example
    /// --check 1000
    #[arg(long, value_name = "N", default_value_t = 0,
        value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    pub check: u32,
    /// A pixel to report in detail, by row and column, simulated photon by photon; may be repeated:
    /// --pixel 96,128
    #[arg(long = "pixel", value_name = "R,C")]
    pub pixels: Vec<PixelPlace>,
    /// Seed of all random numbers
    #[arg(skip)]
    pub seed: u64,
}

impl Default for ImageOptions {
    fn default() -> ImageOptions {
        ImageOptions {
            fidelity: Tier::Expected,
            repetitions: 1,
            estimator: None,
            check: 0,
            pixels: Vec::new(),
            seed: 1,
        }
    }
}

impl ImageOptions {
    /// Whether they suit the array.
    pub(super) fn check(&self, lens: &Lens) -> Result<(), ImageError> {
        if self.fidelity == Tier::Rtl {
            return Err(ImageError::Rtl);
        }
        let is_none = |place: &&PixelPlace| place.row >= lens.rows || place.column >= lens.columns;
        match self.pixels.iter().find(is_none) {
            None => Ok(()),
            Some(&PixelPlace { row, column }) => Err(ImageError::NoPixel {
                row,
                column,
                last_row: lens.rows - 1,
                last_column: lens.columns - 1,
            }),
        }
    }

    /// The tier that simulates the pixels that are looked at.
    pub(super) fn photons(&self) -> Tier {
        match self.fidelity {
            Tier::Expected => Tier::Sampled,
            tier => tier,
        }
    }
}

/// Row and column of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PixelPlace {
    /// From the top.
    pub row: u32,
    /// From the left.
    pub column: u32,
}

impl FromStr for PixelPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<PixelPlace, String> {
        let numbers = text.split_once(',').map(|(row, column)| (row.trim(), column.trim()));
        let numbers =
            numbers.and_then(|(row, column)| Some((row.parse().ok()?, column.parse().ok()?)));
        let (row, column) = numbers.ok_or_else(|| {
            format!("\"{text}\" is not a row, a comma and a column; write for example 96,128")
        })?;
        Ok(PixelPlace { row, column })
    }
}
