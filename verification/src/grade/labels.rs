//! Nets in the words of the Verilog.

use std::collections::HashMap;

use crate::cosim::lanes::netlist::{BitNet, GateNetlist, VerilogName};

/// Names of nets: of several that a net has the shortest.
pub(super) struct Labels<'a> {
    netlist: &'a GateNetlist,
    of: HashMap<BitNet, (&'a VerilogName, usize)>,
}

impl<'a> Labels<'a> {
    pub(super) fn of(netlist: &'a GateNetlist) -> Labels<'a> {
        let mut of: HashMap<BitNet, (&VerilogName, usize)> = HashMap::new();
        for name in &netlist.names {
            for (bit, &net) in name.nets.iter().enumerate() {
                let known = of.entry(net).or_insert((name, bit));
                if name.word.len() < known.0.word.len() {
                    *known = (name, bit);
                }
            }
        }
        Labels { netlist, of }
    }

    /// Name and source of a net, or else of the first one that it goes to.
    pub(super) fn describe(&self, net: BitNet) -> (String, String) {
        if let Some((name, bit)) = self.of.get(&net) {
            return (format!("{}[{bit}]", name.word), name.source.clone());
        }
        let mut reached = vec![false; self.netlist.nets];
        reached[net.index()] = true;
        for gate in &self.netlist.gates {
            if gate.inputs.iter().any(|input| reached[input.index()]) {
                reached[gate.output.index()] = true;
                if let Some(&found) = self.of.get(&gate.output) {
                    return in_logic_of(found);
                }
            }
        }
        let mut registers = self.netlist.registers.iter();
        let fed = registers.find(|register| {
            let reset = register.reset.map(|reset| reset.when);
            let nets = [Some(register.d), register.enable, reset];
            nets.into_iter().flatten().any(|net| reached[net.index()])
        });
        match fed.map(|register| (register, self.of.get(&register.q))) {
            Some((_, Some(&found))) => in_logic_of(found),
            Some((register, None)) => {
                let (word, bit) = &register.name;
                (format!("in the logic of {word}[{bit}]"), String::new())
            }
            None => ("a net without a name".to_owned(), String::new()),
        }
    }
}

fn in_logic_of((name, bit): (&VerilogName, usize)) -> (String, String) {
    let text = format!("in the logic of {}[{bit}]", name.word);
    (text, name.source.clone())
}

/// Of the places that Yosys knows for a net, in modules and in the instances above them,
/// those of a single line, which a declaration is and an instance is not; all if there is
/// none.
pub(super) fn places(source: &str) -> String {
    let is_line = |place: &&str| {
        let lines = place.rsplit_once(':').and_then(|(_, at)| at.split_once('-'));
        let line = |at: &str| at.split_once('.').map(|(line, _)| line.to_owned());
        lines.is_some_and(|(from, to)| line(from) == line(to))
    };
    let all: Vec<&str> = source.split('|').collect();
    let lines: Vec<&str> = all.iter().copied().filter(|place| is_line(place)).collect();
    match lines.is_empty() {
        true => all.join(", "),
        false => lines.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_declaration_goes_before_the_instances_above_it() {
        let source = "top.v:67.22-76.6|a.v:21.17-21.24|channel.v:5.1-9.2";
        assert_eq!(places(source), "a.v:21.17-21.24");
        assert_eq!(places("top.v:67.22-76.6|b.v:1.1-2.2"), "top.v:67.22-76.6, b.v:1.1-2.2");
        assert_eq!(places(""), "");
    }
}
