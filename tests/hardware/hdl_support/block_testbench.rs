//! One Verilator model of many blocks, each with inputs of its own.

use std::fmt::Write as _;
use std::fs;

use goldtof::rtl::back::{ModuleText, Prefix, verilog_of};
use goldtof::rtl::front::tick;
use rust_hdl_core::block::Block;
use rust_hdl_core::simulate::simulate;

use super::run;

/// Names and widths of a block's ports besides clock and reset.
pub struct Ports {
    inputs: Vec<(String, u32)>,
    outputs: Vec<(String, u32)>,
}

impl Ports {
    pub fn new(inputs: &[(&str, u32)], outputs: &[(&str, u32)]) -> Ports {
        let owned = |ports: &[(&str, u32)]| {
            let port = |&(name, width): &(&str, u32)| (name.to_owned(), width);
            ports.iter().map(port).collect()
        };
        Ports { inputs: owned(inputs), outputs: owned(outputs) }
    }
}

/// A block, its inputs, and its outputs after every clock.
pub struct Case {
    modules: Vec<ModuleText>,
    ports: Ports,
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

    /// A block with a clock. `set` sets its inputs, and `get` reads its outputs, in the order of
    /// `ports`.
    pub fn clocked<B: Block>(
        mut block: B,
        ports: Ports,
        inputs: Vec<Vec<u128>>,
        expected: Vec<Option<Vec<u128>>>,
        set: impl Fn(&mut B, &[u128]),
        get: impl Fn(&B) -> Vec<u128>,
    ) -> Case {
        let modules = verilog_of(&block, &Prefix::default(), "a test").expect("the block is sound");
        let simulated = inputs
            .iter()
            .enumerate()
            .map(|(number, input)| {
                set(&mut block, input);
                let settle = |block: &mut B| {
                    assert!(simulate(block, 50), "the block does not settle");
                };
                settle(&mut block);
                tick(&mut block, number < Self::RESET_CLOCKS);
                settle(&mut block);
                get(&block)
            })
            .collect();
        Case { modules, ports, is_clocked: true, inputs, simulated, expected }
    }

    /// A block without a clock.
    pub fn combinational<B: Block>(
        block: B,
        ports: Ports,
        inputs: Vec<Vec<u128>>,
        expected: Vec<Option<Vec<u128>>>,
        set: impl Fn(&mut B, &[u128]),
        get: impl Fn(&B) -> Vec<u128>,
    ) -> Case {
        Case { is_clocked: false, ..Case::clocked(block, ports, inputs, expected, set, get) }
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
        1 + self.ports.inputs.iter().map(|(_, width)| width).sum::<u32>()
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
        let output_bits: u32 = self.ports.outputs.iter().map(|(_, width)| width).sum();
        let last = self.inputs.len() - 1;
        let mut pins = Vec::new();
        if self.is_clocked {
            pins.push(".i_clk(clk)".to_owned());
            pins.push(format!(".i_rst(now_{number}[0])"));
        }
        let mut at = 1;
        for (name, width) in vectors(&self.ports.inputs) {
            pins.push(format!(".{name}(now_{number}[{}:{at}])", at + width - 1));
            at += width;
        }
        let mut at = 0;
        for (name, width) in vectors(&self.ports.outputs) {
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
            for (value, (_, width)) in input.iter().zip(&self.ports.inputs) {
                word |= value << at;
                at += width;
            }
            let _ = writeln!(file, "{word:x}");
        }
        file
    }

    fn outputs_of(&self, mut word: u128) -> Vec<u128> {
        let values = self.ports.outputs.iter().map(|(_, width)| {
            let value = word & (u128::MAX >> (128 - width));
            word >>= width;
            value
        });
        values.collect()
    }
}

/// Ports as the Verilog has them: `name_0`, `name_1` and so on are one.
fn vectors(ports: &[(String, u32)]) -> Vec<(String, u32)> {
    let mut out: Vec<(String, u32)> = Vec::new();
    let mut next = 0;
    for (name, width) in ports {
        let (base, place) = match name.rsplit_once('_') {
            Some((base, place)) if place.parse::<usize>().is_ok() => (base, place.parse().ok()),
            _ => (name.as_str(), None),
        };
        match out.last_mut() {
            Some((last, bits)) if last == base && place == Some(next) => *bits += width,
            _ => {
                next = 0;
                out.push((base.to_owned(), *width));
            }
        }
        next += 1;
    }
    out
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
