//! What reference each sample has to get.

use super::codes;
use super::harness::{Harness, numbered, range};
use crate::rtl::back::Prefix;
use crate::sensor::interface::Interface;

/// Each sample is counted by the chip that the phase step gives it.
pub(super) fn harness(interface: &Interface, prefix: &Prefix) -> (Harness, String) {
    let mut harness = Harness::new(
        interface,
        "reference",
        "Each sample's reference is the chip of the detector's code that the delay of its phase step\n\
         gives it: in step k sample l of chip n has chip floor((n S + l - k) / S). The delay is a\n\
         number here; the reference's generator stands still, and chips come again, as it grows.",
    );
    harness.see("ends", "controller.o_last_chip", 1);
    if interface.realigns() {
        harness.see("start", "controller.o_start", 1);
    } else {
        harness.line("wire start = 1'b0;");
    }
    let delay = Delay::of(interface);
    delay.declare(&mut harness);
    let mut modules = String::new();
    let detectors = interface.reference_codes.len() as u32;
    for d in 0..detectors {
        let path = format!("{}.stepper.o_window", numbered("channel", d, detectors));
        harness.see(&format!("window_{d}"), &path, delay.window());
        let code = prefix.of(&format!("code_of_detector_{d}"));
        modules += &delay.detector(interface, d, &code, &mut harness);
    }
    harness.reaches("ends & ~i_rst");
    (harness, modules)
}

/// How the delay grows.
struct Delay {
    /// Samples per chip.
    lanes: u32,
    parallel: u32,
    /// Samples of the first step's delay beside whole chips.
    first: u32,
}

impl Delay {
    fn of(interface: &Interface) -> Delay {
        Delay {
            lanes: interface.lanes(),
            parallel: interface.parallel(),
            first: (interface.timing.scan.first_step % u64::from(interface.lanes())) as u32,
        }
    }

    /// Samples of reference that a group needs.
    fn window(&self) -> u32 {
        self.lanes + self.parallel - 1
    }

    /// Chips that the reference goes back by, at most, when the delay grows.
    fn replayed(&self) -> u32 {
        self.parallel.div_ceil(self.lanes) - 1
    }

    fn grows_by_samples(&self) -> bool {
        !self.parallel.is_multiple_of(self.lanes)
    }

    fn bits(&self) -> u32 {
        self.lanes.trailing_zeros()
    }

    /// Samples between the first lane of a group's first step and sample
    /// `sample` of the window: whole chips back, and the place in the chip.
    fn place(&self, sample: u32) -> (u32, u32) {
        let back = self.parallel - 1;
        let chips = back.saturating_sub(sample).div_ceil(self.lanes);
        (chips, sample + chips * self.lanes - back)
    }

    /// The chip of a sample among those kept: one of two where the delay decides.
    fn chosen(&self, d: u32, sample: u32) -> String {
        let chip = |back: u32| match self.kept() {
            1 => format!("chips_{d}"),
            _ => format!("chips_{d}[{back}]"),
        };
        // A sample behind the window's first chips lies in the present chip.
        let (back, place) = self.place(sample);
        if self.grows_by_samples() && place + 1 < self.lanes {
            format!("(samples > {place} ? {} : {})", chip(back + 1), chip(back))
        } else {
            let later = !self.grows_by_samples() && place < self.first;
            chip(back + u32::from(later))
        }
    }

    /// Chips that the reference keeps.
    fn kept(&self) -> u32 {
        let oldest = (0..self.window()).map(|sample| {
            let (back, place) = self.place(sample);
            let may_be_later =
                if self.grows_by_samples() { place + 1 < self.lanes } else { place < self.first };
            back + u32::from(may_be_later)
        });
        oldest.max().unwrap_or(0) + 1 + self.replayed()
    }

