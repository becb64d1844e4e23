//! The energy ledger: every term has its own formula, none is the remainder.
//!
//! With M dv = H r + h F over a step and v_theta = theta v' + (1 - theta) v, the motion itself says
//! dK = v_theta.(H r + h F) - (theta - 1/2) dv.M dv. The first product is work at the contacts, of the loads and at the
//! interface; the second is the numerical loss of the scheme. Contacts turn their share into spring energy, friction
//! and impact (see [`contact_loss`]), bonds into bond energy and decohesion as well (see [`crate::bond::end_step`]).
//! Between two steps nothing moves, and yet springs may change: by what detection finds otherwise than the step left it, and
//! by a repair of overlaps. Both are terms of their own, so that neither work nor impact hides an error of the geometry.

use protocol::Role;
use serde::{Deserialize, Serialize};

use crate::law::Law;

/// Work and losses since the start (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Accounts {
    /// Work of the boundary on the glued disks, -F_g.v_g h.
    pub interface: f64,
    /// Work of the vertical load on the wheel.
    pub load: f64,
    /// Work of the sideways drive of the wheel.
    pub drive: f64,
    /// Work of moving walls and of drives of clusters.
    pub walls: f64,
    /// Work of fed grains that grow.
    pub injection: f64,
    /// Lost in the damping of driven clusters.
    pub damping: f64,
    /// Work of the grains' weight.
    pub weight: f64,
    /// Lost in impacts and by the scheme.
    pub impact: f64,
    /// Lost in slip.
    pub friction: f64,
    /// Lost by falling adhesion.
    pub cohesion: f64,
    /// Energy of springs and bonds that detection did not find again, less what it found too much.
    pub detection: f64,
    /// Size of `detection`, contact by contact and step by step: no sign hides another.
    pub detection_size: f64,
    /// Work of load and weight in repairs of overlaps, which nothing stores.
    pub repair: f64,
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

impl Accounts {
    /// Names, roles and values of the terms of the balance; `stored` are kinetic, spring and bond energies since the start.
    pub fn terms(&self, stored: [f64; 4]) -> [(&'static str, Role, f64); 12] {
        let [kinetic, normal, tangential, bonds] = stored;
        [
            ("interface", Role::InterfaceWork, self.interface),
            ("wheel_load", Role::Work, self.load),
            ("wheel_drive", Role::Work, self.drive),
            ("weight", Role::Work, self.weight),
            ("kinetic", Role::Stored, kinetic),
            ("springs_normal", Role::Stored, normal),
            ("springs_tangential", Role::Stored, tangential),
            ("bonds_elastic", Role::Stored, bonds),
            ("impact", Role::Dissipated, self.impact),
            ("friction", Role::Dissipated, self.friction),
            ("cohesion", Role::Dissipated, self.cohesion),
            ("detection", Role::Dissipated, self.detection),
        ]
    }

    /// Books the loss of a contact.
    pub fn lose(&mut self, loss: &Loss) {
        self.impact += loss.impact;
        self.friction += loss.friction;
        self.cohesion += loss.cohesion;
        self.detection += loss.detection;
        self.detection_size += loss.detection.abs();
    }

    /// Books the losses of other contacts.
    pub fn join(&mut self, losses: &Accounts) {
        self.impact += losses.impact;
        self.friction += losses.friction;
        self.cohesion += losses.cohesion;
        self.detection += losses.detection;
        self.detection_size += losses.detection_size;
    }

    /// All accounts but that of walls, which rarely move, in order.
    pub fn numbers(&self) -> [f64; 10] {
        [
            self.interface,
            self.load,
            self.drive,
            self.weight,
            self.impact,
            self.friction,
            self.cohesion,
            self.detection,
            self.detection_size,
            self.repair,
        ]
    }
}

/// Impulse and motion of a contact in a step.
#[derive(Clone, Copy, Debug)]
pub struct ContactStep {
    /// Step (s).
    pub step: f64,
    /// Weight of the end velocity.
    pub theta: f64,
    /// Gap at detection (m).
    pub gap: f64,
    /// Gap that the last step left along its normal (m).
    pub left: f64,
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
    /// is about s^2/(2 (r_1 + r_2)) wider than the one that the last step left. A loss of the scheme, of first order
    /// over a run: 1.8 % of the energy of a wheel that falls on a layer at 10 m/s in steps of 2e-7 s.
    pub fn turned(&self, k: f64) -> f64 {
        0.5 * k * (self.left.min(0.0).powi(2) - self.gap.min(0.0).powi(2))
    }
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

    /// Stored and dissipated energies have the same sign in the balance, so that no balance shows one in the other's place.
    #[test]
    fn what_can_come_back_is_stored_and_what_cannot_is_dissipated() {
        let of = |wanted: Role| {
            let terms = Accounts::default().terms([0.0; 4]).into_iter();
            let names = terms.filter(|(_, role, _)| *role == wanted);
            names.map(|(name, ..)| name).collect::<Vec<_>>()
        };
        let stored = [
            "kinetic",
            "springs_normal",
            "springs_tangential",
            "bonds_elastic",
        ];
        assert_eq!(of(Role::Stored), stored);
        let dissipated = ["impact", "friction", "cohesion", "detection"];
        assert_eq!(of(Role::Dissipated), dissipated);
    }

    /// Pushed from an overlap of 0.3 to 0.5, 2 / (0.5 x 8); of the way of 0.5 the tangential spring takes 0.2.
    fn step(gap: f64) -> ContactStep {
        ContactStep {
            step: 0.5,
            theta: 0.75,
            gap,
            left: -0.5,
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

    #[test]
    fn losses_add_up_and_jumps_of_both_signs_do_not_cancel_in_size() {
        let mut accounts = Accounts::default();
        for detection in [0.5, -2.0] {
            accounts.lose(&Loss {
                impact: 1.0,
                friction: 2.0,
                cohesion: 3.0,
                detection,
            });
        }
        let expected = Accounts {
            impact: 2.0,
            friction: 4.0,
            cohesion: 6.0,
            detection: -1.5,
            detection_size: 2.5,
            ..Accounts::default()
        };
        assert_eq!(accounts, expected);
    }
}
