//! A figure that is made, as it is drawn and written.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::figure::{Claim, Figure};
use super::{FigureId, ReproduceOptions, RunError};
use crate::files::{FileError, OutputFolder};

/// A figure with its drawing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MadeFigure {
    /// Which one it is: the stem of its files' names.
    #[serde(rename = "figure")]
    #[schemars(with = "String")]
    pub id: FigureId,
    /// Title.
    pub title: String,
    /// The drawing.
    pub svg: String,
    /// The data behind it.
    pub csv: String,
    /// The claims that its data decide.
    pub claims: Vec<Claim>,
    /// What the data say beside that.
    pub notes: Vec<String>,
    /// Wall time.
    pub run_time_s: f64,
}

impl MadeFigure {
    /// Makes a figure.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn new(id: FigureId, options: &ReproduceOptions) -> Result<MadeFigure, RunError> {
        let started = Instant::now();
        let Figure { chart, table, claims, notes } = id.make(options)?;
        Ok(MadeFigure {
            id,
            svg: chart.svg(),
            title: chart.title,
            csv: table.csv(),
            claims,
            notes,
            run_time_s: started.elapsed().as_secs_f64(),
        })
    }

    /// Names of its files: the drawing, the data.
    pub fn file_names(&self) -> [String; 2] {
        ["svg", "csv"].map(|kind| format!("{}.{kind}", self.id.name()))
    }

    /// Writes its files.
    ///
    /// # Errors
    /// When one cannot be written.
    pub fn write(&self, out: &OutputFolder) -> Result<(), FileError> {
        let [drawing, data] = self.file_names();
        out.write(&drawing, &self.svg)?;
        out.write(&data, &self.csv)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::reproduce::ClaimVerdict;

    #[test]
    fn a_figure_comes_back_with_every_bit() {
        let claim = Claim {
            id: "C1".into(),
            article: "a".into(),
            criterion: "c".into(),
            measured: 0.1 + 0.2,
            unit: "mm".into(),
            measured_ci95: Some([f64::NEG_INFINITY, 5e-324]),
            verdict: ClaimVerdict::Undecided,
            remark: "r".to_owned(),
        };
        let figure = MadeFigure {
            id: FigureId::Fig5,
            title: "t".to_owned(),
            svg: "<svg/>".to_owned(),
            csv: "series".to_owned(),
            claims: vec![claim],
            notes: vec!["n".to_owned()],
            run_time_s: 0.5,
        };
        let text = serde_json::to_string(&figure).unwrap();
        assert_eq!(serde_json::from_str::<MadeFigure>(&text).unwrap(), figure);
        for (part, told) in [("undecided", "no verdict"), (FigureId::Fig5.name(), "no figure")] {
            let other = text.replace(part, "yes");
            let error = serde_json::from_str::<MadeFigure>(&other).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
