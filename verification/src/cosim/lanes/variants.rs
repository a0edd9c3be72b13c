//! A design of which every lane is another variant, all with the same inputs: a fault
//! each, or a mutant each. `testbench/grade.cpp` is the other side.

use std::fmt::Write as _;
use std::path::Path;

use super::LaneRefusal;
use super::design::{WORDS, name_of, planes, registers_text};
use super::model::halted;
use super::netlist::{BitNet, CHOICE, FlipFlop, Function, GateNetlist, LogicGate, PortNets};
use super::verilog::{CLOCK, LANES, MODULE, module};
use crate::cosim::build::{Built, LanesUnit, build_lanes};
use crate::cosim::error::CosimError;
use crate::cosim::process::Process;
use crate::rtl::blocks::{CountRegister, ScanRegisters};
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

const HEADER: &str = "goldtof_lanes.h";
const TESTBENCH: &str = include_str!("../../../../testbench/grade.cpp");
/// Most clocks of a block.
pub const MOST_CLOCKS: u64 = 16_384;

/// A net that may be stuck.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Site {
    /// The net of the design without faults.
    pub net: BitNet,
}

/// A design in which every gate's and register's output and every input may be stuck, but for
/// what lies inside a memory, which is block RAM's own:
/// bit 2 i of the choice sets site i to 0, bit 2 i + 1 to 1.
pub fn with_faults(netlist: &GateNetlist) -> (GateNetlist, Vec<Site>) {
    let mut faulty = netlist.clone();
    let is_inside = netlist.inside_memories();
    let sites: Vec<Site> = netlist
        .inputs
        .iter()
        .flat_map(|port| port.nets.iter().copied())
        .chain(netlist.registers.iter().map(|register| register.q))
        .chain(netlist.gates.iter().map(|gate| gate.output))
        .filter(|net| !is_inside[net.index()])
        .map(|net| Site { net })
        .collect();
    let mut seen: Vec<BitNet> = (0..netlist.nets as u32).map(BitNet).collect();
    let mut fresh = netlist.nets as u32;
    let mut new_net = || {
        fresh += 1;
        BitNet(fresh - 1)
    };
    let mut choice = Vec::new();
    let mut gates = Vec::new();
    for site in &sites {
        let [zero, one, kept, stuck] = [(); 4].map(|()| new_net());
        choice.extend([zero, one]);
        let gate = |table, a, b, output| LogicGate {
            function: Function::Table(table),
            inputs: [a, b, BitNet::ZERO],
            output,
        };
        gates.push(gate(0b0010, site.net, zero, kept));
        gates.push(gate(0b1110, kept, one, stuck));
        seen[site.net.index()] = stuck;
    }
    let see = |net: BitNet| seen[net.index()];
    for gate in &mut faulty.gates {
        gate.inputs = gate.inputs.map(see);
    }
    for register in &mut faulty.registers {
        register.d = see(register.d);
        register.enable = register.enable.map(see);
        if let Some(reset) = &mut register.reset {
            reset.when = see(reset.when);
        }
    }
    for net in faulty.outputs.iter_mut().flat_map(|port| &mut port.nets) {
        *net = see(*net);
    }
    faulty.gates.extend(gates);
    faulty.inputs.push(PortNets { name: CHOICE.to_owned(), nets: choice });
    faulty.nets = fresh as usize;
    faulty.sort().expect("a stuck net closes no loop that was not there");
    (faulty, sites)
}

/// What came of a block.
#[derive(Debug, Clone)]
pub struct Differences {
    /// Lanes that differed from lane 0.
    pub lanes: u64,
    /// For each of them the first clock of the block at which it did.
    pub first_clocks: [u64; LANES],
}

/// A design of variants, running.
#[derive(Debug)]
pub struct Variants {
    process: Process,
    registers: Vec<FlipFlop>,
    choice: usize,
    record_words: usize,
    records_at: u64,
    found_at: u64,
    flips_at: u64,
}

/// The registers of the scan's counters, chips and groups, bit by bit: those that can
/// be moved on between two clocks.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Counters([Vec<usize>; 2]);

