//! A module with exactly the interface's ports round one that has more.

use std::fmt::Write as _;

use crate::cosim::ports::FoundPort;
use crate::sensor::port::{Direction, Port};

/// The wrapper's name.
const NAME: &str = "goldtof_wrapper";

/// A wrapper, and what it does with ports that the interface does not have.
pub(super) struct Wrapper {
    pub(super) name: String,
    pub(super) text: String,
    pub(super) remarks: Vec<String>,
}

/// The wrapper of a module whose ports are the interface's and `found` further ones; none
/// where it needs no wrapper. Further outputs are left open, further inputs are 0.
pub(super) fn wrapper(top: &str, ports: &[Port], found: &[FoundPort]) -> Option<Wrapper> {
    let further: Vec<&FoundPort> =
        found.iter().filter(|found| !ports.iter().any(|port| port.name == found.name)).collect();
    // Verilator has names of its own for modules with these.
    if further.is_empty() && !top.contains("__") {
        return None;
    }
    let declared: Vec<String> = ports.iter().map(declared).collect();
    let mut connected: Vec<String> =
        ports.iter().map(|port| format!(".{0}({0})", port.name)).collect();
    let mut remarks = Vec::new();
    for port in further {
        let (value, remark) = match port.direction {
            Some(Direction::Input) => (
                format!("{}'d0", port.width),
                "an input that the interface does not have is 0 at every clock",
            ),
            _ => (String::new(), "an output that the interface does not have is not compared"),
        };
        // With the space an escaped name ends at.
        connected.push(format!(".\\{} ({value})", port.name));
        remarks.push(format!("{}: {remark}", port.name));
    }
    let mut text = String::new();
    let _ = write!(
        text,
        "\n`default_nettype wire\nmodule {NAME} (\n    {}\n);\n    {top} own (\n        {}\n    );\n\
         endmodule\n",
        declared.join(",\n    "),
        connected.join(",\n        "),
    );
    Some(Wrapper { name: NAME.to_owned(), text, remarks })
}

fn declared(port: &Port) -> String {
    let direction = match port.direction {
        Direction::Input => "input",
        Direction::Output => "output",
    };
    match port.width {
        1 => format!("{direction} wire {}", port.name),
        width => format!("{direction} wire [{}:0] {}", width - 1, port.name),
    }
}
