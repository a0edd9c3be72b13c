//! Stress cases, every N-th for each shard.

use super::ShardError;
use super::every::in_order;
use super::job::{Results, StressJob};
use super::part::Part;
use crate::study::stress::{Case, CaseReport, StressReport, cases};

impl StressJob {
    /// The cases, in their order.
    ///
    /// # Errors
    /// When a name is unknown.
    pub fn cases(&self) -> Result<Vec<Case>, ShardError> {
        let all = cases();
        let of_name = |name: &String| {
            let found = all.iter().find(|case| case.name == name);
            found.copied().ok_or_else(|| ShardError::NoJob {
                reason: format!("there is no stress case \"{name}\""),
            })
        };
        self.cases.iter().map(of_name).collect()
    }
}

/// The report that all shards together are.
///
/// # Errors
/// When a shard's cases are not those of its part.
pub fn stress_report(
    job: &StressJob,
    shards: Vec<(Part, Results)>,
) -> Result<StressReport, ShardError> {
    let cases = job.cases()?;
    let reports = |results| match results {
        Results::Stress(reports) => Some(reports),
        _ => None,
    };
    let is_its = |number: usize, report: &CaseReport| report.name == cases[number].name;
    let cases = in_order(cases.len(), shards, "it has other cases", reports, is_its)?;
    Ok(StressReport { seed: job.seed, cases })
}
