//! Bilinear quadrilateral with one integration point and hourglass stiffness.
//!
//! Flanagan and Belytschko, "A uniform strain hexahedron and quadrilateral with orthogonal hourglass control",
//! Int. J. Numer. Meth. Engng 17 (1981) 679-706. With corners 1..4 anticlockwise, A the area and t the thickness,
//! the mean gradient is u,x = sum B_xa u_a with
//!
//! ```text
//! B_x = (y2-y4, y3-y1, y4-y2, y1-y3) / 2A,   B_y = (x4-x2, x1-x3, x2-x4, x3-x1) / 2A
//! ```
//!
//! Corners 1 and 3, 2 and 4 have opposite entries, so only the differences u1-u3 and u2-u4 enter. Forces:
//! f_ia = t A B_ja s_ij(mean strain) + G_a Q_i, with
//!
//! ```text
//! G_a = (h_a - (h.x) B_xa - (h.y) B_ya) / 2,   h = (1, -1, 1, -1)     orthogonal to every linear field
//! Q_i = 0.1 c11 A (sum B_ia^2) t  G.u_i                               c11 = lambda + 2 mu in plane strain
//! ```
//!
//! Under plasticity the hourglass modes yield with the element, or their elastic force would grow without bound in plastic flow and the
//! body would have no limit load: while the point flows and Q g rises, the hourglass stiffness is scaled with the tangent
//! modulus,
//!
//! ```text
//! Q = K (g - g_p),   dg_p = (1 - s) dg   where the point flows and Q dg > 0, else 0,   g = G.u
//! s = max((H + K_kin) / (3 mu + H + K_kin), 0.01)
//! ```
//!
//! It stores Q (g - g_p)/2 and dissipates (Q + Q') dg_p / 2.
//!
//! G has length 1 on a parallelogram. There, for a square and nu = 0.3, the hourglass stiffness is 0.735 of
//! the exact bending stiffness; full integration gives 1.57 of it.

use std::ops::Range;

use super::constants::Constants;
use super::corners::{Corners, StrainPath, StrainState};
use super::layout::Layout;
use super::linear::LinearElements;
use super::row_forces::{CornerForces, RowForces};
use super::shape::{area, slopes};
use super::stiffness::Stiffness;
use crate::material::Elastic;
use crate::material::j2::J2;
use crate::material::nonlinear::{Gradient, NonlinearLaw};
use crate::mesh::Mesh;
use crate::pack::{LANES, Lanes, Pack, Registers};

/// Share of the largest stiffness of the element that resists the hourglass modes.
const HOURGLASS: f64 = 0.1;

/// Constants of each element: B_x1, B_x2, B_y1, B_y2, h.x, h.y, t A, and the hourglass stiffness over 4.
const CONSTANTS: usize = 8;

/// Blocks of history variables of a plastic element: those of its point, and the plastic parts of the hourglass modes.
pub(super) const HISTORY_BLOCKS: usize = 2;

/// Least share of the elastic hourglass stiffness in plastic flow. With 1e-2 a Prandtl punch comes within 1e-3 of the load that it has
/// without any (3 % more with 0.1), and 1e-3 of the largest stiffness still keeps the modes in hand.
const SOFTENING_MIN: f64 = 0.01;

/// All elements of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Q4OnePoint {
    elastic: Elastic,
    layout: Layout,
    constants: Constants<CONSTANTS>,
}

impl Q4OnePoint {
    pub(super) fn new(
        mesh: &Mesh,
        layout: Layout,
        elastic: &Elastic,
        thickness: f64,
    ) -> Q4OnePoint {
        Q4OnePoint {
            elastic: *elastic,
            layout,
            constants: Constants::new(mesh, layout, |p| element_constants(p, elastic, thickness)),
        }
    }

    /// The elements of the piece whose first column of elements is `first`.
    pub(super) fn piece(&self, layout: Layout, first: usize) -> Q4OnePoint {
        Q4OnePoint {
            elastic: self.elastic,
            layout,
            constants: self.constants.piece(layout, first),
        }
    }

