//! A design that can run in lanes: gates, and a program of them that clocks 64 lanes at
//! once. `testbench/lanes.cpp` is the program's other part.

use std::fmt::Write as _;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::netlist::{CHOICE, Driver, Net, Netlist, PortNets, Register};
use super::synthesis::synthesise;
use super::verilog::{CLOCK, MODULE, RESET_CLOCK, module, output_nets};
use super::yosys::{self, Memories};
use super::{Refusal, Unfit};
use crate::cosim::build::{Built, LanesUnit, build_lanes};
use crate::cosim::source::SourceFile;
use crate::scene::Polarity;
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Layout, Record};
use crate::sensor::port::{Role, Use};

/// Name of the header that `testbench/lanes.cpp` includes.
const HEADER: &str = "goldtof_lanes.h";
const TESTBENCH: &str = include_str!("../../../../testbench/lanes.cpp");
/// Most gates and registers of a design: the compiler takes longer than lanes save.
const MOST_CELLS: usize = 40_000;

/// A design that can run in lanes.
#[derive(Debug, Clone)]
pub struct Design {
    /// The program.
    pub(super) built: Built,
    /// Its registers, in the order of their planes.
    pub registers: Vec<Register>,
    /// Whether each follows an input other than the reset.
    pub(super) follow_inputs: Vec<bool>,
    /// What the design is; part of the identity of all that follows from it.
    pub(super) identity: String,
    /// Planes of outputs.
    pub(super) outputs: usize,
    /// Planes of samples.
    pub(super) samples: usize,
    /// Outputs that follow a code.
    pub(super) tables: usize,
}

impl Design {
    /// Makes a design from Verilog, or finds it made.
    ///
    /// # Errors
    /// What of it has no place in lanes; or a tool fails.
    pub fn build(
        top: &str,
        sources: &[SourceFile],
        interface: &Interface,
        cache: &Path,
    ) -> Result<Design, Refusal> {
        let netlist = Design::netlist(top, sources, Memories::Refused, cache)?;
        Design::of(&netlist, interface, cache)
    }

    /// The netlist of a design.
    ///
    /// # Errors
    /// What of it has no place in lanes; or a tool fails.
    pub fn netlist(
        top: &str,
        sources: &[SourceFile],
        memories: Memories,
        cache: &Path,
    ) -> Result<Netlist, Refusal> {
        let json = synthesise(top, sources, memories, cache)?;
        Ok(yosys::read(&json, top)?)
    }

    /// Builds a netlist.
    ///
    /// # Errors
    /// What of it has no place in lanes; or a tool fails.
    pub fn of(netlist: &Netlist, interface: &Interface, cache: &Path) -> Result<Design, Refusal> {
        let cells = netlist.gates.len() + netlist.registers.len();
        if cells > MOST_CELLS {
            return Err(Refusal::unfit(format!(
                "it has {cells} gates and registers; more than {MOST_CELLS} take longer to compile \
                 than lanes save"
            )));
        }
        let layout = Layout::of(interface);
        let outputs = planes(&netlist.outputs, &layout.outputs)?;
        planes(&netlist.inputs, &layout.inputs)?;
        let tables = interface.source_codes.len() + 1;
        let reset = netlist.input(Role::Reset.name()).map(|nets| nets[0]);
        let text = module(netlist, reset);
        let mut header = header(netlist, interface, &outputs, tables);
        let reset_clock = reset.map_or(CLOCK, |_| RESET_CLOCK);
        let _ = writeln!(header, "#define LANES_RESET_CLOCK {reset_clock}");
        let unit = LanesUnit {
            module: MODULE,
            verilog: &text,
            testbench: TESTBENCH,
            header: (HEADER, &header),
        };
        let (built, identity) = build_lanes(&unit, cache)?;
        Ok(Design {
            built,
            registers: netlist.registers.clone(),
            follow_inputs: netlist.registers_that_follow_inputs(),
            identity,
            outputs: outputs.len(),
            samples: layout.inputs.field(Role::Samples).port.width as usize,
            tables,
        })
    }
}

impl Design {
    /// Planes of the registers at power-up: as the Verilog says, or at random, in each
    /// lane otherwise.
    pub(super) fn power_up(&self, seed: u64) -> Vec<u64> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let planes = self.registers.iter().map(|register| {
            let random = rng.random::<u64>();
            match register.initial {
                Some(true) => u64::MAX,
                Some(false) => 0,
                None => random,
            }
        });
        planes.collect()
    }
}

