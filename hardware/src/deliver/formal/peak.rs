//! What the peak detector has to find.

use super::harness::{Engine, Harness, constant, element, numbered, range};
use crate::sensor::interface::Interface;
use crate::sensor::peak::PeakPlan;

/// A scan's largest count, the first of equal ones, and its phase step.
pub(super) fn harness(interface: &Interface, plan: &PeakPlan) -> Harness {
    let mut harness = Harness::new(
        interface,
        "peak",
        "After a scan's last counts o_peak_valid is high for one clock, and from then on o_peak_count and\n\
         o_peak_step are the scan's largest count and its phase step, the first of equal ones, steady\n\
         until the next scan's. (Counts are arbitrary here; they come no faster than the design's.) This\n\
         is not proven: it is searched for a counterexample through 30 clocks after reset. That the ports\n\
         stay steady is proven, in `axis`.",
    )
    .engine(Engine::Bounded(30));
    harness.empty("scan_controller");
    harness.empty("detector_channel");
    let peak = Peak {
        plan: *plan,
        detectors: interface.reference_codes.len() as u32,
        settling: interface.clocks_of_counting(),
    };
    peak.inputs(&mut harness);
    peak.turns(&mut harness);
    harness.reaches("o_peak_valid");
    for d in 0..peak.detectors {
        peak.maximum(d, &mut harness);
    }
    harness
}

struct Peak {
    plan: PeakPlan,
    detectors: u32,
    /// Clocks before `counted` in which counts change one after another.
    settling: u32,
}

impl Peak {
    /// Clock after `counted` in which a step's comparison is done.
    fn compared(&self, step: u32) -> u32 {
        step * self.plan.clocks_per_count() + self.plan.clocks_to_compare() + 1
    }

    /// Clocks between two groups at least.
    fn spacing(&self) -> u32 {
        self.plan.least_chips as u32
    }

    fn timer_bits(&self) -> u32 {
        let most = self.spacing().max(self.compared(self.plan.parallel)) + 3;
        u32::BITS - most.leading_zeros()
    }

    /// Counts that stand still from group to group, and when they come.
    fn inputs(&self, harness: &mut Harness) {
        let (bits, settling) = (self.timer_bits(), self.settling);
        harness.free("may_come", 1);
        harness.free("may_end", 1);
        harness.lines(&format!(
            "// Clocks since a group began to come; its counts settle for {settling} clocks.\n\
             reg {0}since;\n\
             reg busy;\n\
             reg ends;\n\
             wire comes = may_come & (~busy | since >= {1});\n\
             wire counted = busy & since == {settling};\n\
             wire last = counted & ends;\n\
             always @(posedge i_clk) begin\n    \
                 if (i_rst) busy <= 0;\n    \
                 else if (comes) busy <= 1;\n    \
                 if (i_rst) since <= 0;\n    \
                 else if (comes) since <= 1;\n    \
                 else if (busy & ~&since) since <= since + 1'b1;\n    \
                 if (i_rst) ends <= 0;\n    \
                 else if (comes) ends <= may_end;\n\
             end",
            range(bits),
            self.spacing()
        ));
        harness.cut("counted", "controller.o_counted", 1);
        harness.cut("last", "controller.o_scan_counted", 1);
        for d in 0..self.detectors {
            let channel = numbered("channel", d, self.detectors);
            for q in 0..self.plan.parallel {
                let width = self.plan.count_bits;
                let count = element("o_count", q, self.plan.parallel, width);
                harness.free(&format!("any_{d}_{q}"), width);
                harness.lines(&format!(
                    "reg {0}held_{d}_{q};\n\
                     wire signed {0}count_{d}_{q} = busy & since <= {settling} ? any_{d}_{q} : held_{d}_{q};\n\
                     always @(posedge i_clk) held_{d}_{q} <= i_rst ? 0 : count_{d}_{q};",
                    range(width)
                ));
                harness.cut(&format!("count_{d}_{q}"), &format!("{channel}.{count}"), width);
            }
        }
    }

