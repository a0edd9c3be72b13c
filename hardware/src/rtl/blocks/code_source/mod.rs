//! Any source of chips.

mod interleaver;

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use rust_hdl_core::ast::Verilog;

pub use self::interleaver::Interleaver;
use super::{ChipTableGenerator, CodePorts, LfsrGenerator, SquareGenerator};
use crate::code::{Code, Generator, Lfsr};
use crate::rtl::front::prelude::*;
use crate::sensor::interface::Interface;
use crate::sensor::registers::Seed;

/// What a host sets of a code, if there is a host and it sets something.
pub(super) fn seed_of(interface: &Interface, code: &Arc<Code>) -> Option<Seed> {
    let plan = interface.registers.as_ref()?;
    plan.seed_number(code, &interface.source_codes).map(|number| plan.seeds[number])
}

/// First bit and bits of that among all that a host sets; no bits of other codes.
pub(super) fn seed_taken(interface: &Interface, code: &Arc<Code>) -> (usize, usize) {
    let taken = interface.registers.as_ref().and_then(|plan| {
        let number = plan.seed_number(code, &interface.source_codes)?;
        Some((plan.first_seed_bit(number) as usize, plan.seeds[number].bits as usize))
    });
    taken.unwrap_or_default()
}

/// Any source of chips; all have [`CodePorts`].
#[derive(Debug, Clone)]
pub enum CodeSource {
    /// One or two LFSRs.
    Lfsr(Box<LfsrGenerator>),
    /// A toggle.
    Square(Box<SquareGenerator>),
    /// A table of given chips.
    ChipTable(Box<ChipTableGenerator>),
    /// Any of these, interleaved.
    Interleaver(Box<Interleaver>),
}

impl CodeSource {
    /// The source of `code` whose reset and load give chip `start`, 0 ..
    /// `code.len()`.
    pub fn new(code: &Code, start: u64, reloads: bool) -> CodeSource {
        CodeSource::of(code, start, reloads, None)
    }

    /// The source of `code` from its first chip on, whose load gives its last LFSR what is on `i_seed`.
    pub fn seeded(code: &Code, seed: Option<Seed>) -> CodeSource {
        CodeSource::of(code, 0, true, seed)
    }

    fn of(code: &Code, start: u64, reloads: bool, seed: Option<Seed>) -> CodeSource {
        let base_start = start >> code.interleave;
        let lfsr = |first: &Lfsr, second: Option<&Lfsr>| {
            let second = second.cloned();
            let lfsr = LfsrGenerator::new(first.clone(), second, base_start, reloads, seed);
            CodeSource::Lfsr(lfsr.into())
        };
        let generator = match &code.generator {
            Generator::MSequence(only) => lfsr(only, None),
            Generator::Gold { u, v } => lfsr(u, Some(v)),
            Generator::Square => {
                CodeSource::Square(SquareGenerator::new(base_start, reloads).into())
            }
            Generator::Chips(chips) => CodeSource::ChipTable(
                ChipTableGenerator::new(chips.clone(), base_start, reloads).into(),
            ),
        };
        if code.interleave == 0 {
            return generator;
        }
        let subchip = start & ((1 << code.interleave) - 1);
        let interleaver = Interleaver::new(code.interleave, subchip, reloads, seed, generator);
        CodeSource::Interleaver(interleaver.into())
    }

    fn block(&self) -> &dyn Block {
        match self {
            CodeSource::Lfsr(block) => &**block,
            CodeSource::Square(block) => &**block,
            CodeSource::ChipTable(block) => &**block,
            CodeSource::Interleaver(block) => &**block,
        }
    }

    fn block_mut(&mut self) -> &mut dyn Block {
        match self {
            CodeSource::Lfsr(block) => &mut **block,
            CodeSource::Square(block) => &mut **block,
            CodeSource::ChipTable(block) => &mut **block,
            CodeSource::Interleaver(block) => &mut **block,
        }
    }
}

impl Deref for CodeSource {
    type Target = CodePorts;
    fn deref(&self) -> &CodePorts {
        match self {
            CodeSource::Lfsr(block) => &block.io,
            CodeSource::Square(block) => &block.io,
            CodeSource::ChipTable(block) => &block.io,
            CodeSource::Interleaver(block) => &block.io,
        }
    }
}

impl DerefMut for CodeSource {
    fn deref_mut(&mut self) -> &mut CodePorts {
        match self {
            CodeSource::Lfsr(block) => &mut block.io,
            CodeSource::Square(block) => &mut block.io,
            CodeSource::ChipTable(block) => &mut block.io,
            CodeSource::Interleaver(block) => &mut block.io,
        }
    }
}

impl BlockInputs for CodeSource {
    fn set(&mut self, port: &str, value: u128) {
        CodePorts::set(self, port, value);
    }
}

impl Logic for CodeSource {
    fn update(&mut self) {
        self.block_mut().update();
    }

    fn hdl(&self) -> Verilog {
        self.block().hdl()
    }
}

impl Block for CodeSource {
    fn connect_all(&mut self) {}

    fn update_all(&mut self) {
        self.block_mut().update_all();
    }

    fn has_changed(&self) -> bool {
        self.block().has_changed()
    }

    fn accept(&self, name: &str, probe: &mut dyn probe::Probe) {
        self.block().accept(name, probe);
    }
}
