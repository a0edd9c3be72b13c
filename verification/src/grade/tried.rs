//! Variants of a design under a stimulus: run, put to the proof, and counted.

use std::collections::HashMap;

use super::labels::{Labels, places};
use super::outcome::FaultOutcome;
use super::proof::{PROOF, ProofAnswer, Question};
use super::run::{Caught, Stream};
use super::variant_set::VariantSet;
use super::{FaultVerdict, Judged};
use crate::cosim::in_users_terms;
use crate::cosim::lanes::LaneRefusal;
use crate::cosim::source::SourceFile;

/// Variants under a stimulus.
pub(super) struct Tried {
    set: VariantSet,
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
        set: VariantSet,
        chosen: Vec<usize>,
        stream: &Stream,
        witness: Option<&Stream>,
    ) -> Result<Tried, LaneRefusal> {
        let mut machines = stream.machines(&set)?;
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
        let open = left.into_iter().filter(|number| !shown.contains_key(number));
        Ok(Tried { open: open.collect(), set, chosen, caught, shown })
    }

    /// What is to be proven of those that nothing has shown.
    pub(super) fn questions(&self) -> impl Iterator<Item = Question<'_>> {
        self.open.iter().map(|&number| Question {
            set: &self.set,
            number,
            good_values: &self.caught.after_reset_good,
            values: &self.caught.after_reset[number],
        })
    }

    /// What became of each, with an answer for each that nothing has shown.
    pub(super) fn outcomes(
        &self,
        answers: &[ProofAnswer],
        sources: &[SourceFile],
        seed: u64,
    ) -> Vec<FaultOutcome> {
        let labels = Labels::of(&self.set.good);
        let outcome = |&number: &usize| FaultOutcome {
            number,
            judged: self.judge(number, answers, &labels, (sources, seed)),
        };
        self.chosen.iter().map(outcome).collect()
    }

    fn judge(
        &self,
        number: usize,
        answers: &[ProofAnswer],
        labels: &Labels,
        (sources, seed): (&[SourceFile], u64),
    ) -> Judged {
        let (change, net, source) = self.set.describe(labels, number);
        let in_users = |text: &str| in_users_terms(text, sources);
        let judged = |verdict| Judged {
            change,
            net: in_users(&net),
            source: in_users(&places(&source)),
            verdict,
            clock: None,
            proof: None,
            needs: None,
        };
        if let Some(clock) = self.caught.at[number] {
            return Judged { clock: Some(clock), ..judged(FaultVerdict::Caught) };
        }
        if let Some(clock) = self.shown.get(&number) {
            let needs = format!("the adversarial inputs of seed {seed} show it at clock {clock}");
            return Judged { needs: Some(needs), ..judged(FaultVerdict::NotCaught) };
        }
        let place = self.open.binary_search(&number);
        match answers[place.expect("what is not shown is open")].clone() {
            ProofAnswer::Equivalent => {
                Judged { proof: Some(PROOF.to_owned()), ..judged(FaultVerdict::ProvenEquivalent) }
            }
            ProofAnswer::Shown(needs) => {
                Judged { needs: Some(needs), ..judged(FaultVerdict::NotCaught) }
            }
            ProofAnswer::Undecided(why) => {
                Judged { needs: Some(why), ..judged(FaultVerdict::Undecided) }
            }
        }
    }

    /// How many variants there are, with those that were not run.
    pub(super) fn total(&self) -> usize {
        self.set.count()
    }
}
