//! Scans as a host sets them: takes over the settings, aligns the reference, counts chips and steps.
//!
//! | port | |
//! |---|---|
//! | `i_go`, `i_changed` | scans are wanted; settings were written since they were last taken over |
//! | `o_takes`, `o_address`, `i_word` | settings are read from the registers |
//! | `o_refused`, `o_busy` | settings do not fit; a scan is under way, or prepared |
//! | `i_epoch`, `i_laser_epoch`, `o_on` | first chip of the transmitted code, in the generator and at the lasers; the generators run |
//! | `o_load`, `o_seed`, `o_delayed` | the reference waits; codes' seeds; lanes of the first delay |
//! | `o_run` ... `o_scan_counted` | as those of the scan controller whose scan is fixed |
//!
//! A host writes chips and steps, not states of a counter: both counters are binary, and begin so many
//! counts late as their ends have to be known ahead. The delay of a scan's first step costs no load of the
//! reference's generator: it waits at the code's first chip until the transmit generator is ahead by the
//! delay. The same counter, and the same comparison, serve for that and for the chips of a step.
//!
//! Cost (ECP5, docs/resources.md): what `hardware.registers` takes, with the registers themselves.

use super::{StateMatch, StepEnds};
use crate::rtl::front::prelude::*;
use crate::sensor::registers::{IDENTITY_WORDS, RegisterPlan, SCAN_WORDS};

/// Chips by which a step's end is looked for ahead: the comparison takes two clocks, the flag of the last
/// chip but one is a chip before the last.
pub(super) const CHIPS_EARLY: u64 = 4;

