//! Bilinear quadrilateral with 2 x 2 Gauss points.
//!
//! Natural coordinates (xi, eta), corners at (s_a, t_a) = (-1,-1), (1,-1), (1,1), (-1,1). Every bilinear field has
//!
//! ```text
//! 4 u,xi  = U_xi  + eta U_h      U_xi  = sum s_a u_a,  U_eta = sum t_a u_a,  U_h = sum s_a t_a u_a
//! 4 u,eta = U_eta + xi  U_h
//! ```
//!
//! and so has the geometry. With J = x,xi y,eta - x,eta y,xi the gradient is u,x = (u,xi y,eta - u,eta y,xi) / J,
//! u,y = (u,eta x,xi - u,xi x,eta) / J, and the virtual work of the stress s at a Gauss point, whose weight is 1, is
//!
//! ```text
//! t J s:grad(du) = q_xi . du,xi + q_eta . du,eta
//! q_xi,i  = t (s_ix y,eta - s_iy x,eta)
//! q_eta,i = t (s_iy x,xi - s_ix y,xi)
//! f_a = sum over the points of [s_a q_xi + t_a q_eta + s_a t_a (eta q_xi + xi q_eta)] / 4
//! ```
//!
//! Only six numbers of geometry and J at the four points are needed, in place of four gradients of eight numbers.
//!
//! # Yield
//! In plane strain s : e = k (tr e)^2 + 2 mu dev e : dev e, k the bulk modulus. The work t J s : e is at least 0 at each point, and the sum over the
//! points is the work u f of the nodal forces, so that everywhere in an element without plastic strain
//!
//! ```text
//! 2 dev e : dev e <= u f / (mu t min J)
//! ```
//!
//! This bound of the trial stress costs a dozen operations. In a uniform deformation it is too large by a factor of four, the number of points, and
//! by the work of the pressure. The forces below serve plasticity as well, with the stress of each point reduced by 2 mu p: an element without
//! plastic strain has the same bits under both laws.
//!
//! The element with one mean dilatation, [`super::q4_bbar`], has the same points under the moduli D - k, and adds the forces
//! of its mean pressure.

use std::ops::Range;

use super::constants::Constants;
use super::corners::{Corners, StrainPath, StrainState};
use super::gauss::{CONSTANTS, GEOMETRY, geometry, integrate};
use super::layout::Layout;
use super::linear::{LIMIT_SHARE, LinearElements};
use super::modes::Modes;
use super::points::{RowPoints, YieldCandidates};
use super::q4_bbar::{add_mean_pressure, deviatoric_moduli};
use super::row_forces::{CornerForces, RowForces};
use crate::material::Elastic;
use crate::material::j2::J2;
use crate::material::nonlinear::NonlinearLaw;
use crate::mesh::{Mesh, area};
use crate::pack::lanes::{LANES, Lanes, Pack, Registers};

/// All elements of a mesh, with or without the mean dilatation.
#[derive(Clone, Debug)]
pub(super) struct Q4FourPoint {
    moduli: [f64; 3],
    pub(super) mean_dilatation: bool,
    layout: Layout,
    thickness: f64,
    constants: Constants<CONSTANTS>,
}

impl Q4FourPoint {
    pub(super) fn new(
        mesh: &Mesh,
        layout: Layout,
        elastic: &Elastic,
        thickness: f64,
        mean_dilatation: bool,
    ) -> Q4FourPoint {
        let of_element = |p: &[[f64; 2]; 4]| {
            let mut constants = [thickness * elastic.bulk() / area(p); CONSTANTS];
            constants[..GEOMETRY].copy_from_slice(&geometry(p, thickness));
            constants
        };
        let moduli = if mean_dilatation {
            deviatoric_moduli(elastic)
        } else {
            elastic.moduli()
        };
        Q4FourPoint {
            moduli,
            mean_dilatation,
            layout,
            thickness,
            constants: Constants::new(mesh, layout, of_element),
        }
    }

