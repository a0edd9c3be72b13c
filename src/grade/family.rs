//! The faults of a design, or its mutants: run, put to the proof, and counted.

use std::collections::HashMap;

use super::labels::{Labels, places};
use super::outcome::{Fate, Outcome};
use super::proof::{Answer, Question};
use super::run::{Caught, Stream};
use super::{GradeRequest, Survivor, Verdict};
use crate::cosim::in_users_terms;
use crate::cosim::lanes::Refusal;
use crate::cosim::lanes::mutants::{Mutant, mutants};
use crate::cosim::lanes::netlist::{Net, Netlist};
use crate::cosim::lanes::variants::{CHOICE, Site, with_faults};

/// Variants of a design, all of a kind.
pub(super) struct Family {
    /// The design with all variants; a bit of the choice for each.
    pub(super) all: Netlist,
    /// The design with none.
    pub(super) good: Netlist,
    kind: Kind,
}

enum Kind {
    /// Stuck at 0 and stuck at 1, in turn.
    Faults(Vec<Site>),
    Mutants(Vec<Mutant>),
}

impl Family {
    /// Every net stuck at 0 and at 1.
    pub(super) fn faults(netlist: &Netlist) -> Family {
        let (all, sites) = with_faults(netlist);
        Family {
            all,
            good: netlist.clone(),
            kind: Kind::Faults(sites),
        }
    }

    /// Mutants that Yosys chooses.
    ///
    /// # Errors
    /// What of the design has no place in lanes; or a tool fails.
    pub(super) fn mutants(request: &GradeRequest, count: u32) -> Result<Family, Refusal> {
        let kept: Vec<String> = request
            .registers
            .iter()
            .flat_map(|registers| registers.present())
            .map(|register| register.path("."))
            .collect();
        let (top, sources) = (&request.top, &request.sources);
        let (all, list) = mutants(top, sources, count, request.seed, &kept, &request.cache)?;
        Ok(Family {
            good: chosen(&all, None),
            all,
            kind: Kind::Mutants(list),
        })
    }

    /// How many variants there are.
    pub(super) fn count(&self) -> usize {
        match &self.kind {
            Kind::Faults(sites) => 2 * sites.len(),
            Kind::Mutants(list) => list.len(),
        }
    }

    /// The design that is one of the variants.
    pub(super) fn variant(&self, number: usize) -> Netlist {
        match &self.kind {
            Kind::Faults(sites) => {
                let stuck = HashMap::from([(sites[number / 2].net, number % 2 == 1)]);
                self.good.with_tied(&stuck)
            }
            Kind::Mutants(_) => chosen(&self.all, Some(number)),
        }
    }

    /// What a variant is, its net, and its lines in the Verilog as Yosys knows them.
    fn describe(&self, labels: &Labels, number: usize) -> (String, String, String) {
        match &self.kind {
            Kind::Faults(sites) => {
                let (net, source) = labels.describe(sites[number / 2].net);
                (format!("stuck at {}", number % 2), net, source)
            }
            Kind::Mutants(list) => {
                let mutant = &list[number];
                (
                    mutant.mode.clone(),
                    mutant.place.clone(),
                    mutant.source.clone(),
                )
            }
        }
    }
}

/// The netlist of mutants with one of them, or none.
fn chosen(all: &Netlist, number: Option<usize>) -> Netlist {
    let choice = all.input(CHOICE).unwrap_or_default();
    let bits = choice.iter().enumerate();
    let tied: HashMap<Net, bool> = bits.map(|(bit, &net)| (net, Some(bit) == number)).collect();
    all.with_tied(&tied)
}

/// Variants under a stimulus.
pub(super) struct Tried {
    family: Family,
    /// Those that are run, in order.
    chosen: Vec<usize>,
    caught: Caught,
    /// What the hostile inputs show of the others, with its clock.
    shown: HashMap<usize, u64>,
    /// Those that nothing has shown, in order.
    pub(super) open: Vec<usize>,
}

impl Tried {
    /// Runs some variants, in order, under a stimulus, and what it does not catch under
    /// that of a witness.
    ///
    /// # Errors
    /// What of the design has no place in lanes; or a tool fails.
    pub(super) fn new(
        family: Family,
        chosen: Vec<usize>,
        stream: &Stream,
        witness: Option<&Stream>,
    ) -> Result<Tried, Refusal> {
        let mut machines = stream.machines(&family)?;
        let caught = stream.run(&mut machines, &chosen)?;
        let left = caught.missed(&chosen);
        let shown = match witness {
            Some(witness) if !left.is_empty() => {
                let later = witness.run(&mut machines, &left)?;
                let at = left.iter().map(|&number| (number, later.at[number]));
                at.filter_map(|(number, at)| Some((number, at?))).collect()
            }
            _ => HashMap::new(),
        };
        let open = left
            .into_iter()
            .filter(|number| !shown.contains_key(number));
        Ok(Tried {
            open: open.collect(),
            family,
            chosen,
            caught,
            shown,
        })
    }

    /// What is to be proven of those that nothing has shown.
    pub(super) fn questions(&self) -> impl Iterator<Item = Question<'_>> {
        self.open.iter().map(|&number| Question {
            family: &self.family,
            number,
            good_values: &self.caught.after_reset_good,
            values: &self.caught.after_reset[number],
        })
    }

    /// What became of each, with an answer for each that nothing has shown.
    pub(super) fn outcomes(&self, answers: &[Answer], request: &GradeRequest) -> Vec<Outcome> {
        let labels = Labels::of(&self.family.good);
        let outcome = |&number: &usize| Outcome {
            number,
            fate: self.fate(number, answers, &labels, request),
        };
        self.chosen.iter().map(outcome).collect()
    }

    fn fate(
        &self,
        number: usize,
        answers: &[Answer],
        labels: &Labels,
        request: &GradeRequest,
    ) -> Fate {
        if let Some(clock) = self.caught.at[number] {
            return Fate::Caught(clock);
        }
        let (verdict, needs) = match self.shown.get(&number) {
            Some(clock) => {
                let needs = format!(
                    "the adversarial inputs of seed {} show it at clock {clock}",
                    request.seed
                );
                (Verdict::NotCaught, needs)
            }
            None => {
                let place = self.open.binary_search(&number);
                match &answers[place.expect("what is not shown is open")] {
                    Answer::Equivalent => return Fate::Equivalent,
                    Answer::Shown(needs) => (Verdict::NotCaught, needs.clone()),
                    Answer::Undecided(why) => (Verdict::Undecided, why.clone()),
                }
            }
        };
        let (change, net, source) = self.family.describe(labels, number);
        let in_users = |text: &str| in_users_terms(text, &request.sources);
        Fate::Survives(Survivor {
            change,
            net: in_users(&net),
            source: in_users(&places(&source)),
            verdict,
            needs,
        })
    }

    /// How many variants there are, with those that were not run.
    pub(super) fn total(&self) -> usize {
        self.family.count()
    }
}
