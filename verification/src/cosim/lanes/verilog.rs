//! A netlist as Verilog in which every net is a word of lanes, and its statements in C++ for
//! [`super::vectors`].
//!
//! One `always` block computes the next clock of all lanes, gate by gate, and writes
//! the registers in an order in which each is read before it is written; where there
//! is no such order the old value is kept. Registers are ports, so that the testbench can
//! set and read them. The block runs at both edges of its clock, so that a clock is one
//! evaluation and not two.
//!
//! Two things keep it fast, and change nothing. While no lane is in reset, the design
//! with `i_rst` tied to 0 is clocked instead: it has an `always` block and a clock of its
//! own, `i_clk`, beside [`RESET_CLOCK`] (in one block, behind a condition, Verilator
//! would keep every gate's value in memory: half the speed). And what only feeds
//! registers behind one enable is computed only where some lane has that enable.

use std::collections::HashMap;
use std::fmt::Write as _;

use super::netlist::{BitNet, Driver, Function, GateNetlist, LogicGate};

/// Lanes of a word.
pub const LANES: usize = 64;
/// Name of the module.
pub(super) const MODULE: &str = "lanes";
/// Clock of the lanes while none of them is in reset.
pub(super) const CLOCK: &str = "i_clk";
/// Clock of the lanes while some of them are, in a module that has a net for that.
pub(super) const RESET_CLOCK: &str = "i_clk_in_reset";

/// Writes the module. `reset` is the net of `i_rst`, if lanes are clocked apart where
/// it is low.
pub(super) fn module(netlist: &GateNetlist, reset: Option<BitNet>) -> String {
    let mut text = format!("`default_nettype none\nmodule {MODULE} (\n    input wire {CLOCK}");
    if reset.is_some() {
        let _ = write!(text, ",\n    input wire {RESET_CLOCK}");
    }
    let inputs = netlist.inputs.iter().flat_map(|port| &port.nets);
    for i in 0..inputs.count() {
        let _ = write!(text, ",\n    input wire [63:0] i{i}");
    }
    for i in 0..netlist.registers.len() {
        let _ = write!(text, ",\n    output reg [63:0] q{i}");
    }
    for i in outputs_of_no_register(netlist) {
        let _ = write!(text, ",\n    output reg [63:0] y{i}");
    }
    text += "\n);\n";
    let shown = outputs_text(netlist, Language::Verilog);
    let mut clocked = |clock: &str, netlist: &GateNetlist, prefix: &str| {
        let branch = Branch::write(netlist, prefix, Language::Verilog);
        for name in &branch.variables {
            let _ = writeln!(text, "    reg [63:0] {name};");
        }
        let _ = writeln!(
            text,
            "    always @(posedge {clock} or negedge {clock}) begin\n{}{shown}    end",
            branch.text
        );
    };
    match reset {
        None => clocked(CLOCK, netlist, "a"),
        Some(reset) => {
            clocked(RESET_CLOCK, netlist, "a");
            let tied = netlist.with_tied(&HashMap::from([(reset, false)]));
            clocked(CLOCK, &tied, "b");
        }
    }
    text + "endmodule\n`default_nettype wire\n"
}

/// Numbers of the outputs' bits that no register holds.
pub(super) fn outputs_of_no_register(netlist: &GateNetlist) -> impl Iterator<Item = usize> {
    let drivers = netlist.drivers();
    let is_register = move |net: BitNet| matches!(drivers[net.index()], Driver::Register(_));
    output_nets(netlist).enumerate().filter(move |&(_, net)| !is_register(net)).map(|(i, _)| i)
}

/// What the statements are written in. Assignments and operators are the same in both.
#[derive(Debug, Clone, Copy)]
pub(super) enum Language {
    /// Nets of 64 lanes.
    Verilog,
    /// Nets of as many as `Plane` has.
    Cpp,
}

impl Language {
    fn constant(self, value: bool) -> &'static str {
        match (self, value) {
            (Language::Verilog, false) => "64'd0",
            (Language::Verilog, true) => "{64{1'b1}}",
            (Language::Cpp, false) => "Plane{}",
            (Language::Cpp, true) => "~Plane{}",
        }
    }

    /// The start and the end of what is done where a word has a lane.
    fn where_any(self, word: &str) -> (String, &'static str) {
        match self {
            Language::Verilog => (format!("    if (({word}) != 64'd0) begin\n"), "    end\n"),
            Language::Cpp => (format!("    if (any({word})) {{\n"), "    }\n"),
        }
    }
}

