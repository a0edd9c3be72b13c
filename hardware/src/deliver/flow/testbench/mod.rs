//! The self-checking testbench: Verilog that needs neither Rust nor goldtof.

mod header;

use serde::Serialize;

use self::header::{covered, time_in_words};
use super::file_list::testbench_file_list;
use super::run_length::RunLengthWords;
use super::stimulus::{MOST_CLOCKS, PortGroup, Recording, VectorColumn};
use crate::deliver::design::{EmittedDesign, EmittedFile};
use crate::deliver::template::filled;
use crate::reference::cover_report::Coverage;
use crate::scan::{Clock, Timescale};

/// The testbench and how much it covers.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Testbench {
    /// Its top module.
    pub top: String,
    /// Its Verilog.
    pub files: Vec<EmittedFile>,
    /// The design's files and the testbench's, for `-f`.
    pub file_list: EmittedFile,
    /// What its Verilog reads at run time, from the folder it runs in.
    pub vectors: Vec<EmittedFile>,
    /// Clocks that it runs and compares.
    pub clocks: u64,
    /// Phase steps whose integration ends within these clocks.
    pub phase_steps: u64,
    /// Scans whose last phase step ends within these clocks.
    pub scans: u64,
    /// Hits that count up in the results that come to the stream, each once for
    /// every phase step that sees it.
    pub hits_up: u64,
    /// Hits that count down.
    pub hits_down: u64,
    /// How much of what the sensor can be made to do it covers.
    pub coverage: Coverage,
}

/// Name of the vectors that drive the sensor; all others but the next are expected
/// values.
const INPUTS: &str = "inputs";
/// Name of those that move the scan's counters on.
const SKIPS: &str = "skips";

/// What the testbench and its parts are called.
struct Names {
    /// The design's top module.
    design: String,
    /// The testbench's module.
    top: String,
    /// The module that unpacks a vector file.
    reader: String,
    /// The macro for a design that has not the scan's counters.
    whole: String,
}

impl Names {
    fn of(design: &EmittedDesign) -> Names {
        let name = design.top();
        Names {
            top: format!("{name}_tb"),
            reader: format!("{name}_tb_vectors"),
            whole: design.prefix.of_macro("SENSOR_TOP_TB_WHOLE"),
            design: name,
        }
    }
}

/// A group of ports with its vector file.
struct VectorFile<'a> {
    name: &'static str,
    group: &'a PortGroup,
    words: RunLengthWords,
}

impl VectorFile<'_> {
    fn file_name(&self, names: &Names) -> String {
        format!("{}_{}.hex", names.top, self.name)
    }

    /// Nets of the ports, from bit 0 up.
    fn nets(&self) -> impl DoubleEndedIterator<Item = String> {
        self.group.ports.iter().map(|port| match self.name {
            INPUTS => port.name.clone(),
            SKIPS => skip_net(&port.name),
            _ => format!("expected_{}", port.name),
        })
    }
}

/// The net with what goes into a counter.
fn skip_net(register: &str) -> String {
    format!("skip_{}", register.replace('.', "_"))
}

/// Writes the testbench round the vectors of a recorded run.
pub(super) fn testbench(design: &EmittedDesign, recording: Recording) -> Testbench {
    let names = Names::of(design);
    let skips = recording.skips.as_ref().map(|skips| (SKIPS, &skips.values));
    let vectors: Vec<VectorFile> =
        [(INPUTS, &recording.inputs), ("chips", &recording.chips), ("results", &recording.results)]
            .into_iter()
            .chain(skips)
            .map(|(name, group)| VectorFile { name, group, words: group.runs.encode(group.bits()) })
            .collect();
    let file = |name: String, text| EmittedFile { name, text };
    let files = vec![
        file(
            format!("{}.v", names.reader),
            filled(
                include_str!("vectors.v"),
                &[("READER", &names.reader), ("MADE_BY", design.made_by)],
            ),
        ),
        file(
            format!("{}.v", names.top),
            top(&names, design.sensor.clock(), &recording, &vectors, design.made_by),
        ),
    ];
    Testbench {
        file_list: testbench_file_list(design, &names.top, &files),
        files,
        clocks: recording.clocks,
        phase_steps: recording.phase_steps,
        scans: recording.scans,
        hits_up: recording.hits_up,
        hits_down: recording.hits_down,
        coverage: recording.coverage,
        vectors: vectors.into_iter().map(|v| file(v.file_name(&names), v.words.text)).collect(),
        top: names.top,
    }
}

/// `[7:0] name` or, for one bit, `name`, with names in one column.
fn declared(kind: &str, width: u32, name: &str) -> String {
    let range = if width == 1 { String::new() } else { format!("[{}:0]", width - 1) };
    format!("    {kind} {range:<7} {name};\n")
}

