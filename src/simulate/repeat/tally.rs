//! What is kept of scans: as much as their statistics need.

use serde::{Deserialize, Serialize};

use super::answers::ScanAnswer;

/// What the scans of one detector say, in the order of their numbers. Tallies of scans that
/// follow one another, one [appended](ScanTally::append) to the other, are that of all of them,
/// bit for bit: sums of errors are not kept, because they depend on where they are cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(rename = "Tally")]
pub struct ScanTally {
    /// For each path the errors of its estimates.
    pub errors_m: Vec<Vec<f64>>,
    /// For each path how many of them found its peak.
    pub found: Vec<u64>,
    /// Scans.
    pub scans: u64,
    /// Detections that were counted in them.
    pub detections: u64,
    /// Fits, if the estimator fits.
    pub fits: u64,
    /// Those of them with an alarm.
    pub alarms: u64,
    /// Scans whose peak may be chance.
    pub refused: u64,
    /// The last remark of any scan.
    pub remark: Option<String>,
    /// How many scans had one.
    pub remarks: u64,
}

impl ScanTally {
    /// Of no scans, for so many paths.
    pub fn of_paths(paths: usize) -> ScanTally {
        ScanTally {
            errors_m: vec![Vec::new(); paths],
            found: vec![0; paths],
            scans: 0,
            detections: 0,
            fits: 0,
            alarms: 0,
            refused: 0,
            remark: None,
            remarks: 0,
        }
    }

    /// Takes the answers of the scans that follow. An error of at most `tolerance_m` is a
    /// peak that was found.
    pub fn add(&mut self, answers: Vec<ScanAnswer>, tolerance_m: f64) {
        for answer in answers {
            self.scans += 1;
            self.refused += u64::from(answer.is_refused);
            for (place, error_m) in answer.found {
                self.errors_m[place].push(error_m);
                self.found[place] += u64::from(error_m.abs() <= tolerance_m);
            }
            if let Some(alarm) = answer.alarm {
                self.fits += 1;
                self.alarms += u64::from(alarm);
            }
            if answer.remark.is_some() {
                self.remark = answer.remark;
                self.remarks += 1;
            }
        }
    }

    /// Takes the scans that follow.
    pub fn append(&mut self, later: ScanTally) {
        for (errors_m, more) in self.errors_m.iter_mut().zip(later.errors_m) {
            errors_m.extend(more);
        }
        for (found, more) in self.found.iter_mut().zip(later.found) {
            *found += more;
        }
        self.scans += later.scans;
        self.detections += later.detections;
        self.fits += later.fits;
        self.alarms += later.alarms;
        self.refused += later.refused;
        self.remark = later.remark.or(self.remark.take());
        self.remarks += later.remarks;
    }

    /// What went wrong in scans, and in how many, unless it was in all.
    pub fn remark(&self) -> Option<String> {
        let remark = self.remark.as_ref()?;
        Some(match self.remarks == self.scans {
            true => remark.clone(),
            false => format!("in {} of {} scans: {remark}", self.remarks, self.scans),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(found: &[(usize, f64)], alarm: Option<bool>, remark: Option<&str>) -> ScanAnswer {
        let remark = remark.map(str::to_owned);
        ScanAnswer { found: found.to_vec(), alarm, remark, ..ScanAnswer::default() }
    }

    #[test]
    fn two_tallies_are_that_of_all_scans_wherever_they_are_cut() {
        let answers = || {
            vec![
                answer(&[(0, 0.1), (1, -0.7)], Some(true), None),
                answer(&[], None, Some("the first")),
                answer(&[(1, 0.2)], Some(false), Some("the last")),
                answer(&[(0, 1e-17)], Some(false), None),
            ]
        };
        let mut whole = ScanTally::of_paths(2);
        whole.add(answers(), 0.5);
        assert_eq!(whole.errors_m, [vec![0.1, 1e-17], vec![-0.7, 0.2]]);
        assert_eq!((whole.found.clone(), whole.fits, whole.alarms), (vec![2, 1], 3, 1));
        let told = whole.remark().unwrap();
        assert_eq!(told, "in 2 of 4 scans: the last");
        for cut in 0..=4 {
            let mut before = answers();
            let after = before.split_off(cut);
            let mut joined = ScanTally::of_paths(2);
            joined.add(before, 0.5);
            let mut later = ScanTally::of_paths(2);
            later.add(after, 0.5);
            joined.append(later);
            assert_eq!(joined, whole, "cut at {cut}");
        }
    }
}
