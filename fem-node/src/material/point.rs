//! The law at a point: from the gradient of the displacement to the stress, for a pack of points at a time.
//!
//! Small strain takes the symmetric part of the gradient. The corotational strain is E = U - 1 of the polar
//! decomposition 1 + grad u = R U; in the plane R has the cosine and sine (F11 + F22, F21 - F12)/r, r their norm. With
//! the isotropic law S = D E the first Piola-Kirchhoff stress R S is the exact derivative of the energy E D E / 2:
//! S : R^T dF = S : (R^T dR U + dU), and S R^T dR U has no trace because U and S commute (Biot 1965; Ogden, Non-Linear
//! Elastic Deformations, 1984, section 6.1.4). Forces therefore do no work around a closed path and have no resultant.
//! Forces are no longer linear in u, so that the work which the ledger takes by the trapezium rule departs from the
//! energy with the square of the step: 1e-6 of the work for a column that is bent over at 0.9 of the stability limit.

use crate::config::Kinematics;
use crate::material::j2::{J2, Past, Plane3, PointHistory};
use crate::pack::Pack;

/// Everything that makes a point differ from linear elasticity in small strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLaw {
    /// What is taken for the strain.
    pub kinematics: Kinematics,
    /// Plasticity, where the material has it.
    pub plastic: Option<J2>,
}

/// u,x u,y / v,x v,y, or the stress that does work on it.
pub(crate) type Gradient = [[Pack; 2]; 2];

/// What a pack of points answers.
pub(crate) struct Response {
    pub(crate) stress: Gradient,
    /// J/m3.
    pub(crate) dissipated: Pack,
}

/// Cosine and sine of the rotation.
#[derive(Clone, Copy)]
struct Rotation {
    cos: Pack,
    sin: Pack,
}

impl PointLaw {
    /// The law where it is more than linear.
    pub fn new(kinematics: Kinematics, plastic: Option<J2>) -> Option<PointLaw> {
        let linear = kinematics == Kinematics::Small && plastic.is_none();
        (!linear).then_some(PointLaw {
            kinematics,
            plastic,
        })
    }

    /// Stress under `gradient`, the material remembering what it went through. `moduli` (c11, c12, c33) are those of
    /// the element, which may take the change of volume out; `increment` gives the gradient of the last step.
    #[inline(always)]
    pub(crate) fn respond(
        &self,
        moduli: [f64; 3],
        gradient: Gradient,
        increment: impl FnOnce() -> Gradient,
        history: &mut PointHistory,
        at: usize,
    ) -> Response {
        let (strain, rotation) = self.strain(gradient);
        let [c11, c12, c33] = moduli.map(Pack::splat);
        let mut stress = [
            c11 * strain[0] + c12 * strain[1],
            c12 * strain[0] + c11 * strain[1],
            c33 * strain[2],
        ];
        let mut dissipated = Pack::splat(0.0);
        if let Some(plastic) = &self.plastic {
            let since = || self.strain_since(strain, gradient, increment());
            let (less, heat) = plastic.yield_to(strain, since, history, at);
            dissipated = heat;
            for (stress, less) in stress.iter_mut().zip(less) {
                *stress = *stress - less;
            }
        }
        let stress = match rotation {
            None => [[stress[0], stress[2]], [stress[2], stress[1]]],
            Some(rotation) => rotation.turn(stress),
        };
        Response { stress, dissipated }
    }

    /// Stored energy less half the product of stress and gradient (J/m3): the whole of what the sum u F(u) / 2 over
    /// the nodes misses or has too much. With R S : grad u = S : E + tr S - tr R S it is (tr R S - tr S) / 2 for the
    /// rotation, and for plasticity that of [`J2::energy_beyond`].
    #[inline(always)]
    pub(crate) fn energy_beyond(&self, moduli: [f64; 3], gradient: Gradient, past: Past) -> Pack {
        let (strain, rotation) = self.strain(gradient);
        let mut energy = Pack::splat(0.0);
        let mut trace = Pack::splat(moduli[0] + moduli[1]) * (strain[0] + strain[1]);
        if let Some(plastic) = &self.plastic {
            energy = plastic.energy_beyond(strain, past);
            trace = trace - plastic.trace(past);
        }
        if let Some(rotation) = rotation {
            // The trace of R S is cos tr S, S being symmetric.
            energy = energy + Pack::splat(0.5) * (rotation.cos - Pack::splat(1.0)) * trace;
        }
        energy
    }

    /// Strain (exx, eyy, 2 exy) of one point, and the cosine and sine of its rotation where that is taken out.
    pub(crate) fn strain_at(&self, gradient: [[f64; 2]; 2]) -> ([f64; 3], Option<[f64; 2]>) {
        let (strain, rotation) = self.strain(gradient.map(|row| row.map(Pack::splat)));
        let first = |pack: Pack| pack.0[0];
        let rotation = rotation.map(|rotation| [first(rotation.cos), first(rotation.sin)]);
        (strain.map(first), rotation)
    }

    #[inline(always)]
    fn strain(&self, [[xx, xy], [yx, yy]]: Gradient) -> (Plane3, Option<Rotation>) {
        match self.kinematics {
            Kinematics::Small => ([xx, yy, xy + yx], None),
            Kinematics::Corotational => {
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
                (strain, Some(Rotation { cos, sin }))
            }
        }
    }

    /// Strain of a step whose gradient changed by `increment`.
    #[inline(always)]
    fn strain_since(&self, strain: Plane3, gradient: Gradient, increment: Gradient) -> Plane3 {
        match self.kinematics {
            Kinematics::Small => self.strain(increment).0,
            Kinematics::Corotational => {
                let mut before = gradient;
                for (row, increments) in before.iter_mut().zip(increment) {
                    for (value, increment) in row.iter_mut().zip(increments) {
                        *value = *value - increment;
                    }
                }
                let (old, _) = self.strain(before);
                [0, 1, 2].map(|k| strain[k] - old[k])
            }
        }
    }
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
