//! Expressions side by side, and parts of them: concatenations and slices in their
//! shortest form.

use super::expr::{BinaryOp, Expr, SignalId, UnaryOp};
use super::fault::Fault;

/// Inverts every bit.
pub fn not(operand: Expr) -> Expr {
    if let Expr::Literal { value, width } = operand {
        return Expr::Literal { value: !value & (u128::MAX >> (128 - width)), width };
    }
    Expr::Unary(UnaryOp::Not, Box::new(operand))
}

/// `count` times the same bit.
pub fn repeat(bit: Expr, count: u32) -> Expr {
    if count == 1 {
        return bit;
    }
    Expr::Repeat { count, bit: Box::new(bit) }
}

/// Puts single bits side by side, most significant first; runs of one bit
/// become repetitions.
pub fn concat_bits(bits: Vec<Expr>) -> Expr {
    let mut runs: Vec<(Expr, u32)> = Vec::new();
    for bit in bits {
        match runs.last_mut() {
            Some((last, count)) if *last == bit && !matches!(bit, Expr::Literal { .. }) => {
                *count += 1;
            }
            _ => runs.push((bit, 1)),
        }
    }
    concat(runs.into_iter().map(|(bit, count)| repeat(bit, count)).collect())
}

/// Puts parts side by side, most significant first, and joins neighbours that
/// are literals or adjacent slices of one signal.
pub fn concat(parts: Vec<Expr>) -> Expr {
    let mut joined: Vec<Expr> = Vec::new();
    for part in parts {
        let inner = match part {
            Expr::Concat(inner) => inner,
            single => vec![single],
        };
        for next in inner.into_iter().filter(|p| p.width() > 0) {
            match joined.last_mut() {
                Some(last) => match join(last, &next) {
                    Some(both) => *last = both,
                    None => joined.push(next),
                },
                None => joined.push(next),
            }
        }
    }
    if joined.len() == 1 { joined.remove(0) } else { Expr::Concat(joined) }
}

/// One expression for two neighbours in a concatenation, if there is one.
fn join(high: &Expr, low: &Expr) -> Option<Expr> {
    match (high, low) {
        (Expr::Literal { value: a, width: w }, Expr::Literal { value: b, width: v })
            if w + v <= 128 =>
        {
            Some(Expr::Literal { value: (a << v) | b, width: w + v })
        }
        (Expr::Slice { id: a, high, low }, Expr::Slice { id: b, high: next, low: end })
            if a == b && *low == next + 1 =>
        {
            Some(Expr::Slice { id: *a, high: *high, low: *end })
        }
        _ => None,
    }
}

/// One expression for neighbours that are alike: parts of the same vectors, bit by bit.
pub fn fused(high: &Expr, low: &Expr) -> Option<Expr> {
    match (high, low) {
        (Expr::Literal { .. }, Expr::Literal { .. }) if high.is_zero() && low.is_zero() => {
            Some(Expr::zeros(high.width() + low.width()))
        }
        (Expr::Literal { width: 1, .. }, Expr::Literal { width: 1, .. }) if high == low => {
            Some(repeat(low.clone(), 2))
        }
        (Expr::Slice { .. }, Expr::Slice { .. }) => {
            let bit = |e: &Expr| e.width() == 1;
            join(high, low).or_else(|| (bit(high) && high == low).then(|| repeat(low.clone(), 2)))
        }
        (bit, Expr::Repeat { count, bit: same }) if *bit == **same => {
            Some(repeat(bit.clone(), count + 1))
        }
        (Expr::Signal { width: 1, .. }, _) if high == low => Some(repeat(low.clone(), 2)),
        (Expr::Unary(UnaryOp::Not, high), Expr::Unary(UnaryOp::Not, low)) => {
            Some(not(fused(high, low)?))
        }
        (Expr::Binary(op, a, b), Expr::Binary(same, c, d)) if op == same && op.is_bitwise() => {
            Some(Expr::Binary(*op, Box::new(fused(a, c)?), Box::new(fused(b, d)?)))
        }
        (Expr::Mux { test, yes, no }, Expr::Mux { test: same, yes: y, no: n }) if test == same => {
            let (yes, no) = (Box::new(fused(yes, y)?), Box::new(fused(no, n)?));
            Some(Expr::Mux { test: test.clone(), yes, no })
        }
        _ => None,
    }
}

