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

use super::row::{CornerRows, Corners, Course, RowForces, Standing, row_numbers};
use super::stiffness::Stiffness;
use crate::config::Kinematics;
use crate::element::{GAUSS, GAUSS_POINTS, Layout, jacobian, slopes};
use crate::material::Elastic;
use crate::material::j2::J2;
use crate::material::point::{Gradient, PointLaw};
use crate::mesh::Mesh;
use crate::pack::{LANES, Pack, widest};

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
        course: Course,
        store: impl FnMut(usize, [Modes; 2], [Modes; 2]),
    ) -> f64 {
        match (law.kinematics, &law.plastic) {
            (Kinematics::Small, Some(plastic)) => self.forces_of_j2(plastic, course, store),
            _ => self.forces_by(law, course, store),
        }
    }

    /// [`RowPoints::forces_by`] for plasticity in small strain: factors that all components or all points share are
    /// applied once, increments are read once for the four points.
    #[inline(always)]
    fn forces_of_j2(
        &self,
        plastic: &J2,
        mut course: Course,
        mut store: impl FnMut(usize, [Modes; 2], [Modes; 2]),
    ) -> f64 {
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let [c11, c12, c33] = splat3(self.moduli);
        let scale = Pack::splat(4.0 / self.thickness);
        let quarter = Pack::splat(0.25 * self.thickness);
        let mut dissipated = Pack::splat(0.0);
        for i in (0..padded).step_by(LANES) {
            let u = Modes::both(&course.u.load(stride, i));
            let du = Modes::both(&course.du.load(stride, i));
            let mut force = [Modes::default(); 2];
            for point in 0..4 {
                let place = self.place(point, i);
                let weight = scale * place.weight;
                let [xx, yy, xy] = place.strain(weight, &u);
                let (less, heat) = plastic.yield_to(
                    [xx, yy, xy],
                    #[inline(always)]
                    || place.strain(weight, &du),
                    &mut course.point(point, padded),
                    i,
                );
                dissipated = dissipated + place.jacobian() * heat;
                let stress = [
                    (c11 * xx + c12 * yy) - less[0],
                    (c12 * xx + c11 * yy) - less[1],
                    c33 * xy - less[2],
                ];
                place.add_over_quarter(stress, &mut force);
            }
            store(i, [force[0].scaled(quarter), force[1].scaled(quarter)], u);
        }
        self.thickness * dissipated.sum()
    }

    /// Like [`RowPoints::forces`], whatever the law.
    #[inline(always)]
    fn forces_by(
        &self,
        law: &PointLaw,
        mut course: Course,
        mut store: impl FnMut(usize, [Modes; 2], [Modes; 2]),
    ) -> f64 {
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let mut dissipated = Pack::splat(0.0);
        for i in (0..padded).step_by(LANES) {
            let u = Modes::both(&course.u.load(stride, i));
            let du = course.du;
            let mut force = [Modes::default(); 2];
            for point in 0..4 {
                let place = self.place(point, i);
                let increment = || {
                    let du = Modes::both(&du.load(stride, i));
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
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let mut sum = Pack::splat(0.0);
        for i in (0..padded).step_by(LANES) {
            let u = Modes::both(&now.u.load(stride, i));
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
        let padded = self.layout.padded_columns();
        let number = |k: usize| Pack::load(self.numbers, k * padded + i);
        let (upper, right) = (point >= 2, point % 2 == 1);
        let (bx, by) = (number(4), number(5));
        Place {
            x_xi: along(upper, number(0), bx),
            y_xi: along(upper, number(1), by),
            x_eta: along(right, number(2), bx),
            y_eta: along(right, number(3), by),
            weight: number(6 + point),
            upper,
            right,
        }
    }
}

/// `mean` with `slope` added or taken off.
#[inline(always)]
fn along(positive: bool, mean: Pack, slope: Pack) -> Pack {
    match positive {
        true => mean + slope,
        false => mean - slope,
    }
}

#[inline(always)]
fn splat3([a, b, c]: [f64; 3]) -> [Pack; 3] {
    [Pack::splat(a), Pack::splat(b), Pack::splat(c)]
}

impl Place {
    /// t J; the weight t / 16 J would give it by a division, and none in the padding.
    #[inline(always)]
    fn volume(&self, thickness: f64) -> Pack {
        Pack::splat(thickness) * self.jacobian()
    }

    #[inline(always)]
    fn jacobian(&self) -> Pack {
        self.x_xi * self.y_eta - self.x_eta * self.y_xi
    }

    /// Strain (exx, eyy, 2 exy), `weight` being 4/t of its own.
    #[inline(always)]
    fn strain(&self, weight: Pack, [u, v]: &[Modes; 2]) -> [Pack; 3] {
        let (u_xi, u_eta) = self.slopes(u);
        let (v_xi, v_eta) = self.slopes(v);
        let shear =
            (u_eta * self.x_xi - u_xi * self.x_eta) + (v_xi * self.y_eta - v_eta * self.y_xi);
        [
            weight * (u_xi * self.y_eta - u_eta * self.y_xi),
            weight * (v_eta * self.x_xi - v_xi * self.x_eta),
            weight * shear,
        ]
    }

    /// Four times the slopes along xi and eta.
    #[inline(always)]
    fn slopes(&self, u: &Modes) -> (Pack, Pack) {
        (
            along(self.upper, u.xi, u.hourglass),
            along(self.right, u.eta, u.hourglass),
        )
    }

    /// Adds the forces of a stress (sxx, syy, sxy) over t/4.
    #[inline(always)]
    fn add_over_quarter(&self, [xx, yy, xy]: [Pack; 3], [fx, fy]: &mut [Modes; 2]) {
        self.push(xx, xy, fx);
        self.push(xy, yy, fy);
    }

    /// Adds the forces along one axis of the stresses (sx, sy) that act along it, over t/4.
    #[inline(always)]
    fn push(&self, sx: Pack, sy: Pack, force: &mut Modes) {
        let xi = sx * self.y_eta - sy * self.x_eta;
        let eta = sy * self.x_xi - sx * self.y_xi;
        force.add_xi(self.upper, xi);
        force.add_eta(self.right, eta);
    }

    #[inline(always)]
    fn gradient(&self, u: &[Modes; 2], thickness: f64) -> Gradient {
        let scale = Pack::splat(4.0 / thickness) * self.weight;
        let (x_xi, y_xi) = (scale * self.x_xi, scale * self.y_xi);
        let (x_eta, y_eta) = (scale * self.x_eta, scale * self.y_eta);
        let of = |u: &Modes| {
            let (xi, eta) = self.slopes(u);
            [xi * y_eta - eta * y_xi, eta * x_xi - xi * x_eta]
        };
        [of(&u[0]), of(&u[1])]
    }

    /// Adds the forces of a stress.
    #[inline(always)]
    fn add(&self, [x, y]: Gradient, thickness: f64, [fx, fy]: &mut [Modes; 2]) {
        let quarter = Pack::splat(0.25 * thickness);
        self.push(quarter * x[0], quarter * x[1], fx);
        self.push(quarter * y[0], quarter * y[1], fy);
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

    /// Of both components.
    #[inline(always)]
    pub(super) fn both([x, y]: &[Corners; 2]) -> [Modes; 2] {
        [Modes::of(x), Modes::of(y)]
    }

    #[inline(always)]
    fn add_xi(&mut self, upper: bool, xi: Pack) {
        self.xi = self.xi + xi;
        self.hourglass = along(upper, self.hourglass, xi);
    }

    #[inline(always)]
    fn add_eta(&mut self, right: bool, eta: Pack) {
        self.eta = self.eta + eta;
        self.hourglass = along(right, self.hourglass, eta);
    }

    #[inline(always)]
    fn scaled(self, factor: Pack) -> Modes {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{MaterialConfig, Plane};

    /// A row of five skewed elements of which some yield, some do not, under both paths.
    #[test]
    fn the_short_path_of_plasticity_agrees_with_the_plain_one() {
        let mesh = Mesh::structured(5, 1, |i, j| {
            let i = i as f64;
            [i + 0.3 * j as f64, -1.2 * j as f64 + 0.1 * i.sin()]
        });
        let material = MaterialConfig {
            yield_pa: Some(0.5),
            hardening_pa: Some(0.3),
            kinematic_hardening_pa: Some(0.2),
            ..MaterialConfig::elastic(3.0, 0.3, 1.0)
        };
        let elastic = Elastic::new(&material, Plane::Strain);
        let law = PointLaw::new(Kinematics::Small, J2::new(&material, &elastic));
        let law = law.expect("it is plastic");
        let layout = Layout::new(&mesh);
        let elements = Q4Full::new(&mesh, layout, &elastic, 0.7);
        let points = elements.points(0);
        let field = |phase: f64| -> Vec<f64> {
            let wave = |k: usize| (0.9 * k as f64 + phase).sin();
            (0..layout.row_len()).map(|k| 0.2 * wave(k)).collect()
        };
        let rows = [field(0.0), field(1.0), field(2.0), field(3.0)];
        let run = |short: bool| {
            let mut history = vec![0.0; 4 * 4 * layout.padded_columns()];
            for (k, value) in history.iter_mut().enumerate() {
                *value = 0.01 * (k as f64).cos().abs();
            }
            let mut forces = Vec::new();
            let course = Course {
                u: CornerRows::between([&rows[0], &rows[1]]),
                du: CornerRows::between([&rows[2], &rows[3]]),
                history: &mut history,
            };
            let store = |_: usize, force: [Modes; 2], _: [Modes; 2]| {
                for modes in force {
                    forces.extend([modes.xi.0, modes.eta.0, modes.hourglass.0].concat());
                }
            };
            let dissipated = match short {
                true => points.forces(&law, course, store),
                false => points.forces_by(&law, course, store),
            };
            forces.push(dissipated);
            forces.extend(history);
            forces
        };
        let (short, plain) = (run(true), run(false));
        assert!(plain[24 * 2] != 0.0, "some yield");
        for (k, (short, plain)) in short.iter().zip(&plain).enumerate() {
            assert!((short - plain).abs() <= 1e-13, "{k}: {short} {plain}");
        }
    }
}
