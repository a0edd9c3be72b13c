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

mod bias;
mod circular;
mod coarse;
mod correlations;
mod errors;
mod extremes;
mod figure;
mod made;
mod many;
mod phase;
mod precision;
mod printed;
mod run;
mod run_error;
mod sensor;
mod statistics;
mod theory;
mod verdict;

use std::fmt::Write as _;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use self::figure::Figure;
pub use self::figure::{Claim, FigureId};
pub use self::made::MadeFigure;
use self::run::Run;
pub use self::run_error::RunError;
pub use self::verdict::ClaimVerdict;
use crate::document::Body;
use crate::files::{FileError, OutputFolder};

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
    Run(#[from] RunError),
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

impl Body for Reproduction {
    const NAME: &'static str = "reproduce";
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

fn make(id: FigureId, options: &ReproduceOptions) -> Result<Figure, RunError> {
    let mut run = Run::new(id, options);
    match id {
        FigureId::Fig3 => theory::code_correlation(&mut run),
        FigureId::Fig5 => precision::gold_square::gold_and_square(&mut run),
        FigureId::Fig6 => precision::interleaving::interleaving(&mut run),
        FigureId::Fig7 => correlations::interleaving(&mut run),
        FigureId::Fig8 => precision::two_sources::two_sources(&mut run),
        FigureId::Fig9 => correlations::interferer(&mut run),
        FigureId::Fig10 => correlations::two_paths(&mut run),
        FigureId::Fig11 => correlations::path_resolution(&mut run),
        FigureId::Walk => errors::range_walk(&mut run),
        FigureId::Interference => errors::interference(&mut run),
        FigureId::Circular => circular::circular_error(&mut run),
        FigureId::Coarse => coarse::coarse_search(&mut run),
        FigureId::TwoPaths => many::two_paths::two_paths(&mut run),
        FigureId::PowerRatio => many::power_ratio::power_ratio(&mut run),
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
