//! Follows a target with a window of phase steps.
//!
//! | port | |
//! |---|---|
//! | `i_go`, `o_go` | scans are wanted; the next one may begin |
//! | `i_taken_first`, `i_word`, `o_word` | settings on their way to the sequencer, which a window has its own of |
//! | `i_refused` | they do not fit |
//! | `i_count`, `i_counted`, `i_last` | counts of the phase steps |
//! | `i_peak_step`, `i_peak_count`, `i_peak_valid` | what a scan has found |
//! | `o_position`, `o_locked`, `o_lost` | where the target is; it is there; it was lost |
//!
//! A window is a scan of two chips whose first step and number of steps stand in place of the host's while these
//! pass by. A scan that finds a target, and each window, is weighed before the next one begins: some 40 clocks. No two
//! carry chains follow one another within a clock, and none stands behind a choice of many. So there is one adder for the
//! slope, one for its quotient ([`WindowOffset`]), one for the light ([`WindowLight`]) and one for the position
//! ([`WindowPosition`]); [`WindowSettings`] puts a window's own settings in the host's place. The plan has the clocks, the reference model the rule.

mod window_light;
mod window_offset;
mod window_position;
mod window_settings;

use self::window_light::WindowLight;
use self::window_offset::WindowOffset;
use self::window_position::{MOVES, WindowPosition};
use self::window_settings::WindowSettings;
use crate::rtl::front::prelude::*;
use crate::sensor::track::{SHARE_BITS, TrackPlan};

#[block(target_tracker)]
/// follows a target with a window of phase steps
///
/// A scan's peak is where a target is looked for, and each window about it says how far it has moved since. The next window's
/// first step and number of steps take the place of the host's on their way to the sequencer. Windows without the target's
/// light end in a scan.
///
/// - Window: {plan.window_steps()} phase steps
/// - Latency: {plan.decision_clocks() + 1} clocks from a window's last i_counted to o_go
pub struct TargetTracker {
    plan: TrackPlan,
    /// Words of settings; the last is this block's.
    settings: usize,
    /// Bits of a setting.
    word_bits: usize,
    /// Bits of one that the sequencer takes over.
    scan_word_bits: usize,
    /// Bits of a peak's step, from the scan's first on.
    peak_step_bits: usize,
    #[set(plan.step_bits as usize)]
    step_bits: usize,
    #[set(plan.offset_bits() as usize)]
    offset_bits: usize,
    /// The stage that has the quotient, and the one that has the way.
    #[set(offset_bits + 4)]
    divided: usize,
    #[set(plan.decision_clocks() as usize - MOVES)]
    halved: usize,
    /// scans are wanted
    #[under("Registers")]
    pub i_go: Input<bool>,
    /// the next one may begin
    pub o_go: Output<bool>,
    /// the first setting is read
    pub i_taken_first: Input<bool>,
    /// the setting that was read a clock ago
    #[width(word_bits)]
    pub i_word: Input<Word>,
    /// the same, or a window's own
    #[width(scan_word_bits)]
    pub o_word: Output<Word>,
    /// settings do not fit
    pub i_refused: Input<bool>,
    /// a scan's chips are counted
    #[under("Counts")]
    pub i_run: Input<bool>,
    /// count of a phase step, signed
    #[width(plan.count_bits)]
    pub i_count: Input<Word>,
    /// it is new
    pub i_counted: Input<bool>,
    /// it is a scan's last
    pub i_last: Input<bool>,
    /// phase step of a scan's peak, from the scan's first on
    #[under("Peak")]
    #[width(peak_step_bits)]
    pub i_peak_step: Input<Word>,
    /// its count, signed
    #[width(plan.count_bits)]
    pub i_peak_count: Input<Word>,
    /// they have just changed
    pub i_peak_valid: Input<bool>,
    /// phase step of the target's peak, and 8 bits of its fraction
    #[under("Target")]
    #[width(plan.position_bits())]
    pub o_position: Output<Word>,
    /// the last window had its light
    pub o_locked: Output<bool>,
    /// it has just been lost
    pub o_lost: Output<bool>,
    /// there is a target for the next scan to follow
    follows: Register<bool>,
    /// the present scan is a window
    window: Register<bool>,
    /// what follows of the present scan is still to come
    waits: Register<bool>,
    /// the scan that is to find a target has begun: peaks are its own
    began: Register<bool>,
    /// it has ended, with a peak
    finds: Local<bool>,
    /// it had a clock ago
    found: Register<bool>,
    /// a window's last count is there
    window_ends: Local<bool>,
    /// the target is still there
    goes_on: Local<bool>,
    /// stages of a decision, up to the share of the way, one bit for each
    #[width(halved)]
    stage: Register<Word>,
    /// halvings still to come
    #[width(SHARE_BITS)]
    halvings: Register<Word>,
    /// a share is halved
    halves: Register<bool>,
    /// that was the last of them
    gives_up: Register<bool>,
    #[is(WindowSettings::new(plan, settings, word_bits, scan_word_bits))]
    set: WindowSettings,
    #[is(WindowOffset::new(plan))]
    offset: WindowOffset,
    #[is(WindowLight::new(plan))]
    light: WindowLight,
    #[is(WindowPosition::new(plan, peak_step_bits, scan_word_bits))]
    target: WindowPosition,
    locked: Register<bool>,
    lost: Register<bool>,
}