/// Says when a phase step, and when a scan, ends, as the settings say.
#[block(describe(&plan))]
pub struct ScanSequencer {
    plan: RegisterPlan,
    /// Clocks from a step's last one until its hits are in the total.
    clocks_to_dump: u32,
    /// Segments of the total.
    segments: u32,
    /// Clocks from the dump of the lowest segment to the whole count.
    clocks_to_count: u32,
    /// Whether `o_pre_counted` is there.
    counts_early: bool,
    #[set(plan.seeds.len())]
    seeds: usize,
    /// Seed and bit of each bit of all seeds.
    #[set(seed_places(&plan))]
    places: Vec<(usize, usize)>,
    #[set(plan.settings())]
    words: usize,
    #[set(plan.chips_bits as usize)]
    chips_bits: usize,
    #[set(plan.groups_bits as usize)]
    groups_bits: usize,
    #[set(plan.delay_bits as usize)]
    delay_bits: usize,
    #[set(plan.sample_bits as usize)]
    sample_bits: usize,
    /// Whether a delay of the code period is the one number of its bits that is none.
    #[set(plan.period_chips + 1 == 1 << delay_bits)]
    fills_bits: bool,
    /// Bits of the counter of chips: those of a step, or of the code period.
    #[set(chips_bits.max(delay_bits))]
    count_bits: usize,
    /// Lanes that a delay may reach, if a host sets it.
    #[set(plan.lanes() as usize)]
    lanes: usize,
    #[set(plan.least_chips.trailing_zeros() as usize)]
    least_bit: usize,
    /// scans are wanted
    #[under("Registers")]
    pub i_go: Input<bool>,
    /// settings were written since they were last taken over
    pub i_changed: Input<bool>,
    /// the setting that was read a clock ago
    #[width(plan.scan_setting_bits())]
    pub i_word: Input<Word>,
    /// settings are read
    pub o_takes: Output<bool>,
    /// the first of them is
    pub o_taken_first: Output<bool>,
    /// which word is
    #[width(plan.word_bits())]
    pub o_address: Output<Word>,
    /// they do not fit
    pub o_refused: Output<bool>,
    /// a scan is under way, or prepared
    pub o_busy: Output<bool>,
    /// the transmitted code is at its first chip
    #[under("Codes")]
    pub i_epoch: Input<bool>,
    /// the lasers show it in the next clock
    pub i_laser_epoch: Input<bool>,
    /// the transmit generators run
    pub o_on: Output<bool>,
    /// the references wait at their first chips
    pub o_load: Output<bool>,
    /// first chips of the codes' second registers{if plan.sets_taps() { " and their taps" } else { "" }}, side by side
    #[when(seeds > 0)]
    #[width(plan.seed_bits())]
    pub o_seed: Optional<Output<Word>>,
    /// lanes that take the previous chip in a scan's first step
    #[when(lanes > 0)]
    #[width(lanes)]
    pub o_delayed: Optional<Output<Word>>,
    /// the present chip belongs to a scan
    #[under("Scan")]
    pub o_run: Output<bool>,
    /// it is the last but one of a phase step
    pub o_pre_last_chip: Output<bool>,
    /// it is the last of a phase step
    pub o_last_chip: Output<bool>,
    /// at a step's second chip
    #[width(count_bits)]
    #[value(u128::from(CHIPS_EARLY + 1))]
    #[number]
    chip_count_second: Constant,
    /// word of the first setting
    #[width(plan.word_bits())]
    #[value(IDENTITY_WORDS as u128)]
    #[number]
    first_address: Constant,
    /// chips of the code period
    #[when(!fills_bits)]
    #[width(delay_bits + 1)]
    #[value(u128::from(plan.period_chips))]
    #[number]
    period: Optional<Constant>,
    /// groups of a scan over the whole code period
    #[when(plan.whole_groups.is_some())]
    #[width(groups_bits)]
    #[value(u128::from(plan.whole_groups.unwrap_or(0)))]
    #[number]
    whole_scan: Optional<Constant>,
    /// chips of a phase step
    #[width(chips_bits)]
    chips: Register<Word>,
    /// groups of phase steps of a scan
    #[width(groups_bits)]
    groups: Register<Word>,
    /// whole chips of the first delay
    #[width(delay_bits)]
    delay: Register<Word>,
    /// lanes of the first delay
    #[when(lanes > 0)]
    #[width(lanes)]
    delayed: Optional<Register<Word>>,
    #[each(seed in 0..seeds)]
    #[about(super::first_of(seed, "seeds of the codes"))]
    #[width(plan.seeds[seed].bits)]
    seed: Vec<Register<Word>>,
    /// settings are read, a bit for each; then checked; then acted on
    #[width(words + 3)]
    take: Register<Word>,
    /// a take-over is under way
    taking: Register<bool>,
    /// settings are read
    takes: Register<bool>,
    /// word of the setting that is read
    #[width(plan.word_bits())]
    address: Register<Word>,
    /// settings are to be read
    asks: Local<bool>,
    /// chips, groups and delay fit
    #[width(3)]
    fits: Register<Word>,
    /// the scan is over the whole code period
    #[when(plan.whole_groups.is_some())]
    is_whole: Optional<Register<bool>>,
    /// the transmit generators run
    on: Register<bool>,
    /// the references wait
    #[reset(true)]
    load: Register<bool>,
    /// chips are counted from the transmitted code's first
    indexed: Register<bool>,
    /// code periods of a scan's preparation that have begun
    #[width(2)]
    prepared: Register<Word>,
    run: Register<bool>,
    /// a scan ran one and two clocks ago: chips are those of a step
    #[width(2)]
    ran: Register<Word>,
    /// chips of a step; before a scan those of the transmitted code
    #[width(count_bits)]
    chip_count: Register<Word>,
    /// the present chip is a step's first
    first_chip: Register<bool>,
    /// groups of the scan, the present one included
    #[width(groups_bits)]
    step_count: Register<Word>,
    pre_last_chip: Register<bool>,
    last_chip: Register<bool>,
    /// the present chip is the scan's last
    scan_last_chip: Register<bool>,
    #[shown]
    #[is(StepEnds::new("Scan", clocks_to_dump, segments, clocks_to_count, counts_early))]
    ends: StepEnds,
    #[is(StateMatch::new(chips_bits))]
    chip_count_match: StateMatch,
    #[is(StateMatch::new(delay_bits))]
    delay_match: StateMatch,
    #[is(StateMatch::new(groups_bits))]
    step_count_match: StateMatch,
    /// the delay is less than the code period
    is_within: Local<bool>,
    /// a scan begins with the next clock
    starts: Local<bool>,
    /// the next scan begins where this one ends
    goes_on: Local<bool>,
    #[when(lanes > 0)]
    #[width(sample_bits)]
    samples: Optional<Local<Word>>,
    #[when(lanes > 0)]
    #[width(lanes)]
    first_delayed: Optional<Local<Word>>,
}

