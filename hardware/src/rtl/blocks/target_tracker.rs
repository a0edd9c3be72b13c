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
//! pass by. A scan that finds a target, and each window, is weighed before the next one begins: some 40 clocks, in
//! which there is time for a bit of the quotient in each. The plan has the clocks, the reference model the rule.

use crate::rtl::front::prelude::*;
use crate::sensor::registers::SCAN_WORDS;
use crate::sensor::track::{
    FRACTION_BITS, HIDDEN_BITS, LIGHT_HALVINGS, PATIENCE_BITS, SHARE_BITS, TrackPlan,
};

/// Bits of a position's fraction.
const POSITION_BITS: usize = (FRACTION_BITS + HIDDEN_BITS) as usize;
/// The bit of a setting's word that turns it on, and the first of each number in it.
const GAIN: usize = 1;
const THRESHOLD: usize = GAIN + SHARE_BITS as usize;
const PATIENCE: usize = THRESHOLD + SHARE_BITS as usize;

#[block(target_tracker)]
/// follows a target with a window of phase steps
///
/// A scan's peak is where a target is looked for. Of each window about it the later half's counts less the earlier half's,
/// over the sum of all, say how far the peak is from the middle, and the position moves by a share of that. The next
/// window's first step and number of steps take the place of the host's settings on their way to the sequencer.
///
/// A window with less than a share of the expected sum does not have the target's light; after some of them in a row a scan
/// looks for it again.
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
    #[set(plan.sum_bits() as usize)]
    sum_bits: usize,
    #[set(plan.step_bits as usize)]
    step_bits: usize,
    #[set(plan.sample_bits as usize)]
    sample_bits: usize,
    #[set(plan.offset_bits() as usize)]
    offset_bits: usize,
    /// Bits of the way to the peak: half a chip and some steps, with its fraction and its sign.
    #[set(offset_bits + HIDDEN_BITS as usize + 4)]
    way_bits: usize,
    /// Bits of a step that may be beyond the code period's ends.
    #[set(step_bits + 3)]
    moved_bits: usize,
    /// Stages of a decision.
    #[set(plan.decision_clocks() as usize)]
    stages: usize,
    /// The stage that has the quotient, and the one that has the way.
    #[set(offset_bits + 1)]
    divided: usize,
    #[set(divided + (1 << SHARE_BITS))]
    halved: usize,
    /// scans are wanted
    #[under("Registers")]
    pub i_go: Input<bool>,
    /// the next one may begin
    #[under("Registers")]
    pub o_go: Output<bool>,
    /// the first setting is read
    #[under("Registers")]
    pub i_taken_first: Input<bool>,
    /// the setting that was read a clock ago
    #[under("Registers")]
    #[width(word_bits)]
    pub i_word: Input<Word>,
    /// the same, or a window's own
    #[under("Registers")]
    #[width(scan_word_bits)]
    pub o_word: Output<Word>,
    /// settings do not fit
    #[under("Registers")]
    pub i_refused: Input<bool>,
    /// a scan's chips are counted
    #[under("Counts")]
    pub i_run: Input<bool>,
    /// count of a phase step, signed
    #[under("Counts")]
    #[width(plan.count_bits)]
    pub i_count: Input<Word>,
    /// it is new
    #[under("Counts")]
    pub i_counted: Input<bool>,
    /// it is a scan's last
    #[under("Counts")]
    pub i_last: Input<bool>,
    /// phase step of a scan's peak, from the scan's first on
    #[under("Peak")]
    #[width(peak_step_bits)]
    pub i_peak_step: Input<Word>,
    /// its count, signed
    #[under("Peak")]
    #[width(plan.count_bits)]
    pub i_peak_count: Input<Word>,
    /// they have just changed
    #[under("Peak")]
    pub i_peak_valid: Input<bool>,
    /// phase step of the target's peak, and 8 bits of its fraction
    #[under("Target")]
    #[width(plan.position_bits())]
    pub o_position: Output<Word>,
    /// the last window had its light
    #[under("Target")]
    pub o_locked: Output<bool>,
    /// it has just been lost
    #[under("Target")]
    pub o_lost: Output<bool>,
    /// phase steps of a window
    #[width(scan_word_bits)]
    #[value(u128::from(plan.window_steps()))]
    #[number]
    window_steps: Constant,
    /// phase steps of the code period
    #[width(moved_bits)]
    #[value(u128::from(plan.period_steps))]
    #[number]
    period: Constant,
    /// phase steps of half a window
    #[width(moved_bits)]
    #[value(u128::from(plan.half_steps()))]
    #[number]
    half_window: Constant,
    /// half a phase step
    #[width(POSITION_BITS + 2)]
    #[value(1 << (POSITION_BITS - 1))]
    #[number]
    half_step: Constant,
    /// there is a target for the next scan to follow
    follows: Register<bool>,
    /// the present scan is a window
    window: Register<bool>,
    /// a target is followed, as the present scan's settings say
    on: Register<bool>,
    /// what follows of the present scan is still to come
    waits: Register<bool>,
    /// the scan that is to find a target has begun: peaks are its own
    began: Register<bool>,
    /// it has ended, with a peak
    found: Local<bool>,
    /// a setting passes by, one bit for each
    #[width(settings)]
    passes: Register<Word>,
    #[width(SHARE_BITS)]
    gain: Register<Word>,
    #[width(SHARE_BITS)]
    threshold: Register<Word>,
    #[width(PATIENCE_BITS)]
    patience: Register<Word>,
    /// first phase step of a scan
    #[width(step_bits)]
    first: Register<Word>,
    /// counts of the window so far
    #[width(sample_bits + 1)]
    place: Register<Word>,
    /// sum of the window's counts
    #[width(sum_bits)]
    all: Register<Word>,
    /// its later half less its earlier one
    #[width(sum_bits)]
    slope: Register<Word>,
    /// the sum that is expected
    #[width(sum_bits)]
    light: Register<Word>,
    /// stages of a decision, one bit for each
    #[width(stages)]
    stage: Register<Word>,
    /// halvings still to come
    #[width(SHARE_BITS)]
    halvings: Register<Word>,
    /// the least sum with the target's light
    #[width(sum_bits)]
    least: Register<Word>,
    /// the window has it
    lit: Register<bool>,
    /// the slope is negative
    negative: Register<bool>,
    /// what is left of the slope's size
    #[width(sum_bits + 1)]
    rest: Register<Word>,
    /// less the sum
    #[width(sum_bits + 2)]
    less: Local<Word>,
    #[width(offset_bits)]
    quotient: Register<Word>,
    /// from the position to the peak
    #[width(way_bits)]
    way: Register<Word>,
    /// the slope is as large as the sum
    is_most: Register<bool>,
    /// the quotient, or the most
    #[width(offset_bits)]
    size: Local<Word>,
    /// the same in the way's bits
    #[width(way_bits)]
    offset: Local<Word>,
    /// fraction of the position's step
    #[width(POSITION_BITS)]
    fraction: Register<Word>,
    /// the same with the way's, and what leaves it
    #[width(POSITION_BITS + 1)]
    added: Local<Word>,
    carry: Register<bool>,
    /// what the windows' middles owe to the positions, of one step
    #[width(POSITION_BITS)]
    owed: Register<Word>,
    /// steps from the position's to the first of the window's later half
    #[width(2)]
    ahead: Register<Word>,
    /// half a step behind the position, from its step on
    #[width(POSITION_BITS + 2)]
    half_fraction: Local<Word>,
    /// the same with what is owed
    #[width(POSITION_BITS + 2)]
    placed: Local<Word>,
    /// phase step of the position
    #[width(step_bits)]
    step: Register<Word>,
    /// the same on its way, and then a window's first
    #[width(moved_bits)]
    moved: Register<Word>,
    /// that less the code period
    #[width(moved_bits)]
    wrapped: Local<Word>,
    /// windows without light, one after another
    #[width(PATIENCE_BITS)]
    missed: Register<Word>,
    /// that was the last of them
    gives_up: Register<bool>,
    /// the sum less the light that was expected
    #[width(sum_bits + 1)]
    gained: Local<Word>,
    /// less than a sixteenth of it is left out; linters know by the name
    unused: Local<bool>,
    /// the position as it is told
    #[width(plan.position_bits())]
    position: Register<Word>,
    locked: Register<bool>,
    lost: Register<bool>,
}

