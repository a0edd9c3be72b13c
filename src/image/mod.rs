//! What an array of pixels sees: an image of the scene's room, every pixel a sensor like the
//! scene's.
//!
//! A pixel's light comes from the photon budget ([`crate::scene::Array`]). Its errors come from
//! the exact theory, tabulated over light and delay ([`table`]), or from scans of its own
//! ([`scans`]).
//!
//! ```no_run
//! use goldtof::image::{ImageOptions, image};
//! use goldtof::Sensor;
//!
//! let settings = ["array.rows=6".parse()?, "array.columns=8".parse()?];
//! let sensor = Sensor::load_with("scenes/image.toml", &settings)?;
//! let image = image(&sensor, &ImageOptions::default(), None, |_| ())?;
//! let theory = image.theory.as_ref().unwrap();
//! assert!(theory.interpolation.worst_error_in_std < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod draw;
pub mod map;
mod options;
mod pixels;
mod scans;
mod summary;
mod table;

pub use check::{Check, PixelReport};
pub use map::Map;
pub use options::{ImageOptions, PixelPlace};
pub use pixels::{MapTarget, Seen};
pub use scans::{PixelRow, PixelScans, ScanMaps};
pub use summary::{ImageReport, MapScale, MapSummary, NamedMap};
pub use table::{ExpectedPixel, TableInterpolation, TheoryMaps};

use crate::progress::Progress;
use crate::scene::{DetectorIndex, Lens, TotalsMissing};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::scans::ScansError;

/// The one detector of a scene with an array.
const PIXEL: DetectorIndex = DetectorIndex(0);

/// An image, and what it was made from.
#[derive(Debug, Clone)]
pub struct Image {
    /// Pixels and lens.
    pub lens: Lens,
    /// How it was made.
    pub options: ImageOptions,
    /// What is there: each pixel's light and true distance.
    pub seen: Seen,
    /// What theory expects of each pixel; none where a pixel has more than one path.
    pub theory: Option<TheoryMaps>,
    /// What one frame of the array shows, and what further ones say of its errors.
    pub measured: ScanMaps,
    /// Pixels that were simulated photon by photon, held against theory.
    pub check: Option<Check>,
    /// Pixels that were asked for.
    pub pixels: Vec<PixelReport>,
    /// What there is to say.
    pub remarks: Vec<String>,
}

