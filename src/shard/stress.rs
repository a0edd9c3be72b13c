//! Stress cases, every N-th for each shard.

use super::ShardError;
use super::job::{Results, StressJob};
use super::part::Part;
use crate::study::stress::{Case, CaseReport, KeptCase, StressReport, cases};

impl StressJob {
    /// The cases, in their order.
    ///
    /// # Errors
    /// When there is none of a name.
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
    let mut reports: Vec<Option<CaseReport>> = vec![None; cases.len()];
    for (part, results) in shards {
        let reason = "it has other cases";
        let unfit = || ShardError::Unfit { part, reason };
        let Results::Stress(kept) = results else {
            return Err(unfit());
        };
        let numbers: Vec<usize> = part.every(cases.len() as u64).map(|n| n as usize).collect();
        if numbers.len() != kept.len() {
            return Err(unfit());
        }
        for (number, kept) in numbers.into_iter().zip(&kept) {
            let report = KeptCase::report(kept, &cases[number]);
            reports[number] = Some(report.ok_or_else(unfit)?);
        }
    }
    Ok(StressReport { seed: job.seed, cases: reports.into_iter().flatten().collect() })
}
