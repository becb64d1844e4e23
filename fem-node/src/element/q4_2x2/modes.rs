//! Bilinear fields by their parts along xi, eta and xi eta.

use crate::element::GAUSS;
use crate::element::row::{Corners, RowForces};
use crate::pack::Pack;

/// A bilinear field of a pack of elements, or the forces that do work on it: parts along xi, eta and xi eta.
#[derive(Clone, Copy, Default)]
pub(in crate::element) struct Modes {
    pub(in crate::element) xi: Pack,
    pub(in crate::element) eta: Pack,
    pub(in crate::element) hourglass: Pack,
}

impl Modes {
    /// Four times the slopes, that of xi eta taken at a Gauss point.
    #[inline(always)]
    pub(in crate::element) fn of(corners: &Corners) -> Modes {
        let (xi, eta) = corners.natural();
        Modes {
            xi,
            eta,
            hourglass: Pack::splat(GAUSS) * corners.hourglass(),
        }
    }

    /// Of both components.
    #[inline(always)]
    pub(in crate::element) fn both([x, y]: &[Corners; 2]) -> [Modes; 2] {
        [Modes::of(x), Modes::of(y)]
    }

    #[inline(always)]
    pub(super) fn add_xi(&mut self, upper: bool, xi: Pack) {
        self.xi = self.xi + xi;
        self.hourglass = along(upper, self.hourglass, xi);
    }

    #[inline(always)]
    pub(super) fn add_eta(&mut self, right: bool, eta: Pack) {
        self.eta = self.eta + eta;
        self.hourglass = along(right, self.hourglass, eta);
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
    pub(in crate::element) fn store(&self, out: &mut RowForces, i: usize) {
        let first = Pack::splat(0.0) - self.xi - self.eta;
        let hourglass = Pack::splat(GAUSS) * self.hourglass;
        out.store(i, first, self.xi - self.eta, hourglass);
    }
}

/// `mean` with `slope` added or taken off.
#[inline(always)]
pub(super) fn along(positive: bool, mean: Pack, slope: Pack) -> Pack {
    match positive {
        true => mean + slope,
        false => mean - slope,
    }
}
