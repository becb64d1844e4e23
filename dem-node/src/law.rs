//! Contact laws: unilateral contact, Coulomb friction and elastic compliance, solved in closed form.

use crate::cohesion::Cohesion;
use crate::error::DemError;

/// What happens at every contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Tangential part.
    pub friction: Friction,
    /// Elasticity of the grains; `None` makes rigid contacts.
    pub springs: Option<Springs>,
    /// Bonds between grains; `None` makes a loose material.
    pub cohesion: Option<Cohesion>,
    /// Newton's coefficient e of rigid contacts without bond; `None` makes inelastic impacts.
    pub restitution: Option<f64>,
    /// What happens to overlaps of rigid contacts without bond.
    pub penetration: Penetration,
}

/// How a rigid contact treats its gap, and the overlap that is there already.
///
/// A repair within the velocities throws the grains apart that it separates (Baumgarte): what it moves in a step they keep
/// as speed. The two repairs of positions leave the velocities alone (see [`crate::repair`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Penetration {
    /// U = u_n + g/h: an overlap is gone after the step, at the price of a speed |g|/h.
    #[default]
    Gap,
    /// U = u_n + max(0, g)/h: overlaps stay (LMGC90's IQS).
    Iqs,
    /// As IQS, then the bodies are moved apart along the normals of the step.
    Split,
    /// As IQS, then the bodies are moved apart until no pair overlaps where it is.
    Projection,
}

/// The tangential part of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Friction {
    /// None at all.
    Signorini,
    /// |r_t| <= coefficient r_n, opposed to sliding.
    Coulomb {
        /// The coefficient.
        coefficient: f64,
    },
}

/// Springs of a compliant contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Springs {
    /// kn (N/m).
    pub normal: f64,
    /// kt (N/m).
    pub tangential: f64,
}

impl Law {
    /// Coefficient of friction, 0 without friction.
    pub fn coefficient(&self) -> f64 {
        match self.friction {
            Friction::Signorini => 0.0,
            Friction::Coulomb { coefficient } => coefficient,
        }
    }

    /// Whether overlaps are repaired after a step.
    pub fn repairs(&self) -> bool {
        matches!(
            self.penetration,
            Penetration::Split | Penetration::Projection
        )
    }

    /// What the springs add to the diagonal of W in a step h (1/kg): 1/(kn h^2) and 1/(kt h^2).
    ///
    /// The force at the end of the step is -kn (g + h u_n), so the impulse r obeys
    /// u_n + g/h + r/(kn h^2) = 0 while the contact is closed: a rigid contact with a softer W.
    pub fn compliance(&self, step: f64) -> [f64; 2] {
        match self.springs {
            None => [0.0, 0.0],
            Some(springs) => [
                1.0 / (springs.normal * step * step),
                1.0 / (springs.tangential * step * step),
            ],
        }
    }

    /// What a contact without bond adds to u_n in U (m/s), its gap g being detected, its normal velocity before the
    /// step u_n(t_i) = `before`; `None` where there is no contact.
    ///
    /// Springs: g/h. Restitution: e u_n(t_i) when g <= 0, and no contact before that: a contact that closes its gap within
    /// the step would have lost its speed before it rebounds (Moreau 1988; LMGC90's RST). Otherwise see [`Penetration`].
    #[inline]
    pub fn bias(&self, gap: f64, before: f64, step: f64) -> Option<f64> {
        match (self.springs, self.restitution, self.penetration) {
            (Some(_), _, _) | (None, None, Penetration::Gap) => Some(gap / step),
            (None, Some(restitution), _) => (gap <= 0.0).then_some(restitution * before),
            (None, None, _) => Some(gap.max(0.0) / step),
        }
    }

    /// Elastic energy of a contact under these forces (J).
    pub fn stored(&self, force: [f64; 2]) -> [f64; 2] {
        match self.springs {
            None => [0.0, 0.0],
            Some(springs) => [
                0.5 * force[0] * force[0] / springs.normal,
                0.5 * force[1] * force[1] / springs.tangential,
            ],
        }
    }
}

/// The symmetric 2x2 block of W = H^T M^-1 H at one contact, springs included (1/kg).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Block {
    /// Normal.
    pub nn: f64,
    /// Normal to tangent.
    pub nt: f64,
    /// Tangential.
    pub tt: f64,
}

/// The block with everything that does not change during a step, so that a sweep never divides.
#[derive(Clone, Copy, Debug, Default)]
pub struct LocalLaw {
    inverse: Block,
    /// 1 / (W_nn + s mu W_nt) for s = +1 and s = -1.
    slide: [f64; 2],
    friction: f64,
}