/// Two operands of equal width under an operator. An OR of concatenations that
/// leave each other's bits zero is one concatenation.
pub fn binary(op: BinaryOp, left: Expr, right: Expr) -> Expr {
    if op == BinaryOp::Or
        && let Some(merged) = merge_disjoint(&left, &right)
    {
        return merged;
    }
    Expr::Binary(op, Box::new(left), Box::new(right))
}

fn merge_disjoint(left: &Expr, right: &Expr) -> Option<Expr> {
    let has_zeros = |e: &Expr| match e {
        Expr::Concat(parts) => parts.iter().any(Expr::is_zero),
        other => other.is_zero(),
    };
    if !has_zeros(left) && !has_zeros(right) {
        return None;
    }
    let mut borders: Vec<u32> = borders_of(left).chain(borders_of(right)).collect();
    borders.sort_unstable();
    borders.dedup();
    let mut parts = Vec::new();
    for pair in borders.windows(2).rev() {
        let (high, low) = (pair[1] - 1, pair[0]);
        let a = left.slice(high, low).ok()?;
        let b = right.slice(high, low).ok()?;
        parts.push(if a.is_zero() {
            b
        } else if b.is_zero() {
            a
        } else {
            return None;
        });
    }
    Some(concat(parts))
}

/// Bit positions where an expression's parts begin and end.
fn borders_of(expr: &Expr) -> impl Iterator<Item = u32> {
    let widths: Vec<u32> = match expr {
        Expr::Concat(parts) => parts.iter().rev().map(Expr::width).collect(),
        other => vec![other.width()],
    };
    let mut position = 0;
    std::iter::once(0).chain(widths.into_iter().map(move |width| {
        position += width;
        position
    }))
}

/// Bits `low ..= high` of parts side by side.
fn slice_of_parts(parts: &[Expr], high: u32, low: u32) -> Result<Expr, Fault> {
    let mut chosen = Vec::new();
    let mut top = parts.iter().map(Expr::width).sum::<u32>();
    for part in parts {
        let base = top - part.width();
        if base <= high && low < top {
            chosen.push(part.slice(high.min(top - 1) - base, low.max(base) - base)?);
        }
        top = base;
    }
    Ok(concat(chosen))
}

impl Expr {
    /// Bits `low ..= high` as an expression that Verilog can write.
    pub fn slice(&self, high: u32, low: u32) -> Result<Expr, Fault> {
        let width = self.width();
        if high >= width {
            return Err(Fault::OutOfRange { bit: high, width });
        }
        if low == 0 && high + 1 == width {
            return Ok(self.clone());
        }
        match self {
            Expr::Signal { id, .. } => Ok(Expr::Slice { id: *id, high, low }),
            Expr::Slice { id, low: base, .. } => {
                Ok(Expr::Slice { id: *id, high: base + high, low: base + low })
            }
            Expr::Literal { value, .. } => {
                let width = high - low + 1;
                let mask = u128::MAX >> (128 - width);
                Expr::literal((value >> low) & mask, width)
            }
            Expr::Concat(parts) => slice_of_parts(parts, high, low),
            Expr::Repeat { bit, .. } => Ok(repeat((**bit).clone(), high - low + 1)),
            Expr::Unary(UnaryOp::Not, operand) => Ok(not(operand.slice(high, low)?)),
            Expr::Binary(op, left, right)
                if op.is_bitwise() || (low == 0 && !op.is_comparison()) =>
            {
                // The low bits of a sum depend on the low bits of its operands.
                Ok(binary(*op, left.slice(high, low)?, right.slice(high, low)?))
            }
            Expr::Mux { test, yes, no } => Ok(Expr::Mux {
                test: test.clone(),
                yes: Box::new(yes.slice(high, low)?),
                no: Box::new(no.slice(high, low)?),
            }),
            _ => Err(Fault::Unsupported {
                construct: "a slice of a result that has no name".to_owned(),
            }),
        }
    }

    /// Zero-extended, or cut, to `width` bits.
    pub fn resize(self, width: u32) -> Result<Expr, Fault> {
        let own = self.width();
        if width == 0 {
            return Err(Fault::OutOfRange { bit: 0, width: 0 });
        }
        if width <= own {
            return self.slice(width - 1, 0);
        }
        Ok(concat(vec![Expr::zeros(width - own), self]))
    }

    /// Sign-extended to `width` bits.
    pub fn sign_extend(self, width: u32) -> Result<Expr, Fault> {
        let own = self.width();
        if width < own {
            return Err(Fault::WidthMismatch {
                place: "signed_cast".to_owned(),
                left: width,
                right: own,
            });
        }
        let sign = self.slice(own - 1, own - 1)?;
        if own == 1 {
            return Ok(repeat(sign, width));
        }
        Ok(concat(vec![repeat(sign, width - own), self]))
    }

