//! Two designs as one and-inverter graph whose only output is 1 where theirs differ:
//! what model checkers take (AIGER 1.9, binary).

use std::collections::HashMap;

use crate::cosim::lanes::netlist::{BitNet, CHOICE, FlipFlop, Function, GateNetlist, PortNets};
use crate::sensor::port::PortRole;

/// A literal: twice the number of a variable, plus one if it is inverted.
type Literal = u32;

const FALSE: Literal = 0;

/// A design and the values of its registers from which on it is compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Started<'a> {
    /// The design.
    pub(super) netlist: &'a GateNetlist,
    /// One for each register.
    pub(super) values: &'a [bool],
}

/// Writes the file. Both designs have the same ports, but for a choice of variants that
/// is tied in both. With `ignores_idle_payload` what the result stream shows while it
/// is not valid may differ.
pub(super) fn miter(left: Started, right: Started, ignores_idle_payload: bool) -> Vec<u8> {
    let inputs: Vec<BitNet> = inputs_of(left.netlist).collect();
    let latches = left.values.len() + right.values.len();
    let mut graph = Graph {
        next: (inputs.len() + latches) as u32 + 1,
        ands: Vec::new(),
        known: HashMap::new(),
    };
    let first_latch = inputs.len() as u32 + 1;
    let sides = [(left, first_latch), (right, first_latch + left.values.len() as u32)];
    let mut nexts = Vec::new();
    let mut outputs: Vec<Vec<Vec<Literal>>> = Vec::new();
    for (side, first_latch) in sides {
        let literals = graph.literals(side, first_latch);
        nexts.extend(graph.next_values(side, &literals, first_latch));
        let of_port = |port: &PortNets| port.nets.iter().map(|net| literals[net.index()]).collect();
        outputs.push(side.netlist.outputs.iter().map(of_port).collect());
    }
    let ports = &left.netlist.outputs;
    let valid = ports.iter().position(|port| port.name == PortRole::Valid.name());
    let is_payload = |name: &str| PortRole::of(name).is_some_and(PortRole::is_payload);
    let mut differ = FALSE;
    for (number, port) in ports.iter().enumerate() {
        let mut here = FALSE;
        for (&a, &b) in outputs[0][number].iter().zip(&outputs[1][number]) {
            let bit = graph.xor(a, b);
            here = graph.or(here, bit);
        }
        if let Some(valid) = valid.filter(|_| ignores_idle_payload && is_payload(&port.name)) {
            here = graph.and(here, outputs[0][valid][0]);
        }
        differ = graph.or(differ, here);
    }
    let count = graph.next - 1;
    let mut file = format!("aig {count} {} {latches} 1 {}\n", inputs.len(), graph.ands.len());
    for next in nexts {
        file += &format!("{next}\n");
    }
    file += &format!("{differ}\n");
    let mut bytes = file.into_bytes();
    for (number, &(high, low)) in graph.ands.iter().enumerate() {
        let own = 2 * (first_latch + latches as u32 + number as u32);
        number_to(&mut bytes, own - high);
        number_to(&mut bytes, high - low);
    }
    bytes
}

fn inputs_of(netlist: &GateNetlist) -> impl Iterator<Item = BitNet> + '_ {
    let ports = netlist.inputs.iter().filter(|port| port.name != CHOICE);
    ports.flat_map(|port| port.nets.iter().copied())
}

/// Seven bits a byte, the lowest first.
fn number_to(bytes: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

struct Graph {
    next: u32,
    /// The larger literal first.
    ands: Vec<(Literal, Literal)>,
    known: HashMap<(Literal, Literal), Literal>,
}

impl Graph {
    fn and(&mut self, a: Literal, b: Literal) -> Literal {
        let (high, low) = (a.max(b), a.min(b));
        match low {
            FALSE => return FALSE,
            1 => return high,
            _ if high == low => return high,
            _ if high ^ 1 == low => return FALSE,
            _ => {}
        }
        if let Some(&known) = self.known.get(&(high, low)) {
            return known;
        }
        let literal = 2 * self.next;
        self.next += 1;
        self.ands.push((high, low));
        self.known.insert((high, low), literal);
        literal
    }

    fn or(&mut self, a: Literal, b: Literal) -> Literal {
        self.and(a ^ 1, b ^ 1) ^ 1
    }

    fn mux(&mut self, when_low: Literal, when_high: Literal, select: Literal) -> Literal {
        let high = self.and(select, when_high);
        let low = self.and(select ^ 1, when_low);
        self.or(high, low)
    }

    fn xor(&mut self, a: Literal, b: Literal) -> Literal {
        self.mux(a, a ^ 1, b)
    }

    /// The literal of every net. A latch starts with 0: one that starts with 1 is kept
    /// inverted.
    fn literals(&mut self, side: Started, first_latch: u32) -> Vec<Literal> {
        let netlist = side.netlist;
        let mut literals = vec![FALSE; netlist.nets];
        literals[BitNet::ONE.index()] = 1;
        for (number, net) in inputs_of(netlist).enumerate() {
            literals[net.index()] = 2 * (number as u32 + 1);
        }
        for (number, register) in netlist.registers.iter().enumerate() {
            let latch = 2 * (first_latch + number as u32);
            literals[register.q.index()] = latch | u32::from(side.values[number]);
        }
        for gate in &netlist.gates {
            let [a, b, s] = gate.inputs.map(|net| literals[net.index()]);
            literals[gate.output.index()] = match gate.function {
                Function::Mux => self.mux(a, b, s),
                Function::Table(table) => {
                    let bit = |at: u8| u32::from(table >> at & 1);
                    let of_a = |graph: &mut Graph, zero: u32, one: u32| graph.mux(zero, one, a);
                    let low = of_a(self, bit(0), bit(1));
                    let high = of_a(self, bit(2), bit(3));
                    self.mux(low, high, b)
                }
            };
        }
        literals
    }

    fn next_values(
        &mut self,
        side: Started,
        literals: &[Literal],
        first_latch: u32,
    ) -> Vec<Literal> {
        let registers = side.netlist.registers.iter().enumerate();
        let next = |(number, register): (usize, &FlipFlop)| {
            let inverted = u32::from(side.values[number]);
            let own = (2 * (first_latch + number as u32)) | inverted;
            let mut next = literals[register.d.index()];
            if let Some(enable) = register.enable {
                next = self.mux(own, next, literals[enable.index()]);
            }
            if let Some(reset) = register.reset {
                let value = u32::from(reset.value);
                next = self.mux(next, value, literals[reset.when.index()]);
            }
            next ^ inverted
        };
        registers.map(next).collect()
    }
}