    /// Forces f_ia = t A B_ja s_ij + G_a Q_i of a row under a nonlinear law.
    #[inline(always)]
    pub(super) fn nonlinear_row(
        &self,
        law: &NonlinearLaw,
        row: usize,
        mut path: StrainPath,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        let moduli = self.elastic.moduli();
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let (u, du, constants) = (path.u, path.du, self.constants.row(row));
        for i in columns.step_by(LANES) {
            let [bx1, bx2, by1, by2, hx, hy, volume, hourglass] = constants[i / LANES];
            let (bx, by) = ([bx1, bx2], [by1, by2]);
            let corners = u.load(stride, i);
            let gradient = gradient(bx, by, &corners);
            let response = law.respond(
                moduli,
                gradient,
                #[inline(always)]
                || self::gradient(bx, by, &du.load(stride, i)),
                &mut path.point(0, padded),
                i,
            );
            let modes = hourglass_modes([hx, hy], &corners, gradient);
            let mut plastic_modes = [Pack::splat(0.0); 2];
            let mut dissipated = volume * response.dissipated;
            if let Some(plastic) = law.plastic() {
                let mut history = path.point(1, padded).load(i);
                let flows = response.dissipated;
                if flows.any_above(Pack::splat(0.0)) {
                    let du = du.load(stride, i);
                    let steps = hourglass_modes([hx, hy], &du, self::gradient(bx, by, &du));
                    let softened = Pack::splat(1.0 - softening(plastic));
                    for k in 0..2 {
                        let trial = modes[k] - history[k];
                        let grows = (trial * steps[k]).if_positive(flows);
                        let flow = grows.if_positive(softened * steps[k]);
                        let mean = trial - Pack::splat(0.5) * (steps[k] + flow);
                        dissipated = dissipated + hourglass * mean * flow;
                        history[k] = history[k] + flow;
                    }
                    path.point(1, padded).store(i, history);
                }
                plastic_modes = [history[0], history[1]];
            }
            path.count(dissipated, i);
            for k in 0..2 {
                let q = hourglass * (modes[k] - plastic_modes[k]);
                let sx = volume * response.stress[k][0] - hx * q;
                let sy = volume * response.stress[k][1] - hy * q;
                let forces = CornerForces {
                    first: bx1 * sx + by1 * sy,
                    second: bx2 * sx + by2 * sy,
                    hourglass: q,
                };
                out.store(k * stride + i, forces);
            }
        }
    }

    /// Stored energy less u F / 2 (J) of a row, [`NonlinearLaw::energy_correction`].
    pub(super) fn energy_correction(
        &self,
        law: &NonlinearLaw,
        row: usize,
        now: StrainState,
    ) -> f64 {
        let moduli = self.elastic.moduli();
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let mut sum = Pack::splat(0.0);
        let starts = (0..padded).step_by(LANES);
        for (i, constants) in starts.zip(self.constants.row(row)) {
            let [bx1, bx2, by1, by2, ..] = *constants;
            let corners = now.u.load(stride, i);
            let gradient = gradient([bx1, bx2], [by1, by2], &corners);
            let energy = law.energy_correction(moduli, gradient, now.history(0, padded, i));
            sum = sum + constants[6] * energy;
            if law.plastic().is_some() {
                // Q (g - g_p) / 2 less Q g / 2.
                let modes = hourglass_modes([constants[4], constants[5]], &corners, gradient);
                let plastic = now.history(1, padded, i);
                for k in 0..2 {
                    let q = constants[7] * (modes[k] - plastic[k]);
                    sum = sum - Pack::splat(0.5) * q * plastic[k];
                }
            }
        }
        sum.sum()
    }
}

impl LinearElements for Q4OnePoint {
    type Constants = [Pack; CONSTANTS];

    fn constants(&self, row: usize) -> &[Self::Constants] {
        self.constants.row(row)
    }

