//! One Verilator model of many blocks, each with inputs of its own.

use std::fmt::Write as _;
use std::fs;

use goldtof::rtl::back::{ModuleText, Prefix, verilog_of};
use goldtof::rtl::front::{BlockInputs, tick};
use rust_hdl_core::atom::Atom;
use rust_hdl_core::block::Block;
use rust_hdl_core::probe::Probe;
use rust_hdl_core::simulate::simulate;

use super::run;

/// Names, widths and values of a block's ports.
#[derive(Default)]
struct Ports {
    depth: u32,
    all: Vec<(String, u32, u128)>,
}

impl Probe for Ports {
    fn visit_start_scope(&mut self, _name: &str, _node: &dyn Block) {
        self.depth += 1;
    }

    fn visit_atom(&mut self, name: &str, atom: &dyn Atom) {
        if self.depth == 1 {
            let number = format!("{:x}", atom.verilog());
            let (_, digits) = number.split_once("'h").expect("it is a number");
            let value = u128::from_str_radix(digits, 16).expect("it is one of a word");
            self.all.push((name.to_owned(), atom.bits() as u32, value));
        }
    }

    fn visit_end_scope(&mut self, _name: &str, _node: &dyn Block) {
        self.depth -= 1;
    }
}

/// Those of the ports `names`, in that order; a vector's are one after another.
fn ports_of(block: &dyn Block, names: &[&str]) -> Vec<(String, u32, u128)> {
    let mut ports = Ports::default();
    block.accept("block", &mut ports);
    let named = |name: &str| {
        let is_one = |port: &str| port.split('$').next() == Some(name);
        let found: Vec<_> = ports.all.iter().filter(|(port, _, _)| is_one(port)).cloned().collect();
        assert!(!found.is_empty(), "the block has no port {name}");
        found
    };
    names.iter().flat_map(|name| named(name)).collect()
}

/// A block, its inputs, and its outputs after every clock.
pub struct Case {
    modules: Vec<ModuleText>,
    /// Names and widths.
    in_ports: Vec<(String, u32)>,
    out_ports: Vec<(String, u32)>,
    is_clocked: bool,
    inputs: Vec<Vec<u128>>,
    /// What the rust-hdl simulation gives.
    simulated: Vec<Vec<u128>>,
    /// What the block is for; `None` where nothing is promised.
    expected: Vec<Option<Vec<u128>>>,
}

impl Case {
    /// Clocks of reset at the start.
    pub const RESET_CLOCKS: usize = 2;

    /// A block, whose inputs of these names are set and whose outputs are read, in their order; a
    /// vector's are as many.
    pub fn new<B: Block + BlockInputs>(
        mut block: B,
        (in_names, out_names): (&[&str], &[&str]),
        inputs: Vec<Vec<u128>>,
        expected: Vec<Option<Vec<u128>>>,
    ) -> Case {
        let modules = verilog_of(&block, &Prefix::default(), "a test").expect("the block is sound");
        let is_clocked = modules.last().is_some_and(|module| module.text.contains("i_clk"));
        let ports = |names| {
            let ports = ports_of(&block, names).into_iter();
            ports.map(|(name, width, _)| (name, width)).collect::<Vec<_>>()
        };
        let (in_ports, out_ports) = (ports(in_names), ports(out_names));
        let simulated = inputs
            .iter()
            .enumerate()
            .map(|(number, input)| {
                assert_eq!(input.len(), in_ports.len());
                for ((name, _), value) in in_ports.iter().zip(input) {
                    block.set(name, *value);
                }
                let settle = |block: &mut B| {
                    assert!(simulate(block, 50), "the block does not settle");
                };
                settle(&mut block);
                tick(&mut block, number < Self::RESET_CLOCKS);
                settle(&mut block);
                ports_of(&block, out_names).into_iter().map(|(_, _, value)| value).collect()
            })
            .collect();
        Case { modules, in_ports, out_ports, is_clocked, inputs, simulated, expected }
    }

    /// Name of the block's module.
    fn name(&self) -> &str {
        &self.modules.last().expect("a block has a module").name
    }

    /// Holds simulation, Verilog and expectation against each other.
    pub fn agrees_with(&self, verilog: &[Vec<u128>]) {
        assert_eq!(verilog.len(), self.inputs.len());
        let promised = self.expected.iter().flatten().count();
        assert!(promised * 3 > self.inputs.len(), "{}: too little is promised", self.name());
        for (clock, simulated) in self.simulated.iter().enumerate() {
            let input = &self.inputs[clock];
            assert_eq!(simulated, &verilog[clock], "{}, clock {clock}, {input:?}", self.name());
            if let Some(expected) = &self.expected[clock] {
                assert_eq!(simulated, expected, "{}, clock {clock}, {input:?}", self.name());
            }
        }
    }

    fn input_bits(&self) -> u32 {
        1 + self.in_ports.iter().map(|(_, width)| width).sum::<u32>()
    }

