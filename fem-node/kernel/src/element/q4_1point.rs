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
//! Q_i = 0.1 min(c11, 6 mu) A (sum B_ia^2) t  G.u_i                    c11 = lambda + 2 mu in plane strain
//! ```
//!
//! Bending keeps the volume where it can. With c11 alone, which grows without bound towards Poisson's ratio 0.5, the hourglass modes lock: at 0.499
//! the displacement of a thick cylinder of 16 x 16 elements was 0.868 of Lame's. 6 mu is c11 at 0.4, so nothing changes below; at 0.5 the modes of a
//! square have 0.9 of the exact bending stiffness.
//!
//! Under plasticity the hourglass modes yield with the element. Otherwise their elastic force would grow without bound in plastic flow, and the body
//! would have no limit load. While the point flows and Q g rises, the hourglass stiffness is scaled with the tangent modulus,
//!
//! ```text
//! Q = K (g - g_p),   dg_p = (1 - s) dg   where the point flows and Q dg > 0, else 0,   g = G.u
//! s = max((H + K_kin) / (3 mu + H + K_kin), 0.01)
//! ```
//!
//! It stores Q (g - g_p)/2 and dissipates (Q + Q') dg_p / 2.
//!
//! G has length 1 on a parallelogram. There, for a square and nu = 0.3, the hourglass stiffness is 0.735 of
//! the exact bending stiffness; with full integration it is 1.57.

use std::ops::Range;

use super::constants::Constants;
use super::corners::{Corners, StrainPath, StrainState};
use super::layout::Layout;
use super::linear::{LIMIT_SHARE, LinearElements};
use super::points::YieldCandidates;
use super::row_forces::{CornerForces, RowForces};
use super::shape::slopes;
use crate::element::stiffness::Stiffness;
use crate::material::Elastic;
use crate::material::j2::{History, J2};
use crate::material::nonlinear::{NonlinearLaw, corotational_stress, symmetric};
use crate::mesh::{Mesh, area};
use crate::pack::lanes::{LANES, Lanes, Pack, Registers};

/// Share of the largest stiffness of the element that resists the hourglass modes.
const HOURGLASS: f64 = 0.1;

/// c11 over mu at Poisson's ratio 0.4, and a little for rounding.
const VOLUMETRIC_MAX: f64 = 6.000_000_1;

/// Constants of each element: B_x1, B_x2, B_y1, B_y2, h.x, h.y, t A, and the hourglass stiffness over 4.
const CONSTANTS: usize = 8;

/// Blocks of history variables of a plastic element: of its point, and of the plastic parts of the hourglass modes.
pub(super) const HISTORY_BLOCKS: usize = 2;

