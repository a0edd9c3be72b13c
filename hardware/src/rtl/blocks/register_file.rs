//! The registers, as an AXI4-Lite slave.
//!
//! | port | |
//! |---|---|
//! | [`RegisterPorts`] | the slave (ARM IHI 0022, chapter B1): write, response, read |
//! | `i_takes`, `i_address`, `o_word` | the sequencer reads settings |
//! | `o_go`, `o_changed` | scans are wanted; settings were written |
//! | `i_refused`, `i_busy`, `i_scan_counted`, `i_lost`, `i_clamps` | what the registers tell |
//! | `i_peak_step`, `i_peak_count` | the last peak |
//!
//! A write takes place when address and data are both there; address and data are taken in the clock after
//! that, and answered in the next. A read waits while the sequencer reads settings. Identification and
//! settings are in a memory of lookup tables: there they cost neither flip-flops nor a multiplexer, and the
//! bus reads back what the sequencer takes over.
//!
//! Cost (ECP5, docs/resources.md): what `hardware.registers` takes, with the sequencer.

use std::ops::{Deref, DerefMut};

use crate::rtl::front::prelude::*;
use crate::sensor::registers::{
    ADDRESS_BITS, IDENTITY_WORDS, LOST_BITS, RegisterPlan, SCANS_BITS, state,
};

/// Bit of an address that is high for state and peaks.
const STATE_BIT: usize = 10;
/// Bit that is high among those for peaks.
const PEAK_BIT: usize = 8;

/// An AXI4-Lite slave of 32 bits.
#[block]
pub struct RegisterPorts {
    /// address that is written to, of a byte
    #[under("Registers, AXI4-Lite")]
    #[width(ADDRESS_BITS)]
    pub s_axil_awaddr: Input<Word>,
    pub s_axil_awvalid: Input<bool>,
    pub s_axil_awready: Output<bool>,
    /// word that is written
    #[width(32)]
    pub s_axil_wdata: Input<Word>,
    /// its bytes: all of them, or the write is an error
    #[width(4)]
    pub s_axil_wstrb: Input<Word>,
    pub s_axil_wvalid: Input<bool>,
    pub s_axil_wready: Output<bool>,
    /// 0, or 2 where nothing was written
    #[width(2)]
    pub s_axil_bresp: Output<Word>,
    pub s_axil_bvalid: Output<bool>,
    pub s_axil_bready: Input<bool>,
    /// address that is read, of a byte
    #[width(ADDRESS_BITS)]
    pub s_axil_araddr: Input<Word>,
    pub s_axil_arvalid: Input<bool>,
    pub s_axil_arready: Output<bool>,
    /// word that was read
    #[width(32)]
    pub s_axil_rdata: Output<Word>,
    /// 0, or 2 where there is no register
    #[width(2)]
    pub s_axil_rresp: Output<Word>,
    pub s_axil_rvalid: Output<bool>,
    pub s_axil_rready: Input<bool>,
}

