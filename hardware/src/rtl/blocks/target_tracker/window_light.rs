//! Whether a window has its target's light.

use crate::rtl::front::prelude::*;
use crate::sensor::track::{LIGHT_HALVINGS, PATIENCE_BITS, TrackPlan};

#[block(window_light)]
/// whether a window has its target's light
///
/// A window with less than a share of the expected sum does not have it. The expected sum follows those of the windows that
/// have.
pub struct WindowLight {
    plan: TrackPlan,
    #[set(plan.sum_bits() as usize)]
    sum_bits: usize,
    #[set(plan.sample_bits as usize)]
    sample_bits: usize,
    /// sum of the window's counts
    #[width(sum_bits)]
    pub i_sum: Input<Word>,
    /// a share of the light is taken from the next clock on
    #[under("Stages of a decision")]
    pub i_begins: Input<bool>,
    /// the share is halved
    pub i_halves: Input<bool>,
    /// what the sum has more than was expected is kept
    pub i_gains: Input<bool>,
    /// the share is there
    pub i_weighs: Input<bool>,
    /// the window counts
    pub i_decides: Input<bool>,
    /// a scan has found a target
    #[under("Peak")]
    pub i_found: Input<bool>,
    /// its count, signed
    #[width(plan.count_bits)]
    pub i_peak_count: Input<Word>,
    /// the window has its target's light
    #[under("Light")]
    pub o_lit: Output<bool>,
    /// windows without light, one after another
    #[width(PATIENCE_BITS)]
    pub o_missed: Output<Word>,
    /// the sum that is expected
    #[width(sum_bits)]
    light: Register<Word>,
    /// the least sum with the target's light
    #[width(sum_bits)]
    least: Register<Word>,
    /// the sum less the least
    #[width(sum_bits + 1)]
    spare: Local<Word>,
    /// the sum is less than the least
    is_dim: Register<bool>,
    /// the sum is not zero
    is_any: Register<bool>,
    /// a sixteenth of what the sum has more than was expected
    #[width(sum_bits + 1 - LIGHT_HALVINGS as usize)]
    gained: Register<Word>,
    /// the window has its target's light
    lit: Register<bool>,
    /// windows without light, one after another
    #[width(PATIENCE_BITS)]
    missed: Register<Word>,
    /// bits that nobody reads, below a sixteenth; linters know by the name
    unused: Local<bool>,
}

#[kernel]
impl Logic for WindowLight {
    /// Whether the sum of the counts is at least a share of what was expected; a sixteenth of what it has more is
    /// expected from now on.
    fn update(&mut self) {
        self.spare.next = bit_cast(signed_cast(self.i_sum.val()), self.sum_bits + 1)
            - bit_cast(self.least.val(), self.sum_bits + 1);
        self.is_dim.next = self.spare.val().get_bit(self.sum_bits);
        self.is_any.next = self.i_sum.val().any();
        let (low, high) = (LIGHT_HALVINGS as usize, self.sum_bits + 1 - LIGHT_HALVINGS as usize);
        if self.i_halves.val() {
            self.least.next = self.least.val() >> 1;
        }
        if self.i_begins.val() {
            self.least.next = self.light.val();
        }
        // Of the light no share is taken yet.
        if self.i_gains.val() {
            self.gained.next = self.spare.val().slice(low, high);
        }
        if self.i_weighs.val() {
            self.lit.next = self.is_any.val() & !self.is_dim.val();
        }
        if self.i_decides.val() {
            if self.lit.val() {
                self.light.next =
                    self.light.val() + bit_cast(signed_cast(self.gained.val()), self.sum_bits);
                self.missed.next = 0.into();
            } else {
                self.missed.next = self.missed.val() + 1;
            }
        }
        if self.i_found.val() {
            self.lit.next = self.i_peak_count.val().any()
                & !self.i_peak_count.val().get_bit(self.plan.count_bits as usize - 1);
            self.light.next = bit_cast(self.i_peak_count.val(), self.sum_bits) << self.sample_bits;
            self.missed.next = 0.into();
        }
        self.o_lit.next = self.lit.val();
        self.o_missed.next = self.missed.val();
        self.unused.next = self.spare.val().slice(0, LIGHT_HALVINGS as usize).any();
    }
}
