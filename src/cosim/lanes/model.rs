//! A design in lanes, built and running. `testbench/lanes.cpp` is the other side.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::netlist::{Driver, Net, Netlist, Register};
use super::verilog::{CLOCK, MODULE, RESET_CLOCK, module, output_nets};
use super::{Refusal, Unfit, yosys};
use crate::cosim::build::{Built, LanesUnit, build_lanes};
use crate::cosim::cache::{hash, once, write};
use crate::cosim::error::CosimError;
use crate::cosim::process::Process;
use crate::cosim::source::{RTL, SourceFile};
use crate::cosim::tools::Tool;
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Layout, Record};

/// Name of the header that `testbench/lanes.cpp` includes.
const HEADER: &str = "goldtof_lanes.h";
const BENCH: &str = include_str!("../../../testbench/lanes.cpp");
const NETLIST: &str = "netlist.json";
/// Most gates and registers of a design: the compiler takes longer than lanes save.
const MOST_CELLS: usize = 40_000;

/// Clocks of a block: its samples stay in a core's second-level cache.
pub const BLOCK_CLOCKS: u64 = 4_096;
/// Blocks that the model may have at once: one being clocked, one waiting.
pub const BLOCKS_AT_ONCE: usize = 2;

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
        Design::of(&Design::netlist(top, sources, cache)?, interface, cache)
    }

    /// The netlist of a design.
    ///
    /// # Errors
    /// What of it has no place in lanes; or a tool fails.
    pub fn netlist(top: &str, sources: &[SourceFile], cache: &Path) -> Result<Netlist, Refusal> {
        let json = synthesise(top, sources, cache)?;
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
        let reset = netlist.input("i_rst").map(|nets| nets[0]);
        let text = module(netlist, reset);
        let mut header = header(netlist, &layout, &outputs, tables);
        let reset_clock = reset.map_or(CLOCK, |_| RESET_CLOCK);
        let _ = writeln!(header, "#define LANES_RESET_CLOCK {reset_clock}");
        let unit = LanesUnit {
            module: MODULE,
            verilog: &text,
            testbench: BENCH,
            header: (HEADER, &header),
        };
        let (built, identity) = build_lanes(&unit, cache)?;
        Ok(Design {
            built,
            registers: netlist.registers.clone(),
            follow_inputs: netlist.registers_that_follow_inputs(),
            identity,
            outputs: outputs.len(),
            samples: layout.inputs.field("i_samples").port.width as usize,
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

/// The netlist of a design as Yosys writes it.
fn synthesise(top: &str, sources: &[SourceFile], cache: &Path) -> Result<String, Refusal> {
    let yosys = Tool::yosys();
    let version = yosys_version(&yosys)?;
    let mut parts = vec!["netlist", version.as_str()];
    parts.extend([yosys::TO_WORDS, yosys::WORDS_TO_GATES, top]);
    for source in sources {
        parts.extend([source.name.as_str(), source.text.as_str()]);
    }
    let mut unfit = None;
    let name = format!("netlist-{}", hash(&parts));
    let made = once(cache, &name, NETLIST, |folder| {
        write_sources(folder, sources)?;
        let script = format!(
            "{}{}\n{}\nwrite_json {NETLIST}\n",
            script_of_sources(top, sources),
            yosys::TO_WORDS,
            yosys::WORDS_TO_GATES
        );
        write(&folder.join("to_gates.ys"), &script)?;
        let done = yosys.run(|command| {
            command
                .current_dir(folder)
                .args(["-q", "-s", "to_gates.ys"])
        });
        done.map(|_| ()).inspect_err(|error| {
            unfit = Some(first_error(error));
        })
    });
    failed_in_yosys(made, unfit)
}

/// What Yosys says of its version.
pub(super) fn yosys_version(yosys: &Tool) -> Result<String, Refusal> {
    let version = yosys.run(|command| command.arg("-V"));
    version
        .map(|version| version.trim().to_owned())
        .map_err(|error| match error {
            CosimError::MissingTool { install, .. } => {
                Refusal::unfit(format!("Yosys is missing; install it with: {install}"))
            }
            other => Refusal::unfit(format!("Yosys cannot be asked: {other}")),
        })
}

/// What Yosys does not take has no place in lanes.
pub(super) fn failed_in_yosys(
    made: Result<Vec<u8>, CosimError>,
    unfit: Option<String>,
) -> Result<String, Refusal> {
    match (made, unfit) {
        (Ok(bytes), _) => Ok(String::from_utf8_lossy(&bytes).into_owned()),
        (Err(_), Some(reason)) => Err(Refusal::unfit(format!("Yosys does not take it: {reason}"))),
        (Err(error), None) => Err(error.into()),
    }
}

pub(super) fn write_sources(folder: &Path, sources: &[SourceFile]) -> Result<(), CosimError> {
    let rtl = folder.join(RTL);
    std::fs::create_dir(&rtl).map_err(CosimError::cache(&rtl))?;
    for source in sources {
        write(&rtl.join(&source.name), &source.text)?;
    }
    Ok(())
}

/// The start of a script: the design read.
pub(super) fn script_of_sources(top: &str, sources: &[SourceFile]) -> String {
    let mut text = format!("read_verilog -sv -I {RTL}");
    for source in sources.iter().filter(|source| source.is_compiled()) {
        let _ = write!(text, " \"{RTL}/{}\"", source.name);
    }
    let _ = writeln!(text, "\nhierarchy -check -top {top}");
    text
}

/// What a tool said was wrong, in one line.
pub(super) fn first_error(error: &CosimError) -> String {
    let text = error.to_string();
    let line = text
        .lines()
        .find(|line| line.contains("ERROR"))
        .or(text.lines().next());
    line.unwrap_or_default().trim().to_owned()
}

/// The nets of a record's ports, in the record's order.
pub(super) fn planes(
    ports: &[super::netlist::PortNets],
    record: &Record,
) -> Result<Vec<Net>, Unfit> {
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
fn header(netlist: &Netlist, layout: &Layout, outputs: &[Net], tables: usize) -> String {
    let drivers = netlist.drivers();
    let name = |net: Net| name_of(netlist, &drivers, net);
    let place = |port: &str| -> usize {
        let before = layout.outputs.fields.iter();
        before
            .take_while(|field| field.port.name != port)
            .map(|field| field.port.width as usize)
            .sum()
    };
    let mut text = format!(
        "#include <cstdint>\n#include \"V{MODULE}.h\"\n#include \"V{MODULE}___024root.h\"\n\
         #define LANES_MODEL V{MODULE}\n#define LANES_CLOCK {CLOCK}\n\
         #define LANES_SAMPLES {}\n#define LANES_OUTPUTS {}\n#define LANES_TABLES {tables}\n\
         using LanesRoot = V{MODULE}___024root;\n",
        layout.inputs.field("i_samples").port.width,
        outputs.len(),
    );
    text += "static inline void lanes_apply(LanesRoot& root, uint64_t reset, uint64_t ready, \
             const uint64_t* samples) {\n";
    let mut number = 0;
    for port in &netlist.inputs {
        for bit in 0..port.nets.len() {
            let source = match port.name.as_str() {
                "i_rst" => "reset".to_owned(),
                "m_axis_tready" => "ready".to_owned(),
                "i_samples" => format!("samples[{bit}]"),
                _ => "0".to_owned(),
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
        name(outputs[place("m_axis_tvalid")])
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

/// An output that follows a code: its plane at every clock of a period.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// The output.
    pub(super) output: usize,
    /// Planes.
    pub(super) planes: Arc<Vec<u64>>,
}

/// A change of what an output is expected to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Event {
    /// Clock of the block, from which on it holds.
    pub(super) clock: u64,
    /// The output.
    pub(super) output: usize,
    /// Lanes in which it changes.
    pub(super) flips: u64,
}

/// A block of clocks.
#[derive(Debug, Clone, Default)]
pub(super) struct LaneBlock {
    /// Clocks.
    pub(super) clocks: u64,
    /// Lanes in reset.
    pub(super) reset: u64,
    /// Lanes that are compared.
    pub(super) watched: u64,
    /// Planes of samples, clock after clock.
    pub(super) samples: Vec<u64>,
    /// Changes of the expected outputs, in order.
    pub(super) events: Vec<Event>,
    /// Where each table stands.
    pub(super) phases: Vec<u64>,
}

/// What came of a block.
#[derive(Debug, Clone, Default)]
pub(super) struct Found {
    /// Lanes that differed.
    pub(super) different: u64,
    /// First clock of the block at which one did.
    pub(super) first_clock: u64,
    /// Clocks of the block at which a watched lane's result was valid, each with the
    /// planes of all outputs.
    pub(super) beats: Vec<(u64, Vec<u64>)>,
}

/// What the model is asked for; `testbench/lanes.cpp` has the same.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
enum What {
    Load = 0,
    Save = 1,
    Expect = 2,
    Tables = 3,
    Check = 4,
}

/// Words before the phases in the description of a block.
const BLOCK_WORDS: u64 = 9;
/// Words of an event.
const EVENT_WORDS: u64 = 3;
/// Words before the beats in what is found.
const FOUND_WORDS: u64 = 3;

/// A design in lanes, running.
#[derive(Debug)]
pub(super) struct LaneModel {
    process: Process,
    registers: usize,
    outputs: u64,
    samples: u64,
    /// First word of the first block.
    blocks_at: u64,
    block_words: u64,
    tables: u64,
    next_place: usize,
    under_way: VecDeque<usize>,
}

impl LaneModel {
    /// Starts a design with the tables of its codes.
    ///
    /// # Errors
    /// When it cannot be started.
    pub(super) fn load(design: &Design, tables: &[Table]) -> Result<LaneModel, CosimError> {
        let (outputs, samples) = (design.outputs as u64, design.samples as u64);
        assert_eq!(tables.len(), design.tables);
        let lengths = tables.iter().map(|table| table.planes.len() as u64);
        let scratch = (design.registers.len() as u64).max(outputs);
        let tables_at = scratch;
        let data_at = tables_at + 3 * tables.len() as u64;
        let blocks_at = data_at + lengths.sum::<u64>();
        let block_words = BLOCK_WORDS
            + tables.len() as u64
            + BLOCK_CLOCKS * samples
            + BLOCK_CLOCKS * outputs * EVENT_WORDS
            + FOUND_WORDS
            + BLOCK_CLOCKS * (outputs + 1);
        let words = blocks_at + BLOCKS_AT_ONCE as u64 * block_words;
        let mut model = LaneModel {
            process: Process::load(&design.built, words)?,
            registers: design.registers.len(),
            outputs,
            samples,
            blocks_at,
            block_words,
            tables: tables.len() as u64,
            next_place: 0,
            under_way: VecDeque::new(),
        };
        model
            .set_tables(tables, tables_at, data_at)
            .map_err(halted)?;
        Ok(model)
    }

    fn set_tables(&mut self, tables: &[Table], at: u64, mut data_at: u64) -> Result<(), String> {
        let mut words = Vec::new();
        for table in tables {
            let length = table.planes.len() as u64;
            words.extend([table.output as u64, length, data_at]);
            self.process.write(data_at, &table.planes)?;
            data_at += length;
        }
        self.process.write(at, &words)?;
        self.ask(What::Tables, at)
    }

    fn ask(&mut self, what: What, at: u64) -> Result<(), String> {
        self.process.ask(what as u64, [at, 0, 0, 0, 0])?;
        self.process.answer()
    }

    /// Sets all registers, one plane each.
    pub(super) fn set_registers(&mut self, planes: &[u64]) -> Result<(), String> {
        assert!(planes.len() == self.registers && self.under_way.is_empty());
        self.process.write(0, planes)?;
        self.ask(What::Load, 0)
    }

    /// Reads all registers, one plane each.
    pub(super) fn registers(&mut self) -> Result<Vec<u64>, String> {
        assert!(self.under_way.is_empty());
        self.ask(What::Save, 0)?;
        let mut planes = vec![0; self.registers];
        self.process.read(0, &mut planes)?;
        Ok(planes)
    }

    /// Sets what all outputs are expected to be.
    pub(super) fn expect(&mut self, planes: &[u64]) -> Result<(), String> {
        assert!(planes.len() as u64 == self.outputs && self.under_way.is_empty());
        self.process.write(0, planes)?;
        self.ask(What::Expect, 0)
    }

    /// Blocks under way.
    pub(super) fn under_way(&self) -> usize {
        self.under_way.len()
    }

    /// Hands over a block, and does not wait for its end. At most [`BLOCKS_AT_ONCE`]
    /// may be under way.
    pub(super) fn submit(&mut self, block: &LaneBlock) -> Result<(), String> {
        assert!(self.under_way.len() < BLOCKS_AT_ONCE && block.clocks <= BLOCK_CLOCKS);
        assert_eq!(block.samples.len() as u64, block.clocks * self.samples);
        let place = self.next_place;
        self.next_place = (place + 1) % BLOCKS_AT_ONCE;
        let at = self.blocks_at + place as u64 * self.block_words;
        let samples_at = at + BLOCK_WORDS + self.tables;
        let events_at = samples_at + BLOCK_CLOCKS * self.samples;
        let mut words = vec![
            block.clocks,
            block.reset,
            u64::MAX,
            block.watched,
            !block.reset,
            samples_at,
            block.events.len() as u64,
            events_at,
            self.found_at(place),
        ];
        words.extend(&block.phases);
        let events: Vec<u64> = block
            .events
            .iter()
            .flat_map(|event| [event.clock, event.output as u64, event.flips])
            .collect();
        self.process.write(at, &words)?;
        self.process.write(samples_at, &block.samples)?;
        self.process.write(events_at, &events)?;
        self.process.ask(What::Check as u64, [at, 0, 0, 0, 0])?;
        self.under_way.push_back(place);
        Ok(())
    }

    fn found_at(&self, place: usize) -> u64 {
        let at = self.blocks_at + place as u64 * self.block_words;
        at + self.block_words - FOUND_WORDS - BLOCK_CLOCKS * (self.outputs + 1)
    }

    /// Waits for the end of the block that was handed over first.
    pub(super) fn collect(&mut self) -> Result<Found, String> {
        let place = self.under_way.pop_front().expect("a block is under way");
        self.process.answer()?;
        let at = self.found_at(place);
        let mut head = [0; FOUND_WORDS as usize];
        self.process.read(at, &mut head)?;
        let [different, first_clock, beats] = head;
        let words = self.outputs as usize + 1;
        let beats = beats.min(BLOCK_CLOCKS) as usize;
        let mut list = vec![0; beats * words];
        self.process.read(at + FOUND_WORDS, &mut list)?;
        Ok(Found {
            different,
            first_clock,
            beats: list
                .chunks_exact(words)
                .map(|beat| (beat[0], beat[1..].to_vec()))
                .collect(),
        })
    }
}

/// A model of ours that ended by itself.
pub(super) fn halted(reason: String) -> CosimError {
    CosimError::Halted {
        when: crate::cosim::error::When::Start,
        reason: format!("in lanes: {reason}"),
    }
}
