//! The C++ header that packs a verilated model's ports into words, and moves its scan's
//! counters on.
//!
//! `testbench/cosim.cpp` and this file share these names; nothing else does.

use std::fmt::Write as _;

use crate::reference::blocks::BLOCK_CLOCKS;
use crate::rtl::blocks::{CountRegister, ScanRegisters};
use crate::sensor::layout::{Field, Layout};
use crate::sensor::port::{Direction, Port};

/// Name of the header that `testbench/cosim.cpp` includes.
pub const HEADER: &str = "goldtof_ports.h";

/// Most skips in a block.
pub(super) const MOST_SKIPS: usize = BLOCK_CLOCKS as usize / 8;
/// Room for what a model holds, most of which is never touched. A model that holds more runs in
/// all of its processes to the end.
pub(super) const STATE_BYTES: u64 = 1 << 24;

/// Writes the header for a top module, and its scan's counters if they are to be moved.
pub fn header(top: &str, layout: &Layout, registers: Option<&ScanRegisters>) -> String {
    let mut text = format!(
        "#include <cstdint>\n#include \"V{top}.h\"\n\
         #define GOLDTOF_MODEL V{top}\n\
         #define GOLDTOF_CLOCK {clock}\n\
         #define GOLDTOF_IN_WORDS {inputs}\n\
         #define GOLDTOF_OUT_WORDS {outputs}\n\
         #define GOLDTOF_BLOCK_CLOCKS {BLOCK_CLOCKS}\n\
         #define GOLDTOF_STATE_BYTES {STATE_BYTES}\n\
         #define GOLDTOF_MOST_SKIPS {MOST_SKIPS}\n",
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
            writeln!(text, "    top->{name} = (in[{word}] >> {shift}){};", masked(port.width, 64))
        };
    }
    text.push_str("}\nstatic inline void goldtof_sample(GOLDTOF_MODEL* top, uint64_t* out) {\n");
    for word in 0..layout.outputs.words {
        let terms: Vec<String> =
            layout.outputs.fields.iter().filter_map(|field| term(field, word)).collect();
        let _ = writeln!(text, "    out[{word}] = {};", terms.join(" | "));
    }
    text.push_str("}\n");
    text + &skip(top, registers)
}

/// The function that moves the scan's counters on.
fn skip(top: &str, registers: Option<&ScanRegisters>) -> String {
    let Some(registers) = registers else {
        return "static inline void goldtof_skip(GOLDTOF_MODEL*, uint64_t, uint64_t) {}\n"
            .to_owned();
    };
    let line = |register: &Option<CountRegister>, argument: &str| {
        register.as_ref().map_or(format!("    (void){argument};\n"), |register| {
            let path = register.path("__DOT__");
            format!("    top->rootp->{top}__DOT__{path} ^= {argument};\n")
        })
    };
    format!(
        "#include \"V{top}___024root.h\"\n\
         static inline void goldtof_skip(GOLDTOF_MODEL* top, uint64_t chips, uint64_t groups) {{\n\
         {}{}    (void)top;\n}}\n",
        line(&registers.chips, "chips"),
        line(&registers.groups, "groups"),
    )
}

/// What Verilator is told, so that it keeps the scan's counters where they can be
/// reached.
pub fn configuration(registers: &ScanRegisters) -> String {
    let lines = registers.present().map(|register| {
        format!("public_flat_rw -module \"{}\" -var \"{}\"\n", register.module(), register.name())
    });
    format!("`verilator_config\n{}", lines.collect::<String>())
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
        format!(" & {:#x}ULL", crate::sensor::layout::mask(width))
    }
}

/// A port as Verilator found it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoundPort {
    /// Its name as it stands in the Verilog.
    pub name: String,
    /// Its direction; none of an `inout`.
    pub direction: Option<Direction>,
    /// Bits.
    pub width: u32,
    /// Whether it has several of these: an unpacked array.
    pub is_array: bool,
}

/// Reads the ports from the header that Verilator wrote for its model.
///
/// Verilator declares each port of the top module as
/// `VL_IN8(&name,msb,lsb);` or `VL_OUTW(&name,msb,lsb,words);` and the like, and an
/// unpacked array as `VL_OUT8((&name)[2],msb,lsb);`.
pub fn verilated_ports(header: &str) -> Vec<FoundPort> {
    header.lines().filter_map(verilated_port).collect()
}

