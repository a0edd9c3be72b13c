//! What the generators of codes have to give.

use std::fmt::Write as _;

use super::harness::{Harness, constant, range};
use crate::code::{Code, Generator, Lfsr};
use crate::rtl::back::Prefix;
use crate::sensor::interface::Interface;

/// Specification of a code that starts with its chip `start`: a module `name`
/// with `chip` and `epoch`, which goes on with `advance` and starts again with
/// `load`.
pub(super) fn module(name: &str, code: &Code, start: u64) -> String {
    let depth = code.interleave;
    let mut state = match &code.generator {
        Generator::MSequence(lfsr) => lfsrs(&[("u", lfsr)], start >> depth),
        Generator::Gold { u, v } => lfsrs(&[("u", u), ("v", v)], start >> depth),
        Generator::Square => table(&[1, 0], start >> depth),
        Generator::Chips(chips) => table(chips, start >> depth),
    };
    if depth > 0 {
        state.interleave(depth, start & ((1 << depth) - 1));
    }
    state.text(name)
}

/// A register of the specification.
struct Register {
    name: &'static str,
    width: u32,
    first: u128,
    next: String,
    advance: &'static str,
}

/// Registers, chip and epoch of a code.
struct State {
    registers: Vec<Register>,
    chip: String,
    epoch: String,
    more: String,
}

/// One or two LFSRs, advanced by `start` chips.
fn lfsrs(lfsrs: &[(&'static str, &Lfsr)], start: u64) -> State {
    let mut more = String::new();
    let registers: Vec<Register> = lfsrs
        .iter()
        .map(|&(name, lfsr)| {
            let _ = writeln!(more, "    always @* assert ({name} != 0);");
            Register {
                name,
                width: lfsr.degree,
                first: state_at(lfsr, start),
                next: format!("{{{}, {name}[{}:1]}}", recurrence(name, lfsr), lfsr.degree - 1),
                advance: "advance",
            }
        })
        .collect();
    let chips: Vec<String> = registers.iter().map(|r| format!("{}[0]", r.name)).collect();
    State { chip: chips.join(" ^ "), epoch: is_first(&registers[0]), registers, more }
}

/// c[t + n] from c[t + n - e] over the exponents e > 0; bit i holds c[t + i].
fn recurrence(name: &str, lfsr: &Lfsr) -> String {
    let exponents = lfsr.exponents.iter().filter(|&&e| e > 0);
    let terms: Vec<String> = exponents.map(|e| format!("{name}[{}]", lfsr.degree - e)).collect();
    terms.join(" ^ ")
}

/// The first `degree` chips after `start`, the earliest in bit 0.
fn state_at(lfsr: &Lfsr, start: u64) -> u128 {
    let chips = lfsr.advanced(start).seed;
    chips.iter().rev().fold(0, |state, &chip| state << 1 | u128::from(chip))
}

/// Chips by their index.
fn table(chips: &[u8], start: u64) -> State {
    let last = chips.len() as u128 - 1;
    let width = (u128::BITS - last.leading_zeros()).max(1);
    let bits: String = chips.iter().rev().map(|chip| chip.to_string()).collect();
    let register = Register {
        name: "index",
        width,
        first: u128::from(start),
        next: format!("index == {last} ? {width}'d0 : index + 1'b1"),
        advance: "advance",
    };
    State {
        chip: "chips[index]".to_owned(),
        epoch: is_first(&register),
        registers: vec![register],
        more: format!(
            "    wire [{last}:0] chips = {}'b{bits};\n    always @* assert (index <= {last});\n",
            chips.len()
        ),
    }
}

fn is_first(register: &Register) -> String {
    format!("{} == {}", register.name, constant(register.width, register.first))
}

impl State {
    /// Every chip 2^depth times, every odd one inverted (eq. 23).
    fn interleave(&mut self, depth: u32, first: u64) {
        for register in &mut self.registers {
            register.advance = "advance & (&repetition)";
        }
        let repetition = Register {
            name: "repetition",
            width: depth,
            first: u128::from(first),
            next: "repetition + 1'b1".to_owned(),
            advance: "advance",
        };
        self.chip = format!("({}) ^ repetition[0]", self.chip);
        self.epoch = format!("({}) & ({})", self.epoch, is_first(&repetition));
        self.registers.push(repetition);
    }

    fn text(&self, name: &str) -> String {
        let mut text = format!(
            "module {name} (\n    input wire i_clk,\n    input wire i_rst,\n    input wire advance,\n    \
             input wire load,\n    output wire chip,\n    output wire epoch\n);\n"
        );
        for Register { name, width, .. } in &self.registers {
            let _ = writeln!(text, "    reg {}{name};", range(*width));
        }
        text += &self.more;
        let _ = writeln!(text, "    assign chip = {};", self.chip);
        let _ = writeln!(text, "    assign epoch = {};", self.epoch);
        text += "    always @(posedge i_clk) begin\n";
        for register in &self.registers {
            let Register { name, width, first, next, advance } = register;
            let first = constant(*width, *first);
            let _ = writeln!(
                text,
                "        if (i_rst | load) {name} <= {first};\n        else if ({advance}) {name} <= {next};"
            );
        }
        text + "    end\nendmodule\n"
    }
}

/// The lasers show their codes, and the epoch is where the reference's starts.
pub(super) fn harness(interface: &Interface, prefix: &Prefix) -> (Harness, String) {
    let mut harness = Harness::new(
        interface,
        "codes",
        "After reset every laser shows its source's code, chip by chip, and o_epoch the first chip of\n\
         the reference's. No LFSR reaches zero. (That an LFSR comes back to its first state after\n\
         2^n - 1 chips and not before is a matter of its polynomial, not of the design.)",
    );
    let mut modules = String::new();
    let sources = interface.source_codes.len() as u32;
    harness.line(&format!("wire {}chips;", range(sources)));
    for (m, code) in interface.source_codes.iter().enumerate() {
        let name = prefix.of(&format!("code_of_source_{m}"));
        modules += &module(&name, code, 0);
        let chip = if sources == 1 { "chips".to_owned() } else { format!("chips[{m}]") };
        harness.line(&instance(&name, "1'b1", "1'b0", &chip, ""));
    }
    let name = of_reference(prefix);
    modules += &module(&name, &interface.reference_codes[0], 0);
    harness.line("wire epoch;");
    harness.line(&instance(&name, "1'b1", "1'b0", "", "epoch"));
    harness.line(&format!("reg {}laser;", range(sources)));
    harness.lines(
        "reg first;\n\
         always @(posedge i_clk) begin\n    \
             laser <= i_rst ? 0 : chips;\n    \
             first <= i_rst ? 0 : epoch;\n\
         end\n\
         always @* assert (o_laser == laser);\n\
         always @* assert (o_epoch == first);",
    );
    harness.reaches("o_epoch & ~i_rst");
    if interface.realigns() && interface.histogram.is_none() {
        harness.see("epoch_seen", "controller.i_epoch", 1);
        harness.line("always @* assert (epoch_seen == epoch);");
    }
    (harness, modules)
}

/// The module with the reference's code.
pub(super) fn of_reference(prefix: &Prefix) -> String {
    prefix.of("code_of_reference")
}

/// An instance of a code's specification, `spec_<module>`.
pub(super) fn instance(module: &str, advance: &str, load: &str, chip: &str, epoch: &str) -> String {
    format!(
        "{module} spec_{module} (.i_clk(i_clk), .i_rst(i_rst), .advance({advance}), .load({load}), \
         .chip({chip}), .epoch({epoch}));"
    )
}
