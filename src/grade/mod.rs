//! The score of a stimulus on a design: how many faults and mutants it would find.
//!
//! Lane 0 is the good design, every other lane has one fault, or is one mutant; all get
//! the same stimulus. One is caught at the first clock at which an output differs from
//! lane 0's. What is not caught is compared with the design by a model checker, from
//! the state after reset on ([`proof`]): it is equivalent, or there is a way to see it.

mod aiger;
mod proof;
mod run;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::path::PathBuf;
use std::thread;

use serde::Serialize;

use self::proof::{Answer, Question};
use self::run::{Kind, Stream};
use crate::cosim::build::SourceFile;
use crate::cosim::lanes::Refusal;
use crate::cosim::lanes::model::Design;
use crate::cosim::lanes::mutants::mutants;
use crate::cosim::lanes::netlist::{Name, Net, Netlist};
use crate::cosim::lanes::variants::{CHOICE, with_faults};
use crate::rtl::blocks::ScanRegisters;
use crate::sensor::Sensor;

/// What is graded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum GradeStimulus {
    /// The first four million clocks of a scan's photons.
    Photons,
    /// Inputs chosen to hurt, as in a co-simulation.
    Adversarial,
    /// What the emitted testbench has recorded.
    Testbench,
}

/// What to grade.
#[derive(Debug, Clone)]
pub struct GradeRequest {
    /// Name of the module that is graded on.
    pub top: String,
    /// The scan's counters in it, if they may be moved on.
    pub registers: Option<ScanRegisters>,
    /// The Verilog.
    pub sources: Vec<SourceFile>,
    /// Where built models are kept.
    pub cache: PathBuf,
    /// The stimulus.
    pub stimulus: GradeStimulus,
    /// Its clocks; `None` for as many as it takes.
    pub clocks: Option<u64>,
    /// Its seed.
    pub seed: u64,
    /// Number of mutants; 0 for none.
    pub mutants: u32,
    /// Longest time for each that is not caught, in seconds.
    pub proof_s: u32,
}

impl GradeRequest {
    /// Whether the Verilog is the user's own.
    fn is_users(&self) -> bool {
        self.sources.iter().any(|source| source.origin.is_some())
    }
}

/// What a stimulus is worth.
#[derive(Debug, Clone, Serialize)]
pub struct Grade {
    /// The stimulus.
    pub stimulus: GradeStimulus,
    /// Its seed.
    pub seed: u64,
    /// Its clocks.
    pub clocks: u64,
    /// Nets stuck at 0 or at 1.
    pub faults: Score,
    /// Mutants of Yosys.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mutants: Option<Score>,
}

/// How many of a kind are caught.
#[derive(Debug, Clone, Serialize)]
pub struct Score {
    /// All.
    pub total: usize,
    /// Those that an output shows.
    pub caught: usize,
    /// Those of the others that no stimulus could show, as proven.
    pub equivalent: usize,
    /// Caught of all that are not proven equivalent.
    pub share: f64,
    /// Clock by which the last of the caught ones had been.
    pub last_caught_at: u64,
    /// Those that are neither caught nor proven equivalent.
    pub survivors: Vec<Survivor>,
}

/// A fault or mutant that the stimulus does not show.
#[derive(Debug, Clone, Serialize)]
pub struct Survivor {
    /// What it is.
    pub change: String,
    /// Where.
    pub net: String,
    /// File and line of the Verilog.
    pub source: String,
    /// What would have to happen.
    pub needs: String,
}

impl Grade {
    /// The smaller of the two shares.
    pub fn share(&self) -> f64 {
        let mutants = self.mutants.as_ref().map_or(1.0, |score| score.share);
        self.faults.share.min(mutants)
    }
}