impl LocalLaw {
    /// Prepares a contact. Sliding needs W_nn - mu |W_nt| > 0, or its impulse is not unique.
    pub fn new(block: Block, friction: f64, pair: (u32, u32)) -> Result<LocalLaw, DemError> {
        let denominator = block.nn - friction * block.nt.abs();
        let tangential = block.tt.max(PRESCRIBED * block.nn);
        let determinant = block.nn * tangential - block.nt * block.nt;
        // Written so that a NaN is refused as well.
        if !(denominator > 0.0 && determinant > 0.0) {
            return Err(DemError::Denominator {
                a: pair.0,
                b: pair.1,
                denominator: denominator.min(determinant),
            });
        }
        Ok(LocalLaw {
            inverse: Block {
                nn: tangential / determinant,
                nt: -block.nt / determinant,
                tt: block.nn / determinant,
            },
            slide: [
                1.0 / (block.nn + friction * block.nt),
                1.0 / (block.nn - friction * block.nt),
            ],
            friction,
        })
    }

    /// The impulse (r_n, r_t) that solves U = b + W r under Signorini and Coulomb, `b` being U without impulse:
    /// b_n >= 0 opens; else stick r = -W^-1 b if |r_t| <= mu r_n; else slide with
    /// r_t = s mu r_n, r_n = -b_n / (W_nn + s mu W_nt), s the sign of the sticking r_t
    /// (Jean 1999, the closed 2D solution of LMGC90's IQS_CLB). Unique since W_nn > mu |W_nt|.
    #[inline(always)]
    pub fn impulse(&self, b: [f64; 2]) -> [f64; 2] {
        if b[0] >= 0.0 {
            return [0.0, 0.0];
        }
        let stick_n = -(self.inverse.nn * b[0] + self.inverse.nt * b[1]);
        let stick_t = -(self.inverse.nt * b[0] + self.inverse.tt * b[1]);
        if stick_t.abs() <= self.friction * stick_n {
            [stick_n, stick_t]
        } else if stick_t > 0.0 {
            let r_n = -b[0] * self.slide[0];
            [r_n, self.friction * r_n]
        } else {
            let r_n = -b[0] * self.slide[1];
            [r_n, -self.friction * r_n]
        }
    }
}

/// A rigid contact of two bodies with prescribed sideways motion (glued disk on a fixed wall under the wheel) has
/// W_tt = 0: friction then follows the sliding direction. This small value gives just that.
const PRESCRIBED: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCK: Block = Block {
        nn: 2.0,
        nt: 0.6,
        tt: 3.0,
    };

    fn law(friction: f64) -> LocalLaw {
        LocalLaw::new(BLOCK, friction, (0, 1)).expect("it is well posed")
    }

    fn velocity(b: [f64; 2], r: [f64; 2]) -> [f64; 2] {
        [
            b[0] + BLOCK.nn * r[0] + BLOCK.nt * r[1],
            b[1] + BLOCK.nt * r[0] + BLOCK.tt * r[1],
        ]
    }

    #[test]
    fn an_opening_contact_has_no_impulse() {
        assert_eq!(law(0.3).impulse([0.1, -5.0]), [0.0, 0.0]);
    }

    #[test]
    fn sticking_stops_both_components() {
        let b = [-1.0, -0.4];
        let u = velocity(b, law(0.5).impulse(b));
        assert!(u[0].abs() < 1e-15 && u[1].abs() < 1e-15, "{u:?}");
    }

    #[test]
    fn sliding_keeps_contact_and_opposes_the_slip() {
        for b in [[-1.0, 4.0], [-1.0, -4.0]] {
            let r = law(0.3).impulse(b);
            let u = velocity(b, r);
            assert!(u[0].abs() < 1e-15);
            assert!((r[1].abs() - 0.3 * r[0]).abs() < 1e-15);
            assert!(r[1] * u[1] < 0.0, "friction must dissipate: {r:?} {u:?}");
        }
    }

    #[test]
    fn a_block_without_unique_slip_is_refused() {
        let block = Block {
            nn: 1.0,
            nt: 0.9,
            tt: 1.0,
        };
        let error = LocalLaw::new(block, 1.2, (3, 7)).expect_err("1 - 1.2 x 0.9 < 0");
        assert!(error.to_string().contains("bodies 3 and 7"), "{error}");
    }
}
