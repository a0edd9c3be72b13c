//! Whether synthesis and simulation mean the same by a design.
//!
//! Lanes are gates, made by Yosys; they are to say what the simulated Verilog does. An x is
//! any value to synthesis, which may make use of it, and what Yosys has optimised tells nothing
//! of it any more. So the design is read before anything is optimised, as words by Yosys and as
//! Verilator elaborates it, and whatever the two may take differently sends it to lock-step.

use std::collections::BTreeSet;
use std::path::Path;

use super::LaneRefusal;
use super::synthesis::{
    failed_in_yosys, first_error, script_of_sources, write_sources, yosys_version,
};
use super::yosys::{Bit, YosysCell, YosysDocument};
use crate::cosim::build::elaborated;
use crate::cosim::cache::{hash, once, write};
use crate::cosim::drivers;
use crate::cosim::error::CosimError;
use crate::cosim::rejected::{in_build, in_users_terms};
use crate::cosim::source::SourceFile;
use crate::cosim::tools::{Tool, Tools};

/// To words; nothing is optimised but constants, and no x is made use of.
const TO_PLAIN_WORDS: &str = "proc; flatten";
const WORDS: &str = "words.json";
const FOUND: &str = "found.txt";
/// Changes with what this file looks at.
const VERSION: &str = "3";

/// Cells whose value is x for some inputs, or that take x as a value.
const CELLS: [(&str, &str); 12] = [
    ("$div", "a division, of which there is no result by 0"),
    ("$mod", "a remainder, of which there is none by 0"),
    ("$divfloor", "a division, of which there is no result by 0"),
    ("$modfloor", "a remainder, of which there is none by 0"),
    ("$pow", "a power"),
    ("$eqx", "a comparison with x"),
    ("$nex", "a comparison with x"),
    ("$tribuf", "a driver that lets go"),
    ("$memrd", "a memory"),
    ("$memrd_v2", "a memory"),
    ("$mem", "a memory"),
    ("$mem_v2", "a memory"),
];

/// Refuses a design of which simulation and synthesis may not mean the same.
///
/// # Errors
/// What of it that is, and where; or a tool fails.
pub(super) fn refuse_ambiguous(
    top: &str,
    sources: &[SourceFile],
    cache: &Path,
) -> Result<(), LaneRefusal> {
    let yosys = Tool::yosys();
    let version = yosys_version(&yosys, cache)?;
    let tools = Tools::find(cache)?;
    let mut parts = vec!["meaning", VERSION, version.as_str(), tools.versions.as_str()];
    parts.extend([TO_PLAIN_WORDS, top]);
    for source in sources {
        parts.extend([source.name.as_str(), source.text.as_str()]);
    }
    let mut unfit = None;
    let name = format!("meaning-{}", hash(&parts));
    let made = once(cache, &name, FOUND, |folder| {
        write_sources(folder, sources)?;
        let script = script_of_sources(top, sources);
        write(
            &folder.join("to_words.ys"),
            &format!("{script}{TO_PLAIN_WORDS}\nwrite_json {WORDS}\n"),
        )?;
        let done =
            yosys.run(|command| command.current_dir(folder).args(["-q", "-s", "to_words.ys"]));
        done.inspect_err(|error| unfit = Some(first_error(error)))?;
        let path = folder.join(WORDS);
        let words = std::fs::read_to_string(&path).map_err(CosimError::cache(&path))?;
        let mut found = of_directives(sources);
        found.extend(of_words(&words, top));
        let xml = elaborated(&tools, top, sources, folder)?;
        found.extend(xml.map_or_else(
            || vec!["Verilator does not write what it elaborates".to_owned()],
            |xml| [drivers::other_circuits(&xml), drivers::undefined_values(&xml)].concat(),
        ));
        write(&folder.join(FOUND), &found.join("\n"))
    });
    let found = failed_in_yosys(made, unfit)?;
    match found.lines().next() {
        None => Ok(()),
        Some(first) => Err(LaneRefusal::unfit(format!(
            "simulation and synthesis may not mean the same: {}",
            in_users_terms(first, sources)
        ))),
    }
}

