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

mod modes;
mod points;

use super::row::{CornerRows, Course, RowForces, Standing, row_numbers};
use super::stiffness::Stiffness;
use crate::element::{GAUSS, GAUSS_POINTS, Layout, jacobian, slopes};
use crate::material::Elastic;
use crate::material::point::PointLaw;
use crate::mesh::Mesh;
use crate::pack::{LANES, Pack, widest};
pub(super) use modes::Modes;
use modes::along;
pub(super) use points::RowPoints;

/// Numbers kept for each element: the means of x,xi, y,xi, x,eta, y,eta; the slopes of x and y in xi eta at a Gauss
/// point; t / 16 J at the four points.
pub(super) const NUMBERS: usize = 10;

/// All elements of a block.
#[derive(Clone, Debug)]
pub(super) struct Q4Full {
    moduli: [f64; 3],
    layout: Layout,
    thickness: f64,
    numbers: Vec<f64>,
}

impl Q4Full {
    pub(super) fn new(mesh: &Mesh, layout: Layout, elastic: &Elastic, thickness: f64) -> Q4Full {
        Q4Full {
            moduli: [elastic.c11, elastic.c12, elastic.c33],
            layout,
            thickness,
            numbers: row_numbers(mesh, layout, |p| geometry(p, thickness)),
        }
    }

    /// Forces of the elements of a row under the displacements of its corners.
    pub(super) fn row(&self, row: usize, u: CornerRows, out: &mut RowForces) {
        let padded = self.layout.padded_columns();
        let stride = self.layout.element_stride();
        let numbers = &self.numbers[row * NUMBERS * padded..(row + 1) * NUMBERS * padded];
        widest(
            #[inline(always)]
            || {
                for i in (0..padded).step_by(LANES) {
                    let modes = Modes::both(&u.load(stride, i));
                    let number = |k: usize| Pack::load(numbers, k * padded + i);
                    let [fx, fy] = integrate(&number, modes, self.moduli);
                    fx.store(out, i);
                    fy.store(out, stride + i);
                }
            },
        );
    }
}

impl Q4Full {
    /// Like [`Q4Full::row`] under any law; returns what was dissipated (J).
    pub(super) fn row_by(
        &self,
        law: &PointLaw,
        row: usize,
        course: Course,
        out: &mut RowForces,
    ) -> f64 {
        let points = self.points(row);
        widest(
            #[inline(always)]
            || {
                points.forces(
                    law,
                    course,
                    #[inline(always)]
                    |i, [fx, fy], _| {
                        fx.store(out, i);
                        fy.store(out, self.layout.element_stride() + i);
                    },
                )
            },
        )
    }

    /// Stored energy less u F / 2 (J) of a row, [`PointLaw::energy_beyond`].
    pub(super) fn energy_beyond(&self, law: &PointLaw, row: usize, now: Standing) -> f64 {
        self.points(row).energy_beyond(law, now)
    }

    fn points(&self, row: usize) -> RowPoints<'_> {
        let padded = self.layout.padded_columns();
        RowPoints {
            numbers: &self.numbers[row * NUMBERS * padded..(row + 1) * NUMBERS * padded],
            layout: self.layout,
            moduli: self.moduli,
            thickness: self.thickness,
        }
    }
}

/// Forces of the stress D grad u, integrated over the four points; `number` gives those of [`geometry`].
#[inline(always)]
pub(super) fn integrate(
    number: &impl Fn(usize) -> Pack,
    [x, y]: [Modes; 2],
    moduli: [f64; 3],
) -> [Modes; 2] {
    let [c11, c12, c33] = splat3(moduli);
    let (bx, by) = (number(4), number(5));
    let zero = Pack::splat(0.0);
    let (mut fx, mut fy) = (Modes::default(), Modes::default());
    for upper in [false, true] {
        let u_xi = along(upper, x.xi, x.hourglass);
        let v_xi = along(upper, y.xi, y.hourglass);
        let x_xi = along(upper, number(0), bx);
        let y_xi = along(upper, number(1), by);
        let mut row = [zero; 2];
        for right in [false, true] {
            let u_eta = along(right, x.eta, x.hourglass);
            let v_eta = along(right, y.eta, y.hourglass);
            let x_eta = along(right, number(2), bx);
            let y_eta = along(right, number(3), by);
            let weight = number(6 + 2 * usize::from(upper) + usize::from(right));

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

#[inline(always)]
fn splat3([a, b, c]: [f64; 3]) -> [Pack; 3] {
    [Pack::splat(a), Pack::splat(b), Pack::splat(c)]
}

/// See [`NUMBERS`].
pub(super) fn geometry(p: &[[f64; 2]; 4], thickness: f64) -> [f64; NUMBERS] {
    let mean = |k: usize, signs: [f64; 4]| 0.25 * (0..4).map(|a| signs[a] * p[a][k]).sum::<f64>();
    let (s, t, h) = (
        [-1.0, 1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0, -1.0],
    );
    let weight = |xi: f64, eta: f64| thickness / (16.0 * jacobian(p, [xi, eta]));
    [
        mean(0, s),
        mean(1, s),
        mean(0, t),
        mean(1, t),
        GAUSS * mean(0, h),
        GAUSS * mean(1, h),
        weight(-GAUSS, -GAUSS),
        weight(GAUSS, -GAUSS),
        weight(-GAUSS, GAUSS),
        weight(GAUSS, GAUSS),
    ]
}

/// K = sum over the points of t J B^T D B.
pub(super) fn stiffness(p: &[[f64; 2]; 4], moduli: [f64; 3], thickness: f64) -> Stiffness {
    let mut k = Stiffness::default();
    for natural in GAUSS_POINTS {
        k.add_material(
            &slopes(p, natural),
            moduli,
            thickness * jacobian(p, natural),
        );
    }
    k
}
