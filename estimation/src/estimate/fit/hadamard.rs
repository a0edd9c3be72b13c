//! All codes of a Gold set at all delays: one Hadamard transform for each delay.
//!
//! A chip of v, some chips on, is a linear function of the state of v's register. So
//! with the residual of a scan times u's chips, ordered by that state, a
//! Walsh-Hadamard transform has the correlation with u XOR v for every advance of v
//! at once.

use rayon::prelude::*;

use crate::code::{Code, CodeError, Generator, GoldSet, Lfsr};

/// A set of codes that may be in the air.
#[derive(Debug, Clone)]
pub struct CodeSet {
    set: GoldSet,
    interleave: u32,
    /// State of v's register at every chip: bit b is the chip b later.
    states: Vec<u32>,
    /// The function of the state that is v so many chips on: which bits add up.
    advances: Vec<u32>,
    /// Signs of u's chips.
    u_signs: Vec<f32>,
}

/// The place where a set's correlation stands out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HadamardCell {
    /// Index in the set.
    pub index: i64,
    /// Delay in whole chips, interleaved ones.
    pub chip: usize,
    /// Half the correlation of the values with the code's signs.
    pub product: f64,
    /// What cells are compared by.
    score: f32,
}

/// What a set's correlations are compared by: a factor for each code.
#[derive(Debug, Clone)]
pub struct Scales(Vec<f32>);

impl Scales {
    /// Of the codes -2, -1, 0, .., by their templates' powers: as many standard deviations
    /// stand out alike.
    pub fn of_powers(powers: &[f64]) -> Scales {
        Scales(powers.iter().map(|power| 1.0 / power.sqrt() as f32).collect())
    }

    /// Leaves a code out.
    pub fn leave_out(&mut self, index: i64) {
        self.0[(index + 2) as usize] = 0.0;
    }

    fn of(&self, index: i64) -> f32 {
        self.0[(index + 2) as usize]
    }
}

impl CodeSet {
    /// The set of a Gold code, `None` if it is not of one.
    pub fn of(code: &Code) -> Option<CodeSet> {
        let Generator::Gold { u, v } = &code.generator else {
            return None;
        };
        let set = GoldSet { u: u.clone(), v: v.clone() };
        let length = set.length() as usize;
        let chips = v.chips(length);
        let degree = v.degree as usize;
        let states = (0..length).map(|i| {
            let bits = (0..degree).map(|b| u32::from(chips[(i + b) % length]) << b);
            bits.sum()
        });
        Some(CodeSet {
            states: states.collect(),
            advances: advances(v, length),
            u_signs: u.chips(length).iter().map(|&c| sign(c)).collect(),
            interleave: code.interleave,
            set,
        })
    }

    /// Number of codes.
    pub fn members(&self) -> u64 {
        self.set.members()
    }

    /// The code of an index.
    ///
    /// # Errors
    /// If the set has none of that index.
    pub fn code(&self, index: i64) -> Result<Code, CodeError> {
        Code::new(self.set.generator(index)?, self.interleave)
    }

    /// The index of a code of the set.
    pub fn index_of(&self, code: &Code) -> Option<i64> {
        let members = (0..self.set.length() as i64).chain([-2, -1]);
        let mut members = members.filter(|&index| self.starts_like(index, code));
        members.find(|&index| self.code(index).is_ok_and(|member| member.chips == code.chips))
    }

    fn starts_like(&self, index: i64, code: &Code) -> bool {
        let length = self.states.len();
        let chip = |i: usize| {
            let u = u8::from(self.u_signs[i] > 0.0);
            let v = |on: usize| (self.states[(i + on) % length] & 1) as u8;
            match index {
                -2 => u,
                -1 => v(0),
                _ => u ^ v(index as usize),
            }
        };
        code.interleave == self.interleave
            && code.chips.len() == length << self.interleave
            && (0..length.min(64)).all(|i| chip(i) == code.chips[i << self.interleave])
    }

    /// The correlation of `image` (one value per chip) with a code that is largest times its
    /// code's scale; codes of no scale are left out.
    pub fn best(&self, image: &[f64], scales: &Scales) -> Option<HadamardCell> {
        let copies = 1_usize << self.interleave;
        let of_first_chip = |first: usize| {
            // An interleaved chip is itself and its opposite in turns (eq. 23).
            let gathered = (0..self.states.len()).map(|chip| {
                let copy = |s: usize| image[(chip * copies + first + s) % image.len()];
                let signed = (0..copies).map(|s| if s % 2 == 0 { copy(s) } else { -copy(s) });
                signed.sum::<f64>() as f32
            });
            let cell = self.best_before_interleaving(&gathered.collect::<Vec<_>>(), scales)?;
            Some(HadamardCell { chip: cell.chip * copies + first, ..cell })
        };
        (0..copies).filter_map(of_first_chip).reduce(larger)
    }