    /// f_ia = t A B_ja s_ij + G_a Q_i
    #[inline(always)]
    fn forces<R: Registers>(
        &self,
        registers: R,
        (constants, p): (&[Self::Constants], usize),
        [x, y]: [Corners<R::Vector>; 2],
    ) -> [CornerForces<R::Vector>; 2] {
        let [bx1, bx2, by1, by2, hx, hy, volume, hourglass] = registers.load_all(constants, p);
        let [[xx, xy], [yx, yy]] = gradient([bx1, bx2], [by1, by2], &[x, y]);
        let c = |value: f64| registers.splat(value) * volume;
        let (c11, c12, c33) = (
            c(self.elastic.c11),
            c(self.elastic.c12),
            c(self.elastic.c33),
        );
        let shear = c33 * (xy + yx);
        let qx = hourglass * (x.hourglass() - hx * xx - hy * xy);
        let qy = hourglass * (y.hourglass() - hx * yx - hy * yy);

        // G_a Q = h_a Q - B_xa (h.x) Q - B_ya (h.y) Q: the last two join the stress.
        let (sxx, sxy) = (c11 * xx + c12 * yy - hx * qx, shear - hy * qx);
        let (syx, syy) = (shear - hx * qy, c12 * xx + c11 * yy - hy * qy);
        let forces = |sx: R::Vector, sy: R::Vector, q: R::Vector| CornerForces {
            first: bx1 * sx + by1 * sy,
            second: bx2 * sx + by2 * sy,
            hourglass: q,
        };
        [forces(sxx, sxy, qx), forces(syx, syy, qy)]
    }
}

/// Mean gradient of the displacement.
#[inline(always)]
fn gradient<V: Lanes>(bx: [V; 2], by: [V; 2], [x, y]: &[Corners<V>; 2]) -> [[V; 2]; 2] {
    let ((xx, xy), (yx, yy)) = (x.gradient(bx, by), y.gradient(bx, by));
    [[xx, xy], [yx, yy]]
}

/// Twice G.u in x and in y: h.u less its linear part.
#[inline(always)]
fn hourglass_modes(moment: [Pack; 2], corners: &[Corners; 2], gradient: Gradient) -> [Pack; 2] {
    let of = |k: usize| {
        let [along_x, along_y] = gradient[k];
        corners[k].hourglass() - moment[0] * along_x - moment[1] * along_y
    };
    [of(0), of(1)]
}

/// s, the share of the hourglass stiffness that is left in plastic flow.
fn softening(law: &J2) -> f64 {
    let hardening = law.isotropic + law.kinematic;
    (hardening / (3.0 * law.mu + hardening)).max(SOFTENING_MIN)
}

/// K = t A B^T D B + 0.1 c11 A (sum B^2) t G G^T in x and in y: the tangent of the forces above.
pub(super) fn stiffness(p: &[[f64; 2]; 4], elastic: &Elastic, thickness: f64) -> Stiffness {
    let (b, volume) = (slopes(p, [0.0, 0.0]), thickness * area(p));
    let mut k = Stiffness::default();
    k.add_material(&b, elastic.moduli(), volume);
    let h = [1.0, -1.0, 1.0, -1.0];
    let moment = [0, 1].map(|k| (0..4).map(|a| h[a] * p[a][k]).sum::<f64>());
    let pure = [0, 1, 2, 3].map(|a| 0.5 * (h[a] - moment[0] * b[a][0] - moment[1] * b[a][1]));
    let sum_b2: f64 = b.iter().flatten().map(|b| b * b).sum();
    let hourglass = HOURGLASS * elastic.c11 * volume * sum_b2;
    for component in 0..2 {
        let mut row = [0.0; 8];
        (0..4).for_each(|a| row[2 * a + component] = pure[a]);
        k.add_outer(&row, &row, hourglass);
    }
    k
}

