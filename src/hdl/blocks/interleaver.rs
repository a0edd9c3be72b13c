//! Interleaving: every chip 2^nu times, every other one inverted (eq. 23).

use super::{CodePorts, CodeSource};
use crate::hdl::front::prelude::*;

/// A code interleaved with its inverse (eq. 23).
#[derive(Debug, Clone, LogicBlock)]
pub struct Interleaver {
    /// Ports.
    pub io: CodePorts,
    about: About,
    subchip_load: Constant,
    subchip: Register<Word>,
    generator: CodeSource,
}

impl Interleaver {
    /// `generator` interleaved to depth `depth`, starting at sub-chip
    /// `subchip` of its present chip.
    pub fn new(generator: CodeSource, depth: u32, subchip: u64, reloads: bool) -> Interleaver {
        let load = u128::from(subchip);
        Interleaver {
            io: CodePorts::new(reloads),
            about: About::new(
                "interleaver",
                "a code with every chip repeated and every other repetition inverted",
            )
            .note(
                "The code and its inverse take turns chip by chip, which removes the side \
                 lobes' mean from the correlation near the peak.",
            )
            .fact(
                "Depth",
                format!("{depth}: each chip of the generator {} times", 1 << depth),
            )
            .fact("Latency", "0 clocks from register to o_chip")
            .fact("Rate", "one chip per clock with i_advance high"),
            subchip_load: Constant::new(load, depth, "Sub-chip that reset gives"),
            subchip: Register::word(depth, load, "repetition of the generator's chip")
                .reset_to("subchip_load"),
            generator,
        }
    }
}

impl Logic for Interleaver {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, io.i_clk, subchip);
        self.generator.i_clk.next = self.io.i_clk.val();
        self.generator.i_rst.next = self.io.i_rst.val();
        self.generator.i_advance.next = self.io.i_advance.val() & self.subchip.q.val().all();
        self.io.o_chip.next = self.generator.o_chip.val() ^ self.subchip.q.val().get_bit(0);
        self.io.o_epoch.next =
            self.generator.o_epoch.val() & (self.subchip.q.val() == self.subchip_load.val());
        if self.io.i_advance.val() {
            self.subchip.d.next = self.subchip.q.val() + 1;
        }
        for _load in 0..self.io.i_load.count() {
            self.generator.i_load[0].next = self.io.i_load[0].val();
            if self.io.i_load[0].val() {
                self.subchip.d.next = self.subchip_load.val();
            }
        }
    }
}