#[kernel]
impl Logic for TargetTracker {
    fn update(&mut self) {
        self.pass_settings();
        self.sum_counts();
        self.run_stages();
        self.halve();
        self.weigh_light();
        self.divide();
        self.find_way();
        self.move_position();
        self.decide();
        self.tell();
    }

    /// Settings on their way from the registers to the sequencer.
    fn pass_settings(&mut self) {
        let own = self.settings - 1;
        self.passes.next = self.passes.val().shifted_in(self.i_taken_first.val());
        if self.i_taken_first.val() {
            self.window.next = self.follows.val();
        }
        if self.window.val() & self.passes.val().get_bit(1) {
            self.o_word.next = self.window_steps.val();
        } else if self.window.val() & self.passes.val().get_bit(2) {
            self.o_word.next = bit_cast(self.moved.val(), self.scan_word_bits);
        } else {
            self.o_word.next = bit_cast(self.i_word.val(), self.scan_word_bits);
        }
        if self.passes.val().get_bit(SCAN_WORDS - 1) {
            self.first.next = bit_cast(self.i_word.val(), self.step_bits);
        }
        if self.passes.val().get_bit(own) {
            self.on.next = self.i_word.val().get_bit(0);
            self.gain.next = self.i_word.val().slice(GAIN, SHARE_BITS as usize);
            self.threshold.next = self.i_word.val().slice(THRESHOLD, SHARE_BITS as usize);
            self.patience.next = self.i_word.val().slice(PATIENCE, PATIENCE_BITS as usize);
            self.waits.next = self.i_word.val().get_bit(0) | self.window.val();
        }
        if self.i_refused.val() {
            self.waits.next = false;
        }
        self.o_go.next = self.i_go.val() & !self.waits.val();
    }

