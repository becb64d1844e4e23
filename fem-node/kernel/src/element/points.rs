//! The four Gauss points of the elements of a row, under a nonlinear law.

use std::ops::Range;

use super::corners::{StrainPath, StrainState};
use super::gauss::{CONSTANTS, integrate};
use super::layout::Layout;
use super::modes::{Modes, plus_minus};
use crate::material::j2::J2;
use crate::material::nonlinear::{Gradient, NonlinearLaw, corotational_stress};
use crate::pack::lanes::{LANES, Pack};

/// Packs of elements of a row that may need the radial return.
#[derive(Clone, Copy)]
pub(super) struct YieldCandidates<'a> {
    /// By packs: above 0 where an element may flow, [`FLOWED`] where any element of the pack has flowed.
    pub(super) excess: &'a [[f64; LANES]],
    /// Number of the first pack in its row.
    pub(super) first: usize,
    /// Factors on the yield stress, element by element in their row; empty where they are 1.
    pub(super) factors: &'a [f64],
}

/// Excess of a pack with an element that has flowed.
pub(super) const FLOWED: f64 = f64::INFINITY;

impl YieldCandidates<'_> {
    /// First columns of their packs.
    #[inline(always)]
    pub(super) fn columns(&self) -> impl Iterator<Item = usize> + '_ {
        let packs = self.excess.iter().enumerate();
        let above = packs.filter(|(_, excess)| Pack(**excess).any_above(Pack::splat(0.0)));
        above.map(|(pack, _)| (self.first + pack) * LANES)
    }

    /// Factors on the yield stress of the pack from column `i` on.
    #[inline(always)]
    pub(super) fn factor(&self, i: usize) -> Pack {
        if self.factors.is_empty() {
            Pack::splat(1.0)
        } else {
            Pack::load(self.factors, i)
        }
    }

    /// True where an element of the pack from column `i` on has flowed.
    #[inline(always)]
    pub(super) fn has_flowed(&self, i: usize) -> bool {
        self.excess[i / LANES - self.first][0] == FLOWED
    }
}

/// The four points of all elements of a row.
pub(super) struct RowPoints<'a> {
    /// By packs, [`geometry`](super::gauss::geometry) first.
    pub(super) constants: &'a [[Pack; CONSTANTS]],
    pub(super) layout: Layout,
    pub(super) moduli: [f64; 3],
    pub(super) thickness: f64,
}

/// Derivatives of the position at a point of a pack of elements, and t / 16 J.
struct GaussPoint {
    x_xi: Pack,
    y_xi: Pack,
    x_eta: Pack,
    y_eta: Pack,
    weight: Pack,
    upper: bool,
    right: bool,
}

impl RowPoints<'_> {
    /// Forces of the packs of elements that flow or have flowed, handed to `store` with the modes of the displacement.
    #[inline(always)]
    pub(super) fn plastic_forces(
        &self,
        plastic: &J2,
        mut path: StrainPath,
        candidates: YieldCandidates,
        mut store: impl FnMut(usize, [Modes; 2], [Modes; 2]),
    ) {
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let scale = Pack::splat(4.0 / self.thickness);
        let quarter = Pack::splat(0.25 * self.thickness);
        for i in candidates.columns() {
            let (u, factor) = (Modes::both(&path.u.load(stride, i)), candidates.factor(i));
            if !candidates.has_flowed(i) && !self.begins_to_flow(plastic, &u, (i, factor)) {
                continue;
            }
            let du = Modes::both(&path.du.load(stride, i));
            let mut dissipated = Pack::splat(0.0);
            let forces = integrate(
                &self.constants[i / LANES],
                u,
                self.moduli,
                #[inline(always)]
                |k, [exx, eyy, shear], [sxx, syy, sxy]| {
                    let point = self.point(k, i);
                    let weight = scale * point.weight;
                    let (relaxed, dissipation) = plastic.return_map(
                        [weight * exx, weight * eyy, weight * shear],
                        #[inline(always)]
                        || point.strain(weight, &du),
                        &mut path.point(k, padded),
                        (i, factor),
                    );
                    dissipated = dissipated + point.jacobian() * dissipation;
                    [
                        sxx - quarter * relaxed[0],
                        syy - quarter * relaxed[1],
                        sxy - quarter * relaxed[2],
                    ]
                },
            );
            path.count(Pack::splat(self.thickness) * dissipated, i);
            store(i, forces, u);
        }
    }

    /// True where any point of a pack that has never flowed begins to flow.
    #[inline(always)]
    fn begins_to_flow(&self, plastic: &J2, u: &[Modes; 2], (i, factor): (usize, Pack)) -> bool {
        let scale = Pack::splat(4.0 / self.thickness);
        (0..4).any(|k| {
            let point = self.point(k, i);
            plastic.begins_to_flow(point.strain(scale * point.weight, u), factor)
        })
    }

    /// Forces under large rotations, which dissipate nothing.
    #[inline(always)]
    pub(super) fn corotational_forces(
        &self,
        path: StrainPath,
        columns: Range<usize>,
        mut store: impl FnMut(usize, [Modes; 2], [Modes; 2]),
    ) {
        let stride = self.layout.element_stride();
        for i in columns.step_by(LANES) {
            let u = Modes::both(&path.u.load(stride, i));
            let mut force = [Modes::default(); 2];
            for k in 0..4 {
                let point = self.point(k, i);
                let gradient = point.gradient(&u, self.thickness);
                let stress = corotational_stress(self.moduli, gradient);
                point.add(stress, self.thickness, &mut force);
            }
            store(i, force, u);
        }
    }

    /// Stored energy less u F / 2 (J) of the row, [`NonlinearLaw::energy_correction`].
    pub(super) fn energy_correction(&self, law: &NonlinearLaw, now: StrainState) -> f64 {
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let mut sum = Pack::splat(0.0);
        for i in (0..padded).step_by(LANES) {
            if law.plastic().is_some() && now.is_virgin(4, padded, i) {
                continue;
            }
            let u = Modes::both(&now.u.load(stride, i));
            for k in 0..4 {
                let point = self.point(k, i);
                let gradient = point.gradient(&u, self.thickness);
                let history = now.history(k, padded, i);
                let energy = law.energy_correction(self.moduli, gradient, history);
                sum = sum + Pack::splat(self.thickness) * point.jacobian() * energy;
            }
        }
        sum.sum()
    }

    /// Point `k` in the order of the weights: (-, -), (+, -), (-, +), (+, +).
    #[inline(always)]
    fn point(&self, k: usize, i: usize) -> GaussPoint {
        let constants = &self.constants[i / LANES];
        let (upper, right) = (k >= 2, k % 2 == 1);
        let (bx, by) = (constants[4], constants[5]);
        GaussPoint {
            x_xi: plus_minus(upper, constants[0], bx),
            y_xi: plus_minus(upper, constants[1], by),
            x_eta: plus_minus(right, constants[2], bx),
            y_eta: plus_minus(right, constants[3], by),
            weight: constants[6 + k],
            upper,
            right,
        }
    }
}