/// What of a user's design synthesis may make another circuit of than is simulated, in words.
///
/// # Errors
/// When Verilator fails.
pub(in crate::cosim) fn remarks(
    top: &str,
    sources: &[SourceFile],
    cache: &Path,
) -> Result<Vec<String>, CosimError> {
    let tools = Tools::find(cache)?;
    let mut parts = vec!["other circuits", VERSION, tools.versions.as_str(), top];
    for source in sources {
        parts.extend([source.name.as_str(), source.text.as_str()]);
    }
    let found = once(cache, &format!("meaning-{}", hash(&parts)), FOUND, |folder| {
        write_sources(folder, sources)?;
        let xml = elaborated(&tools, top, sources, folder)?;
        let found = xml.map_or_else(Vec::new, |xml| drivers::other_circuits(&xml));
        write(&folder.join(FOUND), &found.join("\n"))
    })?;
    let told = |line: &str| {
        let line = in_users_terms(line, sources);
        format!("{line}: synthesis may make another circuit of it than was simulated")
    };
    Ok(String::from_utf8_lossy(&found).lines().map(told).collect())
}

/// What synthesis is told beside the Verilog, and simulation does not hear.
const DIRECTIVES: [&str; 4] = ["full_case", "parallel_case", "translate_off", "synthesis_off"];

fn of_directives(sources: &[SourceFile]) -> Vec<String> {
    let lines =
        sources.iter().flat_map(|source| (1..).zip(source.text.lines()).map(move |l| (source, l)));
    let told = lines.filter_map(|(source, (number, line))| {
        let directive = DIRECTIVES.iter().find(|directive| line.contains(*directive))?;
        Some(format!("{}:{number}: {directive}, which only synthesis knows", in_build(source)))
    });
    told.collect()
}

fn is_undefined(bit: &Bit) -> bool {
    matches!(bit, Bit::Constant(value) if value != "0" && value != "1")
}