/// All bits of the outputs, port after port.
pub(super) fn output_nets(netlist: &GateNetlist) -> impl Iterator<Item = BitNet> {
    netlist.outputs.iter().flat_map(|port| port.nets.iter().copied())
}

/// What the nets that no gate drives are called.
struct Names {
    inputs: HashMap<BitNet, usize>,
    drivers: Vec<Driver>,
    language: Language,
}

impl Names {
    fn of(netlist: &GateNetlist, language: Language) -> Names {
        let inputs = netlist.inputs.iter().flat_map(|port| &port.nets);
        Names {
            inputs: inputs.enumerate().map(|(i, &net)| (net, i)).collect(),
            drivers: netlist.drivers(),
            language,
        }
    }

    /// A constant or an input; what nobody drives is 0.
    fn outside(&self, net: BitNet) -> String {
        match (net.as_constant(), self.inputs.get(&net)) {
            (Some(true), _) => self.language.constant(true).to_owned(),
            (None, Some(input)) => format!("i{input}"),
            _ => self.language.constant(false).to_owned(),
        }
    }
}

/// The gates' right-hand side, of inputs with these names.
fn expression(language: Language, function: Function, [a, b, s]: &[String; 3]) -> String {
    match function {
        Function::Mux => format!("({s} & {b}) | (~{s} & {a})"),
        Function::Table(table) => match table & 0xf {
            0b0000 => language.constant(false).to_owned(),
            0b1111 => language.constant(true).to_owned(),
            0b1000 => format!("{a} & {b}"),
            0b1110 => format!("{a} | {b}"),
            0b0110 => format!("{a} ^ {b}"),
            0b1001 => format!("~({a} ^ {b})"),
            0b0111 => format!("~({a} & {b})"),
            0b0001 => format!("~({a} | {b})"),
            0b0010 => format!("{a} & ~{b}"),
            0b1011 => format!("{a} | ~{b}"),
            0b0100 => format!("~{a} & {b}"),
            0b1101 => format!("~{a} | {b}"),
            0b0101 => format!("~{a}"),
            0b0011 => format!("~{b}"),
            0b1010 => a.clone(),
            _ => b.clone(),
        },
    }
}

/// Outputs that are no register's, after the registers have their new values.
pub(super) fn outputs_text(netlist: &GateNetlist, language: Language) -> String {
    let names = Names::of(netlist, language);
    let outputs: Vec<BitNet> = output_nets(netlist).collect();
    let value = |net: BitNet, known: &HashMap<BitNet, String>| match names.drivers[net.index()] {
        Driver::Outside => names.outside(net),
        Driver::Register(i) => format!("q{i}"),
        Driver::Gate(_) => known[&net].clone(),
    };
    let mut wanted = vec![false; netlist.nets];
    for net in &outputs {
        wanted[net.index()] = true;
    }
    for gate in netlist.gates.iter().rev() {
        if wanted[gate.output.index()] {
            for net in gate.inputs {
                wanted[net.index()] = true;
            }
        }
    }
    let mut known: HashMap<BitNet, String> = HashMap::new();
    for gate in &netlist.gates {
        if wanted[gate.output.index()] {
            let inputs = gate.inputs.map(|net| value(net, &known));
            let text = format!("({})", expression(language, gate.function, &inputs));
            known.insert(gate.output, text);
        }
    }
    let mut text = String::new();
    for i in outputs_of_no_register(netlist) {
        let _ = writeln!(text, "    y{i} = {};", value(outputs[i], &known));
    }
    text
}

/// Registers that are written together: those behind one enable, or a single one.
struct Unit {
    enable: Option<BitNet>,
    registers: Vec<usize>,
}

/// The statements of one clock.
pub(super) struct Branch {
    pub(super) text: String,
    pub(super) variables: Vec<String>,
}

impl Branch {
    /// Those of a design; its gates' names begin with `prefix`.
    pub(super) fn write(netlist: &GateNetlist, prefix: &str, language: Language) -> Branch {
        let mut writer = Writer::new(netlist, prefix, language);
        let order = writer.order();
        // Once to see which old values are still read, once to keep them.
        writer.write(&order);
        writer.begin_again();
        writer.write(&order);
        Branch { text: writer.text, variables: writer.variables }
    }
}