    fn sum_counts(&mut self) {
        if self.i_counted.val() {
            self.place.next = self.place.val() + 1;
            self.all.next = self.all.val() + signed_cast(self.i_count.val());
            if self.place.val().get_bit(self.sample_bits) {
                self.slope.next = self.slope.val() + signed_cast(self.i_count.val());
            } else {
                self.slope.next = self.slope.val() - signed_cast(self.i_count.val());
            }
        }
        if self.i_taken_first.val() {
            self.place.next = 0.into();
            self.all.next = 0.into();
            self.slope.next = 0.into();
        }
    }

    /// A window's decision has all stages, a scan's those in which its peak's step comes within the code period.
    fn run_stages(&mut self) {
        self.began.next = self.i_run.val() | (self.began.val() & !self.i_taken_first.val());
        self.found.next =
            self.i_peak_valid.val() & self.began.val() & self.waits.val() & !self.window.val();
        self.stage.next =
            self.stage.val().shifted_in(self.i_last.val() & self.window.val()).replace_bit(
                self.halved + 3,
                self.stage.val().get_bit(self.halved + 2) | self.found.val(),
            );
    }

    /// Shares are taken by halves, that of the light and later that of the way.
    fn halve(&mut self) {
        if self.halvings.val().any() {
            self.halvings.next = self.halvings.val() - 1;
            self.least.next = self.least.val() >> 1;
            self.way.next =
                bit_cast(signed_cast(self.way.val().slice(1, self.way_bits - 1)), self.way_bits);
        }
        if self.stage.val().get_bit(0) {
            self.halvings.next = self.threshold.val();
            self.least.next = self.light.val();
        }
        if self.stage.val().get_bit(self.divided) {
            self.halvings.next = self.gain.val();
        }
    }

