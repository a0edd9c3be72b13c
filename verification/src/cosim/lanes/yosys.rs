//! Yosys: from Verilog to a [`GateNetlist`].

use std::collections::{BTreeMap, HashMap};

use serde::Deserialize;

use super::Unfit;
use super::netlist::{
    BitNet, Driver, FlipFlop, Function, GateNetlist, LogicGate, PortNets, SynchronousReset,
    VerilogName,
};
use crate::sensor::layout::Layout;

/// What becomes of memories that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memories {
    /// A design that has some has no place in lanes.
    Refused,
    /// Each bit is a register.
    Registers,
}

impl Memories {
    /// From words to gates.
    pub(super) fn to_gates(self) -> String {
        match self {
            Memories::Refused => WORDS_TO_GATES.to_owned(),
            Memories::Registers => format!("memory_map; opt -full; {WORDS_TO_GATES}"),
        }
    }
}

/// From Verilog to cells of words in one module.
pub(super) const TO_WORDS: &str = "proc; flatten; opt -full; memory -nomap; memory_map -rom-only; \
     opt -full; wreduce; opt_clean";

/// From there to gates, and flip-flops on a rising edge with an enable and a synchronous
/// reset where they have one. What cannot be made of these (latches, asynchronous
/// resets, memories that are no registers) ends it.
const WORDS_TO_GATES: &str = "alumacc; techmap -map +/techmap.v; opt -full; simplemap; \
     dfflegalize -cell $_DFF_P_ 01 -cell $_DFFE_PP_ 01 -cell $_SDFF_PP?_ 01 -cell $_SDFFE_PP?P_ 01 \
     -mince 1 -minsrst 1; abc -fast -g AND,OR,XOR,MUX,ANDNOT,ORNOT,XNOR,NAND,NOR; opt_clean";

/// What `write_json` writes.
#[derive(Deserialize)]
pub(super) struct YosysDocument {
    pub(super) modules: HashMap<String, YosysModule>,
}

#[derive(Deserialize)]
pub(super) struct YosysModule {
    // Ordered, so that the same Verilog gives the same netlist.
    pub(super) ports: BTreeMap<String, YosysPort>,
    pub(super) cells: BTreeMap<String, YosysCell>,
    #[serde(default)]
    netnames: BTreeMap<String, NetName>,
}

#[derive(Deserialize)]
pub(super) struct YosysPort {
    pub(super) direction: String,
    pub(super) bits: Vec<Bit>,
}

#[derive(Deserialize)]
pub(super) struct YosysCell {
    pub(super) r#type: String,
    #[serde(default)]
    pub(super) parameters: HashMap<String, serde_json::Value>,
    #[serde(default)]
    pub(super) attributes: HashMap<String, serde_json::Value>,
    #[serde(default)]
    pub(super) port_directions: HashMap<String, String>,
    pub(super) connections: HashMap<String, Vec<Bit>>,
}

#[derive(Deserialize)]
struct NetName {
    #[serde(default)]
    hide_name: u8,
    bits: Vec<Bit>,
    #[serde(default)]
    attributes: HashMap<String, serde_json::Value>,
}

/// A net's number, or a constant as text.
#[derive(Deserialize, Clone, PartialEq, Eq, Hash)]
#[serde(untagged)]
pub(super) enum Bit {
    Net(u32),
    Constant(String),
}

/// Reads what `write_json` wrote of the module `top`.
///
/// # Errors
/// What of the design has no place in lanes.
pub fn read(json: &str, top: &str) -> Result<GateNetlist, Unfit> {
    let document: YosysDocument = serde_json::from_str(json)
        .map_err(|error| Unfit::new(format!("Yosys's netlist cannot be read: {error}")))?;
    let module = document
        .modules
        .get(top)
        .ok_or_else(|| Unfit::new(format!("Yosys has no module {top}")))?;
    Reader::new(module).read()
}

struct Reader<'a> {
    module: &'a YosysModule,
    numbers: HashMap<u32, BitNet>,
    clock: Option<Bit>,
}