/// Registers behind an AXI4-Lite slave.
#[block(describe(&plan))]
pub struct RegisterFile {
    plan: RegisterPlan,
    initial: Vec<u32>,
    /// Whether counts can be clamped.
    saturates: bool,
    /// Bits of a peak's step, and of its count.
    peak_bits: (u32, u32),
    #[set(plan.word_bits() as usize)]
    word_bits: usize,
    #[set((0..1 << plan.word_bits()).map(|word| (IDENTITY_WORDS..plan.words()).contains(&word).into()).collect())]
    which_are_settings: Vec<u8>,
    #[set(plan.peaks as usize)]
    peaks: usize,
    #[set(peaks > 0)]
    has_peaks: bool,
    /// Whether a target is followed.
    #[set(plan.track.is_some())]
    tracks: bool,
    /// Words with a peak, and where the target is.
    #[set(plan.readings() as usize)]
    peak_words: usize,
    /// Bits of the number of such a word.
    #[set(if has_peaks { peak_words.next_power_of_two().trailing_zeros() as usize } else { 0 })]
    peak_words_bits: usize,
    /// Places of the flags that there are in the status register.
    #[set(flags(saturates, tracks))]
    flag_places: Vec<u32>,
    /// ports
    #[is(RegisterPorts::new())]
    pub io: RegisterPorts,
    /// settings are read
    pub i_takes: Input<bool>,
    /// the first of them is
    pub i_taken_first: Input<bool>,
    /// which word is
    #[width(word_bits)]
    pub i_address: Input<Word>,
    /// the setting that was read a clock ago
    #[width(plan.setting_bits())]
    pub o_word: Output<Word>,
    /// scans are wanted
    pub o_go: Output<bool>,
    /// settings were written, or a single scan asked for
    pub o_changed: Output<bool>,
    /// settings do not fit
    pub i_refused: Input<bool>,
    /// a scan is under way, or prepared
    pub i_busy: Input<bool>,
    /// the count of a scan's last step is there
    pub i_scan_counted: Input<bool>,
    /// a group of results was lost
    pub i_lost: Input<bool>,
    /// a count was clamped
    #[when(saturates)]
    pub i_clamps: Optional<Input<bool>>,
    /// phase step of the last scan's peak, from the scan's first
    #[when(has_peaks)]
    #[width(plan.peaks * peak_bits.0)]
    pub i_peak_step: Optional<Input<Word>>,
    /// its count, signed
    #[when(has_peaks)]
    #[width(plan.peaks * peak_bits.1)]
    pub i_peak_count: Optional<Input<Word>>,
    /// phase step of the target's peak, and 8 bits of fraction
    #[when(tracks)]
    #[width(plan.track.map_or(1, |track| track.position_bits()))]
    pub i_position: Optional<Input<Word>>,
    /// the last window had its light
    #[when(tracks)]
    pub i_locked: Optional<Input<bool>>,
    /// it has just been lost
    #[when(tracks)]
    pub i_target_lost: Optional<Input<bool>>,
    #[is(RegisterMemory::new(&initial, plan.word_bits(), "identification and settings"))]
    memory: RegisterMemory,
    #[is(BitTable::new(which_are_settings.clone(), plan.word_bits(), "Words that a host may write"))]
    settable: BitTable,
    /// a write takes place
    write: Register<bool>,
    /// it is to a setting
    to_setting: Register<bool>,
    /// it is to the control register, or to the flags
    to_state: Register<bool>,
    /// it is of all bytes
    of_all_bytes: Register<bool>,
    /// a write is answered
    answers: Register<bool>,
    /// nothing was written
    write_error: Register<bool>,
    /// a word is to be read, once the settings are left alone
    read: Register<bool>,
    /// it has been
    fetched: Register<bool>,
    /// the address read is a word's, but for the state's bit
    by_word: Register<bool>,
    /// it has the state's bit
    by_state: Register<bool>,
    /// it is the first's or the second's of the state, or of the memory
    by_first_two: Register<bool>,
    /// it is a peak's
    #[when(has_peaks)]
    by_peak: Optional<Register<bool>>,
    /// what is read is a word in the memory
    of_word: Register<bool>,
    /// it is the control register, or the flags
    of_state: Register<bool>,
    /// it is any register
    of_register: Register<bool>,
    /// the word that was read in the memory
    #[width(32)]
    word: Register<Word>,
    /// what was read is there
    valid: Register<bool>,
    /// there is no register
    read_error: Register<bool>,
    /// the word that was read
    #[width(32)]
    data: Register<Word>,
    /// scans follow one another
    #[reset(true)]
    runs: Register<bool>,
    /// one scan is asked for
    single: Register<bool>,
    changed: Register<bool>,
    /// what a host has not cleared yet, in the status register's order
    #[width(flag_places.len())]
    flags: Register<Word>,
    /// flags that the host clears
    #[width(flag_places.len())]
    cleared: Local<Word>,
    /// flags that are raised, which wins
    #[width(flag_places.len())]
    raised: Local<Word>,
    /// groups of results that were lost
    #[width(LOST_BITS)]
    lost: Register<Word>,
    /// scans that have ended
    #[width(SCANS_BITS)]
    scans: Register<Word>,
    /// what the control and status registers read as
    #[width(32)]
    state: Local<Word>,
    /// the word of a peak that is read
    #[when(has_peaks)]
    #[width(32)]
    peak: Optional<Local<Word>>,
    /// number of that word
    #[when(has_peaks)]
    #[width(peak_words_bits)]
    peak_word: Optional<Local<Word>>,
    /// a whole word is written
    writes: Local<bool>,
    /// linters know by the name
    unused: Local<bool>,
}

