//! Testbenches round the design in other frameworks, each in a folder of its own: for cocotb, and for
//! any simulator with DPI-C and `bind`.

use super::design::EmittedFile;
use super::emission::{Emission, made_by};
use super::template::filled;
use crate::printable::printable_ascii;
use crate::rtl::back::Prefix;
use crate::scene::SceneText;
use crate::sensor::Sensor;
use crate::sensor::port::{Direction, Port, PortRole, Use};
use crate::sensor::registers::{MappedRegister, RegisterPlan, is_same};

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
        let values = [
            ("SETTINGS", format!("[{}]", settings.join(", "))),
            ("CLOCKS", clocks(sensor).to_string()),
            ("MADE_BY", format!("Made by  {}", made_by(&emission.command))),
            ("TOP", emission.top.clone()),
            ("FILES", files.join(" ")),
            ("HOST_AT_REST", rest.concat()),
            ("MORE_TESTS", more_tests.to_owned()),
            ("DEFINES", defines.clone()),
        ];
        filled(text, &values.each_ref().map(|(name, value)| (*name, value.as_str())))
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
        let MappedRegister { name, address, .. } = register;
        format!("    \"{name}\": {address:#05x},\n")
    });
    let values = [
        ("REGISTERS", format!("{{\n{}}}", registers.collect::<String>())),
        ("REFERENCES", format!("[{}]", references.collect::<Vec<_>>().join(", "))),
        ("SAMPLES", samples.to_string()),
        ("CELLS", interface.input_cells.count.to_string()),
        ("COINCIDENCE", interface.input_cells.coincidence.to_string()),
        ("PARALLEL", parallel.to_string()),
        ("CODE_CHIPS", plan.period_chips.to_string()),
        ("COUNT_BITS", interface.count_bits().to_string()),
        ("CHIPS", chips.to_string()),
        ("GROUPS", groups.to_string()),
        ("FIRST", first.to_string()),
    ];
    filled(
        include_str!("test_registers.py"),
        &values.each_ref().map(|(name, value)| (*name, value.as_str())),
    )
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
    filled(
        include_str!("testbench.v"),
        &[
            ("MADE_BY", &made_by(&emission.command)),
            ("TOP", &emission.top),
            ("PORTS", &declared.join(",\n")),
            ("OWN", &own.join(",\n        ")),
            ("WIDTHS", &widths),
            ("CONNECTED", &connected.join(",\n        ")),
        ],
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
    let width = |role: PortRole| ports.iter().find(|port| port.role == role).map(|port| port.width);
    let widths = [
        ("SAMPLES", PortRole::Samples),
        ("LASERS", PortRole::Laser),
        ("TDATA", PortRole::Data),
        ("PEAK_STEP", PortRole::PeakStep),
        ("PEAK_COUNT", PortRole::PeakCount),
    ];
    let widths: Vec<String> = widths
        .into_iter()
        .filter_map(|(name, role)| Some(format!(".{name}({})", width(role)?)))
        .collect();
    let optional =
        [PortRole::Saturated, PortRole::PeakStep, PortRole::PeakCount, PortRole::PeakValid];
    let lacking = optional.into_iter().filter(|role| width(*role).is_none());
    let own = ports.iter().map(|port| format!(".{0}({0})", port.name));
    let connected = own.chain(lacking.map(|role| format!(".{}(1'b0)", role.name())));
    (widths.join(", "), connected.collect())
}

/// What binds goldtof's scoreboard, and rules of its stream, to a design, in the folder [`BIND`].
pub fn bind(emission: &Emission, prefix: &Prefix, scene: &SceneText) -> Vec<EmittedFile> {
    let made_by = made_by(&emission.command);
    let (widths, connected) = beside(&emission.ports);
    let rules = prefix.of("axis_rules");
    let has_registers = emission.ports.iter().any(|port| port.role.usage() == Use::Host);
    let defines = if has_registers { format!("`define {REGISTERS}\n") } else { String::new() };
    let data = emission.ports.iter().find(|port| port.role == PortRole::Data);
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
    let text = filled(
        include_str!("bind.sv"),
        &[
            ("MADE_BY", &made_by),
            ("TOP", &emission.top),
            ("DEFINES", &defines),
            ("SET", &set),
            ("WIDTHS", &widths),
            ("CONNECTED", &connected.join(",\n    ")),
            ("RULES", &rules),
            ("DATA_BITS", &data.map_or(1, |port| port.width).to_string()),
        ],
    );
    let rules_text = filled(
        include_str!("axis_rules.sv"),
        &[("MADE_BY", &format!("Made by  {made_by}")), ("PREFIX", &prefix.to_string())],
    );
    vec![
        EmittedFile { name: format!("{}_bind.sv", emission.top), text },
        EmittedFile { name: format!("{rules}.sv"), text: rules_text },
        EmittedFile { name: "scene.toml".to_owned(), text: scene.text.clone() },
    ]
}