impl Counters {
    /// Finds them in a netlist, whose choice may be tied; none if one is not there.
    pub fn find(netlist: &GateNetlist, registers: &ScanRegisters) -> Option<Counters> {
        let of = |register: &Option<CountRegister>| match register {
            Some(register) => netlist.registers_of(&register.path(".")),
            None => Some(Vec::new()),
        };
        Some(Counters([of(&registers.chips)?, of(&registers.groups)?]))
    }
}

/// Moves the counters on in front of a clock of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flips {
    /// The clock of the block.
    pub clock: u64,
    /// What is XORed into the counter of chips.
    pub chips: u64,
    /// What is XORed into that of groups.
    pub groups: u64,
}

/// Builds a netlist with a choice of variants. Of own Verilog, `ignores_idle_payload`,
/// what the result stream shows without `m_axis_tvalid` does not count.
///
/// # Errors
/// What of it has no place in lanes; or a tool fails.
pub fn build_variants(
    netlist: &GateNetlist,
    counters: &Counters,
    interface: &Interface,
    ignores_idle_payload: bool,
    cache: &Path,
) -> Result<Built, LaneRefusal> {
    let layout = Layout::of(interface);
    let outputs = planes(&netlist.outputs, &layout.outputs)?;
    planes(&netlist.inputs, &layout.inputs)?;
    let text = module(netlist, None);
    let mut header = header(netlist, &layout);
    header += &differ_text(netlist, &layout, &outputs, ignores_idle_payload);
    header += &skip_text(counters);
    header += &registers_text(netlist);
    let unit = LanesUnit {
        verilog: Some((MODULE, &text)),
        flags: &[],
        testbench: TESTBENCH,
        header: (HEADER, &header),
    };
    Ok(build_lanes(&unit, cache)?.0)
}

/// How records and choices go to the module's ports.
fn header(netlist: &GateNetlist, layout: &Layout) -> String {
    let mut text = format!(
        "{WORDS}#include \"V{MODULE}.h\"\n#include \"V{MODULE}___024root.h\"\n\
         #define LANES_MODEL V{MODULE}\n#define LANES_CLOCK {CLOCK}\n#define LANES_RECORD_WORDS {}\n\
         using LanesRoot = V{MODULE}___024root;\n",
        layout.inputs.words,
    );
    let (mut apply, mut choose) = (String::new(), String::new());
    let mut number = 0;
    for port in &netlist.inputs {
        for bit in 0..port.nets.len() {
            if port.name == CHOICE {
                let _ = writeln!(choose, "    root.i{number} = planes[{bit}];");
            } else {
                let mut fields = layout.inputs.fields.iter();
                let field = fields.find(|field| field.port.name == port.name);
                let field = field.expect("the planes of inputs are known");
                let at = field.shift as usize + bit;
                let (word, shift) = (field.word + at / 64, at % 64);
                let _ = writeln!(apply, "    root.i{number} = -(record[{word}] >> {shift} & 1);");
            }
            number += 1;
        }
    }
    let _ = write!(
        text,
        "static inline void lanes_apply(LanesRoot& root, const uint64_t* record) {{\n{apply}}}\n\
         static inline void lanes_choose(LanesRoot& root, const uint64_t* planes) {{\n{choose}}}\n"
    );
    text
}

/// The function that gives the lanes in which an output differs from lane 0's.
fn differ_text(
    netlist: &GateNetlist,
    layout: &Layout,
    outputs: &[BitNet],
    ignores_idle_payload: bool,
) -> String {
    let drivers = netlist.drivers();
    let differences = |of_payload: bool| -> String {
        let mut nets = outputs.iter();
        let mut text = String::new();
        for field in &layout.outputs.fields {
            let nets = nets.by_ref().take(field.port.width as usize);
            let is_payload = ignores_idle_payload && field.port.role.is_payload();
            for &net in nets.filter(|_| is_payload == of_payload) {
                let name = name_of(netlist, &drivers, net);
                let _ = writeln!(text, "    differ |= {name} ^ -({name} & 1);");
            }
        }
        text
    };
    format!(
        "static inline uint64_t lanes_differ(const LanesRoot& root) {{\n    uint64_t differ = 0;\n\
         {}    differ &= -({} & 1);\n{}    return differ;\n}}\n",
        differences(true),
        name_of(netlist, &drivers, outputs[layout.outputs.bits_before(PortRole::Valid)]),
        differences(false)
    )
}