/// Places in the status register of the flags of such hardware.
fn flags(saturates: bool, tracks: bool) -> Vec<u32> {
    let all = [
        (state::OVERRUN, true),
        (state::SATURATED, saturates),
        (state::REFUSED, true),
        (state::LOCK_LOST, tracks),
    ];
    all.into_iter().filter(|(_, is_there)| *is_there).map(|(place, _)| place).collect()
}

fn describe(plan: &RegisterPlan) -> About {
    About::new("register_file", "identification, settings, control and state, as an AXI4-Lite slave")
        .note(
            "A write is taken when its address and its data are both there. An address without a \
             register, a register that is only read, and a write of some bytes of a word are answered \
             with SLVERR, and change nothing. The memory keeps the settings in reset.",
        )
        .note(
            "After reset scans follow one another, with the scene's settings until a host writes others.",
        )
        .fact("Words", format!("{} in the memory, of which {} are settings", plan.words(), plan.settings()))
        .fact("Latency", "2 clocks from a write to its answer, 3 from a read, and more during a take-over")
}

impl Deref for RegisterFile {
    type Target = RegisterPorts;
    fn deref(&self) -> &RegisterPorts {
        &self.io
    }
}

impl DerefMut for RegisterFile {
    fn deref_mut(&mut self) -> &mut RegisterPorts {
        &mut self.io
    }
}

#[kernel]
impl Logic for RegisterFile {
    fn update(&mut self) {
        self.unused.next = self.io.s_axil_awaddr.val().slice(0, 2).any()
            | self.io.s_axil_araddr.val().slice(0, 2).any();
        self.find_registers();
        self.gather_state();
        if self.has_peaks {
            self.choose_peak();
        }
        self.write_words();
        self.read_words();
        self.control();
        self.tell();
    }

    /// What the addresses are of: of a write in one clock, of a read, which waits for the memory, in two.
    fn find_registers(&mut self) {
        let above_words = ADDRESS_BITS as usize - 2 - self.word_bits;
        let above_state = PEAK_BIT - 3;
        // Two comparisons would be shorter, but their proof takes many times as long.
        self.settable.address.next = self.io.s_axil_awaddr.val().slice(2, self.word_bits);
        self.to_setting.d.next =
            !self.io.s_axil_awaddr.val().slice(2 + self.word_bits, above_words).any()
                & self.settable.data.val();
        self.to_state.d.next = !self.io.s_axil_awaddr.val().get_bit(STATE_BIT + 1)
            & self.io.s_axil_awaddr.val().get_bit(STATE_BIT)
            & !self.io.s_axil_awaddr.val().slice(PEAK_BIT, 2).any()
            & !self.io.s_axil_awaddr.val().slice(3, above_state).any();
        let above_words = STATE_BIT - 2 - self.word_bits;
        self.by_word.d.next = !self.io.s_axil_araddr.val().get_bit(STATE_BIT + 1)
            & !self.io.s_axil_araddr.val().slice(2 + self.word_bits, above_words).any();
        self.by_state.d.next = self.io.s_axil_araddr.val().get_bit(STATE_BIT);
        self.by_first_two.d.next = !self.io.s_axil_araddr.val().slice(3, self.word_bits - 1).any();
        self.of_word.d.next = self.by_word.q.val() & !self.by_state.q.val();
        self.of_state.d.next =
            self.by_word.q.val() & self.by_state.q.val() & self.by_first_two.q.val();
        if self.has_peaks {
            self.by_peak.d.next = !self.io.s_axil_araddr.val().get_bit(STATE_BIT + 1)
                & self.io.s_axil_araddr.val().get_bit(STATE_BIT)
                & !self.io.s_axil_araddr.val().get_bit(STATE_BIT - 1)
                & self.io.s_axil_araddr.val().get_bit(PEAK_BIT)
                & (self.io.s_axil_araddr.val().slice(2, PEAK_BIT - 2) < self.peak_words);
            self.of_register.d.next = (self.by_word.q.val()
                & (!self.by_state.q.val() | self.by_first_two.q.val()))
                | self.by_peak.q.val();
        } else {
            self.of_register.d.next =
                self.by_word.q.val() & (!self.by_state.q.val() | self.by_first_two.q.val());
        }
    }

