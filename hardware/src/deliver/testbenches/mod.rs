//! Testbenches round the design in other frameworks, each in a folder of its own: for cocotb, and for
//! any simulator with DPI-C and `bind`.

use std::fmt::Write as _;

use super::design::EmittedFile;
use super::emission::{Emission, made_by};
use crate::printable::printable_ascii;
use crate::rtl::back::Prefix;
use crate::scene::SceneText;
use crate::sensor::Sensor;
use crate::sensor::port::{Direction, Port, Role, Use};
use crate::sensor::registers::{Register, RegisterPlan, is_same};

/// Folder of the testbench for cocotb.
pub const COCOTB: &str = "cocotb";
/// Folder of what is bound to a design.
pub const BIND: &str = "bind";

/// Results that a testbench waits for.
const RESULTS: u64 = 3;
/// Groups of the scan that a testbench's host asks for.
const GROUPS: u64 = 4;
/// The macro that gives what stands beside a design the ports of its registers.
const REGISTERS: &str = "GOLDTOF_REGISTERS";

/// A testbench for cocotb, in the folder [`COCOTB`] beside the design: a test with goldtof's
/// scoreboard, the design with the recorder, a Makefile, and the scene.
pub fn cocotb(sensor: &Sensor, emission: &Emission, scene: &SceneText) -> Vec<EmittedFile> {
    let settings: Vec<String> = scene
        .settings
        .iter()
        .map(|setting| {
            let (key, value) = setting.key_and_value();
            format!("({}, {})", python_text(key), python_text(value))
        })
        .collect();
    let files: Vec<String> =
        emission.files.iter().map(|file| format!("$(CURDIR)/../{}", file.name)).collect();
    let plan = sensor.interface().registers.as_deref();
    let rest: Vec<String> = emission
        .ports
        .iter()
        .filter(|port| port.role.usage() == Use::Host)
        .map(|port| format!("    dut.{}.value = 0\n", port.name))
        .collect();
    let (more_tests, defines) = match plan {
        None => ("", String::new()),
        Some(_) => (",test_registers", format!(" -D{REGISTERS}")),
    };
    let filled = |text: &str| {
        text.replace("@SETTINGS@", &format!("[{}]", settings.join(", ")))
            .replace("@CLOCKS@", &clocks(sensor).to_string())
            .replace("@MADE_BY@", &format!("Made by  {}", made_by(&emission.command)))
            .replace("@TOP@", &emission.top)
            .replace("@FILES@", &files.join(" "))
            .replace("@HOST_AT_REST@", &rest.concat())
            .replace("@MORE_TESTS@", more_tests)
            .replace("@DEFINES@", &defines)
    };
    let file = |name: &str, text: String| EmittedFile { name: name.to_owned(), text };
    let mut all = vec![
        file("test_sensor.py", filled(include_str!("test_sensor.py"))),
        file("Makefile", filled(include_str!("Makefile"))),
        file("testbench.v", around(emission)),
        file("scene.toml", scene.text.clone()),
    ];
    all.extend(plan.map(|plan| file("test_registers.py", of_registers(sensor, plan))));
    all
}

