//! Table `[estimate]`.

use super::declare::*;

tables! {
    ESTIMATE = "estimate" {
        estimator = choice(EstimatorKind::CHOICES), Or("\"fft\""), "\"fft\"";
            "how counts become distances";
        other_light = choice(OtherLight::CHOICES), Or("\"given\""), "\"given\"";
            "which light besides the strongest path the model estimator looks for";
    }
}

choices! {
    /// Turns counts into distance.
    #[derive(
        Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize,
        schemars::JsonSchema, clap::ValueEnum,
    )]
    #[serde(rename_all = "lowercase")]
    pub enum EstimatorKind {
        /// Coarse argmax, then the phase of the fundamental
        #[default]
        Fft = "fft",
        /// Weighted least squares against the exact mean response
        Model = "model",
    }
}

impl EstimatorKind {
    /// The one that this is not.
    pub fn other(self) -> EstimatorKind {
        match self {
            EstimatorKind::Fft => EstimatorKind::Model,
            EstimatorKind::Model => EstimatorKind::Fft,
        }
    }
}

impl std::fmt::Display for EstimatorKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = EstimatorKind::NAMES.iter().find_map(|(name, k)| (k == self).then_some(*name));
        f.write_str(name.unwrap_or_default())
    }
}

choices! {
    /// Which light besides the strongest path of its own source a detector's fit
    /// looks for.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum OtherLight {
        /// Of each code at most as many paths as the scene has for this detector; which
        /// there are, where, and how strong, is found in the scan.
        Given = "given",
        /// Up to eight sensors with codes that are not known, of the reference's Gold set
        /// and of those of the scene's other sources; and up to four own paths.
        Search = "search",
        /// None: everything else counts as constant.
        None = "none",
    }
}

pub(super) fn read(root: &Section) -> Option<(EstimatorKind, OtherLight)> {
    let section = root.section_or_defaults("estimate");
    let estimator = EstimatorKind::read(&section, "estimator");
    let other_light = OtherLight::read(&section, "other_light");
    section.finish();
    estimator.zip(other_light)
}

/// The model estimator was asked for, of hardware that sends no total counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the estimator \"model\" needs the total counts, which total_counts = false leaves out of \
     the hardware; remove that key, or estimate with \"fft\""
)]
pub struct TotalsMissing;