    fn write_words(&mut self) {
        self.write.d.next = self.io.s_axil_awvalid.val()
            & self.io.s_axil_wvalid.val()
            & !self.write.q.val()
            & !self.answers.q.val();
        self.of_all_bytes.d.next = self.io.s_axil_wstrb.val().all();
        self.writes.next = self.write.q.val() & self.of_all_bytes.q.val();
        self.io.s_axil_awready.next = self.write.q.val();
        self.io.s_axil_wready.next = self.write.q.val();
        self.answers.d.next =
            self.write.q.val() | (self.answers.q.val() & !self.io.s_axil_bready.val());
        if self.write.q.val() {
            self.write_error.d.next =
                !(self.of_all_bytes.q.val() & (self.to_setting.q.val() | self.to_state.q.val()));
        }
        self.io.s_axil_bvalid.next = self.answers.q.val();
        self.io.s_axil_bresp.next = bit_cast(self.write_error.q.val(), 2) << 1;
        self.memory.i_write.next = self.writes.val() & self.to_setting.q.val();
        self.memory.i_write_address.next = self.io.s_axil_awaddr.val().slice(2, self.word_bits);
        self.memory.i_data.next = self.io.s_axil_wdata.val();
    }

    /// The memory is the sequencer's first. Its words come out of a register, so that neither the choice of an
    /// address nor that of a word is added to the memory's own time.
    fn read_words(&mut self) {
        if self.i_takes.val() {
            self.memory.i_address.next = self.i_address.val();
        } else {
            self.memory.i_address.next = self.io.s_axil_araddr.val().slice(2, self.word_bits);
        }
        self.word.d.next = self.memory.o_word.val();
        self.o_word.next = bit_cast(self.word.q.val(), self.plan.setting_bits() as usize);
        self.read.d.next = (self.io.s_axil_arvalid.val()
            & !self.read.q.val()
            & !self.fetched.q.val()
            & !self.valid.q.val())
            | (self.read.q.val() & self.i_takes.val());
        self.fetched.d.next = self.read.q.val() & !self.i_takes.val();
        self.valid.d.next =
            self.fetched.q.val() | (self.valid.q.val() & !self.io.s_axil_rready.val());
        if self.fetched.q.val() {
            self.read_error.d.next = !self.of_register.q.val();
            if self.of_word.q.val() {
                self.data.d.next = self.word.q.val();
            } else if self.of_state.q.val() {
                self.data.d.next = self.state.val();
            } else if self.has_peaks {
                self.data.d.next = self.peak.val() & signed_cast(self.of_register.q.val());
            } else {
                self.data.d.next = bit_cast(false, 32);
            }
        }
        self.io.s_axil_arready.next = self.fetched.q.val();
        self.io.s_axil_rvalid.next = self.valid.q.val();
        self.io.s_axil_rdata.next = self.data.q.val();
        self.io.s_axil_rresp.next = bit_cast(self.read_error.q.val(), 2) << 1;
    }

