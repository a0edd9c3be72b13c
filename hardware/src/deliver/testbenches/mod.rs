//! Testbenches round the design in other frameworks, each in a folder of its own: for cocotb, and for
//! any simulator with DPI-C and `bind`.

use super::design::EmittedFile;
use super::emission::{Emission, made_by};
use super::template::filled;
use crate::printable::printable_ascii;
use crate::rtl::back::Prefix;
use crate::scene::SceneText;
use crate::sensor::Sensor;
use crate::sensor::port::{Direction, Port, Role};

/// Folder of the testbench for cocotb.
pub const COCOTB: &str = "cocotb";
/// Folder of what is bound to a design.
pub const BIND: &str = "bind";

/// Results that a testbench waits for.
const RESULTS: u64 = 3;

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
    let filled = |text: &str| {
        let values = [
            ("SETTINGS", format!("[{}]", settings.join(", "))),
            ("CLOCKS", clocks(sensor).to_string()),
            ("MADE_BY", format!("Made by  {}", made_by(&emission.command))),
            ("TOP", emission.top.clone()),
            ("FILES", files.join(" ")),
        ];
        filled(text, &values.each_ref().map(|(name, value)| (*name, value.as_str())))
    };
    let file = |name: &str, text: String| EmittedFile { name: name.to_owned(), text };
    vec![
        file("test_sensor.py", filled(include_str!("test_sensor.py"))),
        file("Makefile", filled(include_str!("Makefile"))),
        file("testbench.v", around(emission)),
        file("scene.toml", scene.text.clone()),
    ]
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
    // A receiver that stalls takes a third longer for the rows, and reset some clocks.
    groups * integration + 2 * interface.beats_of_group() + 1000
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
    let made_by = made_by(&emission.command);
    let (widths, connected) = beside(&emission.ports);
    let rules = prefix.of("axis_rules");
    let data = emission.ports.iter().find(|port| port.role == Role::Data);
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
