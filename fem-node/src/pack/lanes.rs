//! Vectors of four doubles, and the registers that hold them.

use std::ops::{Add, Div, Mul, Sub};

/// Numbers in a [`Pack`]: two registers of the baseline x86-64, one of AVX.
pub(crate) const LANES: usize = 4;

/// Vectors of [`LANES`] numbers, computed lane by lane, each operation rounded as that of a double.
pub(crate) trait Lanes:
    Copy + Into<[f64; LANES]> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// The same number in every lane.
    fn all(self, value: f64) -> Self;
}

/// Vector registers, from which [`Lanes`] come.
pub(crate) trait Registers: Copy {
    /// Their vectors.
    type Vector: Lanes;

    /// A vector of these numbers.
    fn load(self, numbers: &[f64; LANES]) -> Self::Vector;

    /// The same number in every lane.
    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.load(&[value; LANES])
    }

    /// Vectors of all these packs. A loop, which is unrolled: the `map` of an array is a call, and all of them would pass
    /// through memory.
    #[inline(always)]
    fn load_all<const N: usize>(self, packs: &[Pack; N]) -> [Self::Vector; N] {
        let mut vectors = [self.splat(0.0); N];
        for (vector, pack) in vectors.iter_mut().zip(packs) {
            *vector = self.load(&pack.0);
        }
        vectors
    }
}

/// A computation that is compiled for each kind of registers.
pub(crate) trait InRegisters {
    /// Runs it; must be inlined.
    fn run<R: Registers>(self, registers: R);
}

/// `LANES` neighbouring numbers of a row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pack(pub [f64; LANES]);

impl Pack {
    /// The same number in every lane.
    #[inline(always)]
    pub(crate) fn splat(value: f64) -> Pack {
        Pack([value; LANES])
    }

    /// The numbers from `at` on.
    #[inline(always)]
    pub(crate) fn load(row: &[f64], at: usize) -> Pack {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&row[at..at + LANES]);
        Pack(lanes)
    }

    /// Writes the numbers from `at` on.
    #[inline(always)]
    pub(crate) fn store(self, row: &mut [f64], at: usize) {
        row[at..at + LANES].copy_from_slice(&self.0);
    }

    /// Writes the first `count` numbers, at most all of them, from `at` on.
    #[inline(always)]
    pub(crate) fn store_up_to(self, count: usize, row: &mut [f64], at: usize) {
        if count >= LANES {
            self.store(row, at);
        } else {
            row[at..at + count].copy_from_slice(&self.0[..count]);
        }
    }

    /// Adds to the numbers from `at` on.
    #[inline(always)]
    pub(crate) fn add_to(self, row: &mut [f64], at: usize) {
        (Pack::load(row, at) + self).store(row, at);
    }

    /// Sum of the lanes, pairwise.
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        (self.0[0] + self.0[2]) + (self.0[1] + self.0[3])
    }

    /// Square root of each lane.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Pack {
        self.zip(self, |a, _| a.sqrt())
    }

    /// The larger one, lane by lane.
    #[inline(always)]
    pub(crate) fn max(self, other: Pack) -> Pack {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// `other` in the lanes that are positive, zero in the rest.
    #[inline(always)]
    pub(crate) fn if_positive(self, other: Pack) -> Pack {
        self.zip(other, |a, b| if a > 0.0 { b } else { 0.0 })
    }

    /// True where any lane is above that of `other`.
    #[inline(always)]
    pub(crate) fn any_above(self, other: Pack) -> bool {
        let above = self.zip(other, |a, b| if a > b { 1.0 } else { 0.0 });
        above.sum() > 0.0
    }

    #[inline(always)]
    fn zip(self, other: Pack, combine: impl Fn(f64, f64) -> f64) -> Pack {
        let mut lanes = self.0;
        for (lane, right) in lanes.iter_mut().zip(other.0) {
            *lane = combine(*lane, right);
        }
        Pack(lanes)
    }
}

impl Lanes for Pack {
    #[inline(always)]
    fn all(self, value: f64) -> Pack {
        Pack::splat(value)
    }
}

impl From<Pack> for [f64; LANES] {
    #[inline(always)]
    fn from(pack: Pack) -> [f64; LANES] {
        pack.0
    }
}

macro_rules! lane_by_lane {
    ($($operator:ident $function:ident $symbol:tt),*) => {$(
        impl $operator for Pack {
            type Output = Pack;
            #[inline(always)]
            fn $function(self, other: Pack) -> Pack {
                self.zip(other, |a, b| a $symbol b)
            }
        }
    )*};
}

lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);
