//! A design as single-bit gates and registers on one clock.

use crate::sensor::port::PortRole;
use std::collections::HashMap;

/// Name of the input whose bits choose a variant of the design.
pub const CHOICE: &str = "goldtof_choice";

/// A one-bit net. The first two are the constants 0 and 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BitNet(pub u32);

impl BitNet {
    /// Constant 0.
    pub const ZERO: BitNet = BitNet(0);
    /// Constant 1.
    pub const ONE: BitNet = BitNet(1);

    /// The constant.
    pub fn constant(value: bool) -> BitNet {
        BitNet(u32::from(value))
    }

    /// Its value if it is a constant.
    pub fn as_constant(self) -> Option<bool> {
        (self.0 < 2).then_some(self.0 == 1)
    }

    /// Its place in a list of all nets.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What a gate does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// Two inputs: bit a + 2 b of the table is the output.
    Table(u8),
    /// Inputs a, b, s: s ? b : a.
    Mux,
}

impl Function {
    /// The inverse of its first input.
    pub const NOT: Function = Function::Table(0b0101);
    /// Its first input.
    pub const BUFFER: Function = Function::Table(0b1010);
}

/// A gate; a table of two inputs has a constant as its third.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LogicGate {
    /// What it does.
    pub function: Function,
    /// Its inputs.
    pub inputs: [BitNet; 3],
    /// Its output.
    pub output: BitNet,
}

/// A synchronous reset: at a rising edge at which `when` is high the register takes
/// `value`, whatever its enable says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SynchronousReset {
    /// Its net.
    pub when: BitNet,
    /// What it sets.
    pub value: bool,
}

/// A flip-flop on the rising edge of the clock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FlipFlop {
    /// Name of its word in the Verilog, and its bit there.
    pub name: (String, u32),
    /// Its output.
    pub q: BitNet,
    /// Its input.
    pub d: BitNet,
    /// Takes its input only where this is high.
    pub enable: Option<BitNet>,
    /// Its reset.
    pub reset: Option<SynchronousReset>,
    /// Its value at power-up, if the Verilog says so.
    pub initial: Option<bool>,
}

/// A port's bits, least significant first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortNets {
    /// Its name.
    pub name: String,
    /// Its nets.
    pub nets: Vec<BitNet>,
}

/// A word of the Verilog.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VerilogName {
    /// What it is called, from the top module down.
    pub word: String,
    /// File and lines where it is declared; empty if nobody knows.
    pub source: String,
    /// Its nets, least significant first.
    pub nets: Vec<BitNet>,
}

/// A design.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GateNetlist {
    /// All inputs but the clock.
    pub inputs: Vec<PortNets>,
    /// All outputs.
    pub outputs: Vec<PortNets>,
    /// Gates; inputs of each come before it.
    pub gates: Vec<LogicGate>,
    /// Registers.
    pub registers: Vec<FlipFlop>,
    /// Number of nets, the constants included.
    pub nets: usize,
    /// Words that have a name in the Verilog.
    pub names: Vec<VerilogName>,
}

/// What drives a net.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driver {
    /// Nothing, or an input, or a constant.
    Outside,
    /// The register of this number.
    Register(usize),
    /// The gate of this number.
    Gate(usize),
}

impl GateNetlist {
    /// What drives each net.
    pub fn drivers(&self) -> Vec<Driver> {
        let mut drivers = vec![Driver::Outside; self.nets];
        for (i, register) in self.registers.iter().enumerate() {
            drivers[register.q.index()] = Driver::Register(i);
        }
        for (i, gate) in self.gates.iter().enumerate() {
            drivers[gate.output.index()] = Driver::Gate(i);
        }
        drivers
    }

    /// The nets of a port.
    pub fn input(&self, name: &str) -> Option<&[BitNet]> {
        let port = self.inputs.iter().find(|port| port.name == name)?;
        Some(&port.nets)
    }

    /// For each bit of a word the register that holds it; none unless all are held.
    pub fn registers_of(&self, word: &str) -> Option<Vec<usize>> {
        let drivers = self.drivers();
        let name = self.names.iter().find(|name| name.word == word)?;
        let register = |net: &BitNet| match drivers[net.index()] {
            Driver::Register(number) => Some(number),
            _ => None,
        };
        name.nets.iter().map(register).collect()
    }

