//! Bilinear fields as sums of their modes along xi, eta and xi eta.

use super::corners::Corners;
use super::row_forces::RowForces;
use super::shape::GAUSS;
use crate::pack::Pack;

/// A bilinear field of a pack of elements, or the forces that do work on it: parts along xi, eta and xi eta.
#[derive(Clone, Copy, Default)]
pub(crate) struct Modes {
    pub(super) xi: Pack,
    pub(super) eta: Pack,
    pub(super) hourglass: Pack,
}

impl Modes {
    /// Four times the slopes, that of xi eta taken at a Gauss point.
    #[inline(always)]
    pub(super) fn of(corners: &Corners) -> Modes {
        let (xi, eta) = corners.natural();
        Modes {
            xi,
            eta,
            hourglass: Pack::splat(GAUSS) * corners.hourglass(),
        }
    }

    /// Modes of both components.
    #[inline(always)]
    pub(super) fn both([x, y]: &[Corners; 2]) -> [Modes; 2] {
        [Modes::of(x), Modes::of(y)]
    }

    #[inline(always)]
    pub(super) fn add_xi(&mut self, upper: bool, xi: Pack) {
        self.xi = self.xi + xi;
        self.hourglass = plus_minus(upper, self.hourglass, xi);
    }

    #[inline(always)]
    pub(super) fn add_eta(&mut self, right: bool, eta: Pack) {
        self.eta = self.eta + eta;
        self.hourglass = plus_minus(right, self.hourglass, eta);
    }

    #[inline(always)]
    pub(super) fn scaled(self, factor: Pack) -> Modes {
        Modes {
            xi: factor * self.xi,
            eta: factor * self.eta,
            hourglass: factor * self.hourglass,
        }
    }

    /// Hands the forces to the corners.
    #[inline(always)]
    pub(super) fn store(&self, out: &mut RowForces, i: usize) {
        let first = Pack::splat(0.0) - self.xi - self.eta;
        let hourglass = Pack::splat(GAUSS) * self.hourglass;
        out.store(i, first, self.xi - self.eta, hourglass);
    }
}

/// `mean` with `slope` added or taken off.
#[inline(always)]
pub(super) fn plus_minus(positive: bool, mean: Pack, slope: Pack) -> Pack {
    if positive { mean + slope } else { mean - slope }
}
