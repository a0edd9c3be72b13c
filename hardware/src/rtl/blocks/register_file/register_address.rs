//! Which register an address is of.

use crate::rtl::front::prelude::*;
use crate::sensor::registers::{ADDRESS_BITS, IDENTITY_WORDS, RegisterPlan};

/// Bits of the address of a word.
const WORD_ADDRESS_BITS: usize = ADDRESS_BITS as usize - 2;
/// Bit of a word's address that is high for state and peaks.
const STATE_BIT: usize = 8;
/// Bit that is high among those for peaks.
const PEAK_BIT: usize = 6;

#[block(register_address)]
/// which register a write, and which a read, is of
///
/// - Latency: of a write 1 clock, of a read 2
pub struct RegisterAddress {
    plan: RegisterPlan,
    #[set(plan.word_bits() as usize)]
    word_bits: usize,
    #[set(plan.peaks > 0)]
    has_peaks: bool,
    /// Words with a peak, and where the target is.
    #[set(plan.readings() as usize)]
    peak_words: usize,
    #[set(which(plan.word_bits(), |word| {
        (IDENTITY_WORDS..plan.words()).contains(&word)
    }))]
    which_are_settings: Vec<u8>,
    /// address of the word that is written
    #[width(WORD_ADDRESS_BITS)]
    pub i_write: Input<Word>,
    /// address of the word that is read
    #[width(WORD_ADDRESS_BITS)]
    pub i_read: Input<Word>,
    /// the write is to a setting
    pub o_to_setting: Output<bool>,
    /// it is to the control register, or to the flags
    pub o_to_state: Output<bool>,
    /// what is read is a word in the memory
    pub o_of_word: Output<bool>,
    /// it is the control register, or the flags
    pub o_of_state: Output<bool>,
    /// it is any register
    pub o_of_register: Output<bool>,
    /// it is to a setting
    to_setting: Register<bool>,
    /// it is to the control register, or to the flags
    to_state: Register<bool>,
    /// the address that is read is a word's in the memory, but for the state's bit
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
    /// what is read is in the memory, or of the state
    of_either: Local<bool>,
    #[is(BitTable::new(which_are_settings.clone(), plan.word_bits(), "Words that a host may write"))]
    settable: BitTable,
    /// the lowest bit of an address that is read tells words apart, of which only peaks have to be; linters know by the name
    #[when(!has_peaks)]
    unused: Optional<Local<bool>>,
}

/// A table of the words for which something holds.
fn which(word_bits: u32, holds: impl Fn(usize) -> bool) -> Vec<u8> {
    (0..1 << word_bits).map(|word| u8::from(holds(word))).collect()
}

#[kernel]
impl Logic for RegisterAddress {
    /// What the addresses are of: of a write in one clock, of a read, which waits for the memory, in two.
    fn update(&mut self) {
        let above_words = WORD_ADDRESS_BITS - self.word_bits;
        let above_state = PEAK_BIT - 1;
        self.settable.address.next = self.i_write.val().slice(0, self.word_bits);
        self.to_setting.next =
            !self.i_write.val().slice(self.word_bits, above_words).any() & self.settable.data.val();
        self.to_state.next = !self.i_write.val().get_bit(STATE_BIT + 1)
            & self.i_write.val().get_bit(STATE_BIT)
            & !self.i_write.val().slice(PEAK_BIT, 2).any()
            & !self.i_write.val().slice(1, above_state).any();
        let above_words = STATE_BIT - self.word_bits;
        self.by_word.next = !self.i_read.val().get_bit(STATE_BIT + 1)
            & !self.i_read.val().slice(self.word_bits, above_words).any();
        self.by_state.next = self.i_read.val().get_bit(STATE_BIT);
        self.by_first_two.next = !self.i_read.val().slice(1, self.word_bits - 1).any();
        self.of_word.next = self.by_word.val() & !self.by_state.val();
        self.of_state.next = self.by_word.val() & self.by_state.val() & self.by_first_two.val();
        self.of_either.next = self.by_word.val() & (!self.by_state.val() | self.by_first_two.val());
        if self.has_peaks {
            self.by_peak.next = !self.i_read.val().get_bit(STATE_BIT + 1)
                & self.i_read.val().get_bit(STATE_BIT)
                & !self.i_read.val().get_bit(STATE_BIT - 1)
                & self.i_read.val().get_bit(PEAK_BIT)
                & (self.i_read.val().slice(0, PEAK_BIT) < self.peak_words);
            self.of_register.next = self.of_either.val() | self.by_peak.val();
        } else {
            self.unused.next = self.i_read.val().get_bit(0);
            self.of_register.next = self.of_either.val();
        }
        connect! { self: to_setting, to_state, of_word, of_state, of_register }
    }
}
