//! When a histogram's words begin and end frames, and which rows come to the stream.

use super::harness::{Engine, Harness, constant, range};
use crate::sensor::histogram::{CLOCKS_TO_ROW, HistogramPlan};
use crate::sensor::interface::Interface;

/// Clocks from a word until its new bin is written.
const CLOCKS_TO_WRITE: u32 = 6;
/// Clocks from a word that comes of a single memory until its row may be taken.
const CLOCKS_TO_COME: u32 = 3;

/// Rows, code periods and frames, and what the memories are told of them.
pub(super) fn scan(interface: &Interface, plan: &HistogramPlan) -> Harness {
    let mut harness = Harness::new(
        interface,
        "scan",
        &format!(
            "Words count from the second clock after reset on: a row each, {} rows a code period, {} code\n\
             periods a frame, one behind the other without a pause. Row and first code period reach the\n\
             memories after a fixed number of clocks.",
            plan.rows, plan.periods
        ),
    )
    .engine(Engine::Steps(1))
    .freeing("histogram_channel");
    Frames::of(plan, interface).count(&mut harness);
    harness
}

/// Rows on the stream, frames that are lost.
pub(super) fn stream(interface: &Interface, plan: &HistogramPlan) -> Harness {
    let about = match plan.takes_turns() {
        true => {
            "A frame that ends when all rows of the one before have been taken, or with the clock that takes\n\
             the last, is read whole: each row once, in order, detector 0's, then detector 1's, ..., tlast at\n\
             the last and nowhere else. Any other is lost, whole. Memories change places with each frame\n\
             that is read, and with no other. o_overrun rises if and only if a frame is lost, and stays."
        }
        false => {
            "Behind a whole frame its rows come one a clock, in order, tlast at the last and nowhere else. One\n\
             that comes while another waits that is not taken is lost. o_overrun rises if and only if a row is\n\
             lost, and stays until reset."
        }
    };
    let mut harness = Harness::new(interface, "stream", about)
        .engine(Engine::Steps(1))
        .freeing("histogram_channel");
    let frames = Frames::of(plan, interface);
    frames.count(&mut harness);
    match plan.takes_turns() {
        true => frames.read(&mut harness),
        false => frames.send(&mut harness),
    }
    harness
}

struct Frames {
    rows: u64,
    periods: u64,
    detectors: u64,
    takes_turns: bool,
}

/// Bits of numbers up to this one.
fn bits_of(most: u64) -> u32 {
    (u64::BITS - most.leading_zeros()).max(1)
}

impl Frames {
    fn of(plan: &HistogramPlan, interface: &Interface) -> Frames {
        Frames {
            rows: plan.rows,
            periods: plan.periods,
            detectors: interface.reference_codes.len() as u64,
            takes_turns: plan.takes_turns(),
        }
    }

    fn row_bits(&self) -> u32 {
        bits_of(self.rows - 1)
    }

    fn last_row(&self) -> String {
        constant(self.row_bits(), u128::from(self.rows - 1))
    }

    /// The row of the word so many clocks ago.
    fn row_before(&self, clocks: u32) -> String {
        let bits = self.row_bits();
        format!("rows_before[{}:{}]", clocks * bits - 1, (clocks - 1) * bits)
    }

