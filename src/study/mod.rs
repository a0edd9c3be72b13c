//! Studies: which architecture to build, what limits a sensor, the fidelity of the tiers, the article's
//! figures and claims, stiff and extreme cases, sweeps over a scene's keys.
//!
//! ```
//! use goldtof::study::sweep::Axis;
//!
//! let axis: Axis = "path.distance=1 m..10 m +10".parse()?;
//! assert_eq!(axis.values.len(), 10);
//! assert_eq!(axis.column(), "path.distance (m)");
//! # Ok::<(), String>(())
//! ```

pub mod architectures;
mod article;
pub mod fidelity;
pub mod limits;
pub mod reproduce;
pub mod stress;
pub mod sweep;
