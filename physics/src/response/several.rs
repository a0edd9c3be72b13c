//! Numbers that are solved for at once.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// What an equation is solved for: one number, or [several](Several).
pub trait Number:
    Copy
    + Default
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
{
    /// The numbers that each of several has: one after another, column by column.
    fn columns(of: impl Iterator<Item = Self>) -> Vec<Vec<f64>>;

    /// Several made of each column's numbers, the inverse of [`Number::columns`].
    fn rows(columns: &[Vec<f64>]) -> impl Iterator<Item = Self>;
}

impl Number for f64 {
    fn columns(of: impl Iterator<Item = f64>) -> Vec<Vec<f64>> {
        vec![of.collect()]
    }

    fn rows(columns: &[Vec<f64>]) -> impl Iterator<Item = f64> {
        columns.iter().flatten().copied()
    }
}

impl Number for Several {
    fn columns(of: impl Iterator<Item = Several>) -> Vec<Vec<f64>> {
        let all: Vec<Several> = of.collect();
        (0..Several::COUNT).map(|place| Several::row(&all, place)).collect()
    }

    fn rows(columns: &[Vec<f64>]) -> impl Iterator<Item = Several> {
        let length = columns.first().map_or(0, Vec::len);
        (0..length).map(|row| Several(std::array::from_fn(|place| columns[place][row])))
    }
}

/// Solutions of one equation on different right-hand sides. Each is what it would be alone: to the last
/// bit, unless their steady states are extrapolated, for which the last one to settle says when.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Several(pub [f64; Several::COUNT]);

impl Several {
    /// As many as the widest vectors have numbers.
    pub const COUNT: usize = 8;

    /// Turns at most [`Several::COUNT`] rows of one length into one row of several numbers each;
    /// those that lack are zero.
    pub fn interleaved(rows: &[&[f64]]) -> Vec<Several> {
        let length = rows.first().map_or(0, |row| row.len());
        let at = |at: usize| {
            let mut several = Several::default();
            several.0.iter_mut().zip(rows).for_each(|(value, row)| *value = row[at]);
            several
        };
        (0..length).map(at).collect()
    }

    /// The row of numbers that are at some place among the several.
    pub fn row(all: &[Several], place: usize) -> Vec<f64> {
        all.iter().map(|several| several.0[place]).collect()
    }
}

impl Default for Several {
    #[inline(always)]
    fn default() -> Several {
        Several([0.0; Several::COUNT])
    }
}

impl Add for Several {
    type Output = Several;
    #[inline(always)]
    fn add(mut self, other: Several) -> Several {
        self += other;
        self
    }
}

impl AddAssign for Several {
    #[inline(always)]
    fn add_assign(&mut self, other: Several) {
        for place in 0..Several::COUNT {
            self.0[place] += other.0[place];
        }
    }
}

impl Sub for Several {
    type Output = Several;
    #[inline(always)]
    fn sub(mut self, other: Several) -> Several {
        self -= other;
        self
    }
}

impl SubAssign for Several {
    #[inline(always)]
    fn sub_assign(&mut self, other: Several) {
        for place in 0..Several::COUNT {
            self.0[place] -= other.0[place];
        }
    }
}

impl Mul<f64> for Several {
    type Output = Several;
    #[inline(always)]
    fn mul(mut self, factor: f64) -> Several {
        keep_whole();
        for place in 0..Several::COUNT {
            self.0[place] *= factor;
        }
        self
    }
}

/// No instruction, but one that a loop over states is not made into vectors across: of several numbers, a vector as
/// they are, each would be gathered out of as many places.
#[inline(always)]
fn keep_whole() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: there is nothing in it.
    unsafe {
        std::arch::asm!("", options(nomem, nostack, preserves_flags));
    }
}

impl Neg for Several {
    type Output = Several;
    #[inline(always)]
    fn neg(mut self) -> Several {
        for place in 0..Several::COUNT {
            self.0[place] = -self.0[place];
        }
        self
    }
}