/// Why there is no image.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The scene has no array.
    #[error(
        "the scene has no table [array], so that there is one detector and no image; docs/pixels.md has one"
    )]
    NoArray,
    /// No pixel gets light of its own laser.
    #[error(
        "no pixel gets light of the detector's source: there is no [[array.plane]] or [[array.sphere]] in view that it lights, or it has no mean_power"
    )]
    Dark,
    /// Theory is not tabulated over so much.
    #[error(
        "theory is tabulated over the light and the delay of one path, and {pixels} pixels have more of them, of panes or of other lasers; --fidelity events simulates every pixel photon by photon"
    )]
    SeveralPaths {
        /// Pixels with several paths.
        pixels: usize,
    },
    /// Theory has nothing to say.
    #[error("{reason}; --fidelity events simulates every pixel photon by photon")]
    Unexpected {
        /// Of how many pixels, and why.
        reason: String,
    },
    /// The tier goes through the Verilog.
    #[error(
        "all pixels have the same Verilog, and none is simulated through it; --fidelity sampled goes through its bit-exact model, and `goldtof simulate --fidelity rtl --set array.row=R --set array.column=C` through the Verilog of one pixel"
    )]
    Rtl,
    /// Another pixel was asked for than there is.
    #[error(
        "--pixel {row},{column}: the array has rows 0 to {last_row} and columns 0 to {last_column}"
    )]
    NoPixel {
        /// Its row.
        row: u32,
        /// Its column.
        column: u32,
        /// The last row.
        last_row: u32,
        /// The last column.
        last_column: u32,
    },
    /// Pixels cannot be simulated.
    #[error(transparent)]
    Scans(#[from] ScansError),
    /// The estimator needs counts that the hardware does not send.
    #[error(transparent)]
    Totals(#[from] TotalsMissing),
}

/// Makes an image; `target` in place of the scene's surfaces, if it is given. Progress is in
/// pixels.
///
/// # Errors
/// When the scene has no array, nothing is lit, or the tier cannot do its pixels.
pub fn image(
    sensor: &Sensor,
    options: &ImageOptions,
    target: Option<&MapTarget>,
    on_progress: impl FnMut(Progress),
) -> Result<Image, ImageError> {
    let view = ArrayView::new(sensor, options, target)?;
    let rows: Vec<u32> = (0..view.lens.rows).collect();
    let scans = match options.fidelity {
        Tier::Expected => Vec::new(),
        _ => view.scans(&rows, on_progress)?,
    };
    view.image(scans)
}

/// What an array sees, before anything is measured. Rows of pixels are simulated together or
/// apart, and make one image in the end.
#[derive(Debug)]
pub struct ArrayView {
    sensor: Sensor,
    options: ImageOptions,
    lens: Lens,
    seen: Seen,
}

impl ArrayView {
    /// What the array of a sensor sees.
    ///
    /// # Errors
    /// When the scene has no array, or options or light do not suit each other.
    pub fn new(
        sensor: &Sensor,
        options: &ImageOptions,
        target: Option<&MapTarget>,
    ) -> Result<ArrayView, ImageError> {
        let sensor = sensor.with_estimator(options.estimator)?.summed();
        let array = sensor.scene().array.clone().ok_or(ImageError::NoArray)?;
        options.check(&array.lens)?;
        let seen = Seen::of(&sensor, &array, target);
        if seen.lit().next().is_none() {
            return Err(ImageError::Dark);
        }
        match seen.with_several_paths() {
            pixels if pixels > 0 && options.fidelity == Tier::Expected => {
                Err(ImageError::SeveralPaths { pixels })
            }
            _ => Ok(ArrayView { sensor, options: options.clone(), lens: array.lens, seen }),
        }
    }

    /// Pixels and lens.
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// Simulates some rows of pixels.
    ///
    /// # Errors
    /// When the tier cannot do them.
    pub fn scans(
        &self,
        rows: &[u32],
        mut on_progress: impl FnMut(Progress),
    ) -> Result<Vec<PixelRow>, ScansError> {
        scans::rows(&self.sensor, &self.seen, &self.options, rows, &mut on_progress)
    }

    /// The image of all rows, in order; of none where pixels' errors come from theory.
    ///
    /// # Errors
    /// When pixels that are looked at closely cannot be simulated.
    pub fn image(self, rows: Vec<PixelRow>) -> Result<Image, ImageError> {
        let ArrayView { sensor, options, lens, seen } = self;
        let mut remarks = Vec::new();
        let theory = match seen.with_several_paths() {
            0 => {
                let counting = options.fidelity.counting(&sensor);
                Some(TheoryMaps::of(&sensor, &seen, counting, options.seed))
            }
            pixels => {
                remarks.push(format!("no theory beside it: {pixels} pixels have several paths"));
                None
            }
        };
        if let (Tier::Expected, Some(theory)) = (options.fidelity, &theory)
            && theory.pixels.iter().all(Option::is_none)
        {
            return Err(ImageError::Unexpected { reason: theory.remarks.join("; ") });
        }
        let measured = match (options.fidelity, &theory) {
            (Tier::Expected, Some(theory)) => draw::frame(&sensor, &seen, theory, options.seed),
            _ => scans::maps(&sensor, &seen, rows, options.repetitions),
        };
        remarks.extend(theory.iter().flat_map(|theory| theory.remarks.clone()));
        Ok(Image {
            check: check::check(&sensor, &seen, theory.as_ref(), &measured, &options)?,
            pixels: check::pixels(&sensor, &seen, theory.as_ref(), &options)?,
            lens,
            options,
            seen,
            theory,
            measured,
            remarks,
        })
    }
}
