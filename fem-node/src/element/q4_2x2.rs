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

use super::row::{Corners, Course, RowForces, Standing, load_corners, row_numbers};
use super::stiffness::Stiffness;
use crate::element::{GAUSS, GAUSS_POINTS, Layout, jacobian, slopes};
use crate::material::Elastic;
use crate::material::point::{Gradient, PointLaw};
use crate::mesh::Mesh;
use crate::pack::{LANES, Pack};

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

    /// Forces of the elements of a row, between the displacements of two rows of nodes.
    pub(super) fn row(&self, row: usize, upper: &[f64], lower: &[f64], out: &mut RowForces) {
        let padded = self.layout.padded_columns();
        let stride = self.layout.stride();
        let numbers = &self.numbers[row * NUMBERS * padded..(row + 1) * NUMBERS * padded];
        let (ux4, uy4) = upper.split_at(stride);
        let (ux1, uy1) = lower.split_at(stride);
        for i in (0..padded).step_by(LANES) {
            let x = Modes::of(&Corners::load(ux1, ux4, i));
            let y = Modes::of(&Corners::load(uy1, uy4, i));
            let number = |k: usize| Pack::load(numbers, k * padded + i);
            let [fx, fy] = integrate(&number, [x, y], self.moduli);
            fx.store(out, i);
            fy.store(out, stride + i);
        }
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
        points.forces(law, course, |i, [fx, fy], _| {
            fx.store(out, i);
            fy.store(out, self.layout.stride() + i);
        })
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

/// The four points of all elements of a row, under any law.
pub(super) struct RowPoints<'a> {
    /// Those of [`geometry`] come first.
    pub(super) numbers: &'a [f64],
    pub(super) layout: Layout,
    pub(super) moduli: [f64; 3],
    pub(super) thickness: f64,
}

/// Derivatives of the position at a point of a pack of elements, and t / 16 J.
struct Place {
    x_xi: Pack,
    y_xi: Pack,
    x_eta: Pack,
    y_eta: Pack,
    weight: Pack,
    upper: bool,
    right: bool,
}

impl RowPoints<'_> {
    /// Forces by packs of elements, handed to `store` with the modes of the displacement; returns what was
    /// dissipated (J).
    #[inline(always)]
    pub(super) fn forces(
        &self,
        law: &PointLaw,
        mut course: Course,
        mut store: impl FnMut(usize, [Modes; 2], [Modes; 2]),
    ) -> f64 {
        let (padded, stride) = (self.layout.padded_columns(), self.layout.stride());
        let mut dissipated = Pack::splat(0.0);
        for i in (0..padded).step_by(LANES) {
            let u = load_corners(course.u, stride, i).map(|corners| Modes::of(&corners));
            let du = course.du;
            let mut force = [Modes::default(); 2];
            for point in 0..4 {
                let place = self.place(point, i);
                let increment = || {
                    let du = load_corners(du, stride, i).map(|corners| Modes::of(&corners));
                    place.gradient(&du, self.thickness)
                };
                let gradient = place.gradient(&u, self.thickness);
                let history = &mut course.point(point, padded);
                let response = law.respond(self.moduli, gradient, increment, history, i);
                dissipated = dissipated + place.volume(self.thickness) * response.dissipated;
                place.add(response.stress, self.thickness, &mut force);
            }
            store(i, force, u);
        }
        dissipated.sum()
    }

    pub(super) fn energy_beyond(&self, law: &PointLaw, now: Standing) -> f64 {
        let (padded, stride) = (self.layout.padded_columns(), self.layout.stride());
        let mut sum = Pack::splat(0.0);
        for i in (0..padded).step_by(LANES) {
            let u = load_corners(now.u, stride, i).map(|corners| Modes::of(&corners));
            for point in 0..4 {
                let place = self.place(point, i);
                let gradient = place.gradient(&u, self.thickness);
                let past = now.past(point, padded, i);
                let energy = law.energy_beyond(self.moduli, gradient, past);
                sum = sum + place.volume(self.thickness) * energy;
            }
        }
        sum.sum()
    }

    /// Points in the order of the weights: (-, -), (+, -), (-, +), (+, +).
    #[inline(always)]
    fn place(&self, point: usize, i: usize) -> Place {
        let number = |k: usize| Pack::load(self.numbers, k * self.layout.padded_columns() + i);
        let (upper, right) = (point >= 2, point % 2 == 1);
        let along = |positive: bool, mean: Pack, slope: Pack| match positive {
            true => mean + slope,
            false => mean - slope,
        };
        Place {
            x_xi: along(upper, number(0), number(4)),
            y_xi: along(upper, number(1), number(5)),
            x_eta: along(right, number(2), number(4)),
            y_eta: along(right, number(3), number(5)),
            weight: number(6 + point),
            upper,
            right,
        }
    }
}

