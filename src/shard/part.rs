//! A part of a job.

use std::fmt;
use std::ops::Range;

/// Most shards of a job.
pub const MOST_SHARDS: u64 = 1_000_000;

const FORMS: &str = "write I/N for shard I of N, from 1/N to N/N, as 3/20; or task/N for the shard \
                     with the number of this task of an array, whose tasks are numbered from 1 to N";

/// One of the parts that a job is cut into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JobPart {
    number: u64,
    of: u64,
}

impl JobPart {
    /// Shard `number` of `of`, both from 1.
    ///
    /// # Errors
    /// When there is no such shard.
    pub fn new(number: u64, of: u64) -> Result<JobPart, String> {
        if !(1..=MOST_SHARDS).contains(&of) {
            return Err(format!("{of} shards cannot be made, 1 to {MOST_SHARDS} can; {FORMS}"));
        }
        if !(1..=of).contains(&number) {
            return Err(format!(
                "there is no shard {number} of {of}: they are numbered from 1 to {of}; {FORMS}"
            ));
        }
        Ok(JobPart { number, of })
    }

    /// `I/N`, `task/N` or `task`, with the variables of the task as `variable` has them.
    ///
    /// # Errors
    /// When it is in none of these forms, or out of range, or the process is not an array task.
    pub fn parse(text: &str, variable: impl Fn(&str) -> Option<String>) -> Result<JobPart, String> {
        let (number, of) = match text.split_once('/') {
            Some((number, of)) => (number.trim(), Some(of.trim())),
            None => (text.trim(), None),
        };
        let count = |text: &str| {
            let all_digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            let number = all_digits.then(|| text.parse::<u64>().ok()).flatten();
            number.ok_or_else(|| format!("\"{text}\" is not a number of shards; {FORMS}"))
        };
        match (number, of) {
            ("task", Some(of)) => JobPart::new(Task::find(&variable)?.number, count(of)?),
            ("task", None) => {
                let task = Task::find(&variable)?;
                JobPart::new(task.number, task.count(&variable)?)
            }
            (number, Some(of)) => JobPart::new(count(number)?, count(of)?),
            (_, None) => Err(FORMS.to_owned()),
        }
    }

    /// Its number, from 1.
    pub fn number(self) -> u64 {
        self.number
    }

    /// How many there are.
    pub fn of(self) -> u64 {
        self.of
    }

    /// Its share of units of equal cost: those that follow one another. The shares of all
    /// parts are all units, each once, and differ by at most one in length.
    pub fn stretch(self, units: u64) -> Range<u64> {
        let before = |parts: u64| {
            let units = u128::from(units) * u128::from(parts) / u128::from(self.of);
            u64::try_from(units).unwrap_or(u64::MAX)
        };
        before(self.number - 1)..before(self.number)
    }

    /// Its share of units of unequal cost: every N-th, because neighbours cost much the
    /// same.
    pub fn every(self, units: u64) -> impl Iterator<Item = u64> {
        // There are no more units than 64 bits number, nor shards than MOST_SHARDS.
        (self.number - 1..units).step_by(self.of as usize)
    }

    /// Stem of its file's name: names sort as the numbers do.
    pub fn name(self) -> String {
        let digits = self.of.to_string().len();
        format!("{:0digits$}-of-{}", self.number, self.of)
    }

    /// The part whose [`JobPart::name`] it is.
    pub fn of_name(name: &str) -> Option<JobPart> {
        let (number, of) = name.split_once("-of-")?;
        let part = JobPart::new(number.parse().ok()?, of.parse().ok()?).ok()?;
        (part.name() == name).then_some(part)
    }
}

impl fmt::Display for JobPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// The task of an array that this process is of.
struct Task {
    /// The variable that has its number.
    named_by: &'static str,
    number: u64,
}

/// Where a task's number stands. `HyperQueue` may run within a job of Slurm's, so that its
/// tasks are the inner ones.
const NAMES: [&str; 2] = ["HQ_TASK_ID", "SLURM_ARRAY_TASK_ID"];

impl Task {
    fn find(variable: &impl Fn(&str) -> Option<String>) -> Result<Task, String> {
        let found = NAMES.iter().find_map(|&named_by| Some((named_by, variable(named_by)?)));
        let Some((named_by, text)) = found else {
            return Err(format!(
                "this is not a task of an array: neither {} nor {} is set; {FORMS}",
                NAMES[1], NAMES[0]
            ));
        };
        let number =
            text.parse().map_err(|_| format!("{named_by} is \"{text}\", which is not a number"))?;
        if number == 0 {
            return Err(format!("{named_by} is 0: number the tasks from 1, as --array 1-20"));
        }
        Ok(Task { named_by, number })
    }