impl GaussPoint {
    /// J: the weight t / 16 J would give it only by a division, and not in the padding.
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
            plus_minus(self.upper, u.xi, u.hourglass),
            plus_minus(self.right, u.eta, u.hourglass),
        )
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
    use crate::element::constants::Constants;
    use crate::element::corners::CornerRows;
    use crate::element::gauss::{GEOMETRY, geometry};
    use crate::material::Elastic;
    use crate::material::nonlinear::plain::respond;
    use crate::mesh::Mesh;

    /// Forces point by point, with every factor as in the formula.
    fn plain_forces(
        points: &RowPoints,
        plastic: &J2,
        mut path: StrainPath,
        mut store: impl FnMut(usize, [Modes; 2], [Modes; 2]),
    ) {
        let (padded, stride) = (
            points.layout.padded_columns(),
            points.layout.element_stride(),
        );
        for i in (0..padded).step_by(LANES) {
            let mut dissipated = Pack::splat(0.0);
            let [u, du] = [path.u, path.du].map(|field| Modes::both(&field.load(stride, i)));
            let mut force = [Modes::default(); 2];
            for k in 0..4 {
                let point = points.point(k, i);
                let gradient = point.gradient(&u, points.thickness);
                let increment = point.gradient(&du, points.thickness);
                let history = &mut path.point(k, padded);
                let gradients = [gradient, increment];
                let (stress, lost) = respond(plastic, points.moduli, gradients, history, i);
                dissipated = dissipated + Pack::splat(points.thickness) * point.jacobian() * lost;
                point.add(stress, points.thickness, &mut force);
            }
            path.count(dissipated, i);
            store(i, force, u);
        }
    }

    /// A row of five skewed elements, some of which yield, under both paths.
    #[test]
    fn the_short_path_of_plasticity_agrees_with_the_plain_one() {
        let mesh = Mesh::structured(5, 1, |i, j| {
            let i = i as f64;
            [i + 0.3 * j as f64, -1.2 * j as f64 + 0.1 * i.sin()]
        });
        let elastic = Elastic::plane_strain(3.0, 0.3, 1.0);
        let plastic = J2 {
            mu: elastic.c33,
            yield_stress: 0.5,
            isotropic: 0.3,
            kinematic: 0.2,
            softens: false,
        };
        let layout = Layout::new(&mesh);
        let constants = Constants::new(&mesh, layout, |p| {
            let mut constants = [0.0; CONSTANTS];
            constants[..GEOMETRY].copy_from_slice(&geometry(p, 0.7));
            constants
        });
        let points = RowPoints {
            constants: constants.row(0),
            layout,
            moduli: elastic.moduli(),
            thickness: 0.7,
        };
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
            let mut dissipated = vec![0.0; layout.padded_columns()];
            let path = StrainPath {
                u: CornerRows::between([&rows[0], &rows[1]]),
                du: CornerRows::between([&rows[2], &rows[3]]),
                history: &mut history,
                dissipated: &mut dissipated,
            };
            let store = |_: usize, force: [Modes; 2], _: [Modes; 2]| {
                for modes in force {
                    forces.extend([modes.xi.0, modes.eta.0, modes.hourglass.0].concat());
                }
            };
            if short {
                let all = YieldCandidates {
                    excess: &vec![[FLOWED; LANES]; layout.padded_columns() / LANES],
                    first: 0,
                    factors: &[],
                };
                points.plastic_forces(&plastic, path, all, store);
            } else {
                plain_forces(&points, &plastic, path, store);
            }
            forces.extend(dissipated);
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