    /// Puts the gates into an order in which inputs come before outputs.
    ///
    /// # Errors
    /// A net of a combinational loop.
    pub fn sort(&mut self) -> Result<(), BitNet> {
        let drivers = self.drivers();
        let mut sorted = Vec::with_capacity(self.gates.len());
        // 0 not seen, 1 begun, 2 done.
        let mut state = vec![0u8; self.gates.len()];
        for root in 0..self.gates.len() {
            let mut stack = vec![root];
            while let Some(&gate) = stack.last() {
                if state[gate] == 2 {
                    stack.pop();
                    continue;
                }
                let inputs = self.gates[gate].inputs.iter();
                let below = inputs.filter_map(|net| match drivers[net.index()] {
                    Driver::Gate(below) if state[below] < 2 => Some(below),
                    _ => None,
                });
                let below: Vec<usize> = below.collect();
                if below.is_empty() {
                    state[gate] = 2;
                    sorted.push(self.gates[gate]);
                    stack.pop();
                } else if state[gate] == 1 {
                    return Err(self.gates[gate].output);
                } else {
                    state[gate] = 1;
                    stack.extend(below);
                }
            }
        }
        self.gates = sorted;
        Ok(())
    }

    /// Whether each net follows an input without a register between; the choice of a
    /// variant, which never changes, is none.
    pub fn follows_inputs(&self) -> Vec<bool> {
        let mut follows = vec![false; self.nets];
        let inputs = self.inputs.iter();
        let inputs = inputs.filter(|port| !port.name.starts_with(CHOICE));
        for net in inputs.flat_map(|port| &port.nets) {
            follows[net.index()] = true;
        }
        for gate in &self.gates {
            follows[gate.output.index()] = gate.inputs.iter().any(|net| follows[net.index()]);
        }
        follows
    }

    /// Whether each register follows an input other than the reset, however late.
    pub fn registers_that_follow_inputs(&self) -> Vec<bool> {
        let mut follows = vec![false; self.nets];
        let others = self.inputs.iter().filter(|port| port.name != PortRole::Reset.name());
        for net in others.flat_map(|port| &port.nets) {
            follows[net.index()] = true;
        }
        loop {
            for gate in &self.gates {
                follows[gate.output.index()] = gate.inputs.iter().any(|net| follows[net.index()]);
            }
            let mut has_changed = false;
            for register in &self.registers {
                let reset = register.reset.map(|reset| reset.when);
                let mut nets = [Some(register.d), register.enable, reset].into_iter().flatten();
                let now = nets.any(|net| follows[net.index()]);
                has_changed |= now && !follows[register.q.index()];
                follows[register.q.index()] |= now;
            }
            if !has_changed {
                let registers = self.registers.iter();
                return registers.map(|register| follows[register.q.index()]).collect();
            }
        }
    }

    /// The same design with nets tied to constants, and what follows from it. Ports
    /// and registers stay; registers' resets and enables that never happen, or
    /// always, go. A word's bit that is the inverse of a net has that net's name.
    pub fn with_tied(&self, tied: &HashMap<BitNet, bool>) -> GateNetlist {
        let Folded { gates, same, held } = self.folded(tied);
        let see = |net: BitNet| same[net.index()];
        let mut folded = GateNetlist { gates, ..self.clone() };
        for register in &mut folded.registers {
            register.d = see(register.d);
            register.enable = register.enable.map(see).filter(|&net| net != BitNet::ONE);
            let reset =
                register.reset.map(|reset| SynchronousReset { when: see(reset.when), ..reset });
            register.reset = reset.filter(|reset| reset.when != BitNet::ZERO);
        }
        for net in folded.outputs.iter_mut().flat_map(|port| &mut port.nets) {
            *net = see(*net);
        }
        for net in folded.names.iter_mut().flat_map(|name| &mut name.nets) {
            *net = held[net.index()];
        }
        folded.remove_dead();
        folded
    }

    /// The gates that are left where nets are tied to constants.
    fn folded(&self, tied: &HashMap<BitNet, bool>) -> Folded {
        let mut same: Vec<BitNet> = (0..self.nets as u32).map(BitNet).collect();
        for (net, &value) in tied {
            same[net.index()] = BitNet::constant(value);
        }
        let mut held = same.clone();
        let mut gates = Vec::new();
        for gate in &self.gates {
            if tied.contains_key(&gate.output) {
                continue;
            }
            let inputs = gate.inputs.map(|net| same[net.index()]);
            match simplified(gate.function, inputs) {
                Simplified::Net(net) => {
                    same[gate.output.index()] = net;
                    held[gate.output.index()] = held[net.index()];
                }
                Simplified::Gate(function, inputs) => {
                    if function == Function::NOT {
                        held[gate.output.index()] = held[inputs[0].index()];
                    }
                    gates.push(LogicGate { function, inputs, output: gate.output });
                }
            }
        }
        Folded { gates, same, held }
    }

