//! Bounds on the step from the stiffness of contacts and bonds.

use protocol::AccuracyLimit;

use crate::bodies::Bodies;
use crate::bodies::cluster::Cluster;
use crate::bodies::geometry::range;
use crate::contact::bond::Bond;
use crate::step::state::GrainState;

/// Largest h omega of a contact spring whose rebound keeps nine tenths of its speed: e = exp(-pi h omega / 2).
const ELASTIC: f64 = 0.067;

/// Bounds from the stiffness of the contacts, above which results depend on the step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StiffnessBounds {
    /// Longest step with a unique end for any failure of bonds, see [`step_limit`] (s).
    pub bonds_s: Option<f64>,
    /// omega = sqrt(kn/m) of the two lightest grains on a contact spring, m their reduced mass (1/s).
    omega: Option<f64>,
}

impl StiffnessBounds {
    /// The bounds for the bodies of a start, with its bonds and the bonds that healing may make.
    pub fn new(bodies: &Bodies, state: &GrainState) -> StiffnessBounds {
        let heals = bodies.heals();
        let near = state.list.slots.iter().filter(|_| heals);
        let may_be = near.filter_map(|slot| {
            let law = bodies.law.cohesion.as_ref()?;
            Some(Bond::new(bodies, law, [slot.a, slot.b], 0.0))
        });
        let bonds: Vec<Bond> = state.bonds.iter().copied().chain(may_be).collect();
        let masses = bodies.masses.iter().copied().filter(|mass| *mass > 0.0);
        let clusters = bodies.clusters.list.iter().map(Cluster::lightest);
        let lightest = masses.chain(clusters).fold(f64::INFINITY, f64::min);
        let laws = std::iter::once(&bodies.law).chain(bodies.pairs.laws());
        let springs = laws.filter_map(|law| law.springs);
        let stiffest = springs.map(|springs| springs.normal).fold(0.0, f64::max);
        let omega = (2.0 * stiffest / lightest).sqrt();
        StiffnessBounds {
            bonds_s: step_limit(bodies, state, &bonds),
            omega: (omega > 0.0).then_some(omega),
        }
    }

    /// The bounds under their names.
    pub fn limits(&self) -> Vec<AccuracyLimit> {
        let limit = |name: &str, limit_s| AccuracyLimit {
            name: name.into(),
            limit_s,
        };
        let name = "bonds that break, h < 1/(sqrt(3) omega)";
        let bonds = self.bonds_s.map(|h| limit(name, h));
        let springs = self.omega.map(|omega| ELASTIC / omega);
        let springs = springs.map(|h| limit("free rebounds that keep 0.9 of their speed", h));
        bonds.into_iter().chain(springs).collect()
    }

    /// Restitution of an elastic rebound of the two lightest grains in steps of this length (s), least and most over the phases of first touch,
    /// without dampers.
    pub fn restitution(&self, step: f64) -> Option<[f64; 2]> {
        self.omega.map(|omega| numerical_restitution(step * omega))
    }
}

/// Restitution of an elastic contact in steps of h omega under the implicit scheme (theta = 1): least and most over 64 phases of first
/// touch. Each closed step turns velocity and gap by 1/(1 + h omega i) (Jean 1999): e = exp(-pi h omega / 2) for small h omega.
pub fn numerical_restitution(h: f64) -> [f64; 2] {
    if (f64::MIN_POSITIVE..LOOPS).contains(&h) {
        let phases = (0..64).map(|k| short_steps(h, (f64::from(k) + 0.5) / 64.0));
        return range(phases);
    }
    let rebound = |phase: f64| {
        let (mut gap, mut velocity) = (phase * h, -1.0);
        while gap + h * velocity < 0.0 {
            velocity = (velocity - h * gap) / (1.0 + h * h);
            gap += h * velocity;
        }
        velocity
    };
    let phases = (0..64).map(|k| rebound((f64::from(k) + 0.5) / 64.0));
    range(phases)
}

/// Least h omega whose steps are counted out, pi / (h omega) of them.
const LOOPS: f64 = 1e-4;

/// Restitution after `n` closed steps in closed form: z = gap + velocity i turns by -atan(h) and shrinks by sqrt(1 + h^2) in a step, from
/// z = phase h - i until gap + h velocity >= 0.
fn short_steps(h: f64, phase: f64) -> f64 {
    let (start, turn) = ((phase * h).atan(), h.atan());
    let n = ((std::f64::consts::PI + start) / turn).ceil() - 1.0;
    let shrinks = 0.5 * ((phase * h).powi(2).ln_1p() - n * (h * h).ln_1p());
    -shrinks.exp() * (start - n * turn).cos()
}

/// The longest step whose end is unique for any failure of bonds, h < 1/(sqrt(3) omega) with omega = sqrt(l Cn / m_eff) (s); the smallest over all
/// bonds of this state. 1/m_eff of a cluster is 1/M + a^2/I.
pub fn step_limit(bodies: &Bodies, state: &GrainState, bonds: &[Bond]) -> Option<f64> {
    let law = bodies.law.cohesion?;
    let positions = state.positions(bodies);
    let squares = bonds.iter().map(|bond| {
        let pair = [bond.a, bond.b].map(|body| body as usize);
        let normal = positions.proximity(pair[0], pair[1]).normal;
        let [a, b] = pair.map(|body| match state.mobility(bodies, body, normal) {
            None => bodies.masses.get(body).map_or(0.0, |m| 1.0 / m),
            Some([own, ..]) => own,
        });
        bond.area * law.normal * (a + b)
    });
    let fastest = squares.fold(0.0, f64::max).sqrt();
    (fastest > 0.0).then(|| 1.0 / (3f64.sqrt() * fastest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published for small steps; and by hand at h omega = 1 from the middle of a step: after the first step v = (-1 - 0.5)/2 = -0.75 at g = -0.25,
    /// then v = (-0.75 + 0.25)/2 = -0.25 at -0.5, 0.125 at -0.375, 0.25 at -0.125.
    #[test]
    fn the_step_damps_the_rebound_of_a_spring() {
        for h in [1e-3, 1e-2, 0.05] {
            let [low, high] = numerical_restitution(h);
            let exact = (-std::f64::consts::FRAC_PI_2 * h).exp();
            assert!(
                (low..=high).contains(&exact) || (high - exact).abs() < 2.0 * h * h,
                "{low} {exact} {high}"
            );
            assert!(high - low < h * h.max(0.02), "{low} {high}");
        }
        // In closed form as step by step, and in no time where the steps are short.
        for h in [1e-3, 1e-2, 0.1] {
            let closed = range((0..64).map(|k| short_steps(h, (f64::from(k) + 0.5) / 64.0)));
            let counted = numerical_restitution(h);
            for (a, b) in closed.into_iter().zip(counted) {
                assert!((a - b).abs() < 1e-12, "{h}: {closed:?} {counted:?}");
            }
        }
        for h in [1e-8, 1e-30, 1e-300] {
            let [low, high] = numerical_restitution(h);
            assert!(1.0 - low < 2.0 * h && high <= 1.0, "{h}: {low} {high}");
        }
        let [low, high] = numerical_restitution(1.0);
        assert!(low <= 0.25 && (0.25..0.4).contains(&high), "{low} {high}");
    }
}
