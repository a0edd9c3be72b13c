//! Interleaving: every chip 2^nu times, every other one inverted (eq. 23).
//!
//! A counter of nu bits and one XOR gate, in place of a generator of a code 2^nu times as long.
//!
//! Cost (ECP5, docs/resources.md): 4 LUTs, 3 flip-flops for nu = 1 in both generators.

use super::CodeSource;
use crate::rtl::blocks::CodePorts;
use crate::rtl::front::prelude::*;
use crate::sensor::registers::Seed;

#[block(interleaver)]
/// a code with every chip repeated and every other repetition inverted
///
/// The code and its inverse take turns chip by chip (eq. 23), which removes the side lobes' mean from the
/// correlation near the peak.
///
/// - Depth: {depth}: each chip of the generator {1 << depth} times
/// - Latency: 0 clocks from register to o_chip
pub struct Interleaver {
    depth: u32,
    /// Of the generator's first chip.
    first_subchip: u64,
    reloads: bool,
    /// What is set from outside of the generator.
    seed: Option<Seed>,
    /// ports
    #[is(CodePorts::new(reloads, seed))]
    pub io: CodePorts,
    /// that reset gives
    #[width(depth)]
    #[value(u128::from(first_subchip))]
    subchip_load: Constant,
    /// repetition of the generator's chip
    #[width(depth)]
    #[reset(u128::from(first_subchip), subchip_load)]
    subchip: Register<Word>,
    #[given]
    generator: CodeSource,
}

#[kernel]
impl Logic for Interleaver {
    fn update(&mut self) {
        self.generator.i_advance.next = self.io.i_advance.val() & self.subchip.val().all();
        self.io.o_chip.next = self.generator.o_chip.val() ^ self.subchip.val().get_bit(0);
        self.io.o_epoch.next =
            self.generator.o_epoch.val() & (self.subchip.val() == self.subchip_load.val());
        if self.io.i_advance.val() {
            self.subchip.next = self.subchip.val() + 1;
        }
        connect! { self.generator from self.io: i_seed }
        if self.io.i_load.is_present() {
            self.generator.i_load.next = self.io.i_load.val();
            if self.io.i_load.val() {
                self.subchip.next = self.subchip_load.val();
            }
        }
    }
}