/// Least share of the elastic hourglass stiffness in plastic flow. With 1e-2 the load of a Prandtl punch is within 1e-3 of its value with a share of
/// 0 (3 % more with 0.1), and 1e-3 of the largest stiffness still controls the modes.
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

    /// Forces of the elements of a row that flow or have flowed, in whole packs, under plasticity. They are the elastic forces with the mean stress
    /// reduced by 2 mu p and the hourglass modes by their plastic parts, and the elastic bits without either.
    #[inline(always)]
    pub(super) fn plastic_row(
        &self,
        plastic: &J2,
        row: usize,
        mut path: StrainPath,
        candidates: YieldCandidates,
        out: &mut RowForces,
    ) {
        let (padded, stride) = (self.layout.padded_columns(), self.layout.element_stride());
        let (u, du, constants) = (path.u, path.du, self.constants.row(row));
        for i in candidates.columns() {
            let constants = &constants[i / LANES];
            let (corners, volume) = (u.load(stride, i), constants[6]);
            let gradient = mean_gradient(constants, &corners);
            let (relaxed, dissipation) = plastic.return_map(
                symmetric(gradient),
                #[inline(always)]
                || symmetric(mean_gradient(constants, &du.load(stride, i))),
                &mut path.point(0, padded),
                (i, candidates.factor(i)),
            );
            let mut modes = hourglass_modes(constants, &corners, gradient);
            let mut flow = HourglassFlow {
                plastic,
                stiffness: constants[7],
                history: path.point(1, padded).load(i),
                dissipated: volume * dissipation,
            };
            if dissipation.any_above(Pack::splat(0.0)) {
                let du = du.load(stride, i);
                let steps = hourglass_modes(constants, &du, mean_gradient(constants, &du));
                flow.follow(modes, steps, dissipation);
                path.point(1, padded).store(i, flow.history);
            }
            path.count(flow.dissipated, i);
            for (mode, plastic) in modes.iter_mut().zip(flow.history) {
                *mode = *mode - plastic;
            }
            let mut stress = self.elastic_stress(volume, gradient);
            for (stress, relaxed) in stress.iter_mut().zip(relaxed) {
                *stress = *stress - volume * relaxed;
            }
            let [x, y] = corner_forces(constants, full(stress), modes);
            out.store(i, x);
            out.store(stride + i, y);
        }
    }

    /// Forces f_ia = t A B_ja s_ij + G_a Q_i of a row under large rotations.
    #[inline(always)]
    pub(super) fn corotational_row(
        &self,
        row: usize,
        path: StrainPath,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        let moduli = self.elastic.moduli();
        let (stride, constants) = (self.layout.element_stride(), self.constants.row(row));
        for i in columns.step_by(LANES) {
            let (constants, corners) = (&constants[i / LANES], path.u.load(stride, i));
            let gradient = mean_gradient(constants, &corners);
            let stress = corotational_stress(moduli, gradient);
            let stress = stress.map(|row| row.map(|stress| constants[6] * stress));
            let modes = hourglass_modes(constants, &corners, gradient);
            let [x, y] = corner_forces(constants, stress, modes);
            out.store(i, x);
            out.store(stride + i, y);
        }
    }

    /// t A D e (xx, yy, xy), `volume` being t A.
    #[inline(always)]
    fn elastic_stress<V: Lanes>(&self, volume: V, [[xx, xy], [yx, yy]]: [[V; 2]; 2]) -> [V; 3] {
        let c = |value: f64| volume.all(value) * volume;
        let (c11, c12) = (c(self.elastic.c11), c(self.elastic.c12));
        let c33 = c(self.elastic.c33);
        [c11 * xx + c12 * yy, c12 * xx + c11 * yy, c33 * (xy + yx)]
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
            if law.plastic().is_some() && now.is_virgin(1, padded, i) {
                continue;
            }
            let corners = now.u.load(stride, i);
            let gradient = mean_gradient(constants, &corners);
            let energy = law.energy_correction(moduli, gradient, now.history(0, padded, i));
            sum = sum + constants[6] * energy;
            if law.plastic().is_some() {
                // Q (g - g_p) / 2 less Q g / 2.
                let modes = hourglass_modes(constants, &corners, gradient);
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

    /// f_ia = t A B_ja s_ij + G_a Q_i, and the excess of 2 dev e : dev e = (exx - eyy)^2 + (2 exy)^2 + (exx + eyy)^2 / 3, which is exact.
    #[inline(always)]
    fn forces_and_excess<R: Registers>(
        &self,
        registers: R,
        (constants, p): (&[Self::Constants], usize),
        u: [Corners<R::Vector>; 2],
        limit: f64,
    ) -> ([CornerForces<R::Vector>; 2], R::Vector) {
        let constants = registers.load_all(constants, p);
        let gradient = mean_gradient(&constants, &u);
        let modes = hourglass_modes(&constants, &u, gradient);
        let stress = self.elastic_stress(constants[6], gradient);
        let [[xx, xy], [yx, yy]] = gradient;
        let (difference, shear, sum) = (xx - yy, xy + yx, xx + yy);
        let third = registers.splat(1.0 / 3.0);
        let square = (difference * difference + shear * shear) + third * (sum * sum);
        (
            corner_forces(&constants, full(stress), modes),
            square - registers.splat(limit),
        )
    }

    fn limit(&self, plastic: &J2) -> f64 {
        LIMIT_SHARE * plastic.shear_limit()
    }
}

/// Forces of the mean stress times t A and of the hourglass modes, twice G.u, by their stiffness over 4.
#[inline(always)]
fn corner_forces<V: Lanes>(
    [bx1, bx2, by1, by2, hx, hy, _, hourglass]: &[V; CONSTANTS],
    [along_x, along_y]: [[V; 2]; 2],
    [x, y]: [V; 2],
) -> [CornerForces<V>; 2] {
    let forces = |[sx, sy]: [V; 2], mode: V| {
        // G_a Q = h_a Q - B_xa (h.x) Q - B_ya (h.y) Q: the last two join the stress.
        let q = *hourglass * mode;
        let (sx, sy) = (sx - *hx * q, sy - *hy * q);
        CornerForces {
            first: *bx1 * sx + *by1 * sy,
            second: *bx2 * sx + *by2 * sy,
            hourglass: q,
        }
    };
    [forces(along_x, x), forces(along_y, y)]
}

/// The stress (sxx, syy, sxy) as a tensor.
#[inline(always)]
fn full<V: Lanes>([xx, yy, xy]: [V; 3]) -> [[V; 2]; 2] {
    [[xx, xy], [xy, yy]]
}

/// Mean gradient of the displacement of elements with these constants.
#[inline(always)]
fn mean_gradient<V: Lanes>(
    [bx1, bx2, by1, by2, ..]: &[V; CONSTANTS],
    [x, y]: &[Corners<V>; 2],
) -> [[V; 2]; 2] {
    let along = |corners: &Corners<V>| corners.gradient([*bx1, *bx2], [*by1, *by2]);
    [along(x), along(y)]
}

/// Hourglass modes of a pack of elements in plastic flow.
struct HourglassFlow<'a> {
    plastic: &'a J2,
    /// Over 4.
    stiffness: Pack,
    /// 2 g_p in x and in y, and two unused numbers.
    history: History,
    /// Dissipation of the elements (J).
    dissipated: Pack,
}

