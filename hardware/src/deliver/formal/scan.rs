//! When a scan's steps begin and end.

use super::harness::{Engine, Harness, constant, range};
use crate::rtl::blocks::SequenceCounter;
use crate::sensor::interface::Interface;

/// Every step has the asked number of chips, every scan the asked number of
/// steps, and nothing lies between them but the wait for an epoch.
pub(super) fn harness(interface: &Interface) -> Harness {
    let (chips, groups) = (interface.timing.scan.integration_chips, interface.groups());
    let mut harness = Harness::new(
        interface,
        "scan",
        &format!(
            "A step ends {chips} chips after it began, and the next begins with the next clock; a\n\
             scan has {groups} of them (groups, with several at once){}.\n\
             The ends of steps and scans reach the totals and the stream after a fixed number of clocks.\n\
             Chips and steps are counted in the order of LFSRs, as in the design; the states in which\n\
             they end are those after as many steps of the recurrence. When an epoch comes is anything\n\
             here; `codes` shows it.",
            if interface.realigns() {
                ", and begins with an epoch of the reference"
            } else {
                " and follows the one before"
            }
        ),
    )
    // As many as an end takes on its way to the stream, and what recognises it before.
    .engine(Engine::Steps(clocks_to_counted(interface) + 4));
    let segments = interface.count_segments.count;
    for (signal, port, width) in [
        ("run", "o_run", 1),
        ("step_end", "o_last_chip", 1),
        ("dump", "o_dump", segments),
        ("counted", "o_counted", 1),
        ("last", "o_scan_counted", 1),
    ] {
        harness.see(signal, &format!("controller.{port}"), width);
    }
    begins(interface, &mut harness);
    chip_counter(chips, interface.realigns(), &mut harness);
    step_counter(groups, &mut harness);
    reports(interface, &mut harness);
    harness
}

/// When a scan runs.
fn begins(interface: &Interface, harness: &mut Harness) {
    harness.lines("reg running;\nwire ends_step;\nwire ends_scan;");
    if interface.realigns() {
        harness.see("epoch", "controller.i_epoch", 1);
        harness.lines(
            "wire start = epoch & (~running | ends_scan);\n\
             always @(posedge i_clk)\n    \
                 running <= i_rst ? 0 : (start | (running & ~ends_scan));",
        );
        harness.see("start_seen", "controller.o_start", 1);
        harness.holds("start_seen == start");
    } else {
        harness.lines("always @(posedge i_clk)\n    running <= i_rst ? 1'b0 : 1'b1;");
    }
    harness.holds("run == running");
}

/// The last chip of a step.
fn chip_counter(chips: u64, realigns: bool, harness: &mut Harness) {
    if chips == 1 {
        harness.line("assign ends_step = running;");
        return;
    }
    harness.lines("reg before_last;\nreg last_chip;\nassign ends_step = last_chip;");
    harness.lines("always @(posedge i_clk)\n    last_chip <= i_rst ? 0 : before_last;");
    if chips == 2 {
        // Every other chip is a step's last.
        let first = if realigns { "start | (ends_step & ~ends_scan)" } else { "~before_last" };
        harness
            .lines(&format!("always @(posedge i_clk)\n    before_last <= i_rst ? 0 : ({first});"));
        return;
    }
    let counter = SequenceCounter::new(chips - 2);
    let width = counter.width();
    let first = constant(width, counter.state(0));
    let reset =
        if realigns { first.clone() } else { constant(width, counter.state_before_the_first()) };
    let counts = if realigns { "running" } else { "1'b1" };
    harness.lines(&format!(
        "// Chip {} of a step, counted from 0.\n\
         reg {}chip;\n\
         always @(posedge i_clk) begin\n    \
             if (i_rst) chip <= {reset};\n    \
             else if (ends_step) chip <= {first};\n    \
             else if ({counts}) chip <= {{^(chip & {}), chip[{}:1]}};\n    \
             before_last <= i_rst ? 0 : running & chip == {};\n\
         end",
        chips - 3,
        range(width),
        constant(width, counter.taps()),
        width - 1,
        constant(width, counter.state(chips - 3)),
    ));
    harness.see("chip_seen", "controller.chip_count_r", width);
    harness.holds("chip_seen == chip");
    harness.holds("chip != 0");
}

/// The last step of a scan.
fn step_counter(groups: u64, harness: &mut Harness) {
    if groups == 1 {
        harness.line("assign ends_scan = ends_step;");
        return;
    }
    let counter = SequenceCounter::new(groups - 1);
    let width = counter.width();
    let first = constant(width, counter.state(0));
    harness.lines(&format!(
        "// Step {} of a scan, counted from 0, is the last but one.\n\
         reg {}step;\n\
         reg last_step;\n\
         assign ends_scan = ends_step & last_step;\n\
         always @(posedge i_clk) begin\n    \
             if (i_rst | ends_scan) step <= {first};\n    \
             else if (ends_step) step <= {{^(step & {}), step[{}:1]}};\n    \
             if (i_rst) last_step <= 0;\n    \
             else if (ends_step) last_step <= step == {};\n\
         end",
        groups - 2,
        range(width),
        constant(width, counter.taps()),
        width - 1,
        constant(width, counter.state(groups - 2)),
    ));
    harness.see("step_seen", "controller.step_count_r", width);
    harness.see("last_step_seen", "controller.last_step_r", 1);
    harness.holds("step_seen == step");
    harness.holds("step != 0");
    harness.holds("last_step_seen == last_step");
}

/// Clocks from a step's last chip until its count is there.
fn clocks_to_counted(interface: &Interface) -> u32 {
    Interface::clocks_to_dump(interface.lanes()) + interface.clocks_of_counting()
}

/// What the rest of the design is told, and when.
fn reports(interface: &Interface, harness: &mut Harness) {
    let to_dump = Interface::clocks_to_dump(interface.lanes());
    let to_counted = clocks_to_counted(interface);
    let segments = interface.count_segments.count;
    harness.lines(&format!(
        "reg [{to_counted}:1] ended;\n\
         reg [{to_counted}:1] scan_ended;\n\
         always @(posedge i_clk) begin\n    \
             ended <= i_rst ? 0 : {{ended, ends_step}};\n    \
             scan_ended <= i_rst ? 0 : {{scan_ended, ends_scan}};\n\
         end",
    ));
    if interface.timing.scan.integration_chips > 1 {
        harness.see("step_ends", "controller.o_pre_last_chip", 1);
        harness.holds("step_ends == before_last");
    }
    if interface.reference_codes.len() as u32 * interface.parallel() > 1 {
        harness.see("counts", "controller.o_pre_counted", 1);
        harness.holds(&format!("counts == ended[{}]", to_counted - 1));
    }
    harness.reaches("ends_scan");
    harness.holds("step_end == ends_step");
    harness.holds(&format!("dump == ended[{}:{to_dump}]", to_dump + segments - 1));
    harness.holds(&format!("counted == ended[{to_counted}]"));
    harness.holds(&format!("last == scan_ended[{to_counted}]"));
}
