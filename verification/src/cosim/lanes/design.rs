//! A design that can run in lanes: gates, and two programs of them, of which one clocks the lanes
//! of a vector at once and the other those of Verilator's word. `testbench/lanes.cpp` is the other
//! part of both.

use std::fmt::Write as _;
use std::panic::resume_unwind;
use std::path::Path;
use std::thread;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::netlist::{BitNet, CHOICE, Driver, FlipFlop, GateNetlist, PortNets};
use super::synthesis::synthesise;
use super::vectors;
use super::verilog::{self, CLOCK, MODULE, RESET_CLOCK, module, output_nets};
use super::yosys::{self, Memories};
use super::{LaneRefusal, Unfit};
use crate::cosim::build::{Built, LanesUnit, build_lanes};
use crate::cosim::source::SourceFile;
use crate::scene::Polarity;
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Layout, Record};
use crate::sensor::port::{PortRole, Use};

/// Name of the header that `testbench/lanes.cpp` includes.
const HEADER: &str = "goldtof_lanes.h";
const TESTBENCH: &str = include_str!("../../../../testbench/lanes.cpp");
/// Most gates and registers of a design: the compiler takes longer than lanes save.
const MOST_CELLS: usize = 40_000;
/// Samples of a block in each lane, unless it had fewer clocks than are worth asking for, or more
/// than are of use.
const SAMPLES_OF_BLOCK: u64 = 16_384;
const LEAST_CLOCKS: u64 = 64;
const MOST_CLOCKS: u64 = 2_048;

/// A design that can run in lanes.
#[derive(Debug, Clone)]
pub struct LaneDesign {
    /// The program in vectors.
    vectors: Built,
    /// Verilator's program.
    verilator: Built,
    /// Its registers, in the order of their planes.
    pub registers: Vec<FlipFlop>,
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
    /// Most clocks of a block: its samples stay in a core's second-level cache.
    pub(super) block_clocks: u64,
}

/// What makes a program of a netlist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Backend {
    /// The C++ compiler, of vectors.
    Vectors,
    /// Verilator, of words.
    Verilator,
}

impl Backend {
    /// Lanes that its programs clock at once.
    pub(super) const fn lanes(self) -> usize {
        match self {
            Backend::Vectors => vectors::LANES,
            Backend::Verilator => verilog::LANES,
        }
    }
}

impl LaneDesign {
    /// Makes a design from Verilog, or finds it made.
    ///
    /// # Errors
    /// What of it has no place in lanes; or a tool fails.
    pub fn build(
        top: &str,
        sources: &[SourceFile],
        interface: &Interface,
        cache: &Path,
    ) -> Result<LaneDesign, LaneRefusal> {
        let netlist = LaneDesign::netlist(top, sources, Memories::Refused, cache)?;
        LaneDesign::of(&netlist, interface, cache)
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
    ) -> Result<GateNetlist, LaneRefusal> {
        let json = synthesise(top, sources, memories, cache)?;
        Ok(yosys::read(&json, top)?)
    }

    /// Builds a netlist.
    ///
    /// # Errors
    /// What of it has no place in lanes; or a tool fails.
    pub fn of(
        netlist: &GateNetlist,
        interface: &Interface,
        cache: &Path,
    ) -> Result<LaneDesign, LaneRefusal> {
        let cells = netlist.gates.len() + netlist.registers.len();
        if cells > MOST_CELLS {
            return Err(LaneRefusal::unfit(format!(
                "it has {cells} gates and registers; more than {MOST_CELLS} take longer to compile \
                 than lanes save"
            )));
        }
        let layout = Layout::of(interface);
        let outputs = planes(&netlist.outputs, &layout.outputs)?;
        planes(&netlist.inputs, &layout.inputs)?;
        let tables = interface.source_codes.len() + 1;
        let reset = netlist.input(PortRole::Reset.name()).map(|nets| nets[0]);
        let samples = layout.inputs.field(PortRole::Samples).port.width as usize;
        let block_clocks = (SAMPLES_OF_BLOCK / samples as u64).clamp(LEAST_CLOCKS, MOST_CLOCKS);
        let shared = format!(
            "{}#define LANES_TABLES {tables}\n#define LANES_CLOCKS {block_clocks}\n",
            header(netlist, interface, &outputs)
        );
        let of_vectors = vectors::model(netlist, reset) + &shared;
        let of_verilator = verilated(reset.map_or(CLOCK, |_| RESET_CLOCK)) + &shared;
        let verilog = module(netlist, reset);
        let build = |verilog, flags, header: &str| {
            let header = (HEADER, header);
            build_lanes(&LanesUnit { verilog, flags, testbench: TESTBENCH, header }, cache)
        };
        let (vectors, verilator) = thread::scope(|scope| {
            let verilator =
                scope.spawn(|| build(Some((MODULE, verilog.as_str())), &[], &of_verilator));
            let vectors = build(None, vectors::compiler_flags(), &of_vectors);
            (vectors, verilator.join().unwrap_or_else(|panic| resume_unwind(panic)))
        });
        let (vectors, identity) = vectors?;
        Ok(LaneDesign {
            vectors,
            verilator: verilator?.0,
            registers: netlist.registers.clone(),
            follow_inputs: netlist.registers_that_follow_inputs(),
            identity,
            outputs: outputs.len(),
            samples,
            tables,
            block_clocks,
        })
    }

