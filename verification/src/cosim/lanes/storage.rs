//! Which nets of a design lie inside its memories.

use super::netlist::{BitNet, FlipFlop, GateNetlist};

impl GateNetlist {
    /// For each net whether it is a memory's own: a bit that it holds, what chooses among these
    /// on the way to the next register, and what goes to them alone.
    pub fn inside_memories(&self) -> Vec<bool> {
        let mut from_bits = vec![false; self.nets];
        for register in self.registers.iter().filter(|register| holds_a_word(register)) {
            from_bits[register.q.index()] = true;
        }
        let is_held = from_bits.clone();
        for gate in &self.gates {
            from_bits[gate.output.index()] = gate.inputs.iter().any(|net| from_bits[net.index()]);
        }
        let mut leads_out = vec![false; self.nets];
        let mut leave = |net: BitNet| leads_out[net.index()] = true;
        self.outputs.iter().flat_map(|port| &port.nets).for_each(|&net| leave(net));
        for register in self.registers.iter().filter(|register| !is_held[register.q.index()]) {
            let reset = register.reset.map(|reset| reset.when);
            [Some(register.d), register.enable, reset].into_iter().flatten().for_each(&mut leave);
        }
        for gate in self.gates.iter().rev() {
            if leads_out[gate.output.index()] {
                gate.inputs.iter().for_each(|net| leads_out[net.index()] = true);
            }
        }
        for net in 0..self.nets {
            // An input, or a register's output, may well lead to a memory alone.
            from_bits[net] |= !leads_out[net];
        }
        for register in self.registers.iter().filter(|register| !holds_a_word(register)) {
            from_bits[register.q.index()] = false;
        }
        for &net in self.inputs.iter().flat_map(|port| &port.nets) {
            from_bits[net.index()] = false;
        }
        from_bits
    }
}

/// Whether a register is a word of a memory: its name has the word's number.
fn holds_a_word(register: &FlipFlop) -> bool {
    register.name.0.ends_with(']')
}

#[cfg(test)]
mod tests {
    use crate::cosim::lanes::netlist::{
        BitNet, FlipFlop, Function, GateNetlist, LogicGate, PortNets,
    };

    /// Two words of a bit, the choice of one by an address, and a register behind it.
    #[test]
    fn words_and_what_chooses_among_them_are_inside_and_the_registers_round_them_are_not() {
        let [data, address, first, second, chosen, enable, behind] =
            [2, 3, 4, 5, 6, 7, 8].map(BitNet);
        let port = |name: &str, net| PortNets { name: name.to_owned(), nets: vec![net] };
        let register = |name: &str, d, q, enable| FlipFlop {
            name: (name.to_owned(), 0),
            q,
            d,
            enable,
            reset: None,
            initial: None,
        };
        let netlist = GateNetlist {
            inputs: vec![port("data", data), port("address", address)],
            outputs: vec![port("out", behind)],
            gates: vec![
                LogicGate {
                    function: Function::Mux,
                    inputs: [first, second, address],
                    output: chosen,
                },
                LogicGate {
                    function: Function::NOT,
                    inputs: [address, BitNet::ZERO, BitNet::ZERO],
                    output: enable,
                },
            ],
            registers: vec![
                register("words[0]", data, first, Some(enable)),
                register("words[1]", data, second, Some(address)),
                register("word_r", chosen, behind, None),
            ],
            nets: 9,
            names: Vec::new(),
        };
        let inside = netlist.inside_memories();
        for (net, is_inside) in [
            (data, false),
            (address, false),
            (first, true),
            (second, true),
            (chosen, true),
            (enable, true),
            (behind, false),
        ] {
            assert_eq!(inside[net.index()], is_inside, "{net:?}");
        }
    }
}