/// The function that moves the counters on, in all lanes alike.
fn skip_text(counters: &Counters) -> String {
    let mut text =
        "static inline void lanes_skip(LanesRoot& root, uint64_t chips, uint64_t groups) \
                    {\n    (void)root; (void)chips; (void)groups;\n"
            .to_owned();
    for (name, registers) in ["chips", "groups"].iter().zip(&counters.0) {
        for (bit, register) in registers.iter().enumerate() {
            let _ = writeln!(text, "    root.q{register} ^= -({name} >> {bit} & 1);");
        }
    }
    text + "}\n"
}

/// What the model is asked for; `testbench/grade.cpp` has the same.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
enum What {
    Load = 0,
    Save = 1,
    Choose = 2,
    Run = 3,
}

impl Variants {
    /// Starts a design of variants.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn load(
        built: &Built,
        netlist: &GateNetlist,
        interface: &Interface,
    ) -> Result<Variants, CosimError> {
        let choice = netlist.input(CHOICE).map_or(0, <[BitNet]>::len);
        let record_words = Layout::of(interface).inputs.words;
        let records_at = netlist.registers.len().max(choice) as u64;
        let found_at = records_at + MOST_CLOCKS * record_words as u64;
        let flips_at = found_at + 1 + LANES as u64;
        Ok(Variants {
            process: Process::load(built, flips_at + 3 * MOST_CLOCKS)?,
            registers: netlist.registers.clone(),
            choice,
            record_words,
            records_at,
            found_at,
            flips_at,
        })
    }

    fn ask(&mut self, what: What, arguments: [u64; 5]) -> Result<(), CosimError> {
        let asked = self.process.ask(what as u64, arguments);
        asked.and_then(|()| self.process.answer()).map_err(halted)
    }

    /// Sets all registers, one plane each.
    ///
    /// # Errors
    /// When the model has ended.
    ///
    /// # Panics
    /// When there is not one plane for each.
    pub fn set_registers(&mut self, planes: &[u64]) -> Result<(), CosimError> {
        assert_eq!(planes.len(), self.registers.len());
        self.process.write(0, planes).map_err(halted)?;
        self.ask(What::Load, [0; 5])
    }

    /// Reads all registers, one plane each.
    ///
    /// # Errors
    /// When the model has ended.
    pub fn registers(&mut self) -> Result<Vec<u64>, CosimError> {
        self.ask(What::Save, [0; 5])?;
        let mut planes = vec![0; self.registers.len()];
        self.process.read(0, &mut planes).map_err(halted)?;
        Ok(planes)
    }

    /// Sets which variant each lane is.
    ///
    /// # Errors
    /// When the model has ended.
    ///
    /// # Panics
    /// When there is not one plane for each bit of the choice.
    pub fn choose(&mut self, planes: &[u64]) -> Result<(), CosimError> {
        assert_eq!(planes.len(), self.choice);
        self.process.write(0, planes).map_err(halted)?;
        self.ask(What::Choose, [0; 5])
    }

    /// Clocks all lanes with input records of at most [`MOST_CLOCKS`] clocks, and moves
    /// the counters on in between.
    ///
    /// # Errors
    /// When the model has ended.
    ///
    /// # Panics
    /// When there are more.
    pub fn run(&mut self, records: &[u64], flips: &[Flips]) -> Result<Differences, CosimError> {
        let clocks = (records.len() / self.record_words) as u64;
        assert!(clocks <= MOST_CLOCKS);
        self.process.write(self.records_at, records).map_err(halted)?;
        let words: Vec<u64> =
            flips.iter().flat_map(|flip| [flip.clock, flip.chips, flip.groups]).collect();
        self.process.write(self.flips_at, &words).map_err(halted)?;
        self.ask(
            What::Run,
            [self.records_at, clocks, self.found_at, self.flips_at, flips.len() as u64],
        )?;
        let mut found = [0; 1 + LANES];
        self.process.read(self.found_at, &mut found).map_err(halted)?;
        let mut first_clocks = [0; LANES];
        first_clocks.copy_from_slice(&found[1..]);
        Ok(Differences { lanes: found[0], first_clocks })
    }
}