/// What Yosys's words of a design leave undefined, each with its place.
fn of_words(json: &str, top: &str) -> Vec<String> {
    let document: Result<YosysDocument, _> = serde_json::from_str(json);
    let Some(module) = document.ok().and_then(|mut document| document.modules.remove(top)) else {
        return vec!["Yosys's words cannot be read".to_owned()];
    };
    let mut driven: BTreeSet<u32> = BTreeSet::new();
    let mut drive = |bits: &[Bit]| {
        driven.extend(bits.iter().filter_map(|bit| match bit {
            Bit::Net(number) => Some(*number),
            Bit::Constant(_) => None,
        }));
    };
    let inputs = module.ports.values().filter(|port| port.direction == "input");
    inputs.for_each(|port| drive(&port.bits));
    let is_input = |cell: &YosysCell, pin: &str| {
        cell.port_directions.get(pin).is_some_and(|direction| direction == "input")
    };
    for cell in module.cells.values() {
        let outputs = cell.connections.iter().filter(|(pin, _)| !is_input(cell, pin));
        outputs.for_each(|(_, bits)| drive(bits));
    }
    let is_open = |bit: &Bit| matches!(bit, Bit::Net(number) if !driven.contains(number));
    let of_bits = |bits: &[Bit]| {
        let is_undefined = bits.iter().any(is_undefined);
        let is_open = bits.iter().any(is_open);
        is_undefined.then_some("an x").or(is_open.then_some("a net that nothing drives"))
    };
    let mut found: Vec<String> = Vec::new();
    for (name, port) in &module.ports {
        found.extend(of_bits(&port.bits).map(|what| format!("port {name} has {what}")));
    }
    for cell in module.cells.values() {
        let inputs = cell.connections.iter().filter(|(pin, _)| is_input(cell, pin));
        let undefined = inputs.filter_map(|(_, bits)| of_bits(bits)).min();
        let what = CELLS.iter().find(|(name, _)| *name == cell.r#type).map(|(_, what)| *what);
        let what = what.or_else(|| may_select_beyond(cell).then_some("a select out of range"));
        let what = what.or_else(|| cell.r#type.contains("latch").then_some("a latch"));
        found.extend(what.or(undefined).map(|what| format!("{}: {what}", place(cell))));
    }
    found.sort();
    found
}

/// Whether a selection of bits may go beyond them: the largest index is where every bit of
/// it that is not a constant is 1.
fn may_select_beyond(cell: &YosysCell) -> bool {
    if cell.r#type != "$shiftx" {
        return false;
    }
    let number = |name: &str| {
        let digits = cell.parameters.get(name).and_then(|value| value.as_str())?;
        u64::from_str_radix(digits, 2).ok()
    };
    let index = cell.connections.get("B").map(Vec::as_slice).unwrap_or_default();
    let is_zero = |bit: &Bit| *bit == Bit::Constant("0".to_owned());
    let bits = index.iter().enumerate().filter(|(_, bit)| !is_zero(bit));
    let largest = bits.fold(0u128, |sum, (place, _)| sum + (1u128 << place.min(64)));
    let is_signed = number("B_SIGNED") != Some(0) && index.last().is_some_and(|bit| !is_zero(bit));
    let width = |name: &str| number(name).map(u128::from);
    let (Some(all), Some(selected)) = (width("A_WIDTH"), width("Y_WIDTH")) else {
        return true;
    };
    is_signed || largest + selected > all
}

/// The file and line of a cell: of `FILE:LINE.COLUMN-LINE.COLUMN|...` the innermost. Yosys leaves
/// some at line 0.
fn place(cell: &YosysCell) -> String {
    let source = cell.attributes.get("src").and_then(|value| value.as_str()).unwrap_or_default();
    let mut places = source.rsplit('|').filter_map(|place| {
        let (file, columns) = place.rsplit_once(':')?;
        Some((file, columns.split('.').next().filter(|&line| line != "0")?))
    });
    match places.next() {
        Some((file, line)) => format!("{file}:{line}"),
        None => source.rsplit_once(':').map_or(source, |(file, _)| file).to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::of_words;

    fn words(cell: &str) -> Vec<String> {
        let json = format!(
            "{{\"modules\":{{\"t\":{{\"ports\":{{\"a\":{{\"direction\":\"input\",\"bits\":[2,3]}},\
             \"y\":{{\"direction\":\"output\",\"bits\":[9]}}}},\"cells\":{{\"c\":{cell}}}}}}}}}"
        );
        of_words(&json, "t")
    }

    fn cell(kind: &str, a: &str, b: &str, width: &str) -> String {
        format!(
            "{{\"type\":\"{kind}\",\"attributes\":{{\"src\":\"rtl/x.v:7.3-7.9\"}},\"parameters\":{{\
             \"A_WIDTH\":\"{width}\",\"Y_WIDTH\":\"1\",\"B_SIGNED\":\"0\"}},\"port_directions\":{{\
             \"A\":\"input\",\"B\":\"input\",\"Y\":\"output\"}},\"connections\":{{\"A\":{a},\"B\":{b},\
             \"Y\":[9]}}}}"
        )
    }

    #[test]
    fn an_x_is_named_with_its_place() {
        let told = |cell: String| words(&cell);
        assert_eq!(told(cell("$and", "[2]", "[3]", "1")), [""; 0]);
        assert_eq!(told(cell("$and", "[2]", "[\"x\"]", "1")), ["rtl/x.v:7: an x"]);
        assert_eq!(told(cell("$and", "[2]", "[8]", "1")), ["rtl/x.v:7: a net that nothing drives"]);
        assert!(told(cell("$div", "[2]", "[3]", "1"))[0].contains("division"));
        // An index of two bits into three and into four, and of an even number into four.
        let beyond = ["rtl/x.v:7: a select out of range"];
        assert_eq!(told(cell("$shiftx", "[2,2,3]", "[2,3]", "11")), beyond);
        assert_eq!(told(cell("$shiftx", "[2,2,3,3]", "[2,3]", "100")), [""; 0]);
        assert_eq!(told(cell("$shiftx", "[2,2,3]", "[\"0\",3]", "11")), [""; 0]);
        assert_eq!(words("0"), ["Yosys's words cannot be read"]);
    }
}