    /// The delay in samples beside whole chips, and by how many chips it grows.
    fn declare(&self, harness: &mut Harness) {
        let whole = self.parallel / self.lanes;
        if !self.grows_by_samples() {
            harness.line(&format!("wire [7:0] growth = {whole};"));
            return;
        }
        let (bits, rest) = (self.bits(), self.parallel % self.lanes);
        harness.lines(&format!(
            "// Samples of the delay beside whole chips, and the whole chips by which it grows.\n\
             reg {}samples;\n\
             wire wraps = samples >= {};\n\
             wire [7:0] growth = {whole} + wraps;\n\
             always @(posedge i_clk)\n    \
                 if (i_rst | start) samples <= {};\n    \
                 else if (ends) samples <= samples + {bits}'d{rest};",
            range(bits),
            self.lanes - rest,
            self.first
        ));
    }

    /// The reference of a detector, whose code the module `module` has.
    fn detector(
        &self,
        interface: &Interface,
        d: u32,
        module: &str,
        harness: &mut Harness,
    ) -> String {
        let code = &interface.reference_codes[d as usize];
        // Reset stands a clock before a scan's first, a scan's start in it.
        let present = if interface.realigns() { 0 } else { -1 };
        let whole = i128::from(interface.timing.scan.first_step / u64::from(self.lanes));
        let chip_of = |cycle: i128| (cycle - whole).rem_euclid(i128::from(code.len())) as u64;
        let kept = self.kept();
        let first: String = (0..kept)
            .rev()
            .map(|back| code.chips[chip_of(present - i128::from(back)) as usize].to_string())
            .collect();
        harness.lines(&format!(
            "\n// Detector {d}: its code's chips, the present one in bit 0.\n\
             reg {}chips_{d};\nwire next_{d};\nwire waits_{d};",
            range(kept)
        ));
        harness.line(&codes::instance(
            module,
            &format!("~waits_{d}"),
            "start",
            &format!("next_{d}"),
            "",
        ));
        self.replays(d, harness);
        harness.lines(&format!(
            "always @(posedge i_clk)\n    \
                 if (i_rst | start) chips_{d} <= {kept}'b{first};\n    \
                 else if (ends & growth != 0) chips_{d} <= chips_{d} >> (growth - 1);\n    \
                 else chips_{d} <= {{chips_{d}, again_{d}}};\n\
             reg {}expected_{d};",
            range(self.window())
        ));
        harness.line("always @(posedge i_clk) begin");
        for sample in 0..self.window() {
            let bit = if self.window() == 1 { String::new() } else { format!("[{sample}]") };
            harness
                .line(&format!("    expected_{d}{bit} <= i_rst ? 0 : {};", self.chosen(d, sample)));
        }
        harness.line("end");
        harness.line(&format!("always @* assert (window_{d} == expected_{d});"));
        codes::module(module, code, chip_of(present + 1))
    }

    /// The chips that come again after the reference went back.
    fn replays(&self, d: u32, harness: &mut Harness) {
        let replayed = self.replayed();
        if replayed == 0 {
            harness.lines(&format!(
                "assign waits_{d} = ends & growth != 0;\nwire again_{d} = next_{d};"
            ));
            return;
        }
        let top = replayed - 1;
        let bit = if replayed == 1 { String::new() } else { format!("[{top}]") };
        let range = range(replayed);
        harness.lines(&format!(
            "reg {range}saved_{d};\n\
             reg {range}replays_{d};\n\
             wire again_{d} = replays_{d}{bit} ? saved_{d}{bit} : next_{d};\n\
             assign waits_{d} = ends | replays_{d}{bit};\n\
             always @(posedge i_clk)\n    \
                 if (i_rst) begin\n        saved_{d} <= 0;\n        replays_{d} <= 0;\n    end\n    \
                 else begin\n        \
                     saved_{d} <= ends ? chips_{d} << ({replayed} - (growth - 1)) : saved_{d} << 1;\n        \
                     replays_{d} <= start ? 0 : ends ? {{{replayed}{{1'b1}}}} << ({replayed} - (growth - 1)) : replays_{d} << 1;\n    \
                 end"
        ));
    }
}
