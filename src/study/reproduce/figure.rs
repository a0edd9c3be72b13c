//! What a figure and a claim are.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::statistics::Measured;
use super::verdict::ClaimVerdict;
use crate::exact;
use crate::report::chart::{Chart, Panel};
use crate::report::table::Table;

/// Declares the figures: what each shows, its name, what the command line calls it, the
/// article's number of it, and the stem of its files' names.
macro_rules! figures {
    ($($what:literal, $id:ident, $called:literal, $number:expr, $name:literal;)*) => {
        /// The figures that can be made: the article's, those of the errors that it leaves
        /// out, and those of light that the joint fit tells apart.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
        #[serde(into = "&'static str", try_from = "String")]
        pub enum FigureId {
            $(#[doc = $what] #[value(name = $called)] $id,)*
        }

        impl FigureId {
            /// All, in order.
            pub const ALL: [FigureId; [$($name),*].len()] = [$(FigureId::$id),*];

            /// The article's number of it.
            pub fn number(self) -> Option<u32> {
                match self { $(FigureId::$id => $number,)* }
            }

            /// Stem of its files' names.
            pub fn name(self) -> &'static str {
                match self { $(FigureId::$id => $name,)* }
            }

            /// A number of its own, for seeds.
            pub fn ordinal(self) -> u64 {
                self as u64
            }
        }
    };
}

figures! {
    "Correlation of Gold and interleaved codes",
        Fig3, "3", Some(3), "fig03-code-correlation";
    "Standard deviation against power, Gold code and square wave",
        Fig5, "5", Some(5), "fig05-precision-gold-square";
    "Standard deviation against power, by interleaving depth",
        Fig6, "6", Some(6), "fig06-precision-interleaving";
    "Correlation by interleaving depth",
        Fig7, "7", Some(7), "fig07-correlation-interleaving";
    "Standard deviation with a second source or a second path",
        Fig8, "8", Some(8), "fig08-precision-two-sources";
    "Correlation with an interferer",
        Fig9, "9", Some(9), "fig09-correlation-interferer";
    "Correlation over two paths",
        Fig10, "10", Some(10), "fig10-correlation-two-paths";
    "How far apart two paths must be",
        Fig11, "11", Some(11), "fig11-path-resolution";
    "Error left out: range walk (pile-up) against light level",
        Walk, "walk", None, "error-dead-time-walk";
    "Error left out: interference bias against relative delay",
        Interference, "interference", None, "error-interference-bias";
    "Error left out: circular error against sub-step delay",
        Circular, "circular", None, "error-circular";
    "Error left out: failures of the global coarse search",
        Coarse, "coarse", None, "error-coarse-search";
    "Joint fit: two paths of one code by their separation, beside the bound",
        TwoPaths, "two-paths", None, "joint-two-paths";
    "Joint fit: own sensor under another one by their power ratio, synchronised and not",
        PowerRatio, "power-ratio", None, "joint-power-ratio";
}

impl From<FigureId> for &'static str {
    fn from(id: FigureId) -> &'static str {
        id.name()
    }
}

impl TryFrom<String> for FigureId {
    type Error = String;

    fn try_from(name: String) -> Result<FigureId, String> {
        let known = FigureId::ALL.into_iter().find(|id| id.name() == name);
        known.ok_or_else(|| format!("there is no figure \"{name}\""))
    }
}

/// A figure's drawing and data, and the claims that it decides.
#[derive(Debug)]
pub struct Figure {
    /// The drawing.
    pub chart: Chart,
    /// The data behind it.
    pub table: Table,
    /// The claims that its data decide.
    pub claims: Vec<Claim>,
    /// What the data say beside that.
    pub notes: Vec<String>,
}

impl Figure {
    /// A figure that decides no claims.
    pub fn new(title: impl Into<String>, table: Table, panels: Vec<Panel>) -> Figure {
        let chart = Chart { title: title.into(), panels };
        Figure { chart, table, claims: Vec::new(), notes: Vec::new() }
    }
}

/// A claim of the article, as measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Claim {
    /// C1 to C8; with a letter, a second criterion of ours for the same claim.
    pub id: Cow<'static, str>,
    /// What the article says.
    pub article: Cow<'static, str>,
    /// What has to be so for `holds`.
    pub criterion: Cow<'static, str>,
    /// The measured value.
    #[serde(with = "exact")]
    #[schemars(with = "exact::ExactNumber")]
    pub measured: f64,
    /// Its unit.
    pub unit: Cow<'static, str>,
    /// 95 % confidence interval; none for what is exact.
    #[serde(with = "exact")]
    #[schemars(with = "Option<[exact::ExactNumber; 2]>")]
    pub measured_ci95: Option<[f64; 2]>,
    /// Whether the criterion is met; `holds` and `verdict` in JSON.
    #[serde(flatten)]
    pub verdict: ClaimVerdict,
    /// In which range, and at what price.
    pub remark: String,
}

impl Claim {
    /// What a measurement says of a claim.
    pub fn measured(
        [id, article, criterion]: [&'static str; 3],
        measured: Measured,
        unit: &'static str,
        verdict: ClaimVerdict,
        remark: String,
    ) -> Claim {
        let measured_ci95 = Some(measured.interval());
        let exact = Claim::exact([id, article, criterion], measured.value, unit, verdict, remark);
        Claim { measured_ci95, ..exact }
    }

    /// What is known exactly of a claim.
    pub fn exact(
        [id, article, criterion]: [&'static str; 3],
        measured: f64,
        unit: &'static str,
        verdict: ClaimVerdict,
        remark: String,
    ) -> Claim {
        Claim {
            id: id.into(),
            article: article.into(),
            criterion: criterion.into(),
            measured,
            unit: unit.into(),
            measured_ci95: None,
            verdict,
            remark,
        }
    }

    /// Value and interval in words.
    pub fn measured_text(&self) -> String {
        match self.measured_ci95 {
            Some([low, high]) => {
                format!("{:.3} {} ({low:.3} to {high:.3})", self.measured, self.unit)
            }
            None => format!("{} {} (exact)", self.measured, self.unit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_has_files_and_a_seed_of_its_own() {
        for (i, a) in FigureId::ALL.iter().enumerate() {
            for b in &FigureId::ALL[i + 1..] {
                assert_ne!(a.name(), b.name());
                assert_ne!(a.ordinal(), b.ordinal());
            }
        }
    }
}
