//! Laws beyond linear elasticity in small strain, for a pack of points at a time.
//!
//! Small strain takes the symmetric part of the displacement gradient. The corotational strain is E = U - 1 of the polar
//! decomposition 1 + grad u = R U; in the plane R has the cosine and sine (F11 + F22, F21 - F12)/r, r their norm. With
//! the isotropic law S = D E the first Piola-Kirchhoff stress R S is the exact derivative of the energy E D E / 2:
//! S : R^T dF = S : (R^T dR U + dU), and S R^T dR U has no trace because U and S commute (Biot 1965; Ogden, Non-Linear
//! Elastic Deformations, 1984, section 6.1.4). Forces therefore do no work around a closed path and have no resultant.
//! Forces are no longer linear in u, so the ledger's work by the trapezium rule differs from the energy by an error of second order in the step: 1e-6
//! of the work for a column that is bent over at 0.9 of the stability limit.

use crate::material::j2::{History, J2, Plane3};
use crate::pack::lanes::Pack;

/// Law of a point that differs from linear elasticity in small strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NonlinearLaw {
    /// Linear elasticity in the stretch without the rotation.
    Corotational,
    /// Plasticity in small strain.
    Plastic(J2),
}

/// Gradient u,x u,y / v,x v,y of a displacement, or the stress that does work on it.
pub(crate) type Gradient = [[Pack; 2]; 2];

/// Rotation by its cosine and sine.
#[derive(Clone, Copy)]
pub(crate) struct Rotation {
    cos: Pack,
    sin: Pack,
}

impl NonlinearLaw {
    /// Plasticity, where the law has it.
    pub fn plastic(&self) -> Option<&J2> {
        match self {
            NonlinearLaw::Corotational => None,
            NonlinearLaw::Plastic(plastic) => Some(plastic),
        }
    }

    /// Stored energy less half the product of stress and gradient (J/m3), the correction of the sum u F(u) / 2 over the nodes. With R S : grad u = S
    /// : E + tr S - tr R S it is (tr R S - tr S) / 2 for the rotation, and for plasticity [`J2::energy_correction`].
    #[inline(always)]
    pub(crate) fn energy_correction(
        &self,
        moduli: [f64; 3],
        gradient: Gradient,
        history: History,
    ) -> Pack {
        match self {
            NonlinearLaw::Corotational => {
                let (strain, rotation) = stretch(gradient);
                let trace = Pack::splat(moduli[0] + moduli[1]) * (strain[0] + strain[1]);
                // The trace of R S is cos tr S, S being symmetric.
                Pack::splat(0.5) * (rotation.cos - Pack::splat(1.0)) * trace
            }
            NonlinearLaw::Plastic(plastic) => {
                plastic.energy_correction(symmetric(gradient), history)
            }
        }
    }
}

/// Stress R D E of a pack of points, E = U - 1.
#[inline(always)]
pub(crate) fn corotational_stress(moduli: [f64; 3], gradient: Gradient) -> Gradient {
    let (strain, rotation) = stretch(gradient);
    rotation.turn(hooke(moduli.map(Pack::splat), strain))
}

/// Stress D e: (c11 exx + c12 eyy, c12 exx + c11 eyy, c33 2 exy).
#[inline(always)]
pub(crate) fn hooke([c11, c12, c33]: [Pack; 3], [exx, eyy, shear]: Plane3) -> Plane3 {
    [c11 * exx + c12 * eyy, c12 * exx + c11 * eyy, c33 * shear]
}

/// Corotational strain (exx, eyy, 2 exy) of one point, and the cosine and sine of its rotation.
pub fn stretch_at(gradient: [[f64; 2]; 2]) -> ([f64; 3], [f64; 2]) {
    let (strain, rotation) = stretch(gradient.map(|row| row.map(Pack::splat)));
    let first = |pack: Pack| pack.0[0];
    (
        strain.map(first),
        [first(rotation.cos), first(rotation.sin)],
    )
}

/// Strain (exx, eyy, 2 exy).
#[inline(always)]
pub(crate) fn symmetric([[xx, xy], [yx, yy]]: Gradient) -> Plane3 {
    [xx, yy, xy + yx]
}

/// E = U - 1 and R of 1 + grad u = R U.
#[inline(always)]
pub(crate) fn stretch([[xx, xy], [yx, yy]]: Gradient) -> (Plane3, Rotation) {
    let one = Pack::splat(1.0);
    let (fxx, fyy) = (one + xx, one + yy);
    let (a, b) = (fxx + fyy, yx - xy);
    let scale = one / (a * a + b * b).sqrt();
    let (cos, sin) = (scale * a, scale * b);
    let shear = (cos * xy + sin * fyy) + (cos * yx - sin * fxx);
    let strain = [
        cos * fxx + sin * yx - one,
        cos * fyy - sin * xy - one,
        shear,
    ];
    (strain, Rotation { cos, sin })
}

impl Rotation {
    /// R S
    #[inline(always)]
    fn turn(&self, [xx, yy, xy]: Plane3) -> Gradient {
        let Rotation { cos, sin } = *self;
        [
            [cos * xx - sin * xy, cos * xy - sin * yy],
            [sin * xx + cos * xy, sin * xy + cos * yy],
        ]
    }
}

/// Plasticity with every factor as in the formula, a reference for the tests of the elements.
#[cfg(test)]
pub(crate) mod plain {
    use super::{Gradient, hooke, symmetric};
    use crate::material::j2::{J2, PointHistory};
    use crate::pack::lanes::Pack;

    /// Stress D e - 2 mu p' under `gradient` after the radial return [`J2::return_map`], which updates the history, and the dissipation
    /// (J/m3). `moduli` (c11, c12, c33) belong to the element, which may exclude the change of volume; `increment` gives the gradient of the last
    /// step.
    pub(crate) fn respond(
        plastic: &J2,
        moduli: [f64; 3],
        [gradient, increment]: [Gradient; 2],
        history: &mut PointHistory,
        at: usize,
    ) -> (Gradient, Pack) {
        let strain = symmetric(gradient);
        let (relaxed, dissipated) = plastic.return_map(
            strain,
            || symmetric(increment),
            history,
            (at, Pack::splat(1.0)),
        );
        let [xx, yy, xy] = hooke(moduli.map(Pack::splat), strain);
        let shear = xy - relaxed[2];
        let stress = [[xx - relaxed[0], shear], [shear, yy - relaxed[1]]];
        (stress, dissipated)
    }
}
