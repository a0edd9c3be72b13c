//! What a figure and a claim are.

use std::borrow::Cow;
use std::fmt::Write as _;

use serde::Serialize;

use super::statistics::Measured;
use super::verdict::Verdict;
use crate::report::chart::Chart;

/// The figures that can be made: the article's, those of the errors that it leaves
/// out, and those of light that the joint fit tells apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum FigureId {
    /// Correlation of Gold and interleaved codes
    #[cfg_attr(feature = "cli", value(name = "3"))]
    Fig3,
    /// Standard deviation against power, Gold code and square wave
    #[cfg_attr(feature = "cli", value(name = "5"))]
    Fig5,
    /// Standard deviation against power, by interleaving depth
    #[cfg_attr(feature = "cli", value(name = "6"))]
    Fig6,
    /// Correlation by interleaving depth
    #[cfg_attr(feature = "cli", value(name = "7"))]
    Fig7,
    /// Standard deviation with a second source or a second path
    #[cfg_attr(feature = "cli", value(name = "8"))]
    Fig8,
    /// Correlation with an interferer
    #[cfg_attr(feature = "cli", value(name = "9"))]
    Fig9,
    /// Correlation over two paths
    #[cfg_attr(feature = "cli", value(name = "10"))]
    Fig10,
    /// How far apart two paths must be
    #[cfg_attr(feature = "cli", value(name = "11"))]
    Fig11,
    /// Error left out: range walk (pile-up) against light level
    Walk,
    /// Error left out: interference bias against relative delay
    Interference,
    /// Error left out: circular error against sub-step delay
    Circular,
    /// Error left out: failures of the global coarse search
    Coarse,
    /// Joint fit: two paths of one code by their separation, beside the bound
    TwoPaths,
    /// Joint fit: own sensor under another one by their power ratio, synchronised and not
    PowerRatio,
}

impl FigureId {
    /// All, in order.
    pub const ALL: [FigureId; 14] = [
        FigureId::Fig3,
        FigureId::Fig5,
        FigureId::Fig6,
        FigureId::Fig7,
        FigureId::Fig8,
        FigureId::Fig9,
        FigureId::Fig10,
        FigureId::Fig11,
        FigureId::Walk,
        FigureId::Interference,
        FigureId::Circular,
        FigureId::Coarse,
        FigureId::TwoPaths,
        FigureId::PowerRatio,
    ];

    /// The article's number of it.
    pub fn number(self) -> Option<u32> {
        match self {
            FigureId::Fig3 => Some(3),
            FigureId::Fig5 => Some(5),
            FigureId::Fig6 => Some(6),
            FigureId::Fig7 => Some(7),
            FigureId::Fig8 => Some(8),
            FigureId::Fig9 => Some(9),
            FigureId::Fig10 => Some(10),
            FigureId::Fig11 => Some(11),
            _ => None,
        }
    }

    /// Stem of its files' names.
    pub fn name(self) -> &'static str {
        match self {
            FigureId::Fig3 => "fig03-code-correlation",
            FigureId::Fig5 => "fig05-precision-gold-square",
            FigureId::Fig6 => "fig06-precision-interleaving",
            FigureId::Fig7 => "fig07-correlation-interleaving",
            FigureId::Fig8 => "fig08-precision-two-sources",
            FigureId::Fig9 => "fig09-correlation-interferer",
            FigureId::Fig10 => "fig10-correlation-two-paths",
            FigureId::Fig11 => "fig11-path-resolution",
            FigureId::Walk => "error-dead-time-walk",
            FigureId::Interference => "error-interference-bias",
            FigureId::Circular => "error-circular",
            FigureId::Coarse => "error-coarse-search",
            FigureId::TwoPaths => "joint-two-paths",
            FigureId::PowerRatio => "joint-power-ratio",
        }
    }

    /// A number of its own, for seeds.
    pub fn ordinal(self) -> u64 {
        self as u64
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

/// Data of a figure, as CSV.
#[derive(Debug)]
pub struct Table {
    text: String,
    columns: usize,
}

impl Table {
    /// An empty table; names carry their units.
    pub fn new(columns: &[&str]) -> Table {
        Table { text: columns.join(",") + "\n", columns: columns.len() }
    }

    /// Adds a row: its series (in quotes if it has a comma), then a number for each other column. `None` is an
    /// empty field.
    ///
    /// # Panics
    /// If the row has another number of columns than the table.
    pub fn row(&mut self, series: &str, values: &[Option<f64>]) {
        assert_eq!(values.len() + 1, self.columns, "one value for each column");
        if series.contains(',') {
            let _ = write!(self.text, "\"{series}\"");
        } else {
            self.text += series;
        }
        for value in values {
            self.text.push(',');
            if let Some(value) = value {
                let _ = write!(self.text, "{value}");
            }
        }
        self.text.push('\n');
    }

    /// The table as CSV, header first.
    pub fn csv(&self) -> &str {
        &self.text
    }
}

/// A claim of the article, as measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Claim {
    /// C1 to C8; with a letter, a second criterion of ours for the same claim.
    pub id: Cow<'static, str>,
    /// What the article says.
    pub article: Cow<'static, str>,
    /// What has to be so for `holds`.
    pub criterion: Cow<'static, str>,
    /// The measured value.
    pub measured: f64,
    /// Its unit.
    pub unit: Cow<'static, str>,
    /// 95 % confidence interval; none for what is exact.
    pub measured_ci95: Option<[f64; 2]>,
    /// Whether the criterion is met; `holds` and `verdict` in JSON.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// In which range, and at what price.
    pub remark: String,
}

impl Claim {
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

/// The columns of a value and its interval.
pub fn cells(measured: Measured) -> [Option<f64>; 3] {
    [measured.value, measured.low, measured.high].map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_values_are_empty_fields_and_commas_stay_in_quotes() {
        let mut table = Table::new(&["series", "x_ps", "y"]);
        table.row("gold", &[Some(1.5), None]);
        table.row("gold, again", &[None, Some(2.0)]);
        let rows = ["series,x_ps,y", "gold,1.5,", "\"gold, again\",,2", ""];
        assert_eq!(table.csv(), rows.join("\n"));
    }

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
