//! Which cases are run: the command line's options, the library's, and a shard's.

use serde::{Deserialize, Serialize};

use super::case::Case;
use super::cases;

/// Stress cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema, clap::Args)]
pub struct StressOptions {
    /// One case, for example --case no-light-at-all [default: all]
    #[arg(long = "case", value_name = "NAME", conflicts_with = "quick", num_args = 1,
          action = clap::ArgAction::Set)]
    #[schemars(description = "Names of the cases; all of them without any")]
    pub cases: Vec<String>,
    /// The fast subset
    #[arg(long)]
    #[serde(skip)]
    pub quick: bool,
    /// Seed of each case
    #[arg(skip)]
    pub seed: u64,
}

impl Default for StressOptions {
    fn default() -> StressOptions {
        StressOptions { cases: Vec::new(), quick: false, seed: 1 }
    }
}

/// There is no case of that name.
#[derive(Debug, thiserror::Error)]
#[error(
    "there is no case \"{name}\"; did you mean \"{nearest}\"? `goldtof stress --list` names all of \
     them"
)]
pub struct UnknownCase {
    /// The name.
    name: String,
    /// The case whose name is most like it.
    nearest: &'static str,
}

impl StressOptions {
    /// The cases, in their order.
    ///
    /// # Errors
    /// When a name is unknown.
    pub fn chosen(&self) -> Result<Vec<Case>, UnknownCase> {
        let mut all = cases();
        if self.cases.is_empty() {
            all.retain(|case| case.quick || !self.quick);
            return Ok(all);
        }
        let of_name = |name: &String| {
            let likeness = |case: &&Case| strsim::jaro(case.name, name);
            let nearest = all.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
            let nearest = nearest.map_or("", |case| case.name);
            let found = all.iter().find(|case| case.name == name);
            found.copied().ok_or_else(|| UnknownCase { name: name.clone(), nearest })
        };
        self.cases.iter().map(of_name).collect()
    }

    /// The same with each case named, as a shard records them.
    pub fn named(&self, chosen: &[Case]) -> StressOptions {
        let cases = chosen.iter().map(|case| case.name.to_owned());
        StressOptions { cases: cases.collect(), quick: false, seed: self.seed }
    }
}