fn seed_places(plan: &RegisterPlan) -> Vec<(usize, usize)> {
    let seeds = plan.seeds.iter().enumerate();
    seeds.flat_map(|(number, seed)| (0..seed.bits as usize).map(move |bit| (number, bit))).collect()
}

fn describe(plan: &RegisterPlan) -> About {
    About::new("scan_sequencer", "takes over a host's settings, and counts chips and phase steps as they say")
        .note(
            "Settings are read one a clock while no scan is under way, so that they are steady within \
             each. Then the codes begin, the reference's generator waits at its first chip until the \
             transmit generator is ahead by the first step's delay, and the scan begins two code periods \
             later. After one over the whole code period the next follows at once, unless settings were written.",
        )
        .note(
            "The counters are binary, since a host writes numbers. A step's count is 5 at its second chip and ends at \
             the chips as they were written: so its end is known in time.",
        )
        .fact("Chips", format!("{} to {} a step", plan.least_chips, (1u64 << plan.chips_bits) - 1))
        .fact("Groups", format!("1 to {}", (1u64 << plan.groups_bits) - 1))
        .fact("First step", format!("less than {}", plan.period_chips << plan.sample_bits))
}

#[kernel]
impl Logic for ScanSequencer {
    fn update(&mut self) {
        self.take_over();
        self.prepare();
        self.count_chips();
        self.count_steps();
        self.end_scans();
        self.ends.step_ends.next = self.last_chip.val();
        self.ends.scan_ends.next = self.scan_last_chip.val();
        self.ends.report();
    }

    /// Reads the settings, and sees whether they fit.
    fn take_over(&mut self) {
        let words = self.words;
        self.asks.next = self.i_go.val() & !self.on.q.val() & !self.taking.q.val();
        self.taking.d.next =
            self.asks.val() | (self.taking.q.val() & !self.take.q.val().get_bit(words + 2));
        self.take.d.next = (self.take.q.val() << 1).replace_bit(0, self.asks.val());
        self.takes.d.next =
            self.asks.val() | (self.takes.q.val() & !self.take.q.val().get_bit(words - 1));
        if self.takes.q.val() {
            self.address.d.next = self.address.q.val() + 1;
        } else {
            self.address.d.next = self.first_address.val();
        }
        self.o_takes.next = self.takes.q.val();
        self.o_taken_first.next = self.take.q.val().get_bit(0);
        self.o_address.next = self.address.q.val();
        if self.take.q.val().get_bit(1) {
            self.chips.d.next = bit_cast(self.i_word.val(), self.chips_bits);
        }
        if self.take.q.val().get_bit(2) {
            self.groups.d.next = bit_cast(self.i_word.val(), self.groups_bits);
        }
        if self.take.q.val().get_bit(3) {
            self.delay.d.next = self.i_word.val().slice(self.sample_bits, self.delay_bits);
        }
        if self.delayed.is_present() {
            self.choose_lanes();
        }
        for s in 0..self.seed.len() {
            if self.take.q.val().get_bit(SCAN_WORDS + 1 + s) {
                self.seed[s].d.next = bit_cast(self.i_word.val(), self.plan.seeds[s].bits as usize);
            }
        }
        if self.o_seed.is_present() {
            self.gather_seeds();
        }
        if self.fills_bits {
            self.is_within.next = !self.delay.q.val().all();
        } else {
            self.is_within.next =
                bit_cast(self.delay.q.val(), self.delay_bits + 1) < self.period.val();
        }
        self.fits.d.next = gather(3, |which| {
            if which == 0 {
                self.chips.q.val().slice(self.least_bit, self.chips_bits - self.least_bit).any()
            } else if which == 1 {
                self.groups.q.val().any()
            } else {
                self.is_within.val()
            }
        });
        if self.is_whole.is_present() {
            self.is_whole.d.next = self.groups.q.val() == self.whole_scan.val();
        }
        self.o_refused.next = self.take.q.val().get_bit(words + 2) & !self.fits.q.val().all();
        self.o_busy.next = self.on.q.val() | self.taking.q.val();
        if self.take.q.val().get_bit(words + 2) & self.fits.q.val().all() {
            self.on.d.next = true;
        }
    }

