//! What a contact loses in a step: in impacts, in slip, by falling adhesion, and by what detection finds otherwise.

use crate::law::Law;

/// Impulse and motion of a contact in a step.
#[derive(Clone, Copy, Debug)]
pub struct ContactStep {
    /// Step (s).
    pub step: f64,
    /// Weight of the end velocity.
    pub theta: f64,
    /// Gap at detection (m).
    pub gap: f64,
    /// Gap along its normal at the end of the last step (m).
    pub last_gap: f64,
    /// Elongation of the tangential spring before and after (m).
    pub spring: [f64; 2],
    /// Impulse (N s).
    pub impulse: [f64; 2],
    /// Relative velocity after the step (m/s).
    pub velocity: [f64; 2],
    /// Its change in the step (m/s).
    pub change: [f64; 2],
}

impl ContactStep {
    /// Energy that a spring k (N/m) lost since the last step without any work (J), negative for one that gained.
    ///
    /// The work of a step goes along its normal, and disks that pass each other by s turn it: the gap that is then detected
    /// is about s^2/(2 (r_1 + r_2)) wider than the one at the end of the last step. A loss of the scheme, of first order
    /// over a run: 1.8 % of the energy of a wheel that falls on a layer at 10 m/s in steps of 2e-7 s.
    pub fn turned(&self, k: f64) -> f64 {
        0.5 * k * (self.last_gap.min(0.0).powi(2) - self.gap.min(0.0).powi(2))
    }
}

/// Energy that a contact loses in a step (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// Loss in impacts and by the scheme.
    pub impact: f64,
    /// Loss in slip.
    pub friction: f64,
    /// Loss by falling adhesion.
    pub cohesion: f64,
    /// Energy that detection did not find again, of either sign.
    pub detection: f64,
}

/// Energy that a contact without bond loses in a step.
///
/// Rigid: -r_n u_n and -r_t u_t, at the theta velocity.
/// Compliant: a spring driven implicitly from elongation e_0 to e loses k (e - e_0)^2 / 2; one that closes in the step
/// is pushed over the open gap as well, k |e| g. Of the tangential path h u_t the part d' - d goes into the spring and
/// the rest is slip. What theta < 1 weighs differently is r (1 - theta) du.
pub fn contact_loss(law: &Law, contact: &ContactStep) -> Loss {
    let ([r_n, r_t], [u_n, u_t], h) = (contact.impulse, contact.velocity, contact.step);
    let behind = 1.0 - contact.theta;
    let correction = [
        r_n * behind * contact.change[0],
        r_t * behind * contact.change[1],
    ];
    let Some(springs) = law.springs else {
        return Loss {
            impact: -r_n * u_n + correction[0],
            friction: -r_t * u_t + correction[1],
            ..Loss::default()
        };
    };
    let (before, after) = (contact.gap.min(0.0), -r_n / (h * springs.normal));
    let normal = 0.5 * springs.normal * (after - before).powi(2)
        - springs.normal * after * contact.gap.max(0.0);
    let stretch = contact.spring[1] - contact.spring[0];
    let tangential = 0.5 * springs.tangential * stretch.powi(2);
    let slip = h * u_t - stretch;
    Loss {
        impact: normal + tangential + correction[0] + correction[1],
        friction: -r_t * slip / h,
        cohesion: 0.0,
        detection: contact.turned(springs.normal),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Springs;

    const SPRUNG: Law = Law {
        friction: 0.4,
        springs: Some(Springs {
            normal: 8.0,
            tangential: 2.0,
        }),
        cohesion: None,
        restitution: None,
        penetration: crate::law::Penetration::Gap,
    };

    /// Pushed from an overlap of 0.3 to 0.5, 2 / (0.5 x 8); of the way of 0.5 the tangential spring takes 0.2.
    fn step(gap: f64) -> ContactStep {
        ContactStep {
            step: 0.5,
            theta: 0.75,
            gap,
            last_gap: -0.5,
            spring: [0.1, 0.3],
            impulse: [2.0, -0.3],
            velocity: [-0.4, 1.0],
            change: [0.1, 0.2],
        }
    }

    fn close(found: Loss, expected: Loss) {
        let numbers = |loss: Loss| [loss.impact, loss.friction, loss.cohesion, loss.detection];
        for (found, expected) in numbers(found).into_iter().zip(numbers(expected)) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }

    #[test]
    fn a_spring_loses_by_its_step_its_slip_and_its_detection() {
        // 8 x 0.2^2 / 2 + 2 x 0.2^2 / 2 + 0.25 (2 x 0.1 - 0.3 x 0.2); 0.3 x 0.3 / 0.5; 8 (0.5^2 - 0.3^2) / 2.
        let expected = Loss {
            impact: 0.16 + 0.04 + 0.05 - 0.015,
            friction: 0.18,
            cohesion: 0.0,
            detection: 0.64,
        };
        close(contact_loss(&SPRUNG, &step(-0.3)), expected);
        // Over an open gap of 0.1 as well: 8 x 0.5^2 / 2 + 8 x 0.5 x 0.1; nothing of the spring is found again.
        let open = Loss {
            impact: 1.4 + 0.04 + 0.05 - 0.015,
            detection: 1.0,
            ..expected
        };
        close(contact_loss(&SPRUNG, &step(0.1)), open);
    }

    #[test]
    fn a_rigid_contact_loses_what_its_impulse_does_and_finds_no_spring() {
        let rigid = Law {
            springs: None,
            ..SPRUNG
        };
        let expected = Loss {
            impact: 0.8 + 0.05,
            friction: 0.3 - 0.015,
            ..Loss::default()
        };
        close(contact_loss(&rigid, &step(-0.3)), expected);
    }
}
