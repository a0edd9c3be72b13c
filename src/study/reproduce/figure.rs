//! What a figure and a claim are.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::statistics::Measured;
use super::verdict::ClaimVerdict;
use crate::exact;
use crate::report::chart::{Chart, Panel};
use crate::report::table::Table;

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