    /// Whether the sum of the counts is at least a share of what was expected; a sixteenth of what it has more is
    /// expected from now on.
    fn weigh_light(&mut self) {
        // The share is there, and the way's halves are still to come.
        if self.stage.val().get_bit(self.divided) {
            self.lit.next = self.all.val().any()
                & !self.all.val().get_bit(self.sum_bits - 1)
                & (self.all.val() >= self.least.val());
        }
        self.gained.next = bit_cast(signed_cast(self.all.val()), self.sum_bits + 1)
            - bit_cast(self.light.val(), self.sum_bits + 1);
        self.unused.next = self.gained.val().slice(0, LIGHT_HALVINGS as usize).any();
        if self.stage.val().get_bit(self.halved + 1) {
            if self.lit.val() {
                self.light.next = self.light.val()
                    + bit_cast(
                        signed_cast(self.gained.val().slice(
                            LIGHT_HALVINGS as usize,
                            self.sum_bits + 1 - LIGHT_HALVINGS as usize,
                        )),
                        self.sum_bits,
                    );
                self.missed.next = 0.into();
            } else {
                self.missed.next = self.missed.val() + 1;
            }
        }
        if self.found.val() {
            self.lit.next = self.i_peak_count.val().any()
                & !self.i_peak_count.val().get_bit(self.plan.count_bits as usize - 1);
            self.light.next = bit_cast(self.i_peak_count.val(), self.sum_bits) << self.sample_bits;
            self.missed.next = 0.into();
        }
    }

    /// The size of the slope over the sum, a bit in each clock; ones alone where it is as large as the sum, or larger.
    fn divide(&mut self) {
        self.less.next = (bit_cast(self.rest.val(), self.sum_bits + 2) << 1)
            - bit_cast(self.all.val(), self.sum_bits + 2);
        if self.less.val().get_bit(self.sum_bits + 1) {
            self.rest.next = self.rest.val() << 1;
            self.quotient.next = self.quotient.val() << 1;
        } else {
            self.rest.next = bit_cast(self.less.val(), self.sum_bits + 1);
            self.quotient.next = self.quotient.val().shifted_in(true);
        }
        if self.stage.val().get_bit(0) {
            self.negative.next = self.slope.val().get_bit(self.sum_bits - 1);
            if self.slope.val().get_bit(self.sum_bits - 1) {
                self.rest.next = bit_cast(!self.slope.val(), self.sum_bits + 1) + 1;
            } else {
                self.rest.next = bit_cast(self.slope.val(), self.sum_bits + 1);
            }
        }
        if self.stage.val().get_bit(1) {
            self.is_most.next = self.rest.val() >= bit_cast(self.all.val(), self.sum_bits + 1);
        }
    }

    /// From the position to the peak: to the window's middle, and from there by the offset.
    fn find_way(&mut self) {
        if self.is_most.val() {
            self.size.next = bit_cast(signed_cast(true), self.offset_bits);
        } else {
            self.size.next = self.quotient.val();
        }
        self.offset.next = bit_cast(self.size.val(), self.way_bits) << (HIDDEN_BITS as usize);
        self.half_fraction.next =
            bit_cast(self.fraction.val(), POSITION_BITS + 2) + self.half_step.val();
        if self.stage.val().get_bit(self.divided - 1) {
            self.way.next = (bit_cast(self.ahead.val(), self.way_bits) << POSITION_BITS)
                - bit_cast(self.half_fraction.val(), self.way_bits);
        }
        if self.stage.val().get_bit(self.divided) {
            if self.negative.val() {
                self.way.next = self.way.val() - self.offset.val();
            } else {
                self.way.next = self.way.val() + self.offset.val();
            }
        }
    }

