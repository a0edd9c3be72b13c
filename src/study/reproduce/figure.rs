//! What a figure and a claim are.

use std::borrow::Cow;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::prelude::*;
use super::{FigureError, FigureId, ReproduceOptions};
use crate::exact;
use crate::files::{FileError, OutputFolder};
use crate::report::chart::Chart;

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

/// Whether a claim's criterion is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(into = "VerdictFields", try_from = "VerdictFields")]
#[schemars(with = "VerdictFields")]
pub enum ClaimVerdict {
    /// The whole interval meets it.
    Holds,
    /// The whole interval misses it.
    DoesNotHold,
    /// The interval has values of either kind; more scans (`--repeat`) may decide.
    Undecided,
}

impl ClaimVerdict {
    /// Of what is exact.
    pub fn exact(met: bool) -> ClaimVerdict {
        if met { ClaimVerdict::Holds } else { ClaimVerdict::DoesNotHold }
    }

    /// That a value is below a limit.
    pub fn below(measured: Measured, limit: f64) -> ClaimVerdict {
        ClaimVerdict::between(measured, f64::NEG_INFINITY, limit)
    }

    /// That a value is at least a limit.
    pub fn at_least(measured: Measured, limit: f64) -> ClaimVerdict {
        ClaimVerdict::between(measured, limit, f64::INFINITY)
    }

    /// That a value is in a range.
    pub fn between(measured: Measured, least: f64, most: f64) -> ClaimVerdict {
        let inside = |end: f64| (least..=most).contains(&end);
        if inside(measured.low) && inside(measured.high) {
            ClaimVerdict::Holds
        } else if measured.low > most || measured.high < least {
            ClaimVerdict::DoesNotHold
        } else {
            ClaimVerdict::Undecided
        }
    }

    /// That two criteria are met, of which each has its verdict.
    pub fn and(self, other: ClaimVerdict) -> ClaimVerdict {
        match (self, other) {
            (ClaimVerdict::DoesNotHold, _) | (_, ClaimVerdict::DoesNotHold) => {
                ClaimVerdict::DoesNotHold
            }
            (ClaimVerdict::Undecided, _) | (_, ClaimVerdict::Undecided) => ClaimVerdict::Undecided,
            (ClaimVerdict::Holds, ClaimVerdict::Holds) => ClaimVerdict::Holds,
        }
    }

    /// In words, for people.
    pub fn text(self) -> &'static str {
        match self {
            ClaimVerdict::Holds => "holds",
            ClaimVerdict::DoesNotHold => "DOES NOT HOLD",
            ClaimVerdict::Undecided => "UNDECIDED",
        }
    }
}

/// A verdict in JSON.
#[derive(Serialize, Deserialize, schemars::JsonSchema)]
struct VerdictFields {
    /// Whether the criterion is known to be met.
    holds: bool,
    /// `holds`, `does_not_hold` or `undecided`.
    verdict: Cow<'static, str>,
}

impl From<ClaimVerdict> for VerdictFields {
    fn from(verdict: ClaimVerdict) -> VerdictFields {
        let name = match verdict {
            ClaimVerdict::Holds => "holds",
            ClaimVerdict::DoesNotHold => "does_not_hold",
            ClaimVerdict::Undecided => "undecided",
        };
        VerdictFields { holds: verdict == ClaimVerdict::Holds, verdict: name.into() }
    }
}

impl TryFrom<VerdictFields> for ClaimVerdict {
    type Error = String;

    fn try_from(fields: VerdictFields) -> Result<ClaimVerdict, String> {
        match &*fields.verdict {
            "holds" => Ok(ClaimVerdict::Holds),
            "does_not_hold" => Ok(ClaimVerdict::DoesNotHold),
            "undecided" => Ok(ClaimVerdict::Undecided),
            other => Err(format!("there is no verdict \"{other}\"")),
        }
    }
}

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
    pub fn new(id: FigureId, options: &ReproduceOptions) -> Result<MadeFigure, FigureError> {
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

    fn measured(low: f64, high: f64) -> Measured {
        Measured { value: 0.5 * (low + high), low, high }
    }

    #[test]
    fn an_interval_across_a_limit_decides_nothing() {
        assert_eq!(ClaimVerdict::below(measured(1.2, 1.4), 1.5), ClaimVerdict::Holds);
        assert_eq!(ClaimVerdict::below(measured(1.4, 1.6), 1.5), ClaimVerdict::Undecided);
        assert_eq!(ClaimVerdict::below(measured(1.6, 1.7), 1.5), ClaimVerdict::DoesNotHold);
        assert_eq!(ClaimVerdict::at_least(measured(0.98, 1.0), 0.99), ClaimVerdict::Undecided);
        let range = |low, high| ClaimVerdict::between(measured(low, high), 2.9, 3.5);
        assert_eq!(range(3.0, 3.1), ClaimVerdict::Holds);
        assert_eq!(range(2.8, 3.1), ClaimVerdict::Undecided);
        assert_eq!(range(2.8, 3.6), ClaimVerdict::Undecided);
        assert_eq!(range(2.7, 2.8), ClaimVerdict::DoesNotHold);
    }

    #[test]
    fn of_two_criteria_the_worse_verdict_stays() {
        let all = [ClaimVerdict::Holds, ClaimVerdict::Undecided, ClaimVerdict::DoesNotHold];
        for (i, a) in all.into_iter().enumerate() {
            for (j, b) in all.into_iter().enumerate() {
                assert_eq!(a.and(b), all[i.max(j)]);
            }
        }
    }

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
