//! Numbers side by side, one of each contact of a group.
//!
//! The compiler turns loops over many arrays into vector code only when it can prove that they do not overlap, and else gives up. Numbers that are
//! loaded by value, and stored at the end, leave nothing to prove.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or a number of each of several contacts: formulas over it hold for one contact and for contacts side by side, with the same bits.
pub trait Real:
    Copy
    + Default
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The same number for each contact.
    fn of(value: f64) -> Self;

    /// A function of each number.
    fn map(self, function: impl Fn(f64) -> f64) -> Self;

    /// A function of two numbers of each contact.
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self;

    /// The number of each contact in `yes` where the test of its own holds, else in `no`.
    fn choose(self, test: impl Fn(f64) -> bool, yes: Self, no: Self) -> Self;

    /// True if the test holds for any contact.
    fn any_is(self, test: impl Fn(f64) -> bool) -> bool;
}

impl Real for f64 {
    #[inline(always)]
    fn of(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn map(self, function: impl Fn(f64) -> f64) -> f64 {
        function(self)
    }

    #[inline(always)]
    fn zip(self, other: f64, function: impl Fn(f64, f64) -> f64) -> f64 {
        function(self, other)
    }

    #[inline(always)]
    fn choose(self, test: impl Fn(f64) -> bool, yes: f64, no: f64) -> f64 {
        if test(self) { yes } else { no }
    }

    #[inline(always)]
    fn any_is(self, test: impl Fn(f64) -> bool) -> bool {
        test(self)
    }
}

impl<const N: usize> Real for Lanes<N> {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Lanes::splat(value)
    }

    #[inline(always)]
    fn map(self, function: impl Fn(f64) -> f64) -> Self {
        self.zip(self, |x, _| function(x))
    }

    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        Lanes::zip(self, other, function)
    }

    #[inline(always)]
    fn choose(self, test: impl Fn(f64) -> bool, yes: Self, no: Self) -> Self {
        let mut lanes = yes.0;
        for (k, lane) in lanes.iter_mut().enumerate() {
            *lane = if test(self.0[k]) { *lane } else { no.0[k] };
        }
        Lanes(lanes)
    }

    #[inline(always)]
    fn any_is(self, test: impl Fn(f64) -> bool) -> bool {
        self.0.iter().fold(false, |any, x| any | test(*x))
    }
}

/// A number of each of N contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Default for Lanes<N> {
    fn default() -> Self {
        Lanes([0.0; N])
    }
}

/// A number of each contact of a group where seven digits are enough: half the bytes.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub struct ShortLanes<const N: usize>(pub [f32; N]);

impl<const N: usize> Default for ShortLanes<N> {
    fn default() -> Self {
        ShortLanes([0.0; N])
    }
}

impl<const N: usize> ShortLanes<N> {
    /// The same numbers as f64.
    #[inline(always)]
    pub fn wide(self) -> Lanes<N> {
        Lanes(self.0.map(f64::from))
    }
}

/// Does `work` where the compiler may use the widest registers that this machine and the build have. Every function that it calls must be marked
/// `#[inline(always)]`, or it is compiled for the narrow registers. Every operation rounds as elsewhere, so the bits are the same. `work` is the body
/// of a closure: a `return` leaves only it.
macro_rules! widest {
    ($work:expr) => {
        $crate::law::lanes::dispatch(
            #[inline(always)]
            || $work,
        )
    };
}
pub(crate) use widest;

/// Calls `work`. The bound shows the compiler that the closure is called once, which it then inlines.
#[inline(always)]
pub(crate) fn dispatch<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

impl<const N: usize> Lanes<N> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Lanes([value; N])
    }

    /// Sum of the lanes.
    pub fn sum(self) -> f64 {
        self.0.iter().sum()
    }

    /// True if a lane is not the number 0.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.iter().fold(0, |bits, x| bits | x.to_bits()) != 0
    }

    /// Within bounds, lane by lane; written so that a NaN stays NaN.
    #[inline(always)]
    pub fn clamp(self, low: Self, high: Self) -> Self {
        self.zip(low, |x, low| if x < low { low } else { x })
            .least(high)
    }

    /// The smaller number, lane by lane; a NaN of `self` stays NaN.
    #[inline(always)]
    pub fn least(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { b } else { a })
    }

    /// Combination of both, lane by lane.
    #[inline(always)]
    pub fn zip(self, other: Self, combine: impl Fn(f64, f64) -> f64) -> Self {
        let mut lanes = self.0;
        for (lane, right) in lanes.iter_mut().zip(other.0) {
            *lane = combine(*lane, right);
        }
        Lanes(lanes)
    }
}

macro_rules! lane_by_lane {
    ($operator:ident, $method:ident, $symbol:tt) => {
        impl<const N: usize> $operator for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $symbol b)
            }
        }
    };
}

lane_by_lane!(Add, add, +);
lane_by_lane!(Sub, sub, -);
lane_by_lane!(Mul, mul, *);
lane_by_lane!(Div, div, /);

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes(self.0.map(|a| -a))
    }
}