    /// How many tasks the array has, where its numbers say which shards they are.
    fn count(&self, variable: &impl Fn(&str) -> Option<String>) -> Result<u64, String> {
        if self.named_by == "HQ_TASK_ID" {
            return Err("HyperQueue does not say how many tasks there are: write task/N".to_owned());
        }
        let number = |name: &str| variable(name).and_then(|text| text.parse::<u64>().ok());
        let of_array =
            ["MIN", "MAX", "COUNT"].map(|end| number(&format!("SLURM_ARRAY_TASK_{end}")));
        match of_array {
            [Some(1), Some(last), Some(count)] if last == count => Ok(count),
            // Some tasks of an array, run once more, have a count of their own.
            _ => Err(
                "the tasks of this array are not numbered from 1 to their number, so that it does \
                 not say how many shards there are: write task/N"
                    .to_owned(),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(variables: &[(&str, &str)], text: &str) -> Result<String, String> {
        let find = |name: &str| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        JobPart::parse(text, find).map(|part| part.to_string())
    }

    #[test]
    fn a_shard_is_written_as_its_number_and_their_number() {
        assert_eq!(with(&[], "3/20"), Ok("3/20".to_owned()));
        assert_eq!(with(&[], " 1 / 1 "), Ok("1/1".to_owned()));
        for (text, told) in [
            ("0/4", "there is no shard 0 of 4: they are numbered from 1 to 4"),
            ("5/4", "there is no shard 5 of 4"),
            ("1/0", "0 shards cannot be made, 1 to 1000000 can"),
            ("1/1000001", "1000001 shards cannot be made"),
            ("-1/4", "\"-1\" is not a number of shards"),
            ("+1/4", "\"+1\" is not a number of shards"),
            ("1/4/4", "\"4/4\" is not a number of shards"),
            ("1/99999999999999999999", "is not a number of shards"),
            ("/", "\"\" is not a number of shards"),
            ("4", "write I/N"),
            ("", "write I/N"),
            ("task", "neither SLURM_ARRAY_TASK_ID nor HQ_TASK_ID is set"),
            ("task/4", "this is not a task of an array"),
        ] {
            let error = with(&[], text).expect_err(text);
            assert!(error.contains(told), "{text}: {error}");
        }
    }

    #[test]
    fn a_task_of_an_array_says_which_shard_it_is() {
        let slurm = |id, min, max, count| {
            [
                ("SLURM_ARRAY_TASK_ID", id),
                ("SLURM_ARRAY_TASK_MIN", min),
                ("SLURM_ARRAY_TASK_MAX", max),
                ("SLURM_ARRAY_TASK_COUNT", count),
            ]
        };
        assert_eq!(with(&slurm("3", "1", "20", "20"), "task"), Ok("3/20".to_owned()));
        // Tasks 3 and 7 of 20, run again.
        let again = slurm("7", "3", "7", "2");
        assert_eq!(with(&again, "task/20"), Ok("7/20".to_owned()));
        let error = with(&again, "task").unwrap_err();
        assert!(error.contains("write task/N"), "{error}");
        let error = with(&slurm("0", "0", "19", "20"), "task/20").unwrap_err();
        assert!(error.contains("number the tasks from 1"), "{error}");
        let error = with(&slurm("21", "1", "21", "21"), "task/20").unwrap_err();
        assert!(error.contains("there is no shard 21 of 20"), "{error}");
        assert_eq!(with(&[("HQ_TASK_ID", "4")], "task/9"), Ok("4/9".to_owned()));
        let error = with(&[("HQ_TASK_ID", "4")], "task").unwrap_err();
        assert!(error.contains("write task/N"), "{error}");
        // A task of HyperQueue's within an array of Slurm's.
        let both = [("SLURM_ARRAY_TASK_ID", "1"), ("HQ_TASK_ID", "4")];
        assert_eq!(with(&both, "task/9"), Ok("4/9".to_owned()));
        let error = with(&[("HQ_TASK_ID", "x")], "task/9").unwrap_err();
        assert!(error.contains("HQ_TASK_ID is \"x\""), "{error}");
    }

    #[test]
    fn shares_are_all_units_each_once() {
        for of in [1, 2, 3, 7, 20, 1000] {
            for units in [0, 1, 6, 7, 100, 999, 1_000_000] {
                let parts = || (1..=of).map(|number| JobPart::new(number, of).unwrap());
                let mut next = 0;
                for part in parts() {
                    let stretch = part.stretch(units);
                    assert_eq!(stretch.start, next);
                    next = stretch.end;
                    let length = stretch.end - stretch.start;
                    assert!(length == units / of || length == units / of + 1);
                }
                assert_eq!(next, units);
                if units < 1000 {
                    let mut every: Vec<u64> = parts().flat_map(|part| part.every(units)).collect();
                    every.sort_unstable();
                    assert!(every.into_iter().eq(0..units));
                }
            }
        }
        let last = JobPart::new(MOST_SHARDS, MOST_SHARDS).unwrap();
        assert_eq!(last.stretch(u64::MAX).end, u64::MAX);
    }

    #[test]
    fn names_lead_back_to_their_parts() {
        let part = JobPart::new(3, 20).unwrap();
        assert_eq!(part.name(), "03-of-20");
        assert_eq!(JobPart::of_name("03-of-20"), Some(part));
        for other in ["3-of-20", "21-of-20", "00-of-20", "03-of-020", "a-of-20", "03"] {
            assert_eq!(JobPart::of_name(other), None, "{other}");
        }
    }
}
