//! Verilator's 64 lanes beside the first of a vector: the same blocks, and the same words of all
//! registers after them.
//!
//! Both programs are made of one netlist, and by different compilers. What one of them gets wrong
//! shows here, whatever the outputs say.

use std::collections::VecDeque;

use super::design::{Backend, LaneDesign};
use super::model::{BlockAnswer, LaneBlock, LaneModel, PeriodicOutput};
use super::netlist::FlipFlop;
use super::planes::Planes;
use super::vectors;
use super::verilog::LANES;
use crate::cosim::error::CosimError;

/// Verilator's model, and how far it has come.
pub(super) struct Referee {
    model: LaneModel,
    /// What it found, block by block, of which nothing has been heard from the other.
    found: VecDeque<BlockAnswer>,
    /// Clocks of all its lanes together.
    clocks: u64,
    differs: Option<String>,
}

impl Referee {
    /// Clocks of each lane that it sees.
    pub(super) const CLOCKS: u64 = 8_192;

    /// Starts the model with the tables of a vector's lanes.
    ///
    /// # Errors
    /// When it cannot be started.
    pub(super) fn load(
        design: &LaneDesign,
        tables: &[PeriodicOutput],
    ) -> Result<Referee, CosimError> {
        let narrowed = |table: &PeriodicOutput| PeriodicOutput {
            planes: table.planes.narrowed().into(),
            ..table.clone()
        };
        let tables: Vec<PeriodicOutput> = tables.iter().map(narrowed).collect();
        Ok(Referee {
            model: LaneModel::load(design, Backend::Verilator, &tables)?,
            found: VecDeque::new(),
            clocks: 0,
            differs: None,
        })
    }

    /// Begins with a vector's registers and expected outputs.
    pub(super) fn start(&mut self, registers: &Planes, expected: &Planes) -> Result<(), String> {
        self.model.set_registers(&registers.narrowed())?;
        self.model.expect(&expected.narrowed())
    }

    /// Clocks a block that a vector clocks.
    pub(super) fn block(&mut self, block: &LaneBlock) -> Result<(), String> {
        let narrowed = LaneBlock {
            clocks: block.clocks,
            reset: block.reset.narrowed(),
            watched: block.watched.narrowed(),
            edges: block.edges.iter().filter_map(|&edge| narrowed_place(edge)).collect(),
            events: block
                .events
                .iter()
                .filter_map(|&event| {
                    let place = narrowed_place(event as u32)?;
                    Some(event >> 32 << 32 | u64::from(place))
                })
                .collect(),
            phases: block.phases.clone(),
        };
        self.model.submit(&narrowed)?;
        self.found.push_back(self.model.collect()?);
        self.clocks += block.clocks * LANES as u64;
        Ok(())
    }

    /// Hears what a vector has found in the next of the blocks.
    pub(super) fn found(&mut self, found: &BlockAnswer) {
        let Some(own) = self.found.pop_front() else {
            return;
        };
        // A beat of other lanes alone is none of its own.
        let beats = found.beats.iter().map(|(clock, planes)| (*clock, planes.narrowed()));
        let is_same = own.different == found.different.narrowed()
            && own.beats.iter().all(|beat| beats.clone().any(|other| other == *beat));
        if !is_same {
            self.differs.get_or_insert_with(|| "an output".to_owned());
        }
    }

    /// Compares all registers with the vector's: gives the clocks of all lanes together, or what
    /// differs.
    pub(super) fn verdict(
        mut self,
        registers: &[FlipFlop],
        of_vector: &Planes,
    ) -> Result<Result<u64, String>, String> {
        let own = self.model.registers()?;
        let narrowed = of_vector.narrowed();
        let mut pairs = registers.iter().zip(own.rows().zip(narrowed.rows()));
        let found = pairs.find(|(_, (own, other))| own != other);
        let register =
            found.map(|(register, _)| format!("{}[{}]", register.name.0, register.name.1));
        Ok(match register.or(self.differs) {
            Some(differs) => Err(differs),
            None => Ok(self.clocks),
        })
    }
}

/// A place among a vector's lanes as one among the first 64; none if it is another lane's.
fn narrowed_place(place: u32) -> Option<u32> {
    let (row, lane) = (place / vectors::LANES as u32, place % vectors::LANES as u32);
    (lane < LANES as u32).then_some(row * LANES as u32 + lane)
}