impl Place {
    /// t J; the weight t / 16 J would give it by a division, and none in the padding.
    #[inline(always)]
    fn volume(&self, thickness: f64) -> Pack {
        Pack::splat(thickness) * (self.x_xi * self.y_eta - self.x_eta * self.y_xi)
    }

    #[inline(always)]
    fn gradient(&self, u: &[Modes; 2], thickness: f64) -> Gradient {
        let scale = Pack::splat(4.0 / thickness) * self.weight;
        let (x_xi, y_xi) = (scale * self.x_xi, scale * self.y_xi);
        let (x_eta, y_eta) = (scale * self.x_eta, scale * self.y_eta);
        let along = |positive: bool, mean: Pack, slope: Pack| match positive {
            true => mean + slope,
            false => mean - slope,
        };
        [0, 1].map(|k| {
            let xi = along(self.upper, u[k].xi, u[k].hourglass);
            let eta = along(self.right, u[k].eta, u[k].hourglass);
            [xi * y_eta - eta * y_xi, eta * x_xi - xi * x_eta]
        })
    }

    /// Adds the forces of a stress.
    #[inline(always)]
    fn add(&self, stress: Gradient, thickness: f64, force: &mut [Modes; 2]) {
        let quarter = Pack::splat(0.25 * thickness);
        for ([along_x, along_y], force) in stress.into_iter().zip(force) {
            let (sx, sy) = (quarter * along_x, quarter * along_y);
            let xi = sx * self.y_eta - sy * self.x_eta;
            let eta = sy * self.x_xi - sx * self.y_xi;
            force.xi = force.xi + xi;
            force.eta = force.eta + eta;
            let signed = |positive: bool, q: Pack, sum: Pack| match positive {
                true => sum + q,
                false => sum - q,
            };
            force.hourglass = signed(self.right, eta, signed(self.upper, xi, force.hourglass));
        }
    }
}

/// A bilinear field of a pack of elements, or the forces that do work on it: parts along xi, eta and xi eta.
#[derive(Clone, Copy, Default)]
pub(super) struct Modes {
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

    /// Hands the forces to the corners.
    #[inline(always)]
    pub(super) fn store(&self, out: &mut RowForces, i: usize) {
        let first = Pack::splat(0.0) - self.xi - self.eta;
        let hourglass = Pack::splat(GAUSS) * self.hourglass;
        out.store(i, first, self.xi - self.eta, hourglass);
    }
}

/// Forces of the stress D grad u, integrated over the four points; `number` gives those of [`geometry`].
#[inline(always)]
pub(super) fn integrate(
    number: &impl Fn(usize) -> Pack,
    [x, y]: [Modes; 2],
    moduli: [f64; 3],
) -> [Modes; 2] {
    let [c11, c12, c33] = moduli.map(Pack::splat);
    let (bx, by) = (number(4), number(5));
    let zero = Pack::splat(0.0);
    let mut force = [Modes::default(); 2];
    for upper in [false, true] {
        let along = |mean: Pack, slope: Pack| if upper { mean + slope } else { mean - slope };
        let (u_xi, v_xi) = (along(x.xi, x.hourglass), along(y.xi, y.hourglass));
        let (x_xi, y_xi) = (along(number(0), bx), along(number(1), by));
        let mut row = [zero; 2];
        for right in [false, true] {
            let along = |mean: Pack, slope: Pack| if right { mean + slope } else { mean - slope };
            let (u_eta, v_eta) = (along(x.eta, x.hourglass), along(y.eta, y.hourglass));
            let (x_eta, y_eta) = (along(number(2), bx), along(number(3), by));
            let weight = number(6 + 2 * usize::from(upper) + usize::from(right));

            let exx = u_xi * y_eta - u_eta * y_xi;
            let eyy = v_eta * x_xi - v_xi * x_eta;
            let shear = (u_eta * x_xi - u_xi * x_eta) + (v_xi * y_eta - v_eta * y_xi);
            let sxx = weight * (c11 * exx + c12 * eyy);
            let syy = weight * (c12 * exx + c11 * eyy);
            let sxy = weight * (c33 * shear);

            row[0] = row[0] + (sxx * y_eta - sxy * x_eta);
            row[1] = row[1] + (sxy * y_eta - syy * x_eta);
            let eta = [sxy * x_xi - sxx * y_xi, syy * x_xi - sxy * y_xi];
            for (force, eta) in force.iter_mut().zip(eta) {
                force.eta = force.eta + eta;
                force.hourglass = if right {
                    force.hourglass + eta
                } else {
                    force.hourglass - eta
                };
            }
        }
        for (force, xi) in force.iter_mut().zip(row) {
            force.xi = force.xi + xi;
            force.hourglass = if upper {
                force.hourglass + xi
            } else {
                force.hourglass - xi
            };
        }
    }
    force
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
