//! What the testbench's first lines say of it.

use super::Names;
use crate::deliver::flow::stimulus::{Recording, Skips};
use crate::reference::cover_report::{Coverage, Missed};
use crate::scan::{Clock, Timescale};

/// Cover points that the header names at most.
const MOST_NAMED: usize = 4;

/// The comment that the testbench begins with.
pub(super) fn header(
    names: &Names,
    recording: &Recording,
    (clock, time): (Clock, Timescale),
    made_by: &str,
) -> String {
    let Names { design, top, whole, .. } = names;
    let time = time_in_words(clock, time);
    let coverage = &recording.coverage;
    let mut text = format!(
        "\
// {top}: self-checking testbench of {design}
//
// Drives recorded inputs and compares every output port, after every rising edge of i_clk and
// before the next one, with what goldtof's reference model gives. The model takes chips from the code's table and hits from
// the list of pulses: no part of the design has a share in the expected values.
//
// Inputs   hostile, with an aim: {resets} resets, a receiver that stalls, every kind of hit
// Length   {clocks} clocks; {steps} phase steps and {scans} scans end in them
// Counts   {hits_up} hits up and {hits_down} hits down in the results that come to the stream
",
        resets = recording.resets,
        clocks = recording.clocks,
        steps = recording.phase_steps,
        scans = recording.scans,
        hits_up = recording.hits_up,
        hits_down = recording.hits_down,
    );
    text += &what_is_covered(coverage);
    if let Some(skips) = &recording.skips {
        text += &comment("Short", &about_skips(skips, whole));
    }
    text + &format!(
        "\
// Ends     with PASS, what was exercised, and exit status 0; or at the first clock at which a port
//          differs with that clock, the port, the expected value and the one seen, and a non-zero
//          exit status; or with INCONCLUSIVE and a non-zero exit status, if no result was taken
//          that counts anything: a sensor that does nothing would pass then
// Language Verilog-2005, and the system task $fatal of IEEE 1800, which gives the exit status
// Made by  {made_by}
//
// Run it in this folder with
//   $ iverilog -g2005 -s {top} -o {top}.vvp -f {top}.f
//   $ vvp {top}.vvp
// or
//   $ verilator --binary --top-module {top} -f {top}.f
//   $ obj_dir/V{top}
// With +vcd it writes waves to {top}.vcd (Verilator: build with --trace). Time is real:
// {time}.

"
    )
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
fn time_in_words(clock: Clock, time: Timescale) -> String {
    let ns = clock.chip_period_ps / 1e3;
    if time.is_exact() {
        format!("a clock takes {ns} ns, as on the chip")
    } else {
        format!("a clock takes {ns} ns, as on the chip, with edges at whole multiples of {time}")
    }
}