    /// When each of a group's counts has been compared, and its phase step.
    fn turns(&self, harness: &mut Harness) {
        let PeakPlan { step_bits, first_step, parallel, last_steps, wraps_after, .. } = self.plan;
        let turn = |step: u32| match step < last_steps {
            true => format!("came[{}]", self.compared(step)),
            false => format!("(came[{0}] & ~ended[{0}])", self.compared(step)),
        };
        let turns: Vec<String> = (0..parallel).map(turn).collect();
        let (line, short) = (self.compared(parallel - 1), self.compared(last_steps - 1));
        harness.lines(&format!(
            "// Groups that came 1, 2, ... clocks ago, and whether they end a scan.\n\
             reg [{line}:1] came;\n\
             reg [{line}:1] ended;\n\
             always @(posedge i_clk) begin\n    \
                 came <= i_rst ? 0 : {{came, counted}};\n    \
                 ended <= i_rst ? 0 : {{ended, last}};\n\
             end"
        ));
        let first = constant(step_bits, u128::from(first_step));
        let next = match wraps_after {
            Some(last) => format!("k == {} ? 0 : k + 1'b1", constant(step_bits, u128::from(last))),
            None => "k + 1'b1".to_owned(),
        };
        harness.lines(&format!(
            "wire turn = {0};\n\
             wire last_turn = ended[{short}];\n\
             reg first;\n\
             reg {1}k;\n\
             reg [1:0] done;\n\
             always @(posedge i_clk) begin\n    \
                 if (i_rst | last_turn) first <= 1;\n    \
                 else if (turn) first <= 0;\n    \
                 if (i_rst | last_turn) k <= {first};\n    \
                 else if (turn) k <= {next};\n    \
                 done <= i_rst ? 0 : {{done, last_turn}};\n\
             end\n\
             always @* assert (o_peak_valid == done[1]);",
            turns.join(" | "),
            range(step_bits),
        ));
    }

    /// A detector's largest count so far, and at the end of a scan.
    fn maximum(&self, d: u32, harness: &mut Harness) {
        let PeakPlan { step_bits, count_bits, parallel, .. } = self.plan;
        let choosing = self.plan.choosing_clocks;
        for q in 0..parallel {
            for clock in 1..=choosing {
                let before = match clock {
                    1 => format!("count_{d}_{q}"),
                    _ => format!("count_{d}_{q}_{}", clock - 1),
                };
                harness.lines(&format!(
                    "reg signed {0}count_{d}_{q}_{clock};\n\
                     always @(posedge i_clk) count_{d}_{q}_{clock} <= i_rst ? 0 : {before};",
                    range(count_bits)
                ));
            }
        }
        let chosen = |q: u32| match choosing {
            0 => format!("count_{d}_{q}"),
            _ => format!("count_{d}_{q}_{choosing}"),
        };
        let present = (1..parallel).fold(chosen(0), |rest, q| {
            format!("came[{}] ? {} : ({rest})", self.compared(q), chosen(q))
        });
        harness.lines(&format!(
            "wire signed {count}present_{d} = {present};\n\
             reg signed {count}largest_{d};\n\
             reg {step}best_{d};\n\
             reg {count}peak_{d};\n\
             reg {step}peak_step_{d};\n\
             wire greater_{d} = first | present_{d} > largest_{d};\n\
             always @(posedge i_clk) begin\n    \
                 if (i_rst) largest_{d} <= 0;\n    \
                 else if (turn & greater_{d}) largest_{d} <= present_{d};\n    \
                 if (i_rst) best_{d} <= 0;\n    \
                 else if (turn & greater_{d}) best_{d} <= k;\n    \
                 if (i_rst) peak_{d} <= 0;\n    \
                 else if (done[0]) peak_{d} <= largest_{d};\n    \
                 if (i_rst) peak_step_{d} <= 0;\n    \
                 else if (done[0]) peak_step_{d} <= best_{d};\n\
             end\n\
             always @* assert (o_peak_count[{c_top}:{c_low}] == peak_{d});\n\
             always @* assert (o_peak_step[{s_top}:{s_low}] == peak_step_{d});",
            count = range(count_bits),
            step = range(step_bits),
            c_top = (d + 1) * count_bits - 1,
            c_low = d * count_bits,
            s_top = (d + 1) * step_bits - 1,
            s_low = d * step_bits,
        ));
    }
}
