//! Packs of four doubles.
//!
//! The compiler turns loops over whole rows into vector code only when it can prove that a dozen slices do
//! not overlap, and gives up. Loading a few numbers of each slice by value, computing, and storing them at
//! the end leaves nothing to prove.

use std::ops::{Add, Div, Mul, Sub};

use protocol::larger;

/// Numbers in a [`Pack`]: two registers of the baseline x86-64, one of AVX.
pub(crate) const LANES: usize = 4;

/// Calls `work` where the compiler may use the widest vector registers that this machine and the build have; `work` must be
/// inlined. Every operation rounds as it does elsewhere, so the bits are the same.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// `LANES` neighbouring numbers of a row.
#[derive(Clone, Copy, Default)]
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

/// The largest of these, none being negative; not a number if any is not.
pub(crate) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, larger)
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
