//! A co-simulation as a JUnit report, as continuous integration reads it.
//!
//! One suite for the scene; a case for each output port, for each family of cover points
//! and for the stimulus. Cases fail exactly when the command's exit status is not 0.

use std::path::Path;

use maud::{Markup, PreEscaped, html};

use crate::cosim::mismatch::FirstMismatch;
use crate::cosim::{Report, StimulusKind, Verdict};
use crate::files::{self, FileError};
use crate::printable::printable;

/// A case of the report.
struct TestCase {
    class: &'static str,
    name: String,
    outcome: TestOutcome,
}

enum TestOutcome {
    Passed,
    /// What was checked does not hold.
    Failed(String),
    /// It could not be checked.
    Error(String),
    /// It was not asked for, or not reached.
    Skipped(String),
}

/// Writes what a co-simulation found.
pub(super) fn write_report(path: &Path, scene: &str, report: &Report) -> Result<(), FileError> {
    let seconds = report.clocks as f64 / report.clocks_per_s.max(1.0);
    files::write(path, &document(scene, &cases(report), seconds))
}

/// Writes that nothing could be compared.
pub(super) fn write_error(path: &Path, scene: &str, text: &str) -> Result<(), FileError> {
    let case = TestCase {
        class: "goldtof.stimulus",
        name: "co-simulation".to_owned(),
        outcome: TestOutcome::Error(text.to_owned()),
    };
    files::write(path, &document(scene, &[case], 0.0))
}

fn cases(report: &Report) -> Vec<TestCase> {
    let mut cases: Vec<TestCase> =
        report.compared_ports.iter().map(|port| of_port(report, port)).collect();
    let families = report.coverage.families.iter();
    cases.extend(families.map(|family| TestCase {
        class: "goldtof.coverage",
        name: family.family.to_owned(),
        outcome: match family.covered == family.points {
            true => TestOutcome::Passed,
            false => TestOutcome::Skipped(format!(
                "{} of {} cover points reached",
                family.covered, family.points
            )),
        },
    }));
    cases.push(TestCase {
        class: "goldtof.stimulus",
        name: match report.stimulus {
            StimulusKind::Photons => "photons".to_owned(),
            StimulusKind::Adversarial => "adversarial".to_owned(),
        },
        outcome: match report.verdict {
            Verdict::Match => TestOutcome::Passed,
            Verdict::Mismatch => TestOutcome::Failed(first_mismatch(report)),
            Verdict::Inconclusive => TestOutcome::Failed(report.missing.join("; ")),
        },
    });
    cases
}

fn of_port(report: &Report, port: &str) -> TestCase {
    let first = report.first_mismatch.as_ref().filter(|first| first.port == port);
    let told = report.differences.iter().find(|told| told.port == port);
    TestCase {
        class: "goldtof.ports",
        name: port.to_owned(),
        outcome: match (first, told) {
            (Some(_), told) => TestOutcome::Failed(match told {
                Some(told) => format!("{}; {}", first_mismatch(report), told.text),
                None => first_mismatch(report),
            }),
            (None, Some(told)) => TestOutcome::Failed(told.text.clone()),
            (None, None) => TestOutcome::Passed,
        },
    }
}

fn first_mismatch(report: &Report) -> String {
    let told = report.first_mismatch.as_ref().map(|first| {
        let FirstMismatch { clock, port, expected, got, .. } = first;
        let time_ns = first.time_ps / 1e3;
        format!("clock {clock} ({time_ns:.3} ns): port {port} should be {expected} and is {got}")
    });
    told.unwrap_or_default()
}

fn document(scene: &str, cases: &[TestCase], seconds: f64) -> String {
    let count =
        |is: fn(&TestOutcome) -> bool| cases.iter().filter(|case| is(&case.outcome)).count();
    let failures = count(|outcome| matches!(outcome, TestOutcome::Failed(_)));
    let errors = count(|outcome| matches!(outcome, TestOutcome::Error(_)));
    let skipped = count(|outcome| matches!(outcome, TestOutcome::Skipped(_)));
    let time = format!("{seconds:.3}");
    let told = html! {
        testsuites name="goldtof" tests=(cases.len()) failures=(failures) errors=(errors) time=(time) {
            testsuite name=(printable(scene)) tests=(cases.len()) failures=(failures) errors=(errors)
                skipped=(skipped) time=(time) {
                @for case in cases {
                    testcase classname=(case.class) name=(case.name) { (outcome(&case.outcome)) }
                }
            }
        }
    };
    let head = PreEscaped("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    html! { (head) (told) "\n" }.into_string()
}

fn outcome(outcome: &TestOutcome) -> Markup {
    // What XML cannot hold is shown, not written.
    match outcome {
        TestOutcome::Passed => html! {},
        TestOutcome::Failed(text) => {
            html! { failure message=(first_line(text)) type="mismatch" { (crate::printable::printable_lines(text)) } }
        }
        TestOutcome::Error(text) => {
            html! { error message=(first_line(text)) type="error" { (crate::printable::printable_lines(text)) } }
        }
        TestOutcome::Skipped(text) => html! { skipped message=(printable(text)) {} },
    }
}

fn first_line(text: &str) -> String {
    printable(text.lines().next().unwrap_or_default()).into_owned()
}
