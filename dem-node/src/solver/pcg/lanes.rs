//! Four numbers side by side.
//!
//! The compiler turns loops over many arrays into vector code only when it can prove that they do not overlap, and gives
//! up. Numbers that are loaded by value, and stored at the end, leave nothing to prove.

use std::ops::{Add, Mul, Neg, Sub};

/// Contacts in a group.
pub const LANES: usize = 4;

/// A number of each contact of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f64; LANES]);

/// A number of each contact of a group where seven digits are enough: half the bytes.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(16))]
pub struct Short(pub [f32; LANES]);

impl Short {
    /// All digits.
    #[inline(always)]
    pub fn wide(self) -> Lanes {
        Lanes(self.0.map(f64::from))
    }
}

/// Calls `work` where the compiler may use the widest registers that this machine and the build have; `work` must be
/// inlined. Every operation rounds as it does elsewhere, so the bits are the same.
#[inline(always)]
pub fn widest<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

impl Lanes {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(value: f64) -> Lanes {
        Lanes([value; LANES])
    }

    /// Sum of the lanes.
    pub fn sum(self) -> f64 {
        self.0.iter().sum()
    }

    /// Whether a lane is not the number 0.
    #[inline(always)]
    pub fn any(self) -> bool {
        let bits = self.0.map(f64::to_bits);
        (bits[0] | bits[1]) | (bits[2] | bits[3]) != 0
    }

    /// Within bounds, lane by lane; written so that a NaN stays one.
    #[inline(always)]
    pub fn clamp(self, low: Lanes, high: Lanes) -> Lanes {
        self.zip(low, |x, low| if x < low { low } else { x })
            .least(high)
    }

    /// The smaller one, lane by lane; a NaN of `self` stays one.
    #[inline(always)]
    pub fn least(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| if a > b { b } else { a })
    }

    /// What is left of a direction where the impulse is at a bound: nothing if it points outwards.
    ///
    /// Without short cuts: whether a contact slides cannot be foretold, and a wrong guess costs as much as the arithmetic.
    #[inline(always)]
    pub fn held(self, impulse: Lanes, low: Lanes, high: Lanes) -> Lanes {
        let infinity = f64::INFINITY;
        let down = impulse.zip(low, |r, low| if r <= low { 0.0 } else { -infinity });
        let up = impulse.zip(high, |r, high| if r >= high { 0.0 } else { infinity });
        self.clamp(down, up)
    }

    /// Both, lane by lane.
    #[inline(always)]
    pub fn zip(self, other: Lanes, combine: impl Fn(f64, f64) -> f64) -> Lanes {
        let mut lanes = self.0;
        for (lane, right) in lanes.iter_mut().zip(other.0) {
            *lane = combine(*lane, right);
        }
        Lanes(lanes)
    }
}

impl Add for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn add(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn sub(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn mul(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| a * b)
    }
}

impl Neg for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn neg(self) -> Lanes {
        Lanes(self.0.map(|a| -a))
    }
}
