//! Gold codes and m-sequences: one or two linear-feedback shift registers.
//!
//! Two registers and a handful of XOR gates take the place of a table of 2^n - 1 chips.
//!
//! Cost (ECP5, docs/resources.md): 13 LUTs, 23 flip-flops; an m-sequence 11 and 12.

use super::CodePorts;
use crate::code::{Lfsr, polynomial_text};
use crate::rtl::front::prelude::*;

/// A code from one LFSR (m-sequence) or the XOR of two (Gold code).
#[block(describe(&first, second.is_some()))]
pub struct LfsrGenerator {
    first: Lfsr,
    second: Option<Lfsr>,
    start: u64,
    reloads: bool,
    /// Whether the second is loaded with a seed from outside.
    seeded: bool,
    #[set(first.degree)]
    width: u32,
    // The first stands in for the second where there is none.
    #[set(second.clone().unwrap_or_else(|| first.clone()))]
    other: Lfsr,
    /// ports
    #[is(CodePorts::new(reloads, if seeded { width } else { 0 }))]
    pub io: CodePorts,
    #[under(lfsr_heading("u", &first))]
    #[width(width)]
    #[value(tap_mask(&first))]
    u_taps: Constant,
    /// {load_about(width)}
    #[width(width)]
    #[value(state_at(&first, start))]
    u_load: Constant,
    /// {first.period() - 1} shifts on, one chip before the first comes again
    #[width(width)]
    #[value(state_at(&first, start + first.period() - 1))]
    u_last: Constant,
    #[when(second.is_some())]
    #[under(lfsr_heading("v", &other))]
    #[width(width)]
    #[value(tap_mask(&other))]
    v_taps: Optional<Constant>,
    /// {load_about(width)}
    #[when(second.is_some())]
    #[width(width)]
    #[value(state_at(&other, start))]
    v_load: Optional<Constant>,
    #[width(width)]
    #[reset(state_at(&first, start), u_load)]
    u: Register<Word>,
    /// the present chip is the one that reset gives
    #[reset(true)]
    epoch: Register<bool>,
    #[when(second.is_some())]
    #[width(width)]
    #[reset(state_at(&other, start), v_load)]
    v: Optional<Register<Word>>,
}

fn describe(first: &Lfsr, is_gold: bool) -> About {
    let about = match is_gold {
        false => {
            About::new("m_sequence_generator", "m-sequence, one linear-feedback shift register")
        }
        true => About::new(
            "gold_generator",
            "Gold code, the XOR of two linear-feedback shift registers",
        ),
    };
    about
        .note(format!(
            "Bit 0 of a register is its present chip, bit i the chip i clocks later; the \
                 feedback enters at the top. The epoch {}is recognised one chip early, so that it \
                 comes from a register.",
            match is_gold {
                false => "",
                true => "needs u only, because both registers have the same period, and ",
            }
        ))
        .fact("Period", format!("{} chips", first.period()))
        .fact("Latency", "0 clocks from register to o_chip")
        .checks([StateCheck {
            taps: "u_taps".to_owned(),
            first: "u_load".to_owned(),
            shifts: first.period() - 1,
            last: "u_last".to_owned(),
        }])
}

fn load_about(width: u32) -> String {
    format!("the first {width} chips, the earliest in bit 0")
}

#[kernel]
impl Logic for LfsrGenerator {
    fn update(&mut self) {
        if self.v.is_present() {
            self.io.o_chip.next = self.u.val().get_bit(0) ^ self.v.val().get_bit(0);
        } else {
            self.io.o_chip.next = self.u.val().get_bit(0);
        }
        self.io.o_epoch.next = self.epoch.val();
        self.advance();
        if self.io.i_load.is_present() && self.io.i_load.val() {
            self.epoch.next = true;
            self.u.next = self.u_load.val();
            if self.io.i_seed.is_present() {
                self.v.next = self.io.i_seed.val();
            } else if self.v.is_present() {
                self.v.next = self.v_load.val();
            }
        }
    }

    fn advance(&mut self) {
        let bits = self.width as usize;
        if self.io.i_advance.val() {
            self.epoch.next = self.u.val() == self.u_last.val();
            self.u.next = self.u.val().advanced(bits, self.u_taps.val());
            if self.v.is_present() {
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

/// Bits of the state whose XOR is the chip that comes in: c[t + n] is the XOR
/// of c[t + n - e] over the exponents e > 0, and bit i holds c[t + i].
pub(super) fn tap_mask(lfsr: &Lfsr) -> u128 {
    lfsr.exponents.iter().filter(|&&e| e > 0).fold(0, |mask, &e| mask | 1 << (lfsr.degree - e))
}

/// The state whose bit 0 is chip `position`.
pub(super) fn state_at(lfsr: &Lfsr, position: u64) -> u128 {
    let chips = lfsr.advanced(position).seed;
    chips.iter().rev().fold(0, |state, &chip| state << 1 | u128::from(chip))
}