fn verilated_port(line: &str) -> Option<FoundPort> {
    let line = line.trim();
    let (direction, rest) = if let Some(rest) = line.strip_prefix("VL_INOUT") {
        (None, rest)
    } else if let Some(rest) = line.strip_prefix("VL_IN") {
        (Some(Direction::Input), rest)
    } else {
        (Some(Direction::Output), line.strip_prefix("VL_OUT")?)
    };
    let (_, rest) = rest.split_once('(')?;
    let (arguments, _) = rest.rsplit_once(')')?;
    let mut arguments = arguments.split(',');
    let name = arguments.next()?.trim();
    let (name, is_array) = match name.strip_prefix("(&").and_then(|n| n.split_once(')')) {
        Some((name, _)) => (name, true),
        None => (name.trim_start_matches('&'), false),
    };
    let msb: u32 = arguments.next()?.trim().parse().ok()?;
    let lsb: u32 = arguments.next()?.trim().parse().ok()?;
    Some(FoundPort {
        name: unescaped(name),
        direction,
        width: msb.abs_diff(lsb).checked_add(1)?,
        is_array,
    })
}

/// The name in the Verilog: Verilator writes what C++ does not allow in a name as
/// `__0` and two hexadecimal digits.
fn unescaped(name: &str) -> String {
    let mut parts = name.split("__0");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let code = part
            .get(..2)
            .and_then(|code| u8::from_str_radix(code, 16).ok())
            .filter(u8::is_ascii_graphic);
        match code {
            Some(code) => {
                text.push(char::from(code));
                text += &part[2..];
            }
            None => {
                text += "__0";
                text += part;
            }
        }
    }
    text
}

/// Every way in which a top module's ports are not what the interface needs, one sentence
/// each. Further inputs and outputs are no such way, unless they are arrays.
pub fn differences(expected: &[Port], found: &[FoundPort]) -> Vec<String> {
    let word = |direction| match direction {
        Some(Direction::Input) => "input",
        Some(Direction::Output) => "output",
        None => "inout",
    };
    let wanted = |port: &Port| format!("{} of {} bit(s)", word(Some(port.direction)), port.width);
    let describe = |port: &FoundPort| {
        let array = if port.is_array { "an array, each an " } else { "" };
        format!("{array}{} of {} bit(s)", word(port.direction), port.width)
    };
    let fits = |port: &Port, found: &FoundPort| {
        !found.is_array && found.direction == Some(port.direction) && found.width == port.width
    };
    let mut differences = Vec::new();
    for port in expected {
        match found.iter().find(|p| p.name == port.name) {
            None => differences.push(format!(
                "port {} is missing; it should be an {}",
                port.name,
                wanted(port)
            )),
            Some(other) if !fits(port, other) => differences.push(format!(
                "port {} is {}{}; it should be an {}",
                port.name,
                if other.is_array { "" } else { "an " },
                describe(other),
                wanted(port)
            )),
            Some(_) => {}
        }
    }
    for port in found {
        let is_further = !expected.iter().any(|p| p.name == port.name);
        let cannot_be = port.is_array || port.direction.is_none();
        if is_further && cannot_be {
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
    use crate::sensor::port::PortRole;

    #[test]
    fn ports_are_read_from_the_declarations_of_a_verilated_model() {
        let header = "  public:\n    VL_IN8(&i_clk,0,0);\n    VL_OUT(&m_axis_tdata,23,0);\n    \
                      VL_INW(&i_samples,127,0,4);\n    int unrelated(int);\n";
        let ports = verilated_ports(header);
        let found = |name: &str, direction, width| FoundPort {
            name: name.into(),
            direction,
            width,
            is_array: false,
        };
        assert_eq!(
            ports,
            [
                found("i_clk", Some(Direction::Input), 1),
                found("m_axis_tdata", Some(Direction::Output), 24),
                found("i_samples", Some(Direction::Input), 128),
            ]
        );
        assert!(verilated_ports("VL_OUT(&a,4294967295,0);").is_empty());
        let wanted = [(PortRole::Clock, 1), (PortRole::Data, 16), (PortRole::Reset, 1)];
        let wanted = wanted.map(|(role, width)| role.port(width));
        assert_eq!(
            differences(&wanted, &ports),
            [
                "port m_axis_tdata is an output of 24 bit(s); it should be an output of 16 bit(s)",
                "port i_rst is missing; it should be an input of 1 bit(s)",
            ]
        );
    }

    #[test]
    fn inouts_arrays_and_escaped_names_are_named() {
        let header = "VL_INOUT8(&i_rst,0,0);\nVL_OUT8((&o_laser)[2],3,0);\n\
                      VL_INOUTW(&pads,99,0,4);\nVL_OUT8(&o__02bx__0,0,0);\n";
        let wanted = [PortRole::Reset.port(1), PortRole::Laser.port(4)];
        assert_eq!(
            differences(&wanted, &verilated_ports(header)),
            [
                "port i_rst is an inout of 1 bit(s); it should be an input of 1 bit(s)",
                "port o_laser is an array, each an output of 4 bit(s); it should be an output of 4 \
                 bit(s)",
                "port pads (inout of 100 bit(s)) is not one of this scene's ports",
            ]
        );
    }
}
