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

mod register_address;
mod scan_state;

use std::ops::{Deref, DerefMut};

use self::register_address::RegisterAddress;
use self::scan_state::{ScanState, written_bits};
use crate::rtl::front::prelude::*;
use crate::sensor::registers::{ADDRESS_BITS, RegisterPlan};

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
    #[set(plan.peaks as usize)]
    peaks: usize,
    #[set(peaks > 0)]
    has_peaks: bool,
    /// Whether a target is followed.
    #[set(plan.track.is_some())]
    tracks: bool,
    /// Bits of a write that the state takes.
    #[set(written_bits(tracks) as usize)]
    written_bits: usize,
    /// Words with a peak, and where the target is.
    #[set(plan.readings() as usize)]
    peak_words: usize,
    /// Bits of the number of such a word.
    #[set(if has_peaks { peak_words.next_power_of_two().trailing_zeros() as usize } else { 0 })]
    peak_words_bits: usize,
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
    /// settings were written since the last take-over, or a single scan was asked for
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
    /// phase step of the target's peak, and 8 bits of its fraction
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
    #[is(RegisterAddress::new(plan.clone()))]
    address: RegisterAddress,
    #[is(ScanState::new(saturates, tracks))]
    scans: ScanState,
    /// a write takes place
    write: Register<bool>,
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
    /// the bytes of a word have one address; linters know by the name
    unused: Local<bool>,
}

fn describe(plan: &RegisterPlan) -> About {
    About::new("register_file", "identification, settings, control and state, as an AXI4-Lite slave")
        .note(
            "A write is taken when its address and its data are both there. An address without a \
             register, a register that is only read, and a write of some bytes of a word are answered \
             with SLVERR, and change nothing. The memory keeps the settings in reset.",
        )
        .note(
            "After reset scans follow one another, with the settings of the scene until a host writes \
             others.",
        )
        .fact("Words", format!("{} in the memory, of which {} are settings", plan.words(), plan.settings()))
        .fact("Latency", "a write is answered 2 clocks after it is there, a read 3 clocks, and longer during a take-over")
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
        self.address.i_write.next = self.io.s_axil_awaddr.val().slice(2, ADDRESS_BITS as usize - 2);
        self.address.i_read.next = self.io.s_axil_araddr.val().slice(2, ADDRESS_BITS as usize - 2);
        if self.has_peaks {
            self.choose_peak();
        }
        self.write_words();
        self.read_words();
        self.keep_state();
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
        if self.write.q.val() {
            self.answers.d.next = true;
            self.write_error.d.next = !(self.of_all_bytes.q.val()
                & (self.address.o_to_setting.val() | self.address.o_to_state.val()));
        } else if self.io.s_axil_bready.val() {
            self.answers.d.next = false;
        }
        self.io.s_axil_bvalid.next = self.answers.q.val();
        self.io.s_axil_bresp.next = bit_cast(self.write_error.q.val(), 2) << 1;
        self.memory.i_write.next = self.writes.val() & self.address.o_to_setting.val();
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
        if self.fetched.q.val() {
            self.valid.d.next = true;
            self.read_error.d.next = !self.address.o_of_register.val();
            if self.address.o_of_word.val() {
                self.data.d.next = self.word.q.val();
            } else if self.address.o_of_state.val() {
                self.data.d.next = self.scans.o_state.val();
            } else if self.has_peaks {
                self.data.d.next = self.peak.val() & signed_cast(self.address.o_of_register.val());
            } else {
                self.data.d.next = bit_cast(false, 32);
            }
        } else if self.io.s_axil_rready.val() {
            self.valid.d.next = false;
        }
        self.io.s_axil_arready.next = self.fetched.q.val();
        self.io.s_axil_rvalid.next = self.valid.q.val();
        self.io.s_axil_rdata.next = self.data.q.val();
        self.io.s_axil_rresp.next = bit_cast(self.read_error.q.val(), 2) << 1;
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

    /// What is written to the state, and what scans tell it.
    fn keep_state(&mut self) {
        self.scans.i_set.next = self.writes.val() & self.address.o_to_setting.val();
        self.scans.i_control.next = self.writes.val()
            & self.address.o_to_state.val()
            & !self.io.s_axil_awaddr.val().get_bit(2);
        self.scans.i_clear.next = self.writes.val()
            & self.address.o_to_state.val()
            & self.io.s_axil_awaddr.val().get_bit(2);
        self.scans.i_data.next = self.io.s_axil_wdata.val().slice(0, self.written_bits);
        connect! {
            self.scans from self: i_taken_first, i_refused, i_busy, i_scan_counted, i_lost, i_clamps,
                i_locked, i_target_lost
        }
        connect! { self from self.scans: o_go, o_changed }
    }
}
