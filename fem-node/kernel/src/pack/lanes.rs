//! Vectors of four doubles, and the registers that hold them.

use std::ops::{Add, Div, Mul, Sub};

/// Numbers in a [`Pack`]: two registers of the baseline x86-64, one of AVX.
pub(crate) const LANES: usize = 4;

/// Vectors of one pack or several side by side, computed lane by lane, each operation rounded as for a double.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// The same number in every lane.
    fn all(self, value: f64) -> Self;

    /// The larger one, lane by lane; `other` where either is NaN.
    fn larger(self, other: Self) -> Self;

    /// Writes the packs from the `p`th on.
    fn put(self, packs: &mut [[f64; LANES]], p: usize);
}

/// Vector registers, from which [`Lanes`] come.
pub(crate) trait Registers: Copy {
    /// Their vectors.
    type Vector: Lanes;

    /// Registers of the same machine for one pack.
    type Single: Registers;

    /// Packs in a vector.
    const PACKS: usize;

    /// The registers for one pack.
    fn single(self) -> Self::Single;

    /// The same number in every lane.
    fn splat(self, value: f64) -> Self::Vector;

    /// Packs side by side, by their number in the vector.
    fn vector(self, pack: impl Fn(usize) -> [f64; LANES]) -> Self::Vector;

    /// The packs from the `p`th on.
    #[inline(always)]
    fn load(self, packs: &[[f64; LANES]], p: usize) -> Self::Vector {
        self.vector(
            #[inline(always)]
            |pack| packs[p + pack],
        )
    }

    /// All numbers of the packs from the `p`th on. A loop, which is unrolled: `map` on an array is a call, and all vectors would pass through memory.
    #[inline(always)]
    fn load_all<const N: usize>(self, packs: &[[Pack; N]], p: usize) -> [Self::Vector; N] {
        let mut vectors = [self.splat(0.0); N];
        for (k, vector) in vectors.iter_mut().enumerate() {
            *vector = self.vector(
                #[inline(always)]
                |pack| packs[p + pack][k].0,
            );
        }
        vectors
    }
}

/// A computation that is compiled for each kind of registers.
pub(crate) trait InRegisters {
    /// Runs it; must be inlined.
    fn run<R: Registers>(self, registers: R);
}

/// A computation by packs, as many at a time as a vector has.
pub(crate) trait ByPacks {
    /// Computes the packs from the `p`th on; must be inlined.
    fn at<R: Registers>(&mut self, registers: R, p: usize);

    /// Computes this many packs.
    #[inline(always)]
    fn over<R: Registers>(&mut self, registers: R, packs: usize) {
        let whole = packs - packs % R::PACKS;
        for p in (0..whole).step_by(R::PACKS) {
            self.at(registers, p);
        }
        for p in whole..packs {
            self.at(registers.single(), p);
        }
    }
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

    /// True where any lane is above the lane of `other`.
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

    #[inline(always)]
    fn larger(self, other: Pack) -> Pack {
        self.max(other)
    }

    #[inline(always)]
    fn put(self, packs: &mut [[f64; LANES]], p: usize) {
        packs[p] = self.0;
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