impl HourglassFlow<'_> {
    /// dg_p = (1 - s) dg where the point flows and Q dg > 0, given the modes at the end of a step and their increments. It
    /// dissipates (Q + Q') dg_p / 2.
    #[inline(always)]
    fn follow(&mut self, modes: [Pack; 2], steps: [Pack; 2], flows: Pack) {
        let softened = Pack::splat(1.0 - softening(self.plastic));
        for k in 0..2 {
            let trial = modes[k] - self.history[k];
            let grows = (trial * steps[k]).if_positive(flows);
            let flow = grows.if_positive(softened * steps[k]);
            let mean = trial - Pack::splat(0.5) * (steps[k] + flow);
            self.dissipated = self.dissipated + self.stiffness * mean * flow;
            self.history[k] = self.history[k] + flow;
        }
    }
}

/// Twice G.u in x and in y: h.u less its linear part.
#[inline(always)]
fn hourglass_modes<V: Lanes>(
    [.., hx, hy, _, _]: &[V; CONSTANTS],
    corners: &[Corners<V>; 2],
    gradient: [[V; 2]; 2],
) -> [V; 2] {
    let of = |k: usize| {
        let [along_x, along_y] = gradient[k];
        corners[k].hourglass() - *hx * along_x - *hy * along_y
    };
    [of(0), of(1)]
}

/// s, the share of the hourglass stiffness that remains in plastic flow.
fn softening(law: &J2) -> f64 {
    let hardening = law.isotropic + law.kinematic;
    (hardening / (3.0 * law.mu + hardening)).max(SOFTENING_MIN)
}

/// K = t A B^T D B + 0.1 min(c11, 6 mu) A (sum B^2) t G G^T in x and in y: the tangent of the forces above.
pub(super) fn stiffness(p: &[[f64; 2]; 4], elastic: &Elastic, thickness: f64) -> Stiffness {
    let (b, volume) = (slopes(p, [0.0, 0.0]), thickness * area(p));
    let mut k = Stiffness::default();
    k.add_material(&b, elastic.moduli(), volume);
    let h = [1.0, -1.0, 1.0, -1.0];
    let moment = [0, 1].map(|k| (0..4).map(|a| h[a] * p[a][k]).sum::<f64>());
    let pure = [0, 1, 2, 3].map(|a| 0.5 * (h[a] - moment[0] * b[a][0] - moment[1] * b[a][1]));
    let sum_b2: f64 = b.iter().flatten().map(|b| b * b).sum();
    let hourglass = hourglass_modulus(elastic) * volume * sum_b2;
    for component in 0..2 {
        let mut row = [0.0; 8];
        (0..4).for_each(|a| row[2 * a + component] = pure[a]);
        k.add_outer(&row, &row, hourglass);
    }
    k
}

/// Modulus that resists the hourglass modes (Pa).
pub fn hourglass_modulus(elastic: &Elastic) -> f64 {
    HOURGLASS * elastic.c11.min(VOLUMETRIC_MAX * elastic.c33)
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
    let hourglass = 0.25 * hourglass_modulus(elastic) * volume * sum_b2;
    [b[0], b[1], b[2], b[3], h(0), h(1), volume, hourglass]
}

#[cfg(test)]
mod tests;