    /// Which row and code period the present word is of.
    fn count(&self, harness: &mut Harness) {
        let bits = self.row_bits();
        harness.lines(&format!(
            "// Row of the present word, and code period of its frame, counted from 0.\n\
             reg running;\n\
             reg began;\n\
             reg {0}row;\n\
             wire ends_period = began & row == {1};\n\
             always @(posedge i_clk) begin\n    \
                 running <= i_rst ? 1'b0 : 1'b1;\n    \
                 began <= i_rst ? 1'b0 : running;\n    \
                 row <= i_rst | ends_period ? 0 : row + began;\n\
             end",
            range(bits),
            self.last_row(),
        ));
        self.count_periods(harness);
        for (signal, port, width) in [
            ("run_seen", "o_run", 1),
            ("row_seen", "o_row", bits),
            ("ahead_seen", "ahead_r", bits),
            ("ahead_is_last_seen", "ahead_is_last_r", 1),
            ("row_is_last_seen", "row_is_last_r", 1),
        ] {
            see(harness, signal, port, width);
        }
        let last = self.last_row();
        harness.holds("run_seen == running");
        harness.holds("row_seen == row");
        harness.holds(&format!("row <= {last}"));
        harness.holds("running | ~began");
        harness.holds("began | row == 0");
        // The counter is a clock ahead.
        harness.holds(&format!("ahead_seen == (~began | ends_period ? 0 : row + {bits}'d1)"));
        harness.holds(&format!("ahead_is_last_seen == (ahead_seen == {last})"));
        harness.holds(&format!("row_is_last_seen == (row == {last})"));
        self.follow_words(harness);
    }

    fn count_periods(&self, harness: &mut Harness) {
        see(harness, "first_seen", "first_r", 1);
        harness.holds("first_seen == first");
        if self.periods == 1 {
            harness.lines("wire first = 1'b1;\nwire ends_frame = ends_period;");
            return;
        }
        let bits = bits_of(self.periods - 1);
        let last = constant(bits, u128::from(self.periods - 1));
        harness.lines(&format!(
            "reg {0}period;\n\
             reg last_before;\n\
             wire first = period == 0;\n\
             wire ends_frame = ends_period & period == {last};\n\
             always @(posedge i_clk) begin\n    \
                 period <= i_rst | ends_frame ? 0 : period + ends_period;\n    \
                 last_before <= i_rst ? 1'b0 : period == {last};\n\
             end",
            range(bits),
        ));
        see(harness, "period_seen", "period_r", bits);
        see(harness, "period_is_last_seen", "period_is_last_r", 1);
        harness.holds(&format!("period <= {last}"));
        harness.holds("began | period == 0");
        // The design counts up to all ones, from where these are as many code periods.
        let first = (1u128 << bits) - u128::from(self.periods);
        harness.lines(&format!(
            "wire {}period_in_design = period + {};",
            range(bits),
            constant(bits, first)
        ));
        harness.holds("period_seen == period_in_design");
        harness.holds("period_is_last_seen == last_before");
        harness.holds(&format!("row == 0 | last_before == (period == {last})"));
    }

    /// What comes to the memories with a word, and behind it.
    fn follow_words(&self, harness: &mut Harness) {
        let bits = self.row_bits();
        harness.lines(&format!(
            "// The same of the words before it.\n\
             reg [{0}:0] rows_before;\n\
             reg [5:1] firsts;\n\
             always @(posedge i_clk) begin\n    \
                 rows_before <= i_rst ? 0 : {{rows_before, row}};\n    \
                 firsts <= i_rst ? 5'h1f : {{firsts, first}};\n\
             end",
            CLOCKS_TO_WRITE * bits - 1
        ));
        for clocks in 1..=CLOCKS_TO_WRITE {
            let port = match clocks {
                CLOCKS_TO_WRITE => "o_write_row".to_owned(),
                _ => format!("row_before_{}_r", clocks - 1),
            };
            let signal = format!("row_{clocks}_seen");
            see(harness, &signal, &port, bits);
            harness.holds(&format!("{signal} == {}", self.row_before(clocks)));
        }
        see(harness, "firsts_seen", "first_before_r", 5);
        harness.holds("firsts_seen == firsts");
        let come = (!self.takes_turns).then_some(("o_come_first", 2));
        for (port, clocks) in come.into_iter().chain([("o_held_first", 3), ("o_added_first", 5)]) {
            let signal = format!("{}_seen", &port[2..]);
            see(harness, &signal, port, 1);
            harness.holds(&format!("{signal} == firsts[{clocks}]"));
        }
    }