/// A test with a host. Its scan is short and has whole code periods, so that counts follow from the chips; if
/// that cannot be, the model alone judges.
fn of_registers(sensor: &Sensor, plan: &RegisterPlan) -> String {
    let interface = sensor.interface();
    let (samples, parallel) = (u64::from(interface.lanes()), u64::from(interface.parallel()));
    // A receiver that stalls has time for a group.
    let least = plan.least_chips.max(4 * interface.beats_of_group());
    let most = (1 << plan.chips_bits) - 1;
    let whole = least.next_multiple_of(plan.period_chips);
    let chips = match whole <= most && !interface.saturates() {
        true => whole,
        false => least.min(most),
    };
    let groups = GROUPS.min((1 << plan.groups_bits) - 1);
    let first = match plan.fixed_samples {
        Some(fixed) => samples + u64::from(fixed),
        None => samples - 1,
    };
    let codes = &interface.source_codes;
    let references = interface.reference_codes.iter().map(|reference| {
        codes.iter().position(|code| is_same(code, reference)).unwrap_or(0).to_string()
    });
    let map = plan.map(&interface.timing, codes);
    let registers = map.iter().map(|register| {
        let Register { name, address, .. } = register;
        format!("    \"{name}\": {address:#05x},\n")
    });
    include_str!("test_registers.py")
        .replace("@REGISTERS@", &format!("{{\n{}}}", registers.collect::<String>()))
        .replace("@REFERENCES@", &format!("[{}]", references.collect::<Vec<_>>().join(", ")))
        .replace("@SAMPLES@", &samples.to_string())
        .replace("@PARALLEL@", &parallel.to_string())
        .replace("@CODE_CHIPS@", &plan.period_chips.to_string())
        .replace("@COUNT_BITS@", &interface.count_bits().to_string())
        .replace("@CHIPS@", &chips.to_string())
        .replace("@GROUPS@", &groups.to_string())
        .replace("@FIRST@", &first.to_string())
}

/// A text of Python.
fn python_text(text: &str) -> String {
    // A text of JSON is one of Python.
    serde_json::Value::String(text.to_owned()).to_string()
}

/// Clocks in which some results come.
fn clocks(sensor: &Sensor) -> u64 {
    let interface = sensor.interface();
    let groups = match interface.histogram() {
        Some(_) => 1,
        None => RESULTS.min(interface.groups()),
    };
    let integration = sensor.timing().scan.integration_chips;
    // Settings are taken over, and the reference is aligned, before the first scan.
    let plan = interface.registers.as_ref();
    let begins = plan.map_or(0, |plan| plan.start_clocks() + interface.timing.preparation_chips);
    // A receiver that stalls takes a third longer for the rows, and reset some clocks.
    begins + groups * integration + 2 * interface.beats_of_group() + 1000
}

/// The design and the recorder, with the design's ports.
fn around(emission: &Emission) -> String {
    let declared: Vec<String> = emission
        .ports
        .iter()
        .map(|port| {
            let direction = match port.direction {
                Direction::Input => "input  wire",
                Direction::Output => "output wire",
            };
            format!("    {direction} {}{}", range(port), port.name)
        })
        .collect();
    let own: Vec<String> =
        emission.ports.iter().map(|port| format!(".{0}({0})", port.name)).collect();
    let (widths, connected) = beside(&emission.ports);
    format!(
        "// The design with goldtof's recorder beside it, for test_sensor.py.\n\
         // Made by  {}\n\n\
         `timescale 1ns / 1ps\n\n\
         `ifndef DESIGN\n`define DESIGN {}\n`endif\n\n\
         module testbench (\n{}\n);\n\
         \x20   `DESIGN sensor (\n        {});\n\n\
         \x20   goldtof_recorder #({widths}) recorder (\n        {});\n\
         endmodule\n",
        made_by(&emission.command),
        emission.top,
        declared.join(",\n"),
        own.join(",\n        "),
        connected.join(",\n        ")
    )
}

fn range(port: &Port) -> String {
    match port.width {
        1 => String::new(),
        width => format!("[{}:0] ", width - 1),
    }
}

/// Parameters and ports of what stands beside a design, the recorder or the scoreboard: those that
/// the design lacks rest at 0.
fn beside(ports: &[Port]) -> (String, Vec<String>) {
    let width = |role: Role| ports.iter().find(|port| port.role == role).map(|port| port.width);
    let widths = [
        ("SAMPLES", Role::Samples),
        ("LASERS", Role::Laser),
        ("TDATA", Role::Data),
        ("PEAK_STEP", Role::PeakStep),
        ("PEAK_COUNT", Role::PeakCount),
    ];
    let widths: Vec<String> = widths
        .into_iter()
        .filter_map(|(name, role)| Some(format!(".{name}({})", width(role)?)))
        .collect();
    let optional = [Role::Saturated, Role::PeakStep, Role::PeakCount, Role::PeakValid];
    let lacking = optional.into_iter().filter(|role| width(*role).is_none());
    let own = ports.iter().map(|port| format!(".{0}({0})", port.name));
    let connected = own.chain(lacking.map(|role| format!(".{}(1'b0)", role.name())));
    (widths.join(", "), connected.collect())
}