struct Writer<'a> {
    netlist: &'a GateNetlist,
    prefix: &'a str,
    names: Names,
    units: Vec<Unit>,
    /// For each net, the gates and units that read it.
    readers: Vec<Vec<Reader>>,
    /// For each gate, the only unit that it feeds as data, behind an enable.
    only_for: Vec<Option<usize>>,
    text: String,
    variables: Vec<String>,
    done: Vec<bool>,
    /// Gates of one unit alone, for which all that they share is there.
    prepared: Vec<bool>,
    written: Vec<bool>,
    /// Registers whose old values are read after they are written.
    kept: Vec<bool>,
}

#[derive(Clone, Copy)]
enum Reader {
    Gate(usize),
    /// As data of one of its registers.
    Data(usize),
    /// As enable or reset, or as an output.
    Control(usize),
}

impl<'a> Writer<'a> {
    fn new(netlist: &'a GateNetlist, prefix: &'a str, language: Language) -> Writer<'a> {
        let mut units: Vec<Unit> = Vec::new();
        let mut by_enable: HashMap<BitNet, usize> = HashMap::new();
        let mut unit_of = Vec::with_capacity(netlist.registers.len());
        for (i, register) in netlist.registers.iter().enumerate() {
            let unit = match register.enable {
                Some(enable) => *by_enable.entry(enable).or_insert(units.len()),
                None => units.len(),
            };
            if unit == units.len() {
                units.push(Unit { enable: register.enable, registers: Vec::new() });
            }
            units[unit].registers.push(i);
            unit_of.push(unit);
        }
        let mut readers: Vec<Vec<Reader>> = vec![Vec::new(); netlist.nets];
        for (i, gate) in netlist.gates.iter().enumerate() {
            for net in gate.inputs {
                readers[net.index()].push(Reader::Gate(i));
            }
        }
        for (register, &unit) in netlist.registers.iter().zip(&unit_of) {
            readers[register.d.index()].push(Reader::Data(unit));
            let reset = register.reset.map(|reset| reset.when);
            for net in register.enable.into_iter().chain(reset) {
                readers[net.index()].push(Reader::Control(unit));
            }
        }
        let only_for = only_for(netlist, &units, &readers);
        Writer {
            names: Names::of(netlist, language),
            units,
            readers,
            only_for,
            text: String::new(),
            variables: Vec::new(),
            done: vec![false; netlist.gates.len()],
            prepared: vec![false; netlist.gates.len()],
            written: vec![false; netlist.registers.len()],
            kept: vec![false; netlist.registers.len()],
            netlist,
            prefix,
        }
    }

    fn begin_again(&mut self) {
        self.text.clear();
        self.variables.clear();
        self.done.fill(false);
        self.prepared.fill(false);
        self.written.fill(false);
    }

    /// Units in an order in which readers of a register come before its own, as far
    /// as there is one.
    fn order(&self) -> Vec<usize> {
        let gates = self.netlist.gates.len();
        let mut seen = vec![false; gates + self.units.len()];
        let mut order = Vec::with_capacity(self.units.len());
        for root in 0..self.units.len() {
            let mut stack = vec![(gates + root, false)];
            while let Some((node, is_left)) = stack.pop() {
                if is_left {
                    if node >= gates {
                        order.push(node - gates);
                    }
                    continue;
                }
                if std::mem::replace(&mut seen[node], true) {
                    continue;
                }
                stack.push((node, true));
                let of_net = |net: BitNet| {
                    self.readers[net.index()].iter().map(|reader| match reader {
                        Reader::Gate(gate) => *gate,
                        Reader::Data(unit) | Reader::Control(unit) => gates + unit,
                    })
                };
                let mut push = |net: BitNet| {
                    stack.extend(of_net(net).filter(|&r| !seen[r]).map(|r| (r, false)));
                };
                if node < gates {
                    push(self.netlist.gates[node].output);
                } else {
                    for &register in &self.units[node - gates].registers {
                        push(self.netlist.registers[register].q);
                    }
                }
            }
        }
        order
    }

    fn write(&mut self, order: &[usize]) {
        for &unit in order {
            self.write_unit(unit);
        }
    }

    fn write_unit(&mut self, unit: usize) {
        let netlist = self.netlist;
        let registers = self.units[unit].registers.clone();
        let reset_of = |register: usize| netlist.registers[register].reset;
        for net in registers.iter().filter_map(|&register| Some(reset_of(register)?.when)) {
            self.gates_for(net, None);
        }
        let Some(enable) = self.units[unit].enable else {
            for &register in &registers {
                self.gates_for(netlist.registers[register].d, None);
                self.keep(register);
                self.write_register(register, None);
            }
            return;
        };
        self.gates_for(enable, None);
        for &register in &registers {
            self.gates_for(netlist.registers[register].d, None);
            self.keep(register);
        }
        let mut conditions = vec![self.value(enable)];
        for &register in &registers {
            if let Some(reset) = reset_of(register) {
                let reset = self.value(reset.when);
                if !conditions.contains(&reset) {
                    conditions.push(reset);
                }
            }
        }
        let (begin, end) = self.names.language.where_any(&conditions.join(" | "));
        self.text += &begin;
        for &register in &registers {
            self.gates_for(netlist.registers[register].d, Some(unit));
        }
        for &register in &registers {
            self.write_register(register, Some(enable));
        }
        self.text += end;
    }

    /// Keeps a register's old value if it is read once more.
    fn keep(&mut self, register: usize) {
        if self.kept[register] {
            let name = format!("{}s{register}", self.prefix);
            let _ = writeln!(self.text, "    {name} = q{register};");
            self.variables.push(name);
        }
    }

    fn write_register(&mut self, number: usize, enable: Option<BitNet>) {
        let register = &self.netlist.registers[number];
        let mut value = self.value(register.d);
        if let Some(enable) = enable {
            let enable = self.value(enable);
            value = format!("({enable} & {value}) | (~{enable} & q{number})");
        }
        if let Some(reset) = register.reset {
            let when = self.value(reset.when);
            value = match reset.value {
                true => format!("({value}) | {when}"),
                false => format!("({value}) & ~{when}"),
            };
        }
        let _ = writeln!(self.text, "    q{number} = {value};");
        self.written[number] = true;
    }

    /// Writes the gates that a net needs and that are not there yet: those of one
    /// unit alone (`within`), or those that are nobody's alone.
    fn gates_for(&mut self, net: BitNet, within: Option<usize>) {
        let mut stack = vec![net];
        while let Some(&net) = stack.last() {
            let Driver::Gate(number) = self.names.drivers[net.index()] else {
                stack.pop();
                continue;
            };
            let gate = self.netlist.gates[number];
            if within.is_none() && self.only_for[number].is_some() {
                // Its own turn comes, but what it shares with others has to be there.
                stack.pop();
                if !std::mem::replace(&mut self.prepared[number], true) {
                    stack.extend(gate.inputs);
                }
                continue;
            }
            if self.done[number] {
                stack.pop();
                continue;
            }
            let before = stack.len();
            stack.extend(gate.inputs.into_iter().filter(|input| {
                matches!(self.names.drivers[input.index()],
                    Driver::Gate(g) if !self.done[g] && (within.is_some() || self.only_for[g].is_none()))
            }));
            if stack.len() == before {
                self.write_gate(number, gate);
                stack.pop();
            }
        }
    }

    fn write_gate(&mut self, number: usize, gate: LogicGate) {
        let inputs = gate.inputs.map(|net| self.value(net));
        let name = format!("{}{number}", self.prefix);
        let _ = writeln!(
            self.text,
            "    {name} = {};",
            expression(self.names.language, gate.function, &inputs)
        );
        self.variables.push(name);
        self.done[number] = true;
    }

    fn value(&mut self, net: BitNet) -> String {
        match self.names.drivers[net.index()] {
            Driver::Outside => self.names.outside(net),
            Driver::Gate(number) => format!("{}{number}", self.prefix),
            Driver::Register(number) if self.written[number] => {
                self.kept[number] = true;
                format!("{}s{number}", self.prefix)
            }
            Driver::Register(number) => format!("q{number}"),
        }
    }
}

/// For each gate the one unit behind an enable that it feeds, as data only.
fn only_for(netlist: &GateNetlist, units: &[Unit], readers: &[Vec<Reader>]) -> Vec<Option<usize>> {
    let mut only: Vec<Option<usize>> = vec![None; netlist.gates.len()];
    for (i, gate) in netlist.gates.iter().enumerate().rev() {
        let mut fed = readers[gate.output.index()].iter().map(|reader| match *reader {
            Reader::Gate(gate) => only[gate],
            Reader::Data(unit) => units[unit].enable.map(|_| unit),
            Reader::Control(_) => None,
        });
        let first = fed.next().flatten();
        only[i] = first.filter(|&unit| fed.all(|other| other == Some(unit)));
    }
    only
}
