//! Contact laws: unilateral contact, Coulomb friction and elastic compliance, solved in closed form.
//!
//! In reading order:
//! - `lanes`: numbers side by side;
//! - [`adhesion`]: attraction of bodies that touch;
//! - [`cohesion`], [`healing`]: the cohesive zone of a bond, and bonds that grow;
//! - [`heat`]: sources and conductance of a contact;
//! - [`local`], [`vector`]: the local problem of a contact, and of several side by side.

pub mod adhesion;
pub mod cohesion;
pub mod healing;
pub mod heat;
pub(crate) mod lanes;
pub mod local;
pub mod vector;

use crate::law::adhesion::Adhesion;
use crate::law::cohesion::Cohesion;
use crate::law::healing::Healing;

/// The law of every contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Law {
    /// Coefficient of Coulomb friction, |r_t| <= coefficient r_n opposed to sliding; 0 is Signorini alone.
    pub friction: f64,
    /// Coefficient mu_r of rolling resistance: a couple of at most mu_r r r_n against relative spin.
    pub rolling: f64,
    /// Elasticity of the grains; `None` makes rigid contacts.
    pub springs: Option<Springs>,
    /// Attraction of pairs that touch or nearly do.
    pub adhesion: Option<Adhesion>,
    /// Bonds between grains; `None` makes a loose material.
    pub cohesion: Option<Cohesion>,
    /// Growth of bonds between pairs that press on each other.
    pub healing: Option<Healing>,
    /// Newton's coefficient e of rigid contacts without bond; `None` makes inelastic impacts.
    pub restitution: Option<f64>,
    /// Treatment of overlaps of rigid contacts without bond.
    pub penetration: Penetration,
}

/// Treatment of the gap of a rigid contact and of an overlap. The two repairs of positions do not change the velocities (see
/// [`crate::step::repair`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Penetration {
    /// U = u_n + g/h.
    Gap,
    /// U = u_n + max(0, g)/h.
    #[default]
    Iqs,
    /// As IQS, then the bodies are moved apart along the normals of the step.
    Split,
    /// As IQS, then the bodies are moved apart until no pair overlaps at its new position.
    Projection,
}

impl Penetration {
    /// True if overlaps are repaired after a step.
    pub fn repairs(self) -> bool {
        matches!(self, Penetration::Split | Penetration::Projection)
    }
}

/// Springs of a compliant contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Springs {
    /// kn (N/m).
    pub normal: f64,
    /// kt (N/m).
    pub tangential: f64,
    /// Damping ratio zeta of the normal spring: a damper of c = 2 zeta sqrt(kn m) lies parallel to it, m being the reduced mass of the pair. Contacts
    /// without bond have the damper while they overlap.
    pub damping: f64,
}

impl Springs {
    /// Damping ratio under which a pair that meets leaves with this part e of its speed, 0.14 to 1, the contact ending where its
    /// force vanishes: e = exp(-(pi - 2 phi) tan phi), zeta = sin phi (Schwager and Poschel 2007).
    pub fn damping_ratio(restitution: f64) -> f64 {
        let [mut low, mut high] = [0.0, std::f64::consts::FRAC_PI_2];
        while high - low > f64::EPSILON {
            let phi = 0.5 * (low + high);
            let e = (-(std::f64::consts::PI - 2.0 * phi) * phi.tan()).exp();
            *(if e > restitution { &mut low } else { &mut high }) = phi;
        }
        high.sin() * f64::from(u8::from(restitution < 1.0))
    }

    /// Part of its speed with which a pair leaves under this damping ratio, see [`Springs::damping_ratio`]. Above 1, where phi is imaginary
    /// beyond pi/2: e = exp(-2 psi / tanh psi), zeta = cosh psi.
    pub fn restitution(damping_ratio: f64) -> f64 {
        if damping_ratio < 1.0 {
            let phi = damping_ratio.asin();
            return (-(std::f64::consts::PI - 2.0 * phi) * phi.tan()).exp();
        }
        let psi = damping_ratio.acosh().max(f64::EPSILON);
        (-2.0 * psi / psi.tanh()).exp()
    }

    /// Factor of 1/(kn h^2) and g/h on overlapping surfaces in a step h (s), see [`damped_share`].
    pub fn damped_share(&self, pair: PairMobility, h: f64) -> f64 {
        damped_share(relaxation(self.damping, self.normal, pair), h)
    }
}

/// Part of the inverse mass of a body below which its contacts count as held: within 6 degrees of a direction in which the body cannot move.
const HELD: f64 = 0.01;

/// Inverse masses of a pair that set a damper between its bodies (1/kg).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairMobility {
    /// 1/m, the sum over both bodies along the damper.
    pub along: f64,
    /// Least inverse mass of the bodies that can move in some direction.
    pub free: f64,
}

impl PairMobility {
    /// The pair of two bodies that have these inverse masses along the damper, and where nothing holds them.
    pub fn of([a, b]: [[f64; 2]; 2]) -> PairMobility {
        let moving = [a[1], b[1]].into_iter().filter(|inverse| *inverse > 0.0);
        PairMobility {
            along: a[0] + b[0],
            free: moving.reduce(f64::min).unwrap_or(0.0),
        }
    }
}