    /// Removes gates that feed nothing.
    fn remove_dead(&mut self) {
        let mut wanted = vec![false; self.nets];
        let mut want = |net: BitNet| wanted[net.index()] = true;
        self.outputs.iter().flat_map(|port| &port.nets).for_each(|&net| want(net));
        for register in &self.registers {
            want(register.d);
            register.enable.into_iter().for_each(&mut want);
            register.reset.into_iter().for_each(|reset| want(reset.when));
        }
        for gate in self.gates.iter().rev() {
            if wanted[gate.output.index()] {
                for net in gate.inputs {
                    wanted[net.index()] = true;
                }
            }
        }
        self.gates.retain(|gate| wanted[gate.output.index()]);
    }
}

/// Gates of which some nets are constants.
struct Folded {
    gates: Vec<LogicGate>,
    /// The net that each net is.
    same: Vec<BitNet>,
    /// The net that each net is, or is the inverse of.
    held: Vec<BitNet>,
}

enum Simplified {
    Net(BitNet),
    Gate(Function, [BitNet; 3]),
}

/// What a gate is when some of its inputs are constants.
fn simplified(function: Function, inputs: [BitNet; 3]) -> Simplified {
    let [a, b, s] = inputs;
    match function {
        Function::Mux => match s.as_constant() {
            Some(true) => Simplified::Net(b),
            Some(false) => Simplified::Net(a),
            None if a == b => Simplified::Net(a),
            None => Simplified::Gate(function, inputs),
        },
        Function::Table(table) => {
            let bit = |at: u8| u8::from(table >> at & 1 == 1);
            // The table of one input that is left: bit 0 for 0, bit 1 for 1.
            let (rest, net) = match (a.as_constant(), b.as_constant()) {
                (Some(a), Some(b)) => {
                    let value = bit(u8::from(a) + 2 * u8::from(b));
                    return Simplified::Net(BitNet::constant(value == 1));
                }
                (Some(a), None) => (bit(u8::from(a)) | bit(u8::from(a) + 2) << 1, b),
                (None, Some(b)) => (bit(2 * u8::from(b)) | bit(2 * u8::from(b) + 1) << 1, a),
                (None, None) => return Simplified::Gate(function, inputs),
            };
            match rest {
                0b00 => Simplified::Net(BitNet::ZERO),
                0b11 => Simplified::Net(BitNet::ONE),
                0b10 => Simplified::Net(net),
                _ => Simplified::Gate(Function::NOT, [net, BitNet::ZERO, BitNet::ZERO]),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(function: Function, values: [bool; 3]) -> bool {
        match function {
            Function::Mux => values[usize::from(values[2])],
            Function::Table(table) => {
                table >> (u8::from(values[0]) + 2 * u8::from(values[1])) & 1 == 1
            }
        }
    }

    #[test]
    fn a_gate_with_constant_inputs_keeps_its_function() {
        let functions = (0..16).map(Function::Table).chain([Function::Mux]);
        for function in functions {
            for tied in 0..27u32 {
                // Each input: 0, 1, or a net of its own.
                let choice = |i: u32| tied / 3u32.pow(i) % 3;
                let inputs = [0, 1, 2].map(|i| match choice(i) {
                    2 => BitNet(2 + i),
                    constant => BitNet(constant),
                });
                for free in 0..8u32 {
                    let of = |net: BitNet| match net.as_constant() {
                        Some(value) => value,
                        None => free >> (net.0 - 2) & 1 == 1,
                    };
                    let expected = value(function, inputs.map(of));
                    let got = match simplified(function, inputs) {
                        Simplified::Net(net) => of(net),
                        Simplified::Gate(function, inputs) => value(function, inputs.map(of)),
                    };
                    assert_eq!(got, expected, "{function:?} {inputs:?} {free}");
                }
            }
        }
    }

    #[test]
    fn gates_are_sorted_and_loops_named() {
        let gate = |a: u32, b: u32, output: u32| LogicGate {
            function: Function::Table(0b1000),
            inputs: [BitNet(a), BitNet(b), BitNet::ZERO],
            output: BitNet(output),
        };
        let mut netlist = GateNetlist {
            gates: vec![gate(4, 3, 5), gate(3, 2, 4), gate(2, 2, 3)],
            nets: 6,
            ..GateNetlist::default()
        };
        netlist.sort().unwrap();
        let outputs: Vec<u32> = netlist.gates.iter().map(|gate| gate.output.0).collect();
        assert_eq!(outputs, [3, 4, 5]);
        netlist.gates[0] = gate(5, 2, 3);
        assert!(netlist.sort().is_err());
    }
}