fn top(
    names: &Names,
    clock: Clock,
    recording: &Recording,
    vectors: &[VectorFile],
    made_by: &str,
) -> String {
    let time = Timescale::of(clock, MOST_CLOCKS);
    let outputs = || recording.chips.ports.iter().chain(&recording.results.ports);
    let ports = || recording.inputs.ports.iter().chain(outputs());
    let wire = |port: &VectorColumn| declared("wire", port.width, &port.name);
    let mut expected: String = outputs()
        .map(|port| declared("wire", port.width, &format!("expected_{}", port.name)))
        .collect();
    for register in recording.skips.iter().flat_map(|skips| &skips.registers) {
        expected += &declared("wire", register.width(), &skip_net(&register.path(".")));
    }
    for vector in vectors {
        expected += &declared("wire", vector.group.bits(), &format!("{}_value", vector.name));
    }
    let connections: Vec<String> = std::iter::once("i_clk")
        .chain(ports().map(|port| port.name.as_str()))
        .map(|name| format!("        .{name:<13} ({name})"))
        .collect();
    let readers: String = vectors.iter().map(|vector| reader_instance(names, vector)).collect();
    let there: String = vectors.iter().map(|vector| vector_check(names, vector)).collect();
    // Where the scan's counters have just been moved on, what follows them is free to move.
    let unmoved = recording.skips.as_ref().map(|_| format!(" && !(|{SKIPS}_value)"));
    let chip_ps = clock.chip_period_ps;
    filled(
        include_str!("testbench.v"),
        &[
            ("TOP", &names.top),
            ("DESIGN", &names.design),
            ("RESETS", &recording.resets.to_string()),
            ("CLOCKS", &recording.clocks.to_string()),
            ("STEPS", &recording.phase_steps.to_string()),
            ("SCANS", &recording.scans.to_string()),
            ("HITS_UP", &recording.hits_up.to_string()),
            ("HITS_DOWN", &recording.hits_down.to_string()),
            ("COVERS", &covered(recording, &names.whole)),
            ("MADE_BY", made_by),
            ("TIME", &time_in_words(clock, time)),
            ("UNIT", &time.to_string()),
            ("LENGTH", &length(names, recording)),
            // Verilator does not take a time scale in some files of many, and has its own where none has one.
            ("HALVES_PS", &halves((chip_ps / 2.0).round() as u64, chip_ps.round() as u64)),
            ("HALVES", &halves(time.after_halves(1), time.after_halves(2))),
            ("PORTS", &ports().map(wire).collect::<String>()),
            ("EXPECTED", &expected),
            ("CONNECTIONS", &connections.join(",\n")),
            ("READERS", &readers),
            ("COMPARED", &outputs().map(port_check).collect::<String>()),
            ("MOVES", &moves(names, recording)),
            ("UNMOVED", &unmoved.unwrap_or_default()),
            ("THERE", &there),
        ],
    )
}

/// The number of clocks: all of them, or those before a counter is moved on.
fn length(names: &Names, recording: &Recording) -> String {
    match &recording.skips {
        None => format!("    localparam CLOCKS = {};\n", recording.clocks),
        Some(skips) => format!(
            "`ifdef {}\n    localparam CLOCKS = {};\n`else\n    localparam CLOCKS = {};\n`endif\n",
            names.whole, skips.first_clock, recording.clocks
        ),
    }
}

/// How long the clock is low and high in each period.
fn halves(low: u64, period: u64) -> String {
    let low = low.max(1);
    format!("LOW = 64'd{low}, HIGH = 64'd{}", period.saturating_sub(low).max(1))
}

/// What moves the scan's counters on, before a rising edge.
fn moves(names: &Names, recording: &Recording) -> String {
    let Some(skips) = &recording.skips else {
        return String::new();
    };
    let lines: String = skips
        .registers
        .iter()
        .map(|register| {
            let path = register.path(".");
            format!("            dut.{path} <= dut.{path} ^ {};\n", skip_net(&path))
        })
        .collect();
    let whole = &names.whole;
    format!(
        "`ifndef {whole}
            // Steps and scans are cut short: nothing else in the design is touched.
            /* verilator lint_off INITIALDLY */
{lines}            /* verilator lint_on INITIALDLY */
`endif
"
    )
}

fn reader_instance(names: &Names, vector: &VectorFile) -> String {
    let reader = &names.reader;
    let name = vector.name;
    let parts: Vec<String> = vector.nets().rev().collect();
    let file_name = vector.file_name(names);
    format!(
        "
    {reader} #(
        .FILE      (\"{file_name}\"),
        .WORDS     ({words}),
        .W_REPEATS ({repeat_bits}),
        .W_VALUE   ({value_bits})
    ) {name}_file (
        .i_clk     (i_clk),
        .o_value   ({name}_value)
    );
    assign {{
        {parts}
    }} = {name}_value;
",
        words = vector.words.count,
        repeat_bits = vector.words.repeat_bits,
        value_bits = vector.group.bits(),
        parts = parts.join(",\n        "),
    )
}

/// Whether a vector file is there, and long enough.
fn vector_check(names: &Names, vector: &VectorFile) -> String {
    // A simulator with two states reads a missing file as zeros.
    let no_reset = if vector.name == INPUTS { " || (clock == 0 && !i_rst)" } else { "" };
    format!(
        "            if (^{name}_value === 1'bx{no_reset}) begin
                $display(\"FAIL clock %0d: {file} is missing or short\", clock);
                failed = 1'b1;
            end
",
        name = vector.name,
        file = vector.file_name(names),
    )
}

/// Whether a port is as expected.
fn port_check(port: &VectorColumn) -> String {
    // Without a result the interface promises nothing of its payload.
    let counts = if port.is_payload { "expected_m_axis_tvalid && " } else { "" };
    format!(
        "            if ({counts}{name} !== expected_{name}) begin
                $display(\"FAIL clock %0d: {name} expected %h got %h\", at,
                         expected_{name}, {name});
                failed = 1'b1;
            end
",
        name = port.name,
    )
}