/// Ratio c/k of a damper to its parallel spring k (N/m) (s), 2 zeta / omega with omega^2 = k/m.
///
/// Between two bodies that nothing moves along the damper there is no damper. Where 1/m vanishes as a contact turns to a held direction, so does the
/// damper: c = 2 zeta sqrt(k m) alone would grow without bound just beside it, and stop what the held body slides past.
pub fn relaxation(damping: f64, k: f64, pair: PairMobility) -> f64 {
    if pair.along == 0.0 || damping == 0.0 {
        return 0.0;
    }
    let held = (pair.along / (HELD * pair.free)).min(1.0);
    held * 2.0 * damping / (k * pair.along).sqrt()
}

/// Factor of the terms 1/(k h^2) and g/h of a spring with a parallel damper of this ratio c/k (s), in a step h (s): the force is -k (g + h u) - c u.
pub fn damped_share(relaxation: f64, h: f64) -> f64 {
    if relaxation == 0.0 {
        return 1.0;
    }
    1.0 / (1.0 + relaxation / h)
}

impl Law {
    /// Addition of the springs to the diagonal of W in a step h (1/kg): 1/(kn h^2) and 1/(kt h^2).
    ///
    /// The force at the end of the step is -kn (g + h u_n), so the impulse r obeys
    /// u_n + g/h + r/(kn h^2) = 0 while the contact is closed: a rigid contact with a softer W.
    pub fn compliance(&self, step: f64) -> [f64; 2] {
        let both = |springs: Springs| [springs.normal, springs.tangential];
        let compliance = |k: f64| 1.0 / (k * step * step);
        self.springs
            .map_or([0.0; 2], |springs| both(springs).map(compliance))
    }

    /// Term that U_n of a contact without bond has in addition to u_n (m/s), for its detected gap g and its normal velocity before the step u_n(t_i)
    /// = `before`; `None` where there is no contact.
    ///
    /// Springs: g/h. Restitution: e u_n(t_i) when g <= 0, and no contact before: a contact that closed its gap within the step would lose its speed
    /// before it rebounds (Moreau 1988; LMGC90's RST). Otherwise see [`Penetration`].
    #[inline]
    pub fn bias(&self, gap: f64, before: f64, step: f64) -> Option<f64> {
        match (self.springs, self.restitution, self.penetration) {
            (Some(_), _, _) | (None, None, Penetration::Gap) => Some(gap / step),
            (None, Some(restitution), _) => (gap <= 0.0).then_some(restitution * before),
            (None, None, _) => Some(gap.max(0.0) / step),
        }
    }

    /// Part of the friction that remains with a bond of this adhesion: 1 for rigid contacts, 1 - a for springs with healing (Raous and Monerie 2002),
    /// so that a pair does not lose its friction to a bond that bears nothing yet, 0 for other springs.
    pub fn friction_share(&self, adhesion: f64) -> f64 {
        match (self.springs, self.healing) {
            (None, _) => 1.0,
            (Some(_), Some(_)) => 1.0 - adhesion,
            (Some(_), None) => 0.0,
        }
    }

    /// True if there are dampers.
    pub fn is_damped(&self) -> bool {
        self.springs.is_some_and(|springs| springs.damping > 0.0)
            || self.cohesion.is_some_and(|bonds| bonds.damping > 0.0)
    }

    /// The law of a contact that has the share 1 / (1 + `joined`) of its springs.
    pub fn shared(mut self, joined: f64) -> Law {
        if let Some(springs) = &mut self.springs {
            springs.normal /= 1.0 + joined;
            springs.tangential /= 1.0 + joined;
        }
        self
    }

    /// Elastic energy of a contact under these forces (J).
    pub fn stored(&self, force: [f64; 2]) -> [f64; 2] {
        let [n, t] = force.map(|force| 0.5 * force * force);
        let stored = |springs: Springs| [n / springs.normal, t / springs.tangential];
        self.springs.map_or([0.0; 2], stored)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body of 1 kg that moves only along x touches a fixed one under an angle to y: with the angle the damper's force vanishes too.
    #[test]
    fn a_damper_vanishes_with_the_motion_along_it() {
        let damper = |angle: f64| {
            let along = angle.sin() * angle.sin();
            relaxation(0.5, 4.0, PairMobility::of([[along, 1.0], [0.0, 0.0]]))
        };
        assert_eq!(damper(0.0), 0.0);
        assert!((damper(1e-9) - 0.5 * 1e-7).abs() < 1e-15);
        assert!((damper(0.5) - 0.5 / 0.5f64.sin()).abs() < 1e-15);
        assert!((1..100).all(|k| damper(0.01 * f64::from(k)) < 10.0 * 0.5));
        let free = PairMobility::of([[1.0; 2], [3.0; 2]]);
        assert_eq!(relaxation(0.5, 4.0, free), 0.25);
    }

    /// zeta = 1 has the restitution exp(-2), the limit from both sides.
    #[test]
    fn the_damping_ratio_of_a_restitution_gives_it_back() {
        for e in [0.14, 0.3, 0.7, 1.0] {
            let back = Springs::restitution(Springs::damping_ratio(e));
            assert!((back - e).abs() < 1e-7, "{e}: {back}");
        }
        for zeta in [1.0 - 1e-9, 1.0, 1.0 + 1e-9] {
            let e = Springs::restitution(zeta);
            assert!((e - (-2f64).exp()).abs() < 1e-4, "{zeta}: {e}");
        }
        assert!(Springs::restitution(1.5) < Springs::restitution(1.1));
    }
}
