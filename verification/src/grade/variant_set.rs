//! The faults of a design, or its mutants.

use std::collections::HashMap;

use super::GradeOptions;
use super::labels::Labels;
use crate::cosim::lanes::mutants::{Mutant, mutants};
use crate::cosim::lanes::netlist::{BitNet, CHOICE, GateNetlist};
use crate::cosim::lanes::variants::{Site, with_faults};
use crate::cosim::lanes::{LaneRefusal, Memories};
use crate::cosim::source::Verilog;

/// Variants of a design, all of a kind.
pub(super) struct VariantSet {
    /// The design with all variants; a bit of the choice for each.
    pub(super) all: GateNetlist,
    /// The design with none.
    pub(super) good: GateNetlist,
    kind: Kind,
}

enum Kind {
    /// Stuck at 0 and stuck at 1, in turn.
    Faults(Vec<Site>),
    Mutants(Vec<Mutant>),
}

impl VariantSet {
    /// Every net stuck at 0 and at 1.
    pub(super) fn faults(netlist: &GateNetlist) -> VariantSet {
        let (all, sites) = with_faults(netlist);
        VariantSet { all, good: netlist.clone(), kind: Kind::Faults(sites) }
    }

    /// Mutants that Yosys chooses.
    ///
    /// # Errors
    /// What of the design has no place in lanes; or a tool fails.
    pub(super) fn mutants(
        verilog: &Verilog,
        options: &GradeOptions,
        memories: Memories,
        count: u32,
    ) -> Result<VariantSet, LaneRefusal> {
        let kept: Vec<String> = verilog
            .registers
            .iter()
            .flat_map(|registers| registers.present())
            .map(|register| register.path("."))
            .collect();
        let (top, sources, cache) = (&verilog.top, &verilog.sources, &verilog.cache);
        let (all, list) = mutants(top, sources, count, options.seed, &kept, memories, cache)?;
        Ok(VariantSet { good: chosen(&all, None), all, kind: Kind::Mutants(list) })
    }

    /// How many variants there are.
    pub(super) fn count(&self) -> usize {
        match &self.kind {
            Kind::Faults(sites) => 2 * sites.len(),
            Kind::Mutants(list) => list.len(),
        }
    }

    /// The design that is one of the variants.
    pub(super) fn variant(&self, number: usize) -> GateNetlist {
        match &self.kind {
            Kind::Faults(sites) => {
                let stuck = HashMap::from([(sites[number / 2].net, number % 2 == 1)]);
                self.good.with_tied(&stuck)
            }
            Kind::Mutants(_) => chosen(&self.all, Some(number)),
        }
    }

    /// What a variant is, its net, and its lines in the Verilog as Yosys knows them.
    pub(super) fn describe(&self, labels: &Labels, number: usize) -> (String, String, String) {
        match &self.kind {
            Kind::Faults(sites) => {
                let (net, source) = labels.describe(sites[number / 2].net);
                (format!("stuck at {}", number % 2), net, source)
            }
            Kind::Mutants(list) => {
                let mutant = &list[number];
                (mutant.mode.clone(), mutant.place.clone(), mutant.source.clone())
            }
        }
    }
}

/// The netlist of mutants with one of them, or none.
fn chosen(all: &GateNetlist, number: Option<usize>) -> GateNetlist {
    let choice = all.input(CHOICE).unwrap_or_default();
    let bits = choice.iter().enumerate();
    let tied: HashMap<BitNet, bool> = bits.map(|(bit, &net)| (net, Some(bit) == number)).collect();
    all.with_tied(&tied)
}
