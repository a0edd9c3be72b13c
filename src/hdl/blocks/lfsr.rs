//! Gold codes and m-sequences: one or two linear-feedback shift registers.

use super::CodePorts;
use crate::code::{Lfsr, polynomial_text};
use crate::hdl::front::prelude::*;

/// A code from one LFSR (m-sequence) or the XOR of two (Gold code).
#[derive(Debug, Clone, LogicBlock)]
pub struct LfsrGenerator {
    /// Ports.
    pub io: CodePorts,
    about: About,
    u_taps: Constant,
    u_load: Constant,
    u_last: Constant,
    v_taps: Optional<Constant>,
    v_load: Optional<Constant>,
    u: Register<Word>,
    epoch: Register<bool>,
    v: Optional<Register<Word>>,
    _top: usize,
}

impl LfsrGenerator {
    /// The m-sequence of `lfsr`, starting at its chip `start`.
    pub fn m_sequence(lfsr: &Lfsr, start: u64, reloads: bool) -> LfsrGenerator {
        let about = About::new(
            "m_sequence_generator",
            "m-sequence, one linear-feedback shift register",
        )
        .fact("Polynomial", exponents(lfsr));
        Self::with(about, lfsr, None, start, reloads)
    }

    /// The Gold code of `u` and `v`, starting at its chip `start`.
    pub fn gold(u: &Lfsr, v: &Lfsr, start: u64, reloads: bool) -> LfsrGenerator {
        let about = About::new(
            "gold_generator",
            "Gold code, the XOR of two linear-feedback shift registers",
        )
        .fact(
            "Polynomials",
            format!("u {}; v {}", exponents(u), exponents(v)),
        );
        Self::with(about, u, Some(v), start, reloads)
    }

    fn with(about: About, u: &Lfsr, v: Option<&Lfsr>, start: u64, reloads: bool) -> Self {
        let period = u.period();
        let about = about
            .note(
                "Bit 0 of a register is its present chip, bit i the chip i clocks later; the \
                 feedback enters at the top. The epoch needs u only, because both registers \
                 have the same period, and is recognised one chip early, so that it comes from a \
                 register.",
            )
            .fact("Period", format!("{period} chips"))
            .fact("Latency", "0 clocks from register to o_chip")
            .fact("Rate", "one chip per clock with i_advance high");
        let width = u.degree;
        let v_or_u = v.unwrap_or(u);
        let taps = |lfsr: &Lfsr, name: &str| {
            Constant::new(
                tap_mask(lfsr),
                width,
                format!("Taps of {name}: bit n - e for every exponent e > 0 of degree n"),
            )
        };
        let load = |lfsr: &Lfsr, name: &str| {
            let about = format!("First {width} chips of {name}, the earliest in bit 0");
            Constant::new(state_at(lfsr, start), width, about)
        };
        let register = |lfsr: &Lfsr, name: &str| {
            Register::word(width, state_at(lfsr, start), format!("LFSR {name}"))
                .reset_to(&format!("{name}_load"))
        };
        LfsrGenerator {
            io: CodePorts::new(reloads),
            about,
            u_taps: taps(u, "u"),
            u_load: load(u, "u"),
            v_taps: Optional::new(v.is_some(), taps(v_or_u, "v")),
            v_load: Optional::new(v.is_some(), load(v_or_u, "v")),
            u_last: Constant::new(
                state_at(u, start + period - 1),
                width,
                "LFSR u one chip before that",
            ),
            u: register(u, "u"),
            epoch: Register::bit(true, "the present chip is the one that reset gives"),
            v: Optional::new(
                v.is_some(),
                Register::word(width, state_at(v_or_u, start), "LFSR v").reset_to("v_load$0"),
            ),
            _top: width as usize - 1,
        }
    }
}

impl Logic for LfsrGenerator {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, io.i_clk, u, epoch);
        for _two in 0..self.v.count() {
            dff_setup!(self, io.i_clk, v[0]);
            self.io.o_chip.next = self.u.q.val().get_bit(0) ^ self.v[0].q.val().get_bit(0);
        }
        for _one in self.v.count()..1 {
            self.io.o_chip.next = self.u.q.val().get_bit(0);
        }
        self.io.o_epoch.next = self.epoch.q.val();
        for top in self._top..(self._top + 1) {
            if self.io.i_advance.val() {
                self.epoch.d.next = self.u.q.val() == self.u_last.val();
                self.u.d.next = (self.u.q.val() >> 1)
                    .replace_bit(top, (self.u.q.val() & self.u_taps.val()).xor());
                for _two in 0..self.v.count() {
                    self.v[0].d.next = (self.v[0].q.val() >> 1)
                        .replace_bit(top, (self.v[0].q.val() & self.v_taps[0].val()).xor());
                }
            }
        }
        for _reloads in 0..self.io.i_load.count() {
            if self.io.i_load[0].val() {
                self.epoch.d.next = true;
                self.u.d.next = self.u_load.val();
                for _two in 0..self.v.count() {
                    self.v[0].d.next = self.v_load[0].val();
                }
            }
        }
    }
}

fn exponents(lfsr: &Lfsr) -> String {
    format!("{} (exponents)", polynomial_text(&lfsr.exponents))
}

/// Bits of the state whose XOR is the chip that comes in: c[t + n] is the XOR
/// of c[t + n - e] over the exponents e > 0, and bit i holds c[t + i].
pub(super) fn tap_mask(lfsr: &Lfsr) -> u128 {
    lfsr.exponents
        .iter()
        .filter(|&&e| e > 0)
        .fold(0, |mask, &e| mask | 1 << (lfsr.degree - e))
}

/// The state whose bit 0 is chip `position`.
pub(super) fn state_at(lfsr: &Lfsr, position: u64) -> u128 {
    let chips = lfsr.advanced(position).seed;
    chips
        .iter()
        .rev()
        .fold(0, |state, &chip| state << 1 | u128::from(chip))
}
