//! Bilinear fields as sums of their modes along xi, eta and xi eta.

use super::corners::Corners;
use super::row_forces::CornerForces;
use super::shape::GAUSS;
use crate::pack::lanes::{Lanes, Pack};

/// A bilinear field of a pack of elements, or the forces that do work on it: parts along xi, eta and xi eta.
#[derive(Clone, Copy, Default)]
pub(crate) struct Modes<V = Pack> {
    pub(super) xi: V,
    pub(super) eta: V,
    pub(super) hourglass: V,
}

impl<V: Lanes> Modes<V> {
    /// Modes of a zero field.
    #[inline(always)]
    pub(super) fn zero(zero: V) -> Modes<V> {
        Modes {
            xi: zero,
            eta: zero,
            hourglass: zero,
        }
    }

    /// Four times the slopes, the slope of xi eta taken at a Gauss point.
    #[inline(always)]
    pub(super) fn of(corners: &Corners<V>) -> Modes<V> {
        let (xi, eta) = corners.natural();
        Modes {
            xi,
            eta,
            hourglass: xi.all(GAUSS) * corners.hourglass(),
        }
    }

    /// Modes of both components.
    #[inline(always)]
    pub(super) fn both([x, y]: &[Corners<V>; 2]) -> [Modes<V>; 2] {
        [Modes::of(x), Modes::of(y)]
    }

    #[inline(always)]
    pub(super) fn add_xi(&mut self, upper: bool, xi: V) {
        self.xi = self.xi + xi;
        self.hourglass = plus_minus(upper, self.hourglass, xi);
    }

    #[inline(always)]
    pub(super) fn add_eta(&mut self, right: bool, eta: V) {
        self.eta = self.eta + eta;
        self.hourglass = plus_minus(right, self.hourglass, eta);
    }

    /// Sum over the corners of the product of the forces with a field.
    #[inline(always)]
    pub(super) fn work(&self, field: &Modes<V>) -> V {
        (self.xi * field.xi + self.eta * field.eta) + self.hourglass * field.hourglass
    }

    /// Forces on the corners.
    #[inline(always)]
    pub(super) fn on_corners(&self) -> CornerForces<V> {
        CornerForces {
            first: self.xi.all(0.0) - self.xi - self.eta,
            second: self.xi - self.eta,
            hourglass: self.xi.all(GAUSS) * self.hourglass,
        }
    }
}

/// `mean` with `slope` added or subtracted.
#[inline(always)]
pub(super) fn plus_minus<V: Lanes>(positive: bool, mean: V, slope: V) -> V {
    if positive { mean + slope } else { mean - slope }
}