/// A level in all lanes.
fn rest_plane(level: bool) -> &'static str {
    if level { "~uint64_t{0}" } else { "0" }
}

/// The nets of a record's ports, in the record's order.
///
/// # Errors
/// When the netlist has not these ports, or others: nothing drives or expects them.
pub(super) fn planes(ports: &[PortNets], record: &Record) -> Result<Vec<Net>, Unfit> {
    let is_known = |port: &PortNets| record.fields.iter().any(|f| f.port.name == port.name);
    if let Some(port) = ports.iter().find(|port| port.name != CHOICE && !is_known(port)) {
        let name = &port.name;
        return Err(Unfit::new(format!("port {name} is not one of this scene's ports")));
    }
    let mut nets = Vec::new();
    for field in &record.fields {
        let found = ports.iter().find(|port| port.name == field.port.name);
        match found {
            Some(port) if port.nets.len() == field.port.width as usize => {
                nets.extend(&port.nets);
            }
            _ => {
                return Err(Unfit::new(format!(
                    "Yosys has no port {} of {} bits",
                    field.port.name, field.port.width
                )));
            }
        }
    }
    Ok(nets)
}

/// Writes the header: how planes go to the module's ports and come from them.
fn header(netlist: &Netlist, interface: &Interface, outputs: &[Net], tables: usize) -> String {
    let layout = Layout::of(interface);
    let drivers = netlist.drivers();
    let name = |net: Net| name_of(netlist, &drivers, net);
    let mut text = format!(
        "#include <cstdint>\n#include \"V{MODULE}.h\"\n#include \"V{MODULE}___024root.h\"\n\
         #define LANES_MODEL V{MODULE}\n#define LANES_CLOCK {CLOCK}\n\
         #define LANES_SAMPLES {}\n#define LANES_OUTPUTS {}\n#define LANES_TABLES {tables}\n\
         using LanesRoot = V{MODULE}___024root;\n",
        layout.inputs.field(Role::Samples).port.width,
        outputs.len(),
    );
    text += "static inline void lanes_apply(LanesRoot& root, uint64_t reset, \
             const uint64_t* samples) {\n";
    let mut number = 0;
    for port in &netlist.inputs {
        let role = Role::of(&port.name);
        for bit in 0..port.nets.len() {
            let source = match role.map(Role::usage) {
                _ if role == Some(Role::Reset) => "reset".to_owned(),
                // Photons leave all others as they rest.
                Some(Use::Level { rest }) => rest_plane(rest).to_owned(),
                _ if interface.polarity == Polarity::Low => format!("~samples[{bit}]"),
                _ => format!("samples[{bit}]"),
            };
            let _ = writeln!(text, "    root.i{number} = {source};");
            number += 1;
        }
    }
    text += "}\nstatic inline uint64_t lanes_differ(const LanesRoot& root, const uint64_t* expected) \
             {\n    uint64_t differ = 0;\n";
    for (i, &net) in outputs.iter().enumerate() {
        let _ = writeln!(text, "    differ |= {} ^ expected[{i}];", name(net));
    }
    text += "    return differ;\n}\nstatic inline void lanes_outputs(const LanesRoot& root, \
             uint64_t* outputs) {\n";
    for (i, &net) in outputs.iter().enumerate() {
        let _ = writeln!(text, "    outputs[{i}] = {};", name(net));
    }
    let _ = writeln!(
        text,
        "}}\nstatic inline uint64_t lanes_valid(const LanesRoot& root) {{ return {}; }}",
        name(outputs[layout.outputs.bits_before(Role::Valid)])
    );
    text + &registers_text(netlist)
}

/// What an output is called in the verilated module.
pub(super) fn name_of(netlist: &Netlist, drivers: &[Driver], net: Net) -> String {
    match drivers[net.index()] {
        Driver::Register(register) => format!("root.q{register}"),
        _ => {
            let place = output_nets(netlist).position(|other| other == net);
            format!("root.y{}", place.unwrap_or_default())
        }
    }
}

/// Functions that set and read all registers.
pub(super) fn registers_text(netlist: &Netlist) -> String {
    let mut text =
        "static inline void lanes_load(LanesRoot& root, const uint64_t* planes) {\n".to_owned();
    for i in 0..netlist.registers.len() {
        let _ = writeln!(text, "    root.q{i} = planes[{i}];");
    }
    text += "}\nstatic inline void lanes_save(const LanesRoot& root, uint64_t* planes) {\n";
    for i in 0..netlist.registers.len() {
        let _ = writeln!(text, "    planes[{i}] = root.q{i};");
    }
    text += "}\n";
    text
}
