//! The four points of a row of elements, under any law.

use super::modes::{Modes, along};
use super::splat3;
use crate::config::Kinematics;
use crate::element::Layout;
use crate::element::row::{Course, Standing};
use crate::material::j2::J2;
use crate::material::point::{Gradient, PointLaw};
use crate::pack::{LANES, Pack};

/// The four points of all elements of a row, under any law.
pub(in crate::element) struct RowPoints<'a> {
    /// Those of [`geometry`](super::geometry) come first.
    pub(in crate::element) numbers: &'a [f64],
    pub(in crate::element) layout: Layout,
    pub(in crate::element) moduli: [f64; 3],
    pub(in crate::element) thickness: f64,
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
    pub(in crate::element) fn forces(
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

    pub(in crate::element) fn energy_beyond(&self, law: &PointLaw, now: Standing) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{MaterialConfig, Plane};
    use crate::element::q4_2x2::Q4Full;
    use crate::element::row::CornerRows;
    use crate::material::Elastic;
    use crate::mesh::Mesh;

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