    fn gather_seeds(&mut self) {
        self.o_seed.next = gather(self.places.len(), |bit| {
            self.seed[self.places[bit].0].q.val().get_bit(self.places[bit].1)
        });
    }

    /// A thermometer of the delay's samples.
    fn choose_lanes(&mut self) {
        self.samples.next = bit_cast(self.i_word.val(), self.sample_bits);
        self.first_delayed.next = gather(self.lanes, |lane| self.samples.val() > lane);
        if self.take.q.val().get_bit(3) {
            self.delayed.d.next = self.first_delayed.val();
        }
        self.o_delayed.next = self.delayed.q.val();
    }

    /// Holds the reference until the transmitter is ahead by the delay.
    fn prepare(&mut self) {
        self.o_on.next = self.on.q.val();
        self.o_load.next = self.load.q.val();
        self.starts.next = self.i_laser_epoch.val() & self.prepared.q.val().get_bit(1);
        self.indexed.d.next =
            self.on.q.val() & !self.run.q.val() & (self.i_epoch.val() | self.indexed.q.val());
        if self.indexed.q.val() & self.i_laser_epoch.val() {
            self.prepared.d.next = (self.prepared.q.val() << 1) | bit_cast(true, 2);
        }
        if self.prepared.q.val().get_bit(0) & self.delay_match.o_matched.val() {
            self.load.d.next = false;
        }
        if self.starts.val() {
            self.prepared.d.next = 0.into();
            self.run.d.next = true;
        }
    }

    fn count_chips(&mut self) {
        self.chip_count_match.i_state.next = self.chip_count.q.val().slice(0, self.chips_bits);
        self.chip_count_match.i_wanted.next = self.chips.q.val();
        self.delay_match.i_state.next = self.chip_count.q.val().slice(0, self.delay_bits);
        self.delay_match.i_wanted.next = self.delay.q.val();
        self.ran.d.next = (self.ran.q.val() << 1).replace_bit(0, self.run.q.val());
        self.pre_last_chip.d.next =
            self.run.q.val() & self.ran.q.val().get_bit(1) & self.chip_count_match.o_matched.val();
        self.last_chip.d.next = self.pre_last_chip.q.val();
        self.first_chip.d.next = self.starts.val() | self.last_chip.q.val();
        self.chip_count.d.next = self.chip_count.q.val() + 1;
        if self.i_epoch.val() & !self.run.q.val() {
            self.chip_count.d.next = 0.into();
        } else if self.first_chip.q.val() {
            self.chip_count.d.next = self.chip_count_second.val();
        }
        self.o_run.next = self.run.q.val();
        self.o_pre_last_chip.next = self.pre_last_chip.q.val();
        self.o_last_chip.next = self.last_chip.q.val();
    }

    fn count_steps(&mut self) {
        self.step_count_match.i_state.next = self.step_count.q.val();
        self.step_count_match.i_wanted.next = self.groups.q.val();
        self.scan_last_chip.d.next =
            self.pre_last_chip.q.val() & self.step_count_match.o_matched.val();
        if !self.run.q.val() | self.scan_last_chip.q.val() {
            self.step_count.d.next = bit_cast(true, self.groups_bits);
        } else if self.last_chip.q.val() {
            self.step_count.d.next = self.step_count.q.val() + 1;
        }
    }

    /// What comes after a scan.
    fn end_scans(&mut self) {
        if self.is_whole.is_present() {
            self.goes_on.next = self.i_go.val() & !self.i_changed.val() & self.is_whole.q.val();
        } else {
            self.goes_on.next = false;
        }
        if self.scan_last_chip.q.val() {
            self.run.d.next = self.goes_on.val();
            self.load.d.next = !self.goes_on.val();
            self.on.d.next = self.i_go.val() & !self.i_changed.val();
        }
    }
}