    /// Rows of all detectors.
    fn beats(&self) -> u64 {
        self.rows * self.detectors
    }

    /// Two memories: a frame is read while the next one counts.
    fn read(&self, harness: &mut Harness) {
        let all = self.beats();
        let bits = bits_of(all + u64::from(CLOCKS_TO_ROW) + 1);
        let all = constant(bits, u128::from(all));
        harness.lines(&format!(
            "// Rows of the frame that is read that are still to be taken, and clocks until the first stands.\n\
             reg [{top}:0] left;\n\
             reg [2:0] pause;\n\
             reg half;\n\
             reg [6:1] halves;\n\
             reg lost;\n\
             wire stands = left != 0 & pause == 0;\n\
             wire taken = stands & m_axis_tready;\n\
             wire free = left == 0 | (left == 1 & taken);\n\
             wire is_read = ends_frame & free;\n\
             always @(posedge i_clk) begin\n    \
                 left <= i_rst ? 0 : is_read ? {all} : left - taken;\n    \
                 pause <= i_rst ? 0 : is_read ? 3'd{CLOCKS_TO_ROW} : pause - (pause != 0);\n    \
                 half <= i_rst ? 1'b0 : half ^ is_read;\n    \
                 halves <= i_rst ? 0 : {{halves, half}};\n    \
                 lost <= i_rst ? 1'b0 : lost | (ends_frame & ~free);\n\
             end",
            top = bits - 1,
        ));
        harness.reaches("ends_frame & ~free");
        harness.holds("m_axis_tvalid == stands");
        harness.holds("~stands | m_axis_tlast == (left == 1)");
        harness.holds("o_overrun == lost");
        harness.holds(&format!("left <= {all} & (pause == 0 | left == {all})"));
        harness.holds(&format!("pause <= {CLOCKS_TO_ROW}"));
        see(harness, "half_seen", "o_half", 1);
        see(harness, "halves_seen", "half_before_r", 6);
        harness.holds("half_seen == half");
        harness.holds("halves_seen == halves");
        for (port, clocks) in [("o_come_half", 2), ("o_held_half", 3), ("o_write_half", 6)] {
            let signal = format!("{}_seen", &port[2..]);
            see(harness, &signal, port, 1);
            harness.holds(&format!("{signal} == halves[{clocks}]"));
        }
        self.address(bits, &all, harness);
        self.follow_rows(&all, harness);
    }

    /// The row that the reader asks for.
    fn address(&self, bits: u32, all: &str, harness: &mut Harness) {
        harness.lines(&format!(
            "// The row of the frame that is asked for, counted through all detectors.\n\
             wire [{0}:0] asked = {all} - left + {bits}'d{CLOCKS_TO_ROW} - pause;\n\
             wire asks = left != 0 & asked < {all};",
            bits - 1
        ));
        see(harness, "room_seen", "room_r", 1);
        see(harness, "reads_seen", "reads_r", 1);
        see(harness, "read_row_seen", "o_read_row", self.row_bits());
        see(harness, "read_is_last_seen", "read_is_last_r", 1);
        harness.holds("room_seen == ~stands");
        harness.holds("reads_seen == asks");
        harness.holds("asks | (read_row_seen == 0 & ~read_is_last_seen)");
        if self.detectors > 1 {
            see(harness, "detector_seen", "detector_r", self.detectors as u32);
            harness.holds("asks | detector_seen == 1");
        }
        for d in 0..self.detectors {
            let first = d * self.rows;
            let (last, end) = (first + self.rows - 1, first + self.rows);
            let other = format!("~asks | asked < {first} | asked >= {end}");
            harness.holds(&format!("{other} | read_row_seen == asked - {first}"));
            harness.holds(&format!("{other} | read_is_last_seen == (asked == {last})"));
            if self.detectors > 1 {
                harness.holds(&format!("{other} | detector_seen == {}", 1u64 << d));
            }
        }
    }

