//! A figure that is made: as it is drawn and written, and as another run reads it.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::figure::{Claim, Figure, FigureId};
use super::verdict::Verdict;
use super::{Options, ReproduceError, make};
use crate::files::{FileError, OutputFolder};

/// A figure with its drawing.
#[derive(Debug, Clone)]
pub struct MadeFigure {
    /// Which one it is.
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
    pub fn new(id: FigureId, options: &Options) -> Result<MadeFigure, ReproduceError> {
        let started = Instant::now();
        let Figure { chart, table, claims, notes } = make(id, options)?;
        Ok(MadeFigure {
            id,
            svg: chart.svg()?,
            title: chart.title,
            csv: table.csv().to_owned(),
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

    /// What has to be kept of it for [`KeptFigure::figure`] to give it back.
    pub fn kept(&self) -> KeptFigure {
        KeptFigure {
            figure: self.id.name().to_owned(),
            title: self.title.clone(),
            svg: self.svg.clone(),
            csv: self.csv.clone(),
            claims: self.claims.iter().map(KeptClaim::of).collect(),
            notes: self.notes.clone(),
            run_time_s: self.run_time_s,
        }
    }
}

/// A figure on its way from one run to another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct KeptFigure {
    /// Stem of its files' names.
    pub figure: String,
    /// Title.
    pub title: String,
    /// The drawing.
    pub svg: String,
    /// The data behind it.
    pub csv: String,
    /// The claims that its data decide.
    pub claims: Vec<KeptClaim>,
    /// What the data say beside that.
    pub notes: Vec<String>,
    /// Wall time.
    pub run_time_s: f64,
}

/// A claim on its way from one run to another. Numbers are texts, the shortest that read
/// back to the same double: intervals may be open, and JSON has no infinity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct KeptClaim {
    /// C1 to C8.
    id: String,
    /// What the article says.
    article: String,
    /// What has to be so for it to hold.
    criterion: String,
    /// The measured value.
    measured: String,
    /// Its unit.
    unit: String,
    /// Its 95 % confidence interval.
    measured_ci95: Option<[String; 2]>,
    /// `holds`, `does_not_hold` or `undecided`.
    verdict: String,
    /// In which range, and at what price.
    remark: String,
}

impl KeptFigure {
    /// The figure; none if there is none of its name, or a number is none.
    pub fn figure(&self) -> Option<MadeFigure> {
        let mut known = FigureId::ALL.into_iter();
        let claims: Option<Vec<Claim>> = self.claims.iter().map(KeptClaim::claim).collect();
        Some(MadeFigure {
            id: known.find(|id| id.name() == self.figure)?,
            title: self.title.clone(),
            svg: self.svg.clone(),
            csv: self.csv.clone(),
            claims: claims?,
            notes: self.notes.clone(),
            run_time_s: self.run_time_s,
        })
    }
}

impl KeptClaim {
    fn of(claim: &Claim) -> KeptClaim {
        KeptClaim {
            id: claim.id.to_string(),
            article: claim.article.to_string(),
            criterion: claim.criterion.to_string(),
            measured: claim.measured.to_string(),
            unit: claim.unit.to_string(),
            measured_ci95: claim.measured_ci95.map(|ends| ends.map(|end| end.to_string())),
            verdict: claim.verdict.name().to_owned(),
            remark: claim.remark.clone(),
        }
    }

    fn claim(&self) -> Option<Claim> {
        let number = |text: &String| text.parse::<f64>().ok();
        Some(Claim {
            id: self.id.clone().into(),
            article: self.article.clone().into(),
            criterion: self.criterion.clone().into(),
            measured: number(&self.measured)?,
            unit: self.unit.clone().into(),
            measured_ci95: match &self.measured_ci95 {
                Some([low, high]) => Some([number(low)?, number(high)?]),
                None => None,
            },
            verdict: Verdict::of_name(&self.verdict)?,
            remark: self.remark.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_comes_back_with_every_bit() {
        let claim = Claim {
            id: "C1".into(),
            article: "a".into(),
            criterion: "c".into(),
            measured: 0.1 + 0.2,
            unit: "mm".into(),
            measured_ci95: Some([f64::NEG_INFINITY, 5e-324]),
            verdict: Verdict::Undecided,
            remark: "r".to_owned(),
        };
        let text = serde_json::to_string(&KeptClaim::of(&claim)).unwrap();
        let kept: KeptClaim = serde_json::from_str(&text).unwrap();
        assert_eq!(kept.claim().unwrap(), claim);
        let other = KeptClaim { verdict: "yes".to_owned(), ..kept };
        assert_eq!(other.claim(), None);
    }
}