/// What binds goldtof's scoreboard, and rules of its stream, to a design, in the folder [`BIND`].
pub fn bind(emission: &Emission, prefix: &Prefix, scene: &SceneText) -> Vec<EmittedFile> {
    let made_by = format!("Made by  {}", made_by(&emission.command));
    let (widths, connected) = beside(&emission.ports);
    let rules = prefix.of("axis_rules");
    let has_registers = emission.ports.iter().any(|port| port.role.usage() == Use::Host);
    let data = emission.ports.iter().find(|port| port.role == Role::Data);
    let mut text = format!(
        "// Binds goldtof's scoreboard, which compares every output port with the reference model at every\n\
         // clock, and the rules of an AXI4-Stream to a design: the emitted one, or your own by\n\
         // +define+GOLDTOF_DESIGN=NAME. Compile it behind the design, with the folder of\n\
         // goldtof_scoreboard.svh among the include folders, and link libgoldtof_c.so.\n\
         // +define+GOLDTOF_SCENE='\"PATH\"' says where the scene is; +define+GOLDTOF_LATENCY=-2 holds the\n\
         // design to the latency that it shows.\n\
         // {made_by}\n\n\
         {}`include \"goldtof_scoreboard.svh\"\n\n\
         `ifndef GOLDTOF_DESIGN\n`define GOLDTOF_DESIGN {}\n`endif\n\
         `ifndef GOLDTOF_SCENE\n`define GOLDTOF_SCENE \"bind/scene.toml\"\n`endif\n\
         `ifndef GOLDTOF_LATENCY\n`define GOLDTOF_LATENCY -1\n`endif\n\n",
        match has_registers {
            true => format!("`define {REGISTERS}\n"),
            false => String::new(),
        },
        emission.top
    );
    let settings: Vec<String> = scene
        .settings
        .iter()
        .map(|setting| setting.key_and_value())
        .map(|(key, value)| format!("{key}={value}"))
        .collect();
    let set = match settings.is_empty() {
        true => String::new(),
        // A text of JSON in printable ASCII is one of SystemVerilog.
        false => format!(" .SET({}),", printable_ascii(&python_text(&settings.join("\n")))),
    };
    let _ = write!(
        text,
        "bind `GOLDTOF_DESIGN goldtof_scoreboard #(\n\
         \x20   .SCENE(`GOLDTOF_SCENE),{set} .RESULT_LATENCY(`GOLDTOF_LATENCY), {widths}\n\
         ) goldtof_bound_scoreboard (\n    {});\n\n\
         bind `GOLDTOF_DESIGN {rules} #(.TDATA({})) goldtof_bound_rules (\n\
         \x20   .i_clk(i_clk), .i_rst(i_rst), .m_axis_tready(m_axis_tready), .m_axis_tdata(m_axis_tdata),\n\
         \x20   .m_axis_tvalid(m_axis_tvalid), .m_axis_tlast(m_axis_tlast));\n",
        connected.join(",\n    "),
        data.map_or(1, |port| port.width),
    );
    let rules_text = include_str!("axis_rules.sv")
        .replace("@MADE_BY@", &made_by)
        .replace("@PREFIX@", &prefix.to_string());
    vec![
        EmittedFile { name: format!("{}_bind.sv", emission.top), text },
        EmittedFile { name: format!("{rules}.sv"), text: rules_text },
        EmittedFile { name: "scene.toml".to_owned(), text: scene.text.clone() },
    ]
}