    /// Rows on their way out of the memories.
    fn follow_rows(&self, all: &str, harness: &mut Harness) {
        see(harness, "out_seen", "out_r", 3);
        see(harness, "last_out_seen", "last_out_r", 3);
        for stage in 0..3u32 {
            harness.lines(&format!(
                "wire flies_{stage} = left != 0 & pause <= {} & asked - {} < {all};",
                CLOCKS_TO_ROW - 1 - stage,
                stage + 1
            ));
            harness.holds(&format!("out_seen[{stage}] == flies_{stage}"));
            let is_last = format!("flies_{stage} & asked - {} == {all} - 1", stage + 1);
            harness.holds(&format!("last_out_seen[{stage}] == ({is_last})"));
            if self.detectors == 1 {
                continue;
            }
            let signal = format!("detector_{stage}_seen");
            let port = match stage {
                2 => "o_read_detector".to_owned(),
                _ => format!("detector_out_{stage}_r"),
            };
            see(harness, &signal, &port, self.detectors as u32);
            for d in 0..self.detectors {
                let (first, end) = (d * self.rows + u64::from(stage) + 1, (d + 1) * self.rows);
                let end = end + u64::from(stage) + 1;
                harness.holds(&format!(
                    "~flies_{stage} | asked < {first} | asked >= {end} | {signal} == {}",
                    1u64 << d
                ));
            }
        }
        see(harness, "go_seen", "o_go", 1);
        see(harness, "shows_seen", "o_shows", 1);
        harness.holds("go_seen == (~stands | m_axis_tready)");
        harness.holds("shows_seen == (go_seen & flies_2)");
    }

    /// One memory: rows leave in the first code period of the next frame.
    fn send(&self, harness: &mut Harness) {
        let came = self.row_before(CLOCKS_TO_COME);
        let last = self.last_row();
        harness.lines(&format!(
            "// A whole frame is in the memory; its rows come {CLOCKS_TO_COME} clocks behind the words that find them.\n\
             reg follows;\n\
             reg [{CLOCKS_TO_COME}:1] wholes;\n\
             reg stands;\n\
             reg is_last;\n\
             reg lost;\n\
             wire comes = wholes[{CLOCKS_TO_COME}];\n\
             wire free = ~stands | m_axis_tready;\n\
             always @(posedge i_clk) begin\n    \
                 follows <= i_rst ? 1'b0 : follows | ends_frame;\n    \
                 wholes <= i_rst ? 0 : {{wholes, follows & first}};\n    \
                 stands <= i_rst ? 1'b0 : comes | ~free;\n    \
                 is_last <= i_rst ? 1'b0 : comes & free ? {came} == {last} : is_last;\n    \
                 lost <= i_rst ? 1'b0 : lost | (comes & ~free);\n\
             end",
        ));
        harness.reaches("comes & ~free");
        harness.holds("m_axis_tvalid == stands");
        harness.holds("m_axis_tlast == is_last");
        harness.holds("o_overrun == lost");
        for (signal, port, width) in [
            ("shows_seen", "o_shows", 1),
            ("room_seen", "room_r", 1),
            ("follows_seen", "follows_r", 1),
            ("wholes_seen", "whole_before_r", CLOCKS_TO_COME),
            ("lasts_seen", "last_before_r", CLOCKS_TO_COME),
        ] {
            see(harness, signal, port, width);
        }
        harness.holds("shows_seen == (comes & free)");
        harness.holds("room_seen == ~stands");
        harness.holds("follows_seen == follows");
        harness.holds("wholes_seen == wholes");
        for clocks in 1..=CLOCKS_TO_COME {
            let row = self.row_before(clocks);
            harness.holds(&format!("lasts_seen[{}] == ({row} == {last})", clocks - 1));
        }
    }
}

/// Makes a port or a register of the control readable.
fn see(harness: &mut Harness, signal: &str, port: &str, width: u32) {
    harness.see(signal, &format!("control.{port}"), width);
}