    /// The program of a back end.
    pub(super) fn built(&self, backend: Backend) -> &Built {
        match backend {
            Backend::Vectors => &self.vectors,
            Backend::Verilator => &self.verilator,
        }
    }

    /// The registers at power-up: as the Verilog says, or at random.
    pub(super) fn power_up(&self, seed: u64) -> Vec<bool> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let values = self.registers.iter().map(|register| {
            let random = rng.random::<u64>() & 1 == 1;
            register.initial.unwrap_or(random)
        });
        values.collect()
    }
}

/// A level in all lanes.
fn rest_plane(level: bool) -> &'static str {
    if level { "~Plane{}" } else { "Plane{}" }
}

/// The nets of a record's ports, in the record's order.
///
/// # Errors
/// When the netlist has not these ports, or others: nothing drives or expects them.
pub(super) fn planes(ports: &[PortNets], record: &Record) -> Result<Vec<BitNet>, Unfit> {
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

/// What Verilator's model is to `testbench/lanes.cpp`.
fn verilated(reset_clock: &str) -> String {
    format!(
        "{WORDS}#include \"V{MODULE}.h\"\n#include \"V{MODULE}___024root.h\"\n\
         using LanesRoot = V{MODULE}___024root;\nstatic V{MODULE}* lanes;\n\
         // Never deleted: the process ends instead, and nothing of it is wanted then.\n\
         static inline LanesRoot& lanes_start() {{\n    \
         lanes = new V{MODULE}{{new VerilatedContext}};\n    \
         lanes->{CLOCK} = 0;\n    lanes->{reset_clock} = 0;\n    lanes->eval();\n    \
         return *lanes->rootp;\n}}\n\
         static inline void lanes_clock(LanesRoot&, bool in_reset) {{\n    \
         (in_reset ? lanes->{reset_clock} : lanes->{CLOCK}) ^= 1;\n    lanes->eval();\n}}\n"
    )
}

/// What a plane is where Verilator clocks the lanes.
pub(super) const WORDS: &str = "\
#include <cstdint>
#define LANES_WORDS 1
typedef uint64_t Plane;
typedef uint64_t Stored;
static inline bool any(Plane plane) { return plane != 0; }
";

/// Writes the header: how planes go to the model's ports and come from them. The level of each
/// detector, with `lanes` samples in a word, is told by where it changes.
fn header(netlist: &GateNetlist, interface: &Interface, outputs: &[BitNet]) -> String {
    let (layout, lanes) = (Layout::of(interface), interface.lanes());
    let drivers = netlist.drivers();
    let name = |net: BitNet| name_of(netlist, &drivers, net);
    let samples = layout.inputs.field(PortRole::Samples).port.width;
    let mut text = format!(
        "#define LANES_SAMPLES {samples}\n#define LANES_DETECTORS {}\n#define LANES_OUTPUTS {}\n\
         static inline void lanes_apply(LanesRoot& root, const Plane& reset, Plane* levels, \
         const Stored* edges) {{\n",
        samples / lanes,
        outputs.len(),
    );
    let mut number = 0;
    for port in &netlist.inputs {
        let role = PortRole::of(&port.name);
        for bit in 0..port.nets.len() {
            let source = match role.map(PortRole::usage) {
                _ if role == Some(PortRole::Reset) => "reset".to_owned(),
                // Photons leave all others as they rest.
                Some(Use::Level { rest }) => rest_plane(rest).to_owned(),
                _ => {
                    let level = format!("(levels[{}] ^= edges[{bit}])", bit / lanes as usize);
                    if interface.polarity == Polarity::Low { format!("~{level}") } else { level }
                }
            };
            let _ = writeln!(text, "    root.i{number} = {source};");
            number += 1;
        }
    }
    text += "}\nstatic inline Plane lanes_differ(const LanesRoot& root, const Plane* expected) \
             {\n    Plane differ{};\n";
    for (i, &net) in outputs.iter().enumerate() {
        let _ = writeln!(text, "    differ |= {} ^ expected[{i}];", name(net));
    }
    text += "    return differ;\n}\nstatic inline void lanes_outputs(const LanesRoot& root, \
             Stored* outputs) {\n";
    for (i, &net) in outputs.iter().enumerate() {
        let _ = writeln!(text, "    outputs[{i}] = {};", name(net));
    }
    let _ = writeln!(
        text,
        "}}\nstatic inline Plane lanes_valid(const LanesRoot& root) {{ return {}; }}",
        name(outputs[layout.outputs.bits_before(PortRole::Valid)])
    );
    text + &registers_text(netlist)
}

/// What an output is called in the model.
pub(super) fn name_of(netlist: &GateNetlist, drivers: &[Driver], net: BitNet) -> String {
    match drivers[net.index()] {
        Driver::Register(register) => format!("root.q{register}"),
        _ => {
            let place = output_nets(netlist).position(|other| other == net);
            format!("root.y{}", place.unwrap_or_default())
        }
    }
}

/// Functions that set and read all registers.
pub(super) fn registers_text(netlist: &GateNetlist) -> String {
    let mut text =
        "static inline void lanes_load(LanesRoot& root, const Stored* planes) {\n".to_owned();
    for i in 0..netlist.registers.len() {
        let _ = writeln!(text, "    root.q{i} = planes[{i}];");
    }
    text += "}\nstatic inline void lanes_save(const LanesRoot& root, Stored* planes) {\n";
    for i in 0..netlist.registers.len() {
        let _ = writeln!(text, "    planes[{i}] = root.q{i};");
    }
    text += "}\n";
    text
}
