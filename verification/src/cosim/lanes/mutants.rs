//! Mutants of a design in one netlist: an input for each turns it on.

use std::fmt::Write as _;
use std::path::Path;

use super::LaneRefusal;
use super::netlist::{BitNet, CHOICE, GateNetlist, PortNets};
use super::synthesis::{
    failed_in_yosys, first_error, script_of_sources, write_sources, yosys_version,
};
use super::yosys::{self, Memories, TO_WORDS};
use crate::cosim::cache::{hash, once, write};
use crate::cosim::error::CosimError;
use crate::cosim::source::SourceFile;
use crate::cosim::tools::Tool;

/// Mutants beyond a share of those that are asked for, since some are of clocks.
const SPARE_MUTANTS: u32 = 20;
/// Cells get the names of what they drive.
const NAMED: &str = "rename -wire";
const LIST: &str = "mutants.txt";
const NETLIST: &str = "netlist.json";

/// A change of one bit of one cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mutant {
    /// Yosys's name of what is done: inv, const0, const1, cnot0, cnot1.
    pub mode: String,
    /// The wire and its bit, or the cell and its port.
    pub place: String,
    /// Where that is in the Verilog, and the instances above it, with bars between.
    pub source: String,
}

/// A design and `count` mutants of it, chosen by Yosys with `seed`: bit k of the choice
/// turns mutant k on. Words that are `kept` can be found in the netlist.
///
/// # Errors
/// What of it has no place in lanes; or a tool fails.
pub fn mutants(
    top: &str,
    sources: &[SourceFile],
    count: u32,
    seed: u64,
    kept: &[String],
    memories: Memories,
    cache: &Path,
) -> Result<(GateNetlist, Vec<Mutant>), LaneRefusal> {
    let yosys = Tool::yosys();
    let version = yosys_version(&yosys, cache)?;
    let to_gates = memories.to_gates();
    let (count_text, seed_text) = (count.to_string(), seed.to_string());
    let mut parts = vec!["mutants", version.as_str(), TO_WORDS, NAMED, to_gates.as_str(), top];
    parts.extend([count_text.as_str(), seed_text.as_str()]);
    parts.extend(kept.iter().map(String::as_str));
    for source in sources {
        parts.extend([source.name.as_str(), source.text.as_str()]);
    }
    let identity = hash(&parts);
    let mut unfit = None;
    let list = once(cache, &format!("mutants-{identity}"), LIST, |folder| {
        write_sources(folder, sources)?;
        let script = format!(
            "{}{TO_WORDS}\n{NAMED}\nmutate -list {} -seed {} -o {LIST}\n",
            script_of_sources(top, sources),
            count + count / 2 + SPARE_MUTANTS,
            seed % (1 << 31),
        );
        run(&yosys, folder, &script, &mut unfit)
    });
    let list = failed_in_yosys(list, unfit.take())?;
    let list = without_clocks(&list, count as usize);
    let json = once(cache, &format!("mutated-{identity}"), NETLIST, |folder| {
        write_sources(folder, sources)?;
        let mut script = format!("{}{TO_WORDS}\n{NAMED}\n", script_of_sources(top, sources));
        for word in kept {
            let _ = writeln!(script, "setattr -set keep 1 w:{word}");
        }
        for (number, line) in list.iter().enumerate() {
            // An input for each: a number that had to be compared for each would be most of
            // the gates.
            let _ = writeln!(script, "{line} -ctrl {CHOICE}_{number} 1 1");
        }
        let _ = writeln!(script, "{to_gates}\nwrite_json {NETLIST}");
        run(&yosys, folder, &script, &mut unfit)
    });
    let json = failed_in_yosys(json, unfit)?;
    let mutants: Vec<Mutant> = list.iter().map(|line| mutant(line)).collect();
    let mut netlist = yosys::read(&json, top)?;
    let choice = take_choice(&mut netlist, mutants.len())?;
    netlist.inputs.push(choice);
    Ok((netlist, mutants))
}

/// Of Yosys's mutants `count`, evenly, or all if there are fewer, but none of a clock:
/// a register that is not on the clock has no place in lanes.
fn without_clocks(list: &str, count: usize) -> Vec<&str> {
    let is_of_data = |line: &&str| {
        let mut words = line.split_whitespace();
        words.all(|word| word.trim_start_matches('\\') != "CLK")
    };
    let all: Vec<&str> = list.lines().filter(is_of_data).collect();
    let taken = count.min(all.len());
    (0..taken).map(|i| all[i * all.len() / taken]).collect()
}

/// Takes the inputs that turn the mutants on, as one port.
fn take_choice(netlist: &mut GateNetlist, count: usize) -> Result<PortNets, LaneRefusal> {
    let name = |number: usize| format!("{CHOICE}_{number}");
    let net = |number| netlist.input(&name(number)).map(|nets| nets[0]);
    let nets: Option<Vec<BitNet>> = (0..count).map(net).collect();
    let nets = nets.ok_or_else(|| LaneRefusal::unfit("Yosys has lost a mutant"))?;
    let prefix = format!("{CHOICE}_");
    netlist.inputs.retain(|port| !port.name.starts_with(&prefix));
    Ok(PortNets { name: CHOICE.to_owned(), nets })
}

fn run(
    yosys: &Tool,
    folder: &Path,
    script: &str,
    unfit: &mut Option<String>,
) -> Result<(), CosimError> {
    write(&folder.join("script.ys"), script)?;
    let done = yosys.run(|command| command.current_dir(folder).args(["-q", "-s", "script.ys"]));
    done.map(|_| ()).inspect_err(|error| {
        *unfit = Some(first_error(error));
    })
}

/// Reads a line of the list.
fn mutant(line: &str) -> Mutant {
    let words: Vec<&str> = line.split_whitespace().collect();
    let after = |option: &str| {
        let place = words.iter().position(|word| *word == option)?;
        words.get(place + 1).copied()
    };
    let pairs = words.windows(2).filter(|pair| pair[0] == "-src");
    let sources: Vec<&str> = pairs.map(|pair| pair[1]).collect();
    let place = match (after("-wire"), after("-wirebit")) {
        (Some(wire), Some(bit)) => format!("{wire}[{bit}]"),
        _ => format!(
            "{} port {}[{}]",
            after("-cell").unwrap_or_default(),
            after("-port").unwrap_or_default(),
            after("-portbit").unwrap_or_default()
        ),
    };
    Mutant { mode: after("-mode").unwrap_or_default().to_owned(), place, source: sources.join("|") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mutants_of_clocks_are_left_out_and_the_rest_is_taken_evenly() {
        let line = |port: &str, bit: usize| {
            format!("mutate -mode inv -module \\top -cell $dff -port \\{port} -portbit {bit}\n")
        };
        let list: String =
            (0..9).map(|bit| line(if bit % 3 == 0 { "CLK" } else { "D" }, bit)).collect();
        let bits = |count| -> Vec<String> {
            let lines = without_clocks(&list, count);
            let last = |line: &str| line.split(' ').next_back().unwrap_or_default().to_owned();
            lines.into_iter().map(last).collect()
        };
        assert_eq!(bits(3), ["1", "4", "7"]);
        assert_eq!(bits(100), ["1", "2", "4", "5", "7", "8"]);
        assert_eq!(bits(0), [""; 0]);
    }
}
