//! The article's figures and claims, simulated again, and the errors that it
//! leaves out.
//!
//! Every number comes from scenes made in code from Table I ([`sensor`]), by the
//! tier of single detections with the article's continuous-time counter, or from
//! the exact mean response. Distances are by the phase estimator in its working
//! form (one base of the triangle, 2 S samples); as printed, eqs. 16 and 17 return
//! the coarse grid, and no precision can be had from them. What the model
//! estimator leaves of an error stands beside it.
//!
//! Intervals are 95 %: normal for means and standard deviations, exact binomial
//! for rates.

mod circular;
mod correlations;
mod errors;
mod extremes;
mod figure;
mod many;
mod precision;
mod prelude;
mod run;
mod sensor;
mod statistics;
mod theory;

use std::fmt::Write as _;
use std::time::Instant;

use serde::{Deserialize, Serialize};

pub use self::figure::Claim;
pub use self::figure::ClaimVerdict;
use self::figure::Figure;
pub use self::figure::MadeFigure;
pub use self::run::FigureError;
use self::run::FigureScans;
use crate::files::{FileError, OutputFolder};

/// Declares the figures: what each shows, its name, what the command line calls it, the
/// article's number of it, the stem of its files' names, and what makes it.
macro_rules! figures {
    ($($what:literal, $id:ident, $called:literal, $number:expr, $name:literal, $make:expr;)*) => {
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

            /// Makes it.
            fn make(self, options: &ReproduceOptions) -> Result<Figure, FigureError> {
                let mut run = FigureScans::new(self, options);
                match self { $(FigureId::$id => $make(&mut run),)* }
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
        Fig3, "3", Some(3), "fig03-code-correlation", theory::code_correlation;
    "Standard deviation against power, Gold code and square wave",
        Fig5, "5", Some(5), "fig05-precision-gold-square", precision::gold_square::gold_and_square;
    "Standard deviation against power, by interleaving depth",
        Fig6, "6", Some(6), "fig06-precision-interleaving", precision::interleaving::interleaving;
    "Correlation by interleaving depth",
        Fig7, "7", Some(7), "fig07-correlation-interleaving", correlations::interleaving;
    "Standard deviation with a second source or a second path",
        Fig8, "8", Some(8), "fig08-precision-two-sources", precision::two_sources::two_sources;
    "Correlation with an interferer",
        Fig9, "9", Some(9), "fig09-correlation-interferer", correlations::interferer;
    "Correlation over two paths",
        Fig10, "10", Some(10), "fig10-correlation-two-paths", correlations::two_paths;
    "How far apart two paths must be",
        Fig11, "11", Some(11), "fig11-path-resolution", correlations::path_resolution;
    "Error left out: range walk (pile-up) against light level",
        Walk, "walk", None, "error-dead-time-walk", errors::range_walk;
    "Error left out: interference bias against relative delay",
        Interference, "interference", None, "error-interference-bias", errors::interference;
    "Error left out: circular error against sub-step delay",
        Circular, "circular", None, "error-circular", circular::circular_error;
    "Error left out: failures of the global coarse search",
        Coarse, "coarse", None, "error-coarse-search", errors::coarse_search;
    "Joint fit: two paths of one code by their separation, beside the bound",
        TwoPaths, "two-paths", None, "joint-two-paths", many::two_paths::two_paths;
    "Joint fit: own sensor under another one by their power ratio, synchronised and not",
        PowerRatio, "power-ratio", None, "joint-power-ratio", many::power_ratio::power_ratio;
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

/// Figures and claims of the article: which to make, and how well. Of scans shorter than 1.04 ms
/// so many more are made as they are shorter. Mean correlations take at most 100 (as in the
/// article), searches over whole code periods at most 200.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema, clap::Args)]
pub struct ReproduceOptions {
    /// One figure, with the claims that it decides [default: all]
    #[arg(long = "figure", value_name = "N", value_enum, num_args = 1,
          action = clap::ArgAction::Set, default_values_t = FigureId::ALL,
          hide_default_value = true)]
    #[schemars(with = "Vec<String>")]
    pub figures: Vec<FigureId>,
    /// Scans of 1.04 ms per phase step behind each standard deviation and bias, 2 to
    /// 1000000, for example --repeat 2000
    #[arg(long = "repeat", value_name = "R", default_value_t = ReproduceOptions::default().repetitions,
          value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    pub repetitions: u64,
    /// Seed of all random numbers
    #[arg(skip)]
    pub seed: u64,
}

impl Default for ReproduceOptions {
    fn default() -> ReproduceOptions {
        ReproduceOptions { figures: FigureId::ALL.to_vec(), repetitions: 500, seed: 1 }
    }
}

/// Why figures could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReproduceError {
    /// Scans could not be simulated, or what they are held against not be had.
    #[error(transparent)]
    Run(#[from] FigureError),
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
}

/// What was made.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Reproduction {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Scans of 1.04 ms per phase step behind each standard deviation and bias.
    pub repetitions: u64,
    /// How intervals were got.
    pub confidence: &'static str,
    /// The claims that the figures decide, in order.
    pub claims: Vec<Claim>,
    /// The figures.
    pub figures: Vec<FigureFiles>,
    /// Wall time.
    pub run_time_s: f64,
}

