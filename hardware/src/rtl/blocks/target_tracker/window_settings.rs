//! Settings on their way from the registers to the sequencer.

use crate::rtl::front::prelude::*;
use crate::sensor::registers::SCAN_WORDS;
use crate::sensor::track::{PATIENCE_BITS, SHARE_BITS, TrackPlan};

/// The bit of a setting's word that turns it on, and the first of each number in it.
const GAIN: usize = 1;
const THRESHOLD: usize = GAIN + SHARE_BITS as usize;
const PATIENCE: usize = THRESHOLD + SHARE_BITS as usize;

#[block(window_settings)]
/// settings on their way to the sequencer, of which a window has its own
pub struct WindowSettings {
    plan: TrackPlan,
    /// Words of settings; the last says how a target is followed.
    settings: usize,
    /// Bits of a setting.
    word_bits: usize,
    /// Bits of one that the sequencer takes over.
    scan_word_bits: usize,
    #[set(plan.step_bits as usize)]
    step_bits: usize,
    #[set((step_bits + 3).min(scan_word_bits))]
    first_bits: usize,
    /// the first setting is read
    pub i_taken_first: Input<bool>,
    /// the scan is a window
    pub i_window: Input<bool>,
    /// its first phase step
    #[width(first_bits)]
    pub i_first: Input<Word>,
    /// the setting that was read a clock ago
    #[width(word_bits)]
    pub i_word: Input<Word>,
    /// the same, or a window's own
    #[width(scan_word_bits)]
    pub o_word: Output<Word>,
    /// the last setting passes by
    #[under("Settings")]
    pub o_last: Output<bool>,
    /// a target is followed
    pub o_on: Output<bool>,
    /// halvings of the way to the peak
    #[width(SHARE_BITS)]
    pub o_gain: Output<Word>,
    /// halvings of the light
    #[width(SHARE_BITS)]
    pub o_threshold: Output<Word>,
    /// windows without light before a target is lost
    #[width(PATIENCE_BITS)]
    pub o_patience: Output<Word>,
    /// first phase step of a scan
    #[width(step_bits)]
    pub o_first: Output<Word>,
    /// phase steps of a window
    #[width(scan_word_bits)]
    #[value(u128::from(plan.window_steps()))]
    #[number]
    window_steps: Constant,
    /// a setting passes by, one bit for each
    #[width(settings)]
    passes: Register<Word>,
    /// the number of steps passes by, and is a window's
    passes_steps: Register<bool>,
    /// the first step does
    passes_first: Register<bool>,
    on: Register<bool>,
    #[width(SHARE_BITS)]
    gain: Register<Word>,
    #[width(SHARE_BITS)]
    threshold: Register<Word>,
    #[width(PATIENCE_BITS)]
    patience: Register<Word>,
    #[width(step_bits)]
    first: Register<Word>,
}

#[kernel]
impl Logic for WindowSettings {
    fn update(&mut self) {
        let own = self.settings - 1;
        self.passes.next = self.passes.val().shifted_in(self.i_taken_first.val());
        self.passes_steps.next = self.i_window.val() & self.passes.val().get_bit(0);
        self.passes_first.next = self.i_window.val() & self.passes.val().get_bit(1);
        if self.passes_steps.val() {
            self.o_word.next = self.window_steps.val();
        } else if self.passes_first.val() {
            self.o_word.next = bit_cast(self.i_first.val(), self.scan_word_bits);
        } else {
            self.o_word.next = bit_cast(self.i_word.val(), self.scan_word_bits);
        }
        if self.passes.val().get_bit(SCAN_WORDS - 1) {
            self.first.next = bit_cast(self.i_word.val(), self.step_bits);
        }
        self.o_last.next = self.passes.val().get_bit(own);
        if self.passes.val().get_bit(own) {
            self.on.next = self.i_word.val().get_bit(0);
            self.gain.next = self.i_word.val().slice(GAIN, SHARE_BITS as usize);
            self.threshold.next = self.i_word.val().slice(THRESHOLD, SHARE_BITS as usize);
            self.patience.next = self.i_word.val().slice(PATIENCE, PATIENCE_BITS as usize);
        }
        connect! { self: on, gain, threshold, patience, first }
    }
}