    /// The position moves, its fraction first, and comes back into the code period; then the next window's first step.
    fn move_position(&mut self) {
        self.added.next = bit_cast(self.fraction.val(), POSITION_BITS + 1)
            + bit_cast(self.way.val().slice(0, POSITION_BITS), POSITION_BITS + 1);
        if self.stage.val().get_bit(self.halved + 1) & self.lit.val() {
            self.fraction.next = bit_cast(self.added.val(), POSITION_BITS);
            self.carry.next = self.added.val().get_bit(POSITION_BITS);
        }
        self.wrapped.next = self.moved.val() - self.period.val();
        if self.stage.val().get_bit(self.halved + 3)
            | self.stage.val().get_bit(self.halved + 4)
            | self.stage.val().get_bit(self.halved + 6)
        {
            if self.moved.val().get_bit(self.moved_bits - 1) {
                self.moved.next = self.moved.val() + self.period.val();
            } else if !self.wrapped.val().get_bit(self.moved_bits - 1) {
                self.moved.next = self.wrapped.val();
            }
        }
        if self.stage.val().get_bit(self.halved + 2) {
            if self.lit.val() {
                self.moved.next = bit_cast(self.step.val(), self.moved_bits)
                    + bit_cast(
                        signed_cast(
                            self.way.val().slice(POSITION_BITS, self.way_bits - POSITION_BITS),
                        ),
                        self.moved_bits,
                    )
                    + bit_cast(self.carry.val(), self.moved_bits);
            } else {
                self.moved.next = bit_cast(self.step.val(), self.moved_bits);
            }
        }
        if self.stage.val().get_bit(self.halved + 5) {
            self.step.next = bit_cast(self.moved.val(), self.step_bits);
            self.moved.next = self.moved.val() + bit_cast(self.ahead.val(), self.moved_bits)
                - self.half_window.val();
        }
        self.placed.next = self.half_fraction.val() + bit_cast(self.owed.val(), POSITION_BITS + 2);
        if self.stage.val().get_bit(self.halved + 4) {
            self.owed.next = bit_cast(self.placed.val(), POSITION_BITS);
            self.ahead.next = self.placed.val().slice(POSITION_BITS, 2);
        }
        if self.found.val() {
            self.fraction.next = 0.into();
            self.owed.next = 0.into();
            self.moved.next = bit_cast(self.first.val(), self.moved_bits)
                + bit_cast(self.i_peak_step.val(), self.moved_bits);
        }
    }

    /// Whether there is still a target, and with that the next scan may begin.
    fn decide(&mut self) {
        if self.stage.val().get_bit(self.halved + 2) {
            self.gives_up.next = !self.lit.val() & (self.missed.val() >= self.patience.val());
        }
        if self.found.val() {
            self.gives_up.next = false;
        }
        self.lost.next = false;
        if self.stage.val().get_bit(self.halved + 7) {
            self.waits.next = false;
            self.follows.next =
                self.on.val() & !self.gives_up.val() & (self.window.val() | self.lit.val());
            self.locked.next = self.on.val() & self.window.val() & self.lit.val();
            self.lost.next = self.on.val() & self.gives_up.val();
            if self.on.val() & !self.gives_up.val() & (self.window.val() | self.lit.val()) {
                self.position.next = gather(self.plan.position_bits() as usize, |bit| {
                    if bit < FRACTION_BITS as usize {
                        self.fraction.val().get_bit(bit + HIDDEN_BITS as usize)
                    } else {
                        self.step.val().get_bit(bit - FRACTION_BITS as usize)
                    }
                });
            }
        }
        if !self.i_go.val() {
            self.follows.next = false;
            self.locked.next = false;
        }
    }