    /// Of two things at once the host's write counts, and of an event and the write that clears its flag the event.
    fn control(&mut self) {
        if self.i_refused.val() {
            self.runs.d.next = false;
            self.single.d.next = false;
        }
        if self.i_taken_first.val() {
            self.single.d.next = false;
            self.changed.d.next = false;
        }
        if self.writes.val() & self.to_setting.q.val() {
            self.changed.d.next = true;
        }
        if self.writes.val() & self.to_state.q.val() & !self.io.s_axil_awaddr.val().get_bit(2) {
            self.runs.d.next = self.io.s_axil_wdata.val().get_bit(state::RUN as usize);
            self.single.d.next = self.io.s_axil_wdata.val().get_bit(state::SINGLE as usize);
            if self.io.s_axil_wdata.val().get_bit(state::SINGLE as usize) {
                self.changed.d.next = true;
            }
        }
        self.o_go.next = self.runs.q.val() | self.single.q.val();
        self.o_changed.next = self.changed.q.val();
    }

    fn tell(&mut self) {
        self.cleared.next = gather(self.flag_places.len(), |flag| {
            self.io.s_axil_wdata.val().get_bit(self.flag_places[flag] as usize)
        }) & signed_cast(
            self.writes.val() & self.to_state.q.val() & self.io.s_axil_awaddr.val().get_bit(2),
        );
        self.raised.next = gather(self.flag_places.len(), |flag| {
            if self.flag_places[flag] == state::OVERRUN {
                self.i_lost.val()
            } else if self.flag_places[flag] == state::SATURATED {
                self.i_clamps.val()
            } else if self.flag_places[flag] == state::REFUSED {
                self.i_refused.val()
            } else {
                self.i_target_lost.val()
            }
        });
        self.flags.d.next = (self.flags.q.val() & !self.cleared.val()) | self.raised.val();
        if self.i_lost.val() {
            self.lost.d.next = self.lost.q.val() + 1;
        }
        if self.i_scan_counted.val() {
            self.scans.d.next = self.scans.q.val() + 1;
        }
    }

    fn gather_state(&mut self) {
        self.state.next = gather(32, |place| {
            if place == state::RUN as usize {
                self.runs.q.val()
            } else if place == state::SINGLE as usize {
                self.single.q.val()
            } else if place == state::BUSY as usize {
                self.i_busy.val()
            } else if self.tracks && place == state::LOCKED as usize {
                self.i_locked.val()
            } else if self.flag_places.contains(&(place as u32)) {
                self.flags
                    .q
                    .val()
                    .get_bit(self.flag_places.partition_point(|&flag| (flag as usize) < place))
            } else if place < state::LOST as usize {
                false
            } else if place < state::SCANS as usize {
                self.lost.q.val().get_bit(place - state::LOST as usize)
            } else {
                self.scans.q.val().get_bit(place - state::SCANS as usize)
            }
        });
    }

    /// Step and count of each detector, one after another.
    fn choose_peak(&mut self) {
        let bits = self.peak_words_bits;
        let step_bits = self.peak_bits.0 as usize;
        let count_bits = self.peak_bits.1 as usize;
        self.peak_word.next = self.io.s_axil_araddr.val().slice(2, bits);
        self.peak.next = bit_cast(self.i_peak_step.val().slice(0, step_bits), 32)
            & signed_cast(!self.peak_word.val().any());
        for word in 1..self.peak_words {
            if word == 2 * self.peaks {
                self.peak.next = self.peak.val()
                    | (bit_cast(self.i_position.val(), 32)
                        & signed_cast(self.peak_word.val() == word));
            } else if word % 2 == 0 {
                self.peak.next = self.peak.val()
                    | (bit_cast(
                        self.i_peak_step.val().slice(step_bits * (word / 2), step_bits),
                        32,
                    ) & signed_cast(self.peak_word.val() == word));
            } else {
                self.peak.next = self.peak.val()
                    | (bit_cast(
                        signed_cast(
                            self.i_peak_count.val().slice(count_bits * (word / 2), count_bits),
                        ),
                        32,
                    ) & signed_cast(self.peak_word.val() == word));
            }
        }
    }
}
