//! The C++ header that packs a verilated model's ports into words.
//!
//! `testbench/cosim.cpp` and this file share these names; nothing else does.

use std::fmt::Write as _;

use crate::model::contract::{Direction, Port};
use crate::model::layout::{Field, Layout};

/// Name of the header that `testbench/cosim.cpp` includes.
pub const HEADER: &str = "goldtof_ports.h";

/// Writes the header for a top module.
pub fn header(top: &str, layout: &Layout) -> String {
    let mut text = format!(
        "#include <cstdint>\n#include \"V{top}.h\"\n\
         #define GOLDTOF_MODEL V{top}\n\
         #define GOLDTOF_CLOCK {clock}\n\
         #define GOLDTOF_IN_WORDS {inputs}\n\
         #define GOLDTOF_OUT_WORDS {outputs}\n",
        clock = Layout::CLOCK,
        inputs = layout.inputs.words,
        outputs = layout.outputs.words,
    );
    text.push_str("static inline void goldtof_apply(GOLDTOF_MODEL* top, const uint64_t* in) {\n");
    for field in &layout.inputs.fields {
        let Field { port, word, shift } = field;
        let name = &port.name;
        let _ = if port.width > 64 {
            (0..port.width.div_ceil(32)).try_for_each(|i| {
                writeln!(
                    text,
                    "    top->{name}[{i}] = static_cast<uint32_t>(in[{}] >> {}){};",
                    word + i as usize / 2,
                    i % 2 * 32,
                    masked(port.width - i * 32, 32),
                )
            })
        } else {
            writeln!(
                text,
                "    top->{name} = (in[{word}] >> {shift}){};",
                masked(port.width, 64)
            )
        };
    }
    text.push_str("}\nstatic inline void goldtof_sample(GOLDTOF_MODEL* top, uint64_t* out) {\n");
    for word in 0..layout.outputs.words {
        let terms: Vec<String> = layout
            .outputs
            .fields
            .iter()
            .filter_map(|field| term(field, word))
            .collect();
        let _ = writeln!(text, "    out[{word}] = {};", terms.join(" | "));
    }
    text.push_str("}\n");
    text
}

/// What a port contributes to a word of the output record.
fn term(field: &Field, word: usize) -> Option<String> {
    let name = &field.port.name;
    if field.port.width <= 64 {
        return (field.word == word)
            .then(|| format!("static_cast<uint64_t>(top->{name}) << {}", field.shift));
    }
    let part = word.checked_sub(field.word)? as u32;
    let halves = field.port.width.div_ceil(32);
    let low =
        (part * 2 < halves).then(|| format!("static_cast<uint64_t>(top->{name}[{}])", part * 2))?;
    let high = part * 2 + 1;
    Some(if high < halves {
        format!("{low} | static_cast<uint64_t>(top->{name}[{high}]) << 32")
    } else {
        low
    })
}

/// `& mask` for the lowest `width` bits, or nothing when they fill the type.
fn masked(width: u32, full: u32) -> String {
    if width >= full {
        String::new()
    } else {
        format!(" & {:#x}ULL", crate::model::layout::mask(width))
    }
}

/// Reads the ports from the header that Verilator wrote for its model.
///
/// Verilator declares each port of the top module as
/// `VL_IN8(&name,msb,lsb);` or `VL_OUTW(&name,msb,lsb,words);` and the like.
pub fn verilated_ports(header: &str) -> Vec<Port> {
    header.lines().filter_map(verilated_port).collect()
}

fn verilated_port(line: &str) -> Option<Port> {
    let line = line.trim();
    let (direction, rest) = if let Some(rest) = line.strip_prefix("VL_IN") {
        (Direction::Input, rest)
    } else {
        (Direction::Output, line.strip_prefix("VL_OUT")?)
    };
    let (_, rest) = rest.split_once('(')?;
    let (arguments, _) = rest.split_once(')')?;
    let mut arguments = arguments.split(',');
    let name = arguments.next()?.trim().trim_start_matches('&').to_owned();
    let msb: u32 = arguments.next()?.trim().parse().ok()?;
    let lsb: u32 = arguments.next()?.trim().parse().ok()?;
    Some(Port {
        name,
        direction,
        width: msb.abs_diff(lsb).checked_add(1)?,
    })
}

/// Every way in which a top module's ports differ from the contract's, one
/// sentence each.
pub fn differences(expected: &[Port], found: &[Port]) -> Vec<String> {
    let word = |direction| match direction {
        Direction::Input => "input",
        Direction::Output => "output",
    };
    let describe = |port: &Port| format!("{} of {} bit(s)", word(port.direction), port.width);
    let mut differences = Vec::new();
    for port in expected {
        match found.iter().find(|p| p.name == port.name) {
            None => differences.push(format!(
                "port {} is missing; it should be an {}",
                port.name,
                describe(port)
            )),
            Some(other) if other != port => differences.push(format!(
                "port {} is an {}; it should be an {}",
                port.name,
                describe(other),
                describe(port)
            )),
            Some(_) => {}
        }
    }
    for port in found {
        if !expected.iter().any(|p| p.name == port.name) {
            differences.push(format!(
                "port {} ({}) is not one of this scene's ports",
                port.name,
                describe(port)
            ));
        }
    }
    differences
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_read_from_the_declarations_of_a_verilated_model() {
        let header = "  public:\n    VL_IN8(&i_clk,0,0);\n    VL_OUT(&m_axis_tdata,23,0);\n    \
                      VL_INW(&i_samples,127,0,4);\n    int unrelated(int);\n";
        let ports = verilated_ports(header);
        let port = |name: &str, direction, width| Port {
            name: name.into(),
            direction,
            width,
        };
        assert_eq!(
            ports,
            [
                port("i_clk", Direction::Input, 1),
                port("m_axis_tdata", Direction::Output, 24),
                port("i_samples", Direction::Input, 128),
            ]
        );
        assert!(verilated_ports("VL_OUT(&a,4294967295,0);").is_empty());
        let wanted = [
            port("i_clk", Direction::Input, 1),
            port("m_axis_tdata", Direction::Output, 16),
            port("i_rst", Direction::Input, 1),
        ];
        assert_eq!(
            differences(&wanted, &ports),
            [
                "port m_axis_tdata is an output of 24 bit(s); it should be an output of 16 bit(s)",
                "port i_rst is missing; it should be an input of 1 bit(s)",
                "port i_samples (input of 128 bit(s)) is not one of this scene's ports",
            ]
        );
    }
}