    /// Shifted left by a constant.
    pub fn shift_left(self, bits: u32) -> Result<Expr, Fault> {
        let width = self.width();
        if bits == 0 {
            return Ok(self);
        }
        if bits >= width {
            return Ok(Expr::zeros(width));
        }
        Ok(concat(vec![self.slice(width - 1 - bits, 0)?, Expr::zeros(bits)]))
    }

    /// Shifted right by a constant, zeros coming in.
    pub fn shift_right(self, bits: u32) -> Result<Expr, Fault> {
        let width = self.width();
        if bits == 0 {
            return Ok(self);
        }
        if bits >= width {
            return Ok(Expr::zeros(width));
        }
        Ok(concat(vec![Expr::zeros(bits), self.slice(width - 1, bits)?]))
    }

    /// With the bit at `index` replaced.
    pub fn replace_bit(self, index: u32, bit: Expr) -> Result<Expr, Fault> {
        let width = self.width();
        if index >= width {
            return Err(Fault::OutOfRange { bit: index, width });
        }
        let mut parts = Vec::new();
        if index + 1 < width {
            parts.push(self.slice(width - 1, index + 1)?);
        }
        parts.push(bit);
        if index > 0 {
            parts.push(self.slice(index - 1, 0)?);
        }
        Ok(concat(parts))
    }

    /// With `value_of` in the place of every signal that has one.
    pub fn replaced(&self, value_of: &impl Fn(SignalId) -> Option<Expr>) -> Result<Expr, Fault> {
        let boxed = |e: &Expr| e.replaced(value_of).map(Box::new);
        Ok(match self {
            Expr::Signal { id, .. } => value_of(*id).unwrap_or_else(|| self.clone()),
            Expr::Slice { id, high, low } => match value_of(*id) {
                Some(value) => value.slice(*high, *low)?,
                None => self.clone(),
            },
            Expr::Literal { .. } => self.clone(),
            Expr::Concat(parts) => {
                let parts: Result<_, _> = parts.iter().map(|p| p.replaced(value_of)).collect();
                concat(parts?)
            }
            Expr::Repeat { count, bit } => repeat(bit.replaced(value_of)?, *count),
            Expr::Lookup { table, index } => Expr::Lookup { table: *table, index: boxed(index)? },
            Expr::Unary(op, operand) => Expr::Unary(*op, boxed(operand)?),
            Expr::Binary(op, left, right) => Expr::Binary(*op, boxed(left)?, boxed(right)?),
            Expr::Mux { test, yes, no } => {
                Expr::Mux { test: boxed(test)?, yes: boxed(yes)?, no: boxed(no)? }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rtl::back::expr::SignalId;

    fn signal(id: SignalId, width: u32) -> Expr {
        Expr::Signal { id, width }
    }

    #[test]
    fn a_shift_or_ed_with_a_carried_bit_is_one_concatenation() {
        let shifted = signal(0, 8).shift_left(1).unwrap();
        let carried = signal(1, 1).resize(8).unwrap();
        assert_eq!(
            binary(BinaryOp::Or, shifted, carried),
            Expr::Concat(vec![Expr::Slice { id: 0, high: 6, low: 0 }, signal(1, 1)])
        );
    }

    #[test]
    fn an_or_of_overlapping_parts_stays_an_or() {
        let merged = binary(BinaryOp::Or, signal(0, 4), signal(1, 4));
        assert!(matches!(merged, Expr::Binary(BinaryOp::Or, ..)));
    }

    #[test]
    fn slices_of_slices_and_parts_name_the_signal() {
        let shifted = signal(0, 11).shift_right(1).unwrap();
        assert_eq!(shifted.slice(9, 3).unwrap(), Expr::Slice { id: 0, high: 10, low: 4 });
        assert!(signal(0, 4).slice(4, 0).is_err());
    }

    #[test]
    fn replacing_the_incoming_zero_of_a_shift_leaves_no_zero() {
        let next = signal(0, 5).shift_right(1).unwrap().replace_bit(4, signal(1, 1)).unwrap();
        assert_eq!(next, Expr::Concat(vec![signal(1, 1), Expr::Slice { id: 0, high: 4, low: 1 }]));
    }

    #[test]
    fn sign_extension_repeats_the_top_bit() {
        let extended = signal(0, 2).sign_extend(4).unwrap();
        assert_eq!(extended.width(), 4);
        assert!(signal(0, 4).sign_extend(2).is_err());
    }
}