    /// The elements of the piece whose first column of elements is `first`.
    pub(super) fn piece(&self, layout: Layout, first: usize) -> Q4FourPoint {
        Q4FourPoint {
            layout,
            constants: self.constants.piece(layout, first),
            ..*self
        }
    }

    /// Forces of the elements of a row that flow or have flowed, in whole packs, under plasticity: their excess is above 0, and infinite if any
    /// element of the pack has flowed.
    #[inline(always)]
    pub(super) fn plastic_row(
        &self,
        plastic: &J2,
        row: usize,
        path: StrainPath,
        candidates: YieldCandidates,
        out: &mut RowForces,
    ) {
        let points = self.points(row);
        points.plastic_forces(
            plastic,
            path,
            candidates,
            #[inline(always)]
            |i, forces, u| self.store(&points, i, (forces, u), out),
        );
    }

    /// Forces of the elements of a row under large rotations.
    #[inline(always)]
    pub(super) fn corotational_row(
        &self,
        row: usize,
        path: StrainPath,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        let points = self.points(row);
        points.corotational_forces(
            path,
            columns,
            #[inline(always)]
            |i, forces, u| self.store(&points, i, (forces, u), out),
        );
    }

    /// Stores the forces of the pack of elements from `i` on, with the forces of the mean pressure.
    #[inline(always)]
    fn store(
        &self,
        points: &RowPoints,
        i: usize,
        (mut forces, u): ([Modes; 2], [Modes; 2]),
        out: &mut RowForces,
    ) {
        if self.mean_dilatation {
            add_mean_pressure(&points.constants[i / LANES], u, &mut forces);
        }
        out.store(i, forces[0].on_corners());
        out.store(self.layout.element_stride() + i, forces[1].on_corners());
    }

    /// Stored energy less u F / 2 (J) of a row, [`NonlinearLaw::energy_correction`].
    pub(super) fn energy_correction(
        &self,
        law: &NonlinearLaw,
        row: usize,
        now: StrainState,
    ) -> f64 {
        self.points(row).energy_correction(law, now)
    }

    fn points(&self, row: usize) -> RowPoints<'_> {
        RowPoints {
            constants: self.constants.row(row),
            layout: self.layout,
            moduli: self.moduli,
            thickness: self.thickness,
        }
    }
}

/// The elements under a linear law. The branch for the mean dilatation is outside the loops: inside it costs the q4_bbar a fifth of its time.
pub(super) struct Linear<'a, const MEAN: bool>(pub(super) &'a Q4FourPoint);

impl<const MEAN: bool> LinearElements for Linear<'_, MEAN> {
    type Constants = [Pack; CONSTANTS];

    fn constants(&self, row: usize) -> &[Self::Constants] {
        self.0.constants.row(row)
    }

    /// The excess of u f max w, w = t / 16 J being the weight of a point, without the work of the mean pressure.
    #[inline(always)]
    fn forces_and_excess<R: Registers>(
        &self,
        registers: R,
        (constants, p): (&[Self::Constants], usize),
        u: [Corners<R::Vector>; 2],
        limit: f64,
    ) -> ([CornerForces<R::Vector>; 2], R::Vector) {
        let (u, constants) = (Modes::both(&u), registers.load_all(constants, p));
        let mut forces = integrate(&constants, u, self.0.moduli, elastic);
        let work = forces[0].work(&u[0]) + forces[1].work(&u[1]);
        let [.., w1, w2, w3, w4, _] = constants;
        let largest = w1.larger(w2).larger(w3.larger(w4));
        if MEAN {
            add_mean_pressure(&constants, u, &mut forces);
        }
        (
            [forces[0].on_corners(), forces[1].on_corners()],
            largest * work - registers.splat(limit),
        )
    }

    /// 2 dev e : dev e <= 16 u f max w / (mu t^2)
    fn limit(&self, plastic: &J2) -> f64 {
        let t = self.0.thickness;
        LIMIT_SHARE * plastic.shear_limit() * plastic.mu * t * t / 16.0
    }
}

/// The stress of a point without plastic strain.
#[inline(always)]
fn elastic<V>(_: usize, _: [V; 3], stress: [V; 3]) -> [V; 3] {
    stress
}
