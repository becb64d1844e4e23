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
//! The element with one mean dilatation, [`super::q4_bbar`], has the same points under the moduli D - k, and adds the forces
//! of its mean pressure.

use std::ops::Range;

use super::corners::{CornerRows, StrainPath, StrainState, row_constants};
use super::layout::Layout;
use super::modes::{Modes, plus_minus};
use super::points::{GEOMETRY, RowPoints, geometry};
use super::q4_bbar::{add_mean_pressure, deviatoric_moduli};
use super::row_forces::RowForces;
use super::shape::area;
use crate::material::Elastic;
use crate::material::nonlinear::NonlinearLaw;
use crate::mesh::Mesh;
use crate::pack::{LANES, Pack};

/// Constants of each element: those of [`geometry`], and t k / area for the mean pressure.
const CONSTANTS: usize = GEOMETRY + 1;

/// All elements of a mesh, with or without the mean dilatation.
#[derive(Clone, Debug)]
pub(super) struct Q4FourPoint {
    moduli: [f64; 3],
    mean_dilatation: bool,
    layout: Layout,
    thickness: f64,
    /// For each row of elements its constants, arrays of [`Layout::padded_columns`].
    constants: Vec<f64>,
}

impl Q4FourPoint {
    pub(super) fn new(
        mesh: &Mesh,
        layout: Layout,
        elastic: &Elastic,
        thickness: f64,
        mean_dilatation: bool,
    ) -> Q4FourPoint {
        let plain = |p: &[[f64; 2]; 4]| geometry(p, thickness);
        let with_pressure = |p: &[[f64; 2]; 4]| {
            let mut constants = [thickness * elastic.bulk() / area(p); CONSTANTS];
            constants[..GEOMETRY].copy_from_slice(&plain(p));
            constants
        };
        let (moduli, constants) = if mean_dilatation {
            let constants = row_constants(mesh, layout, with_pressure);
            (deviatoric_moduli(elastic), constants)
        } else {
            (elastic.moduli(), row_constants(mesh, layout, plain))
        };
        Q4FourPoint {
            moduli,
            mean_dilatation,
            layout,
            thickness,
            constants,
        }
    }

    /// The elements of a piece, their constants cut out by `cut`.
    pub(super) fn piece(&self, layout: Layout, cut: impl Fn(&[f64]) -> Vec<f64>) -> Q4FourPoint {
        Q4FourPoint {
            layout,
            constants: cut(&self.constants),
            ..*self
        }
    }

    /// Forces of the elements of a row under the displacements of its corners.
    #[inline(always)]
    pub(super) fn row(
        &self,
        row: usize,
        u: CornerRows,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        if self.mean_dilatation {
            self.row_of::<true>(row, u, columns, out);
        } else {
            self.row_of::<false>(row, u, columns, out);
        }
    }

    /// The branch for the mean dilatation stands outside the loop: inside it costs the q4_bbar a fifth of its time.
    #[inline(always)]
    fn row_of<const MEAN: bool>(
        &self,
        row: usize,
        u: CornerRows,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let constants = self.row_constants(row);
        for i in columns.step_by(LANES) {
            let u = Modes::both(&u.load(stride, i));
            let constant = |k: usize| Pack::load(constants, k * padded + i);
            let mut forces = integrate(&constant, u, self.moduli);
            if MEAN {
                add_mean_pressure(&constant, constant(GEOMETRY), u, &mut forces);
            }
            forces[0].store(out, i);
            forces[1].store(out, stride + i);
        }
    }

    /// Forces of the elements of a row under a nonlinear law.
    #[inline(always)]
    pub(super) fn nonlinear_row(
        &self,
        law: &NonlinearLaw,
        row: usize,
        path: StrainPath,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        let points = self.points(row);
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        points.forces(
            law,
            path,
            columns,
            #[inline(always)]
            |i, mut forces, u| {
                if self.mean_dilatation {
                    let constant = |k: usize| Pack::load(points.constants, k * padded + i);
                    add_mean_pressure(&constant, constant(GEOMETRY), u, &mut forces);
                }
                forces[0].store(out, i);
                forces[1].store(out, stride + i);
            },
        );
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

    fn row_constants(&self, row: usize) -> &[f64] {
        let size = self.constants.len() / self.layout.rows;
        &self.constants[row * size..(row + 1) * size]
    }

    fn points(&self, row: usize) -> RowPoints<'_> {
        RowPoints {
            constants: self.row_constants(row),
            layout: self.layout,
            moduli: self.moduli,
            thickness: self.thickness,
        }
    }
}

/// Forces f = sum over the four points of t J B^T s, s = D grad u; `constant` gives those of [`geometry`].
#[inline(always)]
pub(crate) fn integrate(
    constant: &impl Fn(usize) -> Pack,
    [x, y]: [Modes; 2],
    moduli: [f64; 3],
) -> [Modes; 2] {
    let [c11, c12, c33] = moduli.map(Pack::splat);
    let (bx, by) = (constant(4), constant(5));
    let zero = Pack::splat(0.0);
    let (mut fx, mut fy) = (Modes::default(), Modes::default());
    for upper in [false, true] {
        let u_xi = plus_minus(upper, x.xi, x.hourglass);
        let v_xi = plus_minus(upper, y.xi, y.hourglass);
        let x_xi = plus_minus(upper, constant(0), bx);
        let y_xi = plus_minus(upper, constant(1), by);
        let mut row = [zero; 2];
        for right in [false, true] {
            let u_eta = plus_minus(right, x.eta, x.hourglass);
            let v_eta = plus_minus(right, y.eta, y.hourglass);
            let x_eta = plus_minus(right, constant(2), bx);
            let y_eta = plus_minus(right, constant(3), by);
            let weight = constant(6 + 2 * usize::from(upper) + usize::from(right));

            let exx = u_xi * y_eta - u_eta * y_xi;
            let eyy = v_eta * x_xi - v_xi * x_eta;
            let shear = (u_eta * x_xi - u_xi * x_eta) + (v_xi * y_eta - v_eta * y_xi);
            let sxx = weight * (c11 * exx + c12 * eyy);
            let syy = weight * (c12 * exx + c11 * eyy);
            let sxy = weight * (c33 * shear);

            row[0] = row[0] + (sxx * y_eta - sxy * x_eta);
            row[1] = row[1] + (sxy * y_eta - syy * x_eta);
            fx.add_eta(right, sxy * x_xi - sxx * y_xi);
            fy.add_eta(right, syy * x_xi - sxy * y_xi);
        }
        fx.add_xi(upper, row[0]);
        fy.add_xi(upper, row[1]);
    }
    [fx, fy]
}