impl<'a> Reader<'a> {
    fn new(module: &'a YosysModule) -> Reader<'a> {
        Reader {
            module,
            numbers: HashMap::new(),
            clock: module.ports.get(Layout::CLOCK).and_then(|port| port.bits.first().cloned()),
        }
    }

    /// An undefined value is 0: any would do, and where it matters the outputs differ.
    fn net(&mut self, bit: &Bit) -> BitNet {
        match bit {
            Bit::Constant(value) => BitNet::constant(value == "1"),
            Bit::Net(number) => {
                let next = BitNet(self.numbers.len() as u32 + 2);
                *self.numbers.entry(*number).or_insert(next)
            }
        }
    }

    fn read(mut self) -> Result<GateNetlist, Unfit> {
        let mut netlist = GateNetlist::default();
        let module = self.module;
        for (name, port) in &module.ports {
            if name == Layout::CLOCK {
                continue;
            }
            let nets = port.bits.iter().map(|bit| self.net(bit)).collect();
            let name = name.clone();
            match port.direction.as_str() {
                "input" => netlist.inputs.push(PortNets { name, nets }),
                "output" => netlist.outputs.push(PortNets { name, nets }),
                _ => return Err(Unfit::new(format!("port {name} is an inout"))),
            }
        }
        let mut names = self.names();
        for (cell_name, cell) in &module.cells {
            if let Some(function) = function(&cell.r#type) {
                netlist.gates.push(self.gate(cell, function)?);
            } else {
                let register = self.register(cell_name, cell, &mut names)?;
                netlist.registers.push(register);
            }
        }
        netlist.nets = self.numbers.len() + 2;
        netlist.names = self.words();
        self.check(&mut netlist)?;
        Ok(netlist)
    }

    /// Words that have a name in the Verilog, and all of whose bits are used.
    fn words(&self) -> Vec<VerilogName> {
        let named = self.module.netnames.iter();
        let named = named.filter(|(_, net)| net.hide_name == 0);
        let word = |(name, net): (&String, &NetName)| {
            let source = net.attributes.get("src").and_then(|value| value.as_str());
            let of_bit = |bit: &Bit| match bit {
                Bit::Constant(value) => Some(BitNet::constant(value == "1")),
                Bit::Net(number) => self.numbers.get(number).copied(),
            };
            Some(VerilogName {
                word: name.clone(),
                source: source.unwrap_or_default().to_owned(),
                nets: net.bits.iter().map(of_bit).collect::<Option<_>>()?,
            })
        };
        named.filter_map(word).collect()
    }

    /// Name and power-up value of each net that has a name in the Verilog. Of several
    /// the shortest, which lies highest in the hierarchy.
    fn names(&self) -> HashMap<u32, (String, u32, Option<bool>)> {
        let mut names: HashMap<u32, (String, u32, Option<bool>)> = HashMap::new();
        for (name, net) in &self.module.netnames {
            let initial = net.attributes.get("init").and_then(|value| value.as_str());
            for (bit, number) in net.bits.iter().zip(0u32..) {
                let Bit::Net(number_of_net) = bit else {
                    continue;
                };
                let initial = initial.and_then(|text| {
                    let place = text.len().checked_sub(number as usize + 1)?;
                    match text.as_bytes()[place] {
                        b'0' => Some(false),
                        b'1' => Some(true),
                        _ => None,
                    }
                });
                let better = |old: &(String, u32, Option<bool>)| {
                    net.hide_name == 0 && (old.0.starts_with('$') || name.len() < old.0.len())
                };
                let entry =
                    names.entry(*number_of_net).or_insert_with(|| (name.clone(), number, None));
                if better(entry) {
                    (entry.0, entry.1) = (name.clone(), number);
                }
                entry.2 = entry.2.or(initial);
            }
        }
        names
    }

    fn pin(&mut self, cell: &YosysCell, pin: &str) -> Result<BitNet, Unfit> {
        match cell.connections.get(pin).and_then(|bits| bits.first()) {
            Some(bit) => Ok(self.net(bit)),
            None => Err(Unfit::new(format!("Yosys left a {} without {pin}", cell.r#type))),
        }
    }

    fn gate(&mut self, cell: &YosysCell, function: Function) -> Result<LogicGate, Unfit> {
        let a = self.pin(cell, "A")?;
        let is_not = cell.r#type == "$_NOT_" || cell.r#type == "$_BUF_";
        let b = if is_not { BitNet::ZERO } else { self.pin(cell, "B")? };
        let s = match function {
            Function::Mux => self.pin(cell, "S")?,
            Function::Table(_) => BitNet::ZERO,
        };
        Ok(LogicGate { function, inputs: [a, b, s], output: self.pin(cell, "Y")? })
    }

    fn register(
        &mut self,
        cell_name: &str,
        cell: &YosysCell,
        names: &mut HashMap<u32, (String, u32, Option<bool>)>,
    ) -> Result<FlipFlop, Unfit> {
        let unfit = |what: &str| Err(Unfit::new(format!("the design has {what} ({cell_name})")));
        let (enabled, reset) = match cell.r#type.as_str() {
            "$_DFF_P_" => (false, None),
            "$_DFFE_PP_" => (true, None),
            "$_SDFF_PP0_" => (false, Some(false)),
            "$_SDFF_PP1_" => (false, Some(true)),
            "$_SDFFE_PP0P_" => (true, Some(false)),
            "$_SDFFE_PP1P_" => (true, Some(true)),
            other if other.starts_with("$mem") => return unfit("a memory"),
            other if other.contains("LATCH") || other == "$_SR_" => return unfit("a latch"),
            other => return unfit(&format!("a cell of type {other}")),
        };
        if cell.connections.get("C").and_then(|bits| bits.first()) != self.clock.as_ref() {
            return unfit("a register that is not clocked by the rising edge of i_clk");
        }
        let name = match cell.connections.get("Q").and_then(|bits| bits.first()) {
            Some(Bit::Net(number)) => names.remove(number),
            _ => None,
        };
        let (name, bit, initial) = name.unwrap_or_else(|| (cell_name.to_owned(), 0, None));
        Ok(FlipFlop {
            name: (name, bit),
            initial,
            q: self.pin(cell, "Q")?,
            d: self.pin(cell, "D")?,
            enable: if enabled { Some(self.pin(cell, "E")?) } else { None },
            reset: match reset {
                Some(value) => Some(SynchronousReset { when: self.pin(cell, "R")?, value }),
                None => None,
            },
        })
    }

    /// What has no place in lanes, and the order of the gates.
    fn check(&self, netlist: &mut GateNetlist) -> Result<(), Unfit> {
        netlist.sort().map_err(|_| Unfit::new("the design has a combinational loop"))?;
        if let Some(Bit::Net(clock)) = &self.clock
            && self.numbers.contains_key(clock)
        {
            return Err(Unfit::new("i_clk is used as data"));
        }
        let drivers = netlist.drivers();
        let mut is_input = vec![false; netlist.nets];
        for net in netlist.inputs.iter().flat_map(|port| &port.nets) {
            is_input[net.index()] = true;
        }
        let undriven = |net: BitNet| {
            net.as_constant().is_none()
                && !is_input[net.index()]
                && drivers[net.index()] == Driver::Outside
        };
        let follows = netlist.follows_inputs();
        for port in &netlist.outputs {
            if port.nets.iter().any(|net| follows[net.index()]) {
                return Err(Unfit::new(format!("{} follows an input within a clock", port.name)));
            }
            if port.nets.iter().any(|&net| undriven(net)) {
                return Err(Unfit::new(format!("{} is not driven", port.name)));
            }
        }
        Ok(())
    }
}

/// The gate of a cell; none of what is not a gate.
fn function(cell: &str) -> Option<Function> {
    Some(match cell {
        "$_AND_" => Function::Table(0b1000),
        "$_OR_" => Function::Table(0b1110),
        "$_XOR_" => Function::Table(0b0110),
        "$_XNOR_" => Function::Table(0b1001),
        "$_NAND_" => Function::Table(0b0111),
        "$_NOR_" => Function::Table(0b0001),
        // a and not b; a or not b.
        "$_ANDNOT_" => Function::Table(0b0010),
        "$_ORNOT_" => Function::Table(0b1011),
        "$_NOT_" => Function::NOT,
        "$_BUF_" => Function::BUFFER,
        "$_MUX_" => Function::Mux,
        _ => return None,
    })
}