/// A figure's files.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct FigureFiles {
    /// The article's number; none for figures that it does not have.
    pub number: Option<u32>,
    /// Title.
    pub title: String,
    /// Its files, in the folder that was asked for.
    pub files: Vec<String>,
    /// What its data say beside the claims.
    pub notes: Vec<String>,
    /// Wall time.
    pub run_time_s: f64,
}

/// Makes figures into the folder `out`. `progress` hears the title of each
/// figure that is done.
///
/// # Errors
/// When a figure cannot be made, or a file not be written.
pub fn reproduce(
    options: &ReproduceOptions,
    out: &OutputFolder,
    progress: impl Fn(&str),
) -> Result<Reproduction, ReproduceError> {
    let started = Instant::now();
    let mut figures = Vec::new();
    for &id in &options.figures {
        let figure = MadeFigure::new(id, options)?;
        figure.write(out)?;
        progress(&format!("{} ({:.1} s)", figure.title, figure.run_time_s));
        figures.push(figure);
    }
    let run_time_s = started.elapsed().as_secs_f64();
    Ok(Reproduction { run_time_s, ..Reproduction::of(options, figures) })
}

impl Reproduction {
    /// What figures say together, in the order of the options.
    pub fn of(options: &ReproduceOptions, figures: Vec<MadeFigure>) -> Reproduction {
        let run_time_s = figures.iter().map(|figure| figure.run_time_s).sum();
        let mut claims = Vec::new();
        let mut files = Vec::new();
        for figure in figures {
            files.push(FigureFiles {
                number: figure.id.number(),
                files: figure.file_names().into(),
                title: figure.title,
                notes: figure.notes,
                run_time_s: figure.run_time_s,
            });
            claims.extend(figure.claims);
        }
        claims.sort_by(|a, b| a.id.cmp(&b.id));
        Reproduction {
            seed: options.seed,
            repetitions: options.repetitions,
            confidence: "95 %: normal standard errors of means and of standard deviations, \
                         exact binomial (Clopper-Pearson) for rates",
            claims,
            figures: files,
            run_time_s,
        }
    }
}

impl Reproduction {
    /// Whether every claim that was measured holds.
    pub fn holds(&self) -> bool {
        let holds = |claim: &Claim| claim.verdict == ClaimVerdict::Holds;
        self.claims.iter().all(holds)
    }

    /// The claims as a table, and the files, for people.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for claim in &self.claims {
            let verdict = claim.verdict.text();
            let _ = writeln!(text, "{}  {verdict}: {}", claim.id, claim.article);
            let _ = writeln!(text, "    measured  {}", claim.measured_text());
            let _ = writeln!(text, "    asked     {}", claim.criterion);
            let _ = writeln!(text, "    remark    {}", claim.remark);
        }
        for figure in &self.figures {
            let _ = writeln!(text, "{}: {}", figure.title, figure.files.join(", "));
            for note in &figure.notes {
                let _ = writeln!(text, "    {note}");
            }
        }
        let _ = writeln!(
            text,
            "intervals {}; {} scans of 1.04 ms per point, seed {}, {:.1} s",
            self.confidence, self.repetitions, self.seed, self.run_time_s
        );
        text
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