#[kernel]
impl Logic for TargetTracker {
    fn update(&mut self) {
        self.pass_settings();
        self.run_stages();
        self.halve();
        self.weigh();
        self.place();
        self.decide();
        self.tell();
    }

    /// Settings on their way from the registers to the sequencer.
    fn pass_settings(&mut self) {
        if self.i_taken_first.val() {
            self.window.next = self.follows.val();
        }
        connect! { self.set from self: i_taken_first, i_word }
        self.set.i_window.next = self.window.val();
        connect! { self.set from self.target: i_first }
        connect! { self from self.set: o_word }
        if self.set.o_last.val() {
            self.waits.next = self.i_word.val().get_bit(0) | self.window.val();
        }
        if self.i_refused.val() {
            self.waits.next = false;
        }
        self.o_go.next = self.i_go.val() & !self.waits.val();
    }

    /// Which scan finds a target, and since when a window has ended.
    fn run_stages(&mut self) {
        self.began.next = self.i_run.val() | (self.began.val() & !self.i_taken_first.val());
        self.finds.next =
            self.i_peak_valid.val() & self.began.val() & self.waits.val() & !self.window.val();
        self.found.next = self.finds.val();
        self.window_ends.next = self.i_last.val() & self.window.val();
        self.stage.next = self.stage.val().shifted_in(self.window_ends.val());
    }

    /// Shares are taken by halves, that of the light and later that of the way.
    fn halve(&mut self) {
        self.halves.next = self.halvings.val().any();
        if self.halvings.val().any() {
            self.halvings.next = self.halvings.val() - 1;
        }
        if self.stage.val().get_bit(0) {
            self.halvings.next = self.set.o_threshold.val();
        }
        if self.stage.val().get_bit(self.divided + 3) {
            self.halvings.next = self.set.o_gain.val();
        }
    }

    /// What is done with the sums in which stage.
    fn weigh(&mut self) {
        let divided = self.divided;
        connect! { self.offset from self: i_count, i_counted }
        self.offset.i_clear.next = self.i_taken_first.val();
        self.offset.i_ends.next = self.window_ends.val();
        self.offset.i_turns.next = self.stage.val().get_bit(0);
        self.light.i_sum.next = self.offset.o_sum.val();
        self.light.i_begins.next = self.stage.val().get_bit(0);
        self.light.i_halves.next = self.halves.val();
        self.light.i_gains.next = self.stage.val().get_bit(1);
        self.light.i_weighs.next = self.stage.val().get_bit(divided);
        self.light.i_decides.next = self.stage.val().get_bit(self.halved - 1);
        self.light.i_found.next = self.found.val();
        connect! { self.light from self: i_peak_count }
    }

    /// The share of the way to the peak, and what follows from it.
    fn place(&mut self) {
        self.goes_on.next = self.set.o_on.val()
            & !self.gives_up.val()
            & (self.window.val() | self.light.o_lit.val());
        self.target.i_size.next = self.offset.o_size.val();
        self.target.i_negative.next = self.offset.o_negative.val();
        self.target.i_finds.next = self.finds.val();
        self.target.i_found.next = self.found.val();
        connect! { self.target from self.set: i_first }
        connect! { self.target from self: i_peak_step }
        self.target.i_way.next = self.stage.val().slice(self.divided - 1, 5);
        self.target.i_halving.next = self.halvings.val().any();
        self.target.i_halves.next = self.halves.val();
        self.target.i_moves.next = self.stage.val().get_bit(self.halved - 1);
        connect! { self.target from self.light: i_lit }
        self.target.i_follows.next = self.goes_on.val();
        connect! { self from self.target: o_position }
    }

    /// Whether there is still a target, and with that the next scan may begin.
    fn decide(&mut self) {
        if self.target.o_moves.val() {
            self.gives_up.next =
                !self.light.o_lit.val() & (self.light.o_missed.val() >= self.set.o_patience.val());
        }
        if self.found.val() {
            self.gives_up.next = false;
        }
        self.lost.next = false;
        if self.target.o_placed.val() {
            self.waits.next = false;
            self.follows.next = self.goes_on.val();
            self.locked.next = self.set.o_on.val() & self.window.val() & self.light.o_lit.val();
            self.lost.next = self.set.o_on.val() & self.gives_up.val();
        }
        if !self.i_go.val() {
            self.follows.next = false;
            self.locked.next = false;
        }
    }

    fn tell(&mut self) {
        self.o_locked.next = self.locked.val();
        self.o_lost.next = self.lost.val();
    }
}

#[cfg(test)]
mod tests;