    fn best_before_interleaving(&self, image: &[f32], scales: &Scales) -> Option<HadamardCell> {
        let length = self.states.len();
        let of_delay = |chip: usize| {
            let mut values = vec![0.0_f32; length + 1];
            for (i, (&state, sign)) in self.states.iter().zip(&self.u_signs).enumerate() {
                values[state as usize] = image[(i + chip) % length] * sign;
            }
            transform(&mut values);
            let u_alone = (-2, values[0]);
            let others = self.advances.iter().enumerate();
            let others = others.map(|(index, &advance)| (index as i64, values[advance as usize]));
            largest(others.chain([u_alone]), chip, scales)
        };
        let found = (0..length).into_par_iter().filter_map(of_delay);
        let of_both = found.reduce_with(larger);
        let mut values = vec![0.0_f32; length + 1];
        for (&state, &value) in self.states.iter().zip(image) {
            values[state as usize] = value;
        }
        transform(&mut values);
        let v_alone = (0..length).filter_map(|chip| {
            let advance = self.advances[(length - chip) % length];
            largest([(-1, -values[advance as usize])].into_iter(), chip, scales)
        });
        v_alone.chain(of_both).reduce(larger)
    }
}

fn sign(chip: u8) -> f32 {
    2.0 * f32::from(chip) - 1.0
}

/// Which bits of the state at a chip add up to the chip 0, 1, .. places on.
fn advances(v: &Lfsr, length: usize) -> Vec<u32> {
    let degree = v.degree as usize;
    let mut advances: Vec<u32> = (0..degree.min(length)).map(|bit| 1 << bit).collect();
    for chip in degree..length {
        let terms = v.exponents.iter().filter(|&&e| e > 0);
        advances.push(terms.fold(0, |sum, &e| sum ^ advances[chip - e as usize]));
    }
    advances
}

fn larger(a: HadamardCell, b: HadamardCell) -> HadamardCell {
    // Of equal ones that of the earlier delay, whatever the order of work.
    let is_later = (b.chip, b.index) > (a.chip, a.index);
    if b.score > a.score || (b.score == a.score && !is_later) { b } else { a }
}

fn largest(
    products: impl Iterator<Item = (i64, f32)>,
    chip: usize,
    scales: &Scales,
) -> Option<HadamardCell> {
    let mut best: Option<(i64, f32, f32)> = None;
    for (index, product) in products {
        let scale = scales.of(index);
        let score = product * scale;
        if scale > 0.0 && best.is_none_or(|(.., most)| score > most) {
            best = Some((index, product, score));
        }
    }
    best.map(|(index, product, score)| HadamardCell {
        index,
        chip,
        product: 0.5 * f64::from(product),
        score,
    })
}

/// Walsh-Hadamard transform, in place.
fn transform(values: &mut [f32]) {
    let mut half = 1;
    while half < values.len() {
        for block in values.chunks_exact_mut(2 * half) {
            let (left, right) = block.split_at_mut(half);
            for (a, b) in left.iter_mut().zip(right) {
                (*a, *b) = (*a + *b, *a - *b);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{CodeSpec, Family};

    fn gold(index: i64, interleave: u32) -> Code {
        let spec = CodeSpec {
            degree: Some(5),
            index: Some(index),
            interleave,
            ..CodeSpec::new(Family::Gold)
        };
        spec.build().expect("a Gold code")
    }

    /// Every cell against the correlation by its definition.
    #[test]
    fn every_code_and_delay_has_the_correlation_of_the_definition() {
        for interleave in [0, 1, 2] {
            let set = CodeSet::of(&gold(4, interleave)).expect("a set");
            let length = 31 << interleave;
            let image: Vec<f64> =
                (0..length).map(|i| f64::from((i * i * 7 + 3 * i) % 23)).collect();
            let length = image.len();
            for index in (0..31).chain([-2, -1]) {
                let code = set.code(index).expect("a member");
                assert_eq!(set.index_of(&code), Some(index));
                let products = (0..length).map(|chip| {
                    let terms = code.chips.iter().enumerate();
                    let terms =
                        terms.map(|(i, &c)| image[(i + chip) % length] * f64::from(sign(c)));
                    0.5 * terms.sum::<f64>()
                });
                let products: Vec<f64> = products.collect();
                let mut scales = Scales::of_powers(&[4.0; 33]);
                (-2..31).filter(|&i| i != index).for_each(|i| scales.leave_out(i));
                let cell = set.best(&image, &scales).expect("the only one allowed");
                let largest = products.iter().copied().fold(f64::MIN, f64::max);
                assert!((cell.product - largest).abs() < 1e-2, "{index}: {cell:?} {largest}");
                assert!((products[cell.chip] - largest).abs() < 1e-2, "{index}: {cell:?}");
            }
        }
    }
}
