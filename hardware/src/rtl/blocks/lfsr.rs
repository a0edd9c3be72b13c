//! Gold codes and m-sequences: one or two linear-feedback shift registers.
//!
//! Two registers and a handful of XOR gates take the place of a table of 2^n - 1 chips.
//!
//! Cost (ECP5, docs/resources.md): 13 LUTs, 23 flip-flops; an m-sequence 11 and 12.

use super::CodePorts;
use crate::code::{Lfsr, polynomial_text};
use crate::rtl::front::prelude::*;
use crate::sensor::registers::Seed;

/// A code from one LFSR (m-sequence) or the XOR of two (Gold code).
#[block(describe(&first, second.is_some(), sets_taps))]
pub struct LfsrGenerator {
    first: Lfsr,
    second: Option<Lfsr>,
    start: u64,
    reloads: bool,
    /// What is set from outside of the last register.
    seed: Option<Seed>,
    #[set(first.degree)]
    width: u32,
    /// Whether that is its taps, too.
    #[set(seed.is_some_and(|seed| seed.has_taps()))]
    sets_taps: bool,
    /// Whether there is a register v. Beside an m-sequence with taps from outside u counts the chips of a period.
    #[set(second.is_some() || sets_taps)]
    has_v: bool,
    // The first stands in for the second where there is none.
    #[set(second.clone().unwrap_or_else(|| first.clone()))]
    other: Lfsr,
    /// ports
    #[is(CodePorts::new(reloads, seed))]
    pub io: CodePorts,
    #[under(lfsr_heading("u", &first))]
    #[width(width)]
    #[value(first.taps().into())]
    u_taps: Constant,
    /// {load_about(width)}
    #[width(width)]
    #[value(state_at(&first, start))]
    u_load: Constant,
    /// {shifts_to_last(&first, sets_taps)} shifts on, {if sets_taps { "two chips" } else { "one chip" }} before the first comes again
    #[width(width)]
    #[value(state_at(&first, start + shifts_to_last(&first, sets_taps)))]
    u_last: Constant,
    #[when(has_v && !sets_taps)]
    #[under(lfsr_heading("v", &other))]
    #[width(width)]
    #[value(other.taps().into())]
    v_taps: Optional<Constant>,
    /// {load_about(width)}
    #[under(if sets_taps { "v: an LFSR of the taps in i_seed".to_owned() } else { lfsr_heading("v", &other) })]
    #[when(has_v)]
    #[width(width)]
    #[value(state_at(&other, start))]
    v_load: Optional<Constant>,
    #[width(width)]
    #[reset(state_at(&first, start), u_load)]
    u: Register<Word>,
    /// the present chip is the one that reset gives
    #[reset(true)]
    epoch: Register<bool>,
    #[when(has_v)]
    #[width(width)]
    #[reset(state_at(&other, start), v_load)]
    v: Optional<Register<Word>>,
    /// the present chip is the period's last
    #[when(sets_taps)]
    last: Optional<Register<bool>>,
    #[when(sets_taps)]
    #[width(width)]
    taps: Optional<Local<Word>>,
    #[when(sets_taps)]
    #[width(width)]
    first_chips: Optional<Local<Word>>,
}

fn describe(first: &Lfsr, is_gold: bool, sets_taps: bool) -> About {
    let about = match is_gold {
        false => {
            About::new("m_sequence_generator", "m-sequence, one linear-feedback shift register")
        }
        true => About::new(
            "gold_generator",
            "Gold code, the XOR of two linear-feedback shift registers",
        ),
    };
    let about = about.note(format!(
        "Bit 0 of a register is its present chip, bit i the chip i clocks later; the \
                 feedback enters at the top. The epoch {}is recognised one chip early, so that it \
                 comes from a register.",
        match is_gold {
            false => "",
            true => "needs u only, because both registers have the same period, and ",
        }
    ));
    let about = match (sets_taps, is_gold) {
        (false, _) => about,
        (true, true) => about.note(
            "The upper half of i_seed has the taps of v, which begins anew with each period of u, so that a code has the \
             same period with any taps.",
        ),
        (true, false) => about.note(
            "The chips are those of v, of which the upper half of i_seed has the taps. It begins anew with each period of \
             u, so that a code has the same period with any taps.",
        ),
    };
    about
        .fact("Period", format!("{} chips", first.period()))
        .fact("Latency", "0 clocks from register to o_chip")
        .checks([StateCheck {
            taps: "u_taps".to_owned(),
            first: "u_load".to_owned(),
            shifts: shifts_to_last(first, sets_taps),
            last: "u_last".to_owned(),
        }])
}

/// Shifts from the first state to the one that is recognised: before a reload a chip more is needed.
fn shifts_to_last(first: &Lfsr, sets_taps: bool) -> u64 {
    first.period() - 1 - u64::from(sets_taps)
}

fn load_about(width: u32) -> String {
    format!("the first {width} chips, the earliest in bit 0")
}

#[kernel]
impl Logic for LfsrGenerator {
    fn update(&mut self) {
        if self.second.is_none() && self.has_v {
            self.io.o_chip.next = self.v.val().get_bit(0);
        } else if self.has_v {
            self.io.o_chip.next = self.u.val().get_bit(0) ^ self.v.val().get_bit(0);
        } else {
            self.io.o_chip.next = self.u.val().get_bit(0);
        }
        self.io.o_epoch.next = self.epoch.val();
        if self.taps.is_present() {
            self.taps.next = self.io.i_seed.val().slice(self.width as usize, self.width as usize);
            self.first_chips.next = self.io.i_seed.val().slice(0, self.width as usize);
        }
        self.advance();
        if self.io.i_load.is_present() && self.io.i_load.val() {
            self.epoch.next = true;
            self.u.next = self.u_load.val();
            if self.taps.is_present() {
                self.last.next = false;
                self.v.next = self.first_chips.val();
            } else if self.io.i_seed.is_present() {
                self.v.next = self.io.i_seed.val();
            } else if self.v.is_present() {
                self.v.next = self.v_load.val();
            }
        }
    }

    fn advance(&mut self) {
        let bits = self.width as usize;
        if self.io.i_advance.val() {
            if self.taps.is_present() {
                self.last.next = self.u.val() == self.u_last.val();
                self.epoch.next = self.last.val();
            } else {
                self.epoch.next = self.u.val() == self.u_last.val();
            }
            self.u.next = self.u.val().advanced(bits, self.u_taps.val());
            if self.taps.is_present() {
                if self.last.val() {
                    self.v.next = self.first_chips.val();
                } else {
                    self.v.next = self.v.val().advanced(bits, self.taps.val());
                }
            } else if self.v.is_present() {
                self.v.next = self.v.val().advanced(bits, self.v_taps.val());
            }
        }
    }
}

/// What stands over the constants of an LFSR in the Verilog.
pub(super) fn lfsr_heading(name: &str, lfsr: &Lfsr) -> String {
    let polynomial = polynomial_text(&lfsr.exponents);
    format!("{name}: an LFSR of the polynomial {polynomial} (exponents)")
}

/// The state whose bit 0 is chip `position`.
pub(super) fn state_at(lfsr: &Lfsr, position: u64) -> u128 {
    let chips = lfsr.advanced(position).seed;
    chips.iter().rev().fold(0, |state, &chip| state << 1 | u128::from(chip))
}
