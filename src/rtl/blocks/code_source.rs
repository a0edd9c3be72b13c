//! What every source of chips has in common: its ports.

use std::ops::{Deref, DerefMut};

use rust_hdl_core::ast::Verilog;

use super::{ChipTableGenerator, Interleaver, LfsrGenerator, SquareGenerator};
use crate::code::{Code, Generator};
use crate::rtl::front::prelude::*;

/// Ports of a source of chips.
#[derive(Debug, Clone)]
pub struct CodePorts {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// Go on to the next chip.
    pub i_advance: Input<bool>,
    /// Start again from the chip that reset gives; wins over `i_advance`.
    pub i_load: Optional<Input<bool>>,
    /// The present chip.
    pub o_chip: Output<bool>,
    /// Whether the present chip is the one that reset gives.
    pub o_epoch: Output<bool>,
}

impl CodePorts {
    /// Ports, with `i_load` if `reloads`.
    pub fn new(reloads: bool) -> CodePorts {
        CodePorts {
            i_clk: Input::bit("one chip per cycle at most"),
            i_rst: Input::bit("synchronous, active high"),
            i_advance: Input::bit("go on to the next chip"),
            i_load: Optional::new(
                reloads,
                Input::bit("start again as after reset; wins over i_advance"),
            ),
            o_chip: Output::bit("present chip"),
            o_epoch: Output::bit("the present chip is the one that reset gives"),
        }
    }
}

impl Logic for CodePorts {
    fn update(&mut self) {}
}

impl Block for CodePorts {
    fn connect_all(&mut self) {
        self.o_chip.connect();
        self.o_epoch.connect();
    }

    fn update_all(&mut self) {
        self.i_clk.update_all();
        self.i_rst.update_all();
        self.i_advance.update_all();
        self.i_load.update_all();
        self.o_chip.update_all();
        self.o_epoch.update_all();
    }

    fn has_changed(&self) -> bool {
        self.i_clk.has_changed()
            || self.i_rst.has_changed()
            || self.i_advance.has_changed()
            || self.i_load.has_changed()
            || self.o_chip.has_changed()
            || self.o_epoch.has_changed()
    }

    fn accept(&self, name: &str, probe: &mut dyn probe::Probe) {
        probe.visit_start_namespace(name, self);
        self.i_clk.accept("i_clk", probe);
        self.i_rst.accept("i_rst", probe);
        self.i_advance.accept("i_advance", probe);
        self.i_load.accept("i_load", probe);
        self.o_chip.accept("o_chip", probe);
        self.o_epoch.accept("o_epoch", probe);
        probe.visit_end_namespace(name, self);
    }
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
        let base_start = start >> code.interleave;
        let generator = match &code.generator {
            Generator::MSequence(lfsr) => {
                CodeSource::Lfsr(LfsrGenerator::m_sequence(lfsr, base_start, reloads).into())
            }
            Generator::Gold { u, v } => {
                CodeSource::Lfsr(LfsrGenerator::gold(u, v, base_start, reloads).into())
            }
            Generator::Square => {
                CodeSource::Square(SquareGenerator::new(base_start, reloads).into())
            }
            Generator::Chips(chips) => {
                CodeSource::ChipTable(ChipTableGenerator::new(chips, base_start, reloads).into())
            }
        };
        if code.interleave == 0 {
            return generator;
        }
        let subchip = start & ((1 << code.interleave) - 1);
        let interleaver = Interleaver::new(generator, code.interleave, subchip, reloads);
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

impl Logic for CodeSource {
    fn update(&mut self) {
        self.block_mut().update();
    }

    fn connect(&mut self) {
        self.block_mut().connect();
    }

    fn hdl(&self) -> Verilog {
        self.block().hdl()
    }
}

impl Block for CodeSource {
    fn connect_all(&mut self) {
        self.block_mut().connect_all();
    }

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