    /// The block's modules, with names that no other case has.
    fn renamed(&self, number: usize) -> String {
        let mut text = String::new();
        for module in &self.modules {
            text += &module.text;
        }
        let words = |text: &str, from: &str, to: &str| {
            let mut renamed = String::new();
            let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let mut rest = text;
            while let Some(at) = rest.find(from) {
                let (before, after) = (&rest[..at], &rest[at + from.len()..]);
                let is_whole = !before.ends_with(is_word) && !after.starts_with(is_word);
                renamed += before;
                renamed += if is_whole { to } else { from };
                rest = after;
            }
            renamed + rest
        };
        for module in &self.modules {
            text = words(&text, &module.name, &format!("case_{number}_{}", module.name));
        }
        text
    }

    /// Memory of inputs, wire of outputs and instance.
    fn in_testbench(&self, number: usize) -> String {
        let mut testbench = String::new();
        let input_bits = self.input_bits();
        let output_bits: u32 = self.out_ports.iter().map(|(_, width)| width).sum();
        let last = self.inputs.len() - 1;
        let mut pins = Vec::new();
        if self.is_clocked {
            pins.push(".i_clk(clk)".to_owned());
            pins.push(format!(".i_rst(now_{number}[0])"));
        }
        let mut at = 1;
        for (name, width) in vectors(&self.in_ports) {
            pins.push(format!(".{name}(now_{number}[{}:{at}])", at + width - 1));
            at += width;
        }
        let mut at = 0;
        for (name, width) in vectors(&self.out_ports) {
            pins.push(format!(".{name}(out_{number}[{}:{at}])", at + width - 1));
            at += width;
        }
        let _ = write!(
            testbench,
            "    reg [{}:0] inputs_{number} [0:{last}];\n    reg [{}:0] now_{number};\n    \
             wire [{}:0] out_{number};\n    case_{number}_{} dut_{number} ({});\n    \
             initial $readmemh(\"inputs_{number}.hex\", inputs_{number});\n",
            input_bits - 1,
            input_bits - 1,
            output_bits - 1,
            self.name(),
            pins.join(", ")
        );
        testbench
    }

    /// The inputs as `$readmemh` takes them.
    fn inputs_file(&self) -> String {
        let mut file = String::new();
        for (clock, input) in self.inputs.iter().enumerate() {
            let mut word = u128::from(clock < Self::RESET_CLOCKS);
            let mut at = 1;
            for (value, (_, width)) in input.iter().zip(&self.in_ports) {
                word |= value << at;
                at += width;
            }
            let _ = writeln!(file, "{word:x}");
        }
        file
    }

    fn outputs_of(&self, mut word: u128) -> Vec<u128> {
        let values = self.out_ports.iter().map(|(_, width)| {
            let value = word & (u128::MAX >> (128 - width));
            word >>= width;
            value
        });
        values.collect()
    }
}

/// Ports as the Verilog has them: a vector's are one.
fn vectors(ports: &[(String, u32)]) -> impl Iterator<Item = (&str, u32)> {
    fn base((name, _): &(String, u32)) -> &str {
        name.split_once('$').map_or(name, |(base, _)| base)
    }
    let vectors = ports.chunk_by(|a, b| base(a) == base(b));
    vectors.map(|vector| (base(&vector[0]), vector.iter().map(|(_, width)| width).sum()))
}

/// Outputs of every case after every clock, from one Verilator model of all.
pub fn run_in_verilator(cases: &[Case]) -> Vec<Vec<Vec<u128>>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut testbench = "module testbench;\n    reg clk = 0;\n    integer clock;\n".to_owned();
    let mut modules = String::new();
    let (mut sets, mut shows, mut formats) = (String::new(), String::new(), String::new());
    for (number, case) in cases.iter().enumerate() {
        modules += &case.renamed(number);
        testbench += &case.in_testbench(number);
        let _ = writeln!(sets, "            now_{number} = inputs_{number}[clock];");
        let _ = write!(shows, ", out_{number}");
        formats += "%h ";
        let name = folder.path().join(format!("inputs_{number}.hex"));
        fs::write(name, case.inputs_file()).expect("the inputs can be written");
    }
    let clocks = cases[0].inputs.len();
    let _ = write!(
        testbench,
        "    initial begin\n        #1;\n        for (clock = 0; clock < {clocks}; clock = clock + 1) begin\n\
         {sets}            #1 clk = 1;\n            #1 $display(\"{formats}\"{shows});\n            \
         clk = 0;\n        end\n        $finish;\n    end\nendmodule\n"
    );
    let text = format!("`timescale 1ns / 1ps\n{testbench}{modules}");
    fs::write(folder.path().join("bench.v"), text).expect("the testbench can be written");
    let arguments = [
        "--binary",
        "--timing",
        "-Wno-fatal",
        "-Wno-lint",
        "-Wno-style",
        "-O3",
        "--x-assign",
        "fast",
        "-CFLAGS",
        "-O1",
        "--top-module",
        "testbench",
        "-j",
        "2",
        "bench.v",
    ];
    run(folder.path(), "verilator", &arguments);
    let said = run(folder.path(), "./obj_dir/Vtestbench", &[]);
    let mut outputs = vec![Vec::new(); cases.len()];
    for line in said.lines().filter(|line| !line.starts_with("- ")) {
        for ((case, outputs), word) in cases.iter().zip(&mut outputs).zip(line.split_whitespace()) {
            let word = u128::from_str_radix(word, 16).expect("outputs are numbers");
            outputs.push(case.outputs_of(word));
        }
    }
    outputs
}