/// Grades a stimulus on a design.
///
/// # Errors
/// What of the design has no place in lanes; or a tool fails.
pub fn grade(
    sensor: &Sensor,
    request: &GradeRequest,
    mut on_progress: impl FnMut(&'static str),
) -> Result<Grade, Refusal> {
    let design = Design::netlist(&request.top, &request.sources, &request.cache)?;
    let stream = Stream::of(sensor, request, &design)?;
    on_progress("comparing the design with the reference model");
    stream.check()?;
    on_progress("grading by faults and mutants");
    let (faults, mutants) = thread::scope(|scope| {
        let mutants = scope.spawn(|| match request.mutants {
            0 => Ok(None),
            count => of_mutants(request, &stream, count).map(Some),
        });
        let faults = stuck_at(request, &stream, &design);
        let mutants = mutants
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        (faults, mutants)
    });
    let (faults, mutants) = (faults?, mutants?);
    Ok(Grade {
        stimulus: request.stimulus,
        seed: request.seed,
        clocks: stream.clocks,
        faults,
        mutants,
    })
}

/// Every net stuck at 0 and at 1.
fn stuck_at(request: &GradeRequest, stream: &Stream, netlist: &Netlist) -> Result<Score, Refusal> {
    let (faulty, sites) = with_faults(netlist);
    let count = 2 * sites.len();
    let caught = stream.run(&faulty, &faulty, Kind::OneBitEach, count)?;
    let variant = |number: usize| {
        let site = sites[number / 2];
        netlist.with_tied(&HashMap::from([(site.net, number % 2 == 1)]))
    };
    let labels = Labels::of(netlist);
    let survivor = |number: usize, needs| {
        let (net, source) = labels.describe(sites[number / 2].net);
        Survivor {
            change: format!("stuck at {}", number % 2),
            net,
            source,
            needs,
        }
    };
    score(request, netlist, &caught, variant, survivor)
}

/// Mutants that Yosys chooses.
fn of_mutants(request: &GradeRequest, stream: &Stream, count: u32) -> Result<Score, Refusal> {
    let (top, sources) = (&request.top, &request.sources);
    let kept: Vec<String> = request
        .registers
        .iter()
        .flat_map(|registers| registers.present())
        .map(|register| register.path("."))
        .collect();
    let (mutated, list) = mutants(top, sources, count, request.seed, &kept, &request.cache)?;
    let choice = mutated.input(CHOICE).map_or(Vec::new(), <[Net]>::to_vec);
    let chosen = |number: usize| {
        let bits = choice.iter().enumerate();
        let tied = bits.map(|(bit, &net)| (net, number >> bit & 1 == 1));
        mutated.with_tied(&tied.collect())
    };
    let good = chosen(0);
    let caught = stream.run(&mutated, &good, Kind::Number, list.len())?;
    let survivor = |number: usize, needs| Survivor {
        change: list[number].mode.clone(),
        net: list[number].place.clone(),
        source: list[number].source.clone(),
        needs,
    };
    score(
        request,
        &good,
        &caught,
        |number| chosen(number + 1),
        survivor,
    )
}

/// Puts those that were not caught to the proof.
fn score(
    request: &GradeRequest,
    good: &Netlist,
    caught: &run::Caught,
    variant: impl Fn(usize) -> Netlist,
    survivor: impl Fn(usize, String) -> Survivor,
) -> Result<Score, Refusal> {
    let open: Vec<usize> = (0..caught.at.len())
        .filter(|&number| caught.at[number].is_none())
        .collect();
    let pairs: Vec<_> = open
        .iter()
        .map(|&number| (variant(number), caught.after_reset(number)))
        .collect();
    let question = Question {
        good,
        good_values: &caught.after_reset_good,
        ignores_idle_payload: request.is_users(),
        limit_s: request.proof_s,
    };
    let answers = question.prove(&pairs)?;
    let mut survivors = Vec::new();
    let mut equivalent = 0;
    for (&number, answer) in open.iter().zip(answers) {
        match answer {
            Answer::Equivalent => equivalent += 1,
            other => survivors.push(survivor(number, other.needs(request.proof_s))),
        }
    }
    let total = caught.at.len();
    let caught_count = total - open.len();
    Ok(Score {
        total,
        caught: caught_count,
        equivalent,
        share: caught_count as f64 / (total - equivalent).max(1) as f64,
        last_caught_at: caught
            .at
            .iter()
            .flatten()
            .copied()
            .max()
            .unwrap_or_default(),
        survivors,
    })
}

/// Names of nets: of several that a net has the shortest.
struct Labels<'a> {
    netlist: &'a Netlist,
    of: HashMap<Net, (&'a Name, usize)>,
}

impl<'a> Labels<'a> {
    fn of(netlist: &'a Netlist) -> Labels<'a> {
        let mut of: HashMap<Net, (&Name, usize)> = HashMap::new();
        for name in &netlist.names {
            for (bit, &net) in name.nets.iter().enumerate() {
                let known = of.entry(net).or_insert((name, bit));
                if name.word.len() < known.0.word.len() {
                    *known = (name, bit);
                }
            }
        }
        Labels { netlist, of }
    }

    /// Name and source of a net, or else of the first one that it goes to.
    fn describe(&self, net: Net) -> (String, String) {
        if let Some((name, bit)) = self.of.get(&net) {
            return (format!("{}[{bit}]", name.word), name.source.clone());
        }
        let beyond = |name: &Name, bit: usize| {
            let text = format!("in the logic of {}[{bit}]", name.word);
            (text, name.source.clone())
        };
        let mut reached = vec![false; self.netlist.nets];
        reached[net.index()] = true;
        for gate in &self.netlist.gates {
            if gate.inputs.iter().any(|input| reached[input.index()]) {
                reached[gate.output.index()] = true;
                if let Some(&(name, bit)) = self.of.get(&gate.output) {
                    return beyond(name, bit);
                }
            }
        }
        let mut registers = self.netlist.registers.iter();
        let fed = registers.find(|register| {
            let reset = register.reset.map(|reset| reset.when);
            let nets = [Some(register.d), register.enable, reset];
            nets.into_iter().flatten().any(|net| reached[net.index()])
        });
        match fed.map(|register| (register, self.of.get(&register.q))) {
            Some((_, Some(&(name, bit)))) => beyond(name, bit),
            Some((register, None)) => {
                let (word, bit) = &register.name;
                (format!("in the logic of {word}[{bit}]"), String::new())
            }
            None => ("a net without a name".to_owned(), String::new()),
        }
    }
}
