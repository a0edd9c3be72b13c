//! What the stream of results has to carry.

use super::harness::{Harness, constant, element, numbered, range};
use crate::sensor::interface::Interface;

/// Every group's counts come once, in order, with `tlast` at a scan's end; what
/// comes too early is dropped whole and flagged.
pub(super) fn harness(interface: &Interface) -> Harness {
    let mut harness = Harness::new(
        interface,
        "stream",
        "The stream carries each group's counts, one per beat, detector 0's steps, then detector 1's, ...,\n\
         each once and in order, with tlast at the scan's last and nowhere else. A group that comes while\n\
         others wait is dropped whole and sets o_overrun, a group with a saturated count, dropped or not,\n\
         o_saturated; both stay until reset. (Counts, and when they come, are arbitrary here.)",
    );
    harness.empty("scan_controller");
    harness.empty("detector_channel");
    let stream = Stream::of(interface);
    stream.inputs(interface, &mut harness);
    stream.groups(&mut harness);
    stream.beats(interface, &mut harness);
    stream.flags(interface, &mut harness);
    harness.reaches("m_axis_tvalid & counted & ~free");
    harness
}

struct Stream {
    detectors: u32,
    parallel: u32,
    last_steps: u32,
}

impl Stream {
    fn of(interface: &Interface) -> Stream {
        Stream {
            detectors: interface.reference_codes.len() as u32,
            parallel: interface.parallel(),
            last_steps: interface.last_group_steps() as u32,
        }
    }

    /// Beats of a group, and of a scan's last.
    fn most(&self) -> u32 {
        self.detectors * self.parallel
    }

    fn least(&self) -> u32 {
        self.detectors * self.last_steps
    }

    fn is_short(&self) -> bool {
        self.last_steps < self.parallel
    }

    /// Counts of a group, which may be anything, and when they come.
    fn inputs(&self, interface: &Interface, harness: &mut Harness) {
        for d in 0..self.detectors {
            let channel = numbered("channel", d, self.detectors);
            let mut cut = |signal: String, port: String, width: u32| {
                harness.free(&signal, width);
                harness.cut(&signal, &format!("{channel}.{port}"), width);
            };
            for q in 0..self.parallel {
                let count = element("o_count", q, self.parallel, interface.count_bits);
                cut(format!("count_{d}_{q}"), count, interface.count_bits);
                if interface.saturates() {
                    let saturated = element("o_clamped", q, self.parallel, 1);
                    cut(format!("clamped_{d}_{q}"), saturated, 1);
                }
            }
            if let Some(total) = interface.total {
                cut(format!("total_{d}"), "o_total".to_owned(), total.bits);
            }
        }
        harness.free("may_come", 1);
        harness.free("may_end", 1);
        // Steps of one chip may end in every clock; others leave one between.
        let spaced = if interface.timing.scan.integration_chips > 1 { " & ~counted" } else { "" };
        harness.lines(&format!(
            "reg counted;\n\
             reg last;\n\
             wire counts = may_come{spaced};\n\
             always @(posedge i_clk) begin\n    \
                 counted <= i_rst ? 0 : counts;\n    \
                 last <= i_rst ? 0 : counts & may_end;\n\
             end"
        ));
        if self.most() > 1 {
            harness.cut("counts", "controller.o_pre_counted", 1);
        }
        harness.cut("counted", "controller.o_counted", 1);
        harness.cut("last", "controller.o_scan_counted", 1);
    }

    /// How many beats of a group are still to be taken.
    fn groups(&self, harness: &mut Harness) {
        let width = u32::BITS - self.most().leading_zeros();
        let beats = |count: u32| constant(width, u128::from(count));
        let beats = match self.is_short() {
            true => format!("last ? {} : {}", beats(self.least()), beats(self.most())),
            false => beats(self.most()),
        };
        harness.lines(&format!(
            "// Beats of the present group that are still to be taken.\n\
             reg {}left;\n\
             reg ends_scan;\n\
             wire taken = left != 0 & m_axis_tready;\n\
             wire free = left == 0 | (left == 1 & taken);\n\
             wire accepted = counted & free;\n\
             always @(posedge i_clk) begin\n    \
                 if (i_rst) left <= 0;\n    \
                 else if (accepted) left <= {beats};\n    \
                 else left <= left - taken;\n    \
                 if (i_rst) ends_scan <= 0;\n    \
                 else if (accepted) ends_scan <= last;\n\
             end\n\
             always @* assert (m_axis_tvalid == (left != 0));\n\
             always @* if (m_axis_tvalid) assert (m_axis_tlast == (ends_scan & left == 1));",
            range(width)
        ));
    }

    /// A count as `m_axis_tdata` has it.
    fn data(&self, interface: &Interface, d: u32, q: u32) -> String {
        let signed_bits = interface.signed_data_bits();
        let fill = signed_bits - interface.count_bits;
        let count = match fill {
            0 => format!("count_{d}_{q}"),
            _ => format!(
                "{{{{{fill}{{count_{d}_{q}[{}]}}}}, count_{d}_{q}}}",
                interface.count_bits - 1
            ),
        };
        let Some(total) = interface.total else {
            return count;
        };
        match interface.tdata_bits - signed_bits - total.bits {
            0 => format!("{{total_{d}, {count}}}"),
            zeros => format!("{{{zeros}'d0, total_{d}, {count}}}"),
        }
    }

    /// What the beats hold.
    fn beats(&self, interface: &Interface, harness: &mut Harness) {
        let places = self.most();
        let bits = interface.tdata_bits;
        harness.lines(&format!(
            "// The group's results, the one on offer first.\nreg {}{};",
            range(bits),
            (0..places).map(|place| format!("beat_{place}")).collect::<Vec<_>>().join(", ")
        ));
        harness.line("always @(posedge i_clk) begin");
        for place in 0..places {
            let of = |steps: u32| (place / steps, place % steps);
            let (d, q) = of(self.parallel);
            let whole = self.data(interface, d, q);
            let loaded = match of(self.last_steps) {
                _ if !self.is_short() || place >= self.least() => whole,
                (d, q) => format!("last ? {} : {whole}", self.data(interface, d, q)),
            };
            let next = match place + 1 {
                next if next == places => "0".to_owned(),
                next => format!("beat_{next}"),
            };
            harness.line(&format!(
                "    beat_{place} <= i_rst ? 0 : accepted ? ({loaded}) : taken ? {next} : beat_{place};"
            ));
        }
        harness.line("end");
        harness.line("always @* if (m_axis_tvalid) assert (m_axis_tdata == beat_0);");
    }

    /// What stays until reset.
    fn flags(&self, interface: &Interface, harness: &mut Harness) {
        harness.lines(
            "reg lost;\n\
             always @(posedge i_clk)\n    \
                 lost <= i_rst ? 0 : (lost | (counted & ~free));\n\
             always @* assert (o_overrun == lost);",
        );
        if !interface.saturates() {
            return;
        }
        let of = |steps: u32| -> String {
            let all = (0..self.detectors).flat_map(|d| (0..steps).map(move |q| (d, q)));
            let all: Vec<String> = all.map(|(d, q)| format!("clamped_{d}_{q}")).collect();
            all.join(" | ")
        };
        harness.lines(&format!(
            "reg saturated;\n\
             wire clamps = last ? {} : {};\n\
             always @(posedge i_clk)\n    \
                 saturated <= i_rst ? 0 : (saturated | (counted & clamps));\n\
             always @* assert (o_saturated == saturated);",
            of(self.last_steps),
            of(self.parallel)
        ));
    }
}