fn element_constants(p: &[[f64; 2]; 4], elastic: &Elastic, thickness: f64) -> [f64; CONSTANTS] {
    let area = area(p);
    let half = 0.5 / area;
    let b = [
        half * (p[1][1] - p[3][1]),
        half * (p[2][1] - p[0][1]),
        half * (p[3][0] - p[1][0]),
        half * (p[0][0] - p[2][0]),
    ];
    let sum_b2 = 2.0 * b.iter().map(|b| b * b).sum::<f64>();
    let h = |k: usize| p[0][k] - p[1][k] + p[2][k] - p[3][k];
    let volume = thickness * area;
    let hourglass = 0.25 * HOURGLASS * elastic.c11 * volume * sum_b2;
    [b[0], b[1], b[2], b[3], h(0), h(1), volume, hourglass]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ElementKind, MaterialConfig, Plane};
    use crate::element::{Body, Supports};
    use crate::probe;

    /// A body in which no two elements are alike and no side is parallel to another.
    fn distorted() -> Mesh {
        Mesh::structured(6, 4, |i, j| {
            let wobble = |k: usize| 0.2 * ((k * 7919 + 13) % 101) as f64 / 101.0;
            let k = j * 7 + i;
            [i as f64 + wobble(k), -1.3 * j as f64 + wobble(k + 50)]
        })
    }

    fn elastic(poisson: f64) -> Elastic {
        let material = MaterialConfig::elastic(3.0, poisson, 1.0);
        Elastic::new(&material, Plane::Strain)
    }

    /// Nodal forces of one element by the book: t A B^T D B u at the centre, and the hourglass vector as what is
    /// left of (1, -1, 1, -1) / 2 once its linear part is taken off.
    fn reference(p: &[[f64; 2]; 4], u: &[[f64; 2]; 4], law: &Elastic, t: f64) -> [[f64; 2]; 4] {
        let stress = law.stress(probe::strain(p, u, [0.0, 0.0]));
        let unit = |a: usize, k: usize| {
            let mut unit = [[0.0; 2]; 4];
            unit[a][k] = 1.0;
            probe::strain(p, &unit, [0.0, 0.0])
        };
        let slopes: Vec<[f64; 2]> = (0..4).map(|a| [unit(a, 0)[0], unit(a, 1)[1]]).collect();
        let h = [1.0, -1.0, 1.0, -1.0];
        let moment = |k: usize| (0..4).map(|a| h[a] * p[a][k]).sum::<f64>();
        let pure = |a: usize| 0.5 * (h[a] - moment(0) * slopes[a][0] - moment(1) * slopes[a][1]);
        let b2: f64 = slopes.iter().flatten().map(|b| b * b).sum();
        let volume = t * area(p);
        let q = [0, 1]
            .map(|k| 0.1 * law.c11 * volume * b2 * (0..4).map(|a| pure(a) * u[a][k]).sum::<f64>());
        [0, 1, 2, 3].map(|a| {
            let [bx, by] = slopes[a];
            [
                volume * (bx * stress[0] + by * stress[2]) + pure(a) * q[0],
                volume * (by * stress[1] + bx * stress[2]) + pure(a) * q[1],
            ]
        })
    }

    #[test]
    fn the_row_kernel_agrees_with_the_textbook_element() {
        let (mesh, law, t) = (distorted(), elastic(0.3), 0.7);
        let body = Body::new(&mesh, ElementKind::Q4OnePoint, &law, Supports::default(), t);
        let layout = body.layout;
        let motion = |n: [usize; 2]| [0, 1].map(|k| ((31 * n[0] + 17 * n[1] + 5 * k) as f64).sin());
        let (mut u, mut expected) = (vec![0.0; layout.len()], vec![0.0; layout.len()]);
        for j in 0..mesh.rows {
            for i in 0..mesh.columns {
                let corners = mesh.corners(i, j);
                let points = corners.map(|n| mesh.point(n[0], n[1]));
                let forces = reference(&points, &corners.map(motion), &law, t);
                for (node, force) in corners.into_iter().zip(forces) {
                    for k in 0..2 {
                        u[layout.index(node, k)] = motion(node)[k];
                        expected[layout.index(node, k)] += force[k];
                    }
                }
            }
        }
        let mut force = vec![0.0; layout.len()];
        body.internal_force(&u, &mut force);
        let scale = expected.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        for (computed, exact) in force.iter().zip(&expected) {
            assert!(
                (computed - exact).abs() <= 1e-12 * scale,
                "{computed} {exact}"
            );
        }
    }

    #[test]
    fn the_hourglass_mode_of_a_square_is_resisted_as_stated() {
        let mesh = Mesh::structured(1, 1, |i, j| [i as f64, -(j as f64)]);
        let law = elastic(0.3);
        let body = Body::new(
            &mesh,
            ElementKind::Q4OnePoint,
            &law,
            Supports::default(),
            1.0,
        );
        let layout = body.layout;
        let mut u = vec![0.0; layout.len()];
        for (node, h) in mesh.corners(0, 0).into_iter().zip([1.0, -1.0, 1.0, -1.0]) {
            u[layout.index(node, 0)] = h;
        }
        let mut force = vec![0.0; layout.len()];
        body.internal_force(&u, &mut force);
        // Bending energy of the exact field u = h xi eta: (4/3) E / (1 - nu^2) per h^2.
        let exact = 4.0 / 3.0 * 3.0 / (1.0 - 0.09);
        let work: f64 = u.iter().zip(&force).map(|(u, f)| u * f).sum();
        assert!((work / exact - 0.735).abs() < 1e-3, "{}", work / exact);
    }
}