    fn tell(&mut self) {
        self.o_position.next = self.position.val();
        self.o_locked.next = self.locked.val();
        self.o_lost.next = self.lost.val();
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rust_hdl_core::simulate::simulate;

    use super::*;
    use crate::reference::tracking::{Follower, Sums};
    use crate::rtl::front::tick;
    use crate::sensor::track::TrackSetting;

    const SETTINGS: usize = 5;
    const WORD_BITS: usize = 16;
    const SCAN_WORD_BITS: usize = 14;
    const PEAK_STEP_BITS: usize = 9;

    struct Bench {
        block: TargetTracker,
        lost: bool,
    }

    impl Bench {
        fn clock(&mut self) {
            assert!(simulate(&mut self.block, 50), "it settles");
            tick(&mut self.block, false);
            assert!(simulate(&mut self.block, 50), "it settles");
            self.lost |= self.block.o_lost.val();
        }

        /// Clocks until the next scan may begin, after one with `signal` high.
        fn clocks_to_go(&mut self) -> u32 {
            (0..200)
                .find(|_| {
                    let goes = self.block.o_go.val();
                    self.clock();
                    goes
                })
                .expect("it goes on")
        }

        /// Settings pass by, of which the sequencer gets these.
        fn pass(&mut self, words: [u64; SETTINGS]) -> Vec<u64> {
            self.block.i_taken_first.next = true;
            self.clock();
            self.block.i_taken_first.next = false;
            let mut passed = Vec::new();
            for word in words {
                self.block.i_word.next = Word::new(word.into(), WORD_BITS as u32);
                assert!(simulate(&mut self.block, 50), "it settles");
                passed.push(self.block.o_word.val().value() as u64);
                self.clock();
            }
            passed
        }
    }

    /// Scans and windows with counts of all kinds, and settings of all kinds: the settings that reach the sequencer, position
    /// and flags are those of the rule in whole numbers, after the clocks of the plan.
    #[test]
    fn the_block_follows_the_rule() {
        for (sample_bits, chips) in [(0, 31), (1, 31), (3, 31), (3, 20)] {
            let setting =
                TrackSetting { is_on: true, gain_halvings: 0, threshold_halvings: 0, patience: 0 };
            let period_steps = chips << sample_bits;
            let step_bits = 5 + sample_bits;
            let plan = TrackPlan { sample_bits, step_bits, period_steps, count_bits: 7, setting };
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(u64::from(sample_bits) + chips);
            let mut bench = Bench {
                block: TargetTracker::new(
                    plan,
                    SETTINGS,
                    WORD_BITS,
                    SCAN_WORD_BITS,
                    PEAK_STEP_BITS,
                ),
                lost: false,
            };
            tick(&mut bench.block, true);
            bench.block.i_go.next = true;
            let mut follower = Follower::new(plan, setting);
            let (mut windows, mut losses) = (0, 0);
            for _ in 0..400 {
                let word: u32 = rng.random_range(0..1 << TrackSetting::BITS) | 1;
                let first = rng.random_range(0..period_steps);
                let window = follower.window();
                let passed = bench.pass([77, 5, first, 13, word.into()]);
                let expected = match window {
                    Some(window) => [77, plan.window_steps(), window, 13, word.into()],
                    None => [77, 5, first, 13, word.into()],
                };
                assert_eq!(passed, expected);
                follower.setting = TrackSetting::of_word(word);
                assert!(!bench.block.o_go.val(), "what follows is waited for");
                bench.block.i_run.next = true;
                bench.clock();
                bench.block.i_run.next = false;
                bench.lost = false;
                let was = bench.block.o_position.val().value() as u64;
                if window.is_some() {
                    windows += 1;
                    let mean = rng.random_range(-10..40);
                    let slope = rng.random_range(-30..30);
                    let mut counts = Vec::new();
                    for step in 0..plan.window_steps() {
                        let late = step >= plan.window_steps() / 2;
                        let count = mean + if late { slope } else { -slope };
                        let count: i64 = (count + rng.random_range(-3..3)).clamp(-64, 63);
                        counts.push(count);
                        bench.block.i_count.next = Word::new(count as u128, 7);
                        bench.block.i_counted.next = true;
                        bench.block.i_last.next = step + 1 == plan.window_steps();
                        bench.clock();
                        bench.block.i_counted.next = false;
                        bench.block.i_last.next = false;
                        if step + 1 < plan.window_steps() {
                            bench.clock();
                        }
                    }
                    let is_lost = follower.counted(Sums::of(&counts, plan.half_steps()));
                    losses += u64::from(is_lost);
                    assert_eq!(bench.clocks_to_go(), plan.decision_clocks(), "{plan:?}");
                    assert_eq!(bench.lost, is_lost, "{counts:?}");
                } else {
                    let (step, count): (u64, i64) = (
                        rng.random_range(0..1 << PEAK_STEP_BITS).min(2 * period_steps - 1),
                        rng.random_range(-8..63),
                    );
                    bench.block.i_peak_step.next = Word::new(step.into(), PEAK_STEP_BITS as u32);
                    bench.block.i_peak_count.next = Word::new(count as u128, 7);
                    bench.block.i_peak_valid.next = true;
                    bench.clock();
                    bench.block.i_peak_valid.next = false;
                    follower.found((first + step) % period_steps, count);
                    assert_eq!(bench.clocks_to_go(), 5);
                    assert!(!bench.lost);
                }
                let position = follower.position().unwrap_or(was);
                assert_eq!(bench.block.o_position.val().value() as u64, position, "{plan:?}");
                assert_eq!(bench.block.o_locked.val(), follower.is_locked());
            }
            assert!(windows > 100 && losses > 10, "{windows} windows, {losses} losses");
        }
    }
}
