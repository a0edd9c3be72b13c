//! What the testbench's first lines say of it.

use crate::deliver::flow::stimulus::{Recording, Skips};
use crate::reference::cover_report::{Coverage, Missed};
use crate::scan::{Clock, Timescale};

/// Cover points that the header names at most.
const MOST_NAMED: usize = 4;

/// What the recording covers, and how steps and scans are cut short in it.
pub(super) fn covered(recording: &Recording, whole: &str) -> String {
    let mut text = what_is_covered(&recording.coverage);
    if let Some(skips) = &recording.skips {
        text += &comment("Short", &about_skips(skips, whole));
    }
    text
}

/// What the recording shows of what can be covered.
fn what_is_covered(coverage: &Coverage) -> String {
    let mut text = comment("Covers", &coverage.summary());
    for (title, missed) in [("Not", &coverage.not_covered), ("Cannot", &coverage.unreachable)] {
        let points: Vec<String> = missed.iter().take(MOST_NAMED).map(Missed::text).collect();
        let more = missed.len().saturating_sub(MOST_NAMED);
        if more > 0 {
            text += &comment(title, &format!("{}; and {more} more", points.join("; ")));
        } else if !points.is_empty() {
            text += &comment(title, &points.join("; "));
        }
    }
    text
}

/// How steps and scans are cut short.
fn about_skips(skips: &Skips, whole: &str) -> String {
    let paths: Vec<String> = skips.registers.iter().map(|r| r.path(".")).collect();
    format!(
        "steps and scans are cut short, so that their ends and many more of them come in this \
             length: between two clocks the testbench XORs a constant into the counters of the scan \
             controller ({}), which moves them on and touches nothing else. A design without them \
             is checked for the first {} clocks, before the first such move, with {whole} defined",
        paths.join(", "),
        skips.first_clock
    )
}

/// A fact of the header, in lines of a hundred characters.
fn comment(title: &str, text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.len() - 1;
        if lines[line].len() + 1 + word.len() > 87 {
            lines.push(word.to_owned());
        } else {
            if !lines[line].is_empty() {
                lines[line].push(' ');
            }
            lines[line] += word;
        }
    }
    let titles = std::iter::once(title).chain(std::iter::repeat(""));
    let lines = titles.zip(lines);
    lines.map(|(title, line)| format!("// {title:<8} {line}\n")).collect()
}

/// What the header says of time.
pub(super) fn time_in_words(clock: Clock, time: Timescale) -> String {
    let ns = clock.chip_period_ps / 1e3;
    if time.is_exact() {
        format!("a clock takes {ns} ns, as on the chip")
    } else {
        format!("a clock takes {ns} ns, as on the chip, with edges at whole multiples of {time}")
    }
}
