//! The energy ledger: every term has its own formula, none is the remainder.
//!
//! With M dv = H r + h F over a step and v_theta = theta v' + (1 - theta) v, the motion itself says
//! dK = v_theta.(H r + h F) - (theta - 1/2) dv.M dv. The first product is work at the contacts, of the loads and at the
//! interface; the second is the numerical loss of the scheme. Contacts turn their share into spring energy, friction
//! and impact (see [`contact_loss`]), bonds into bond energy and decohesion as well (see [`crate::bond::end_step`]).

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
    /// Work of moving walls.
    pub walls: f64,
    /// Work of the grains' weight.
    pub weight: f64,
    /// Lost in impacts and by the scheme.
    pub impact: f64,
    /// Lost in slip.
    pub friction: f64,
    /// Lost by falling adhesion.
    pub cohesion: f64,
}

impl Accounts {
    /// Names, roles and values of the terms of the balance; `stored` are kinetic, spring and bond energies since the start.
    pub fn terms(&self, stored: [f64; 4]) -> [(&'static str, Role, f64); 11] {
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
        ]
    }

    /// All accounts but that of walls, which rarely move, in order.
    pub fn numbers(&self) -> [f64; 7] {
        [
            self.interface,
            self.load,
            self.drive,
            self.weight,
            self.impact,
            self.friction,
            self.cohesion,
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
    /// Energy that a spring k (N/m) lost since the last step without any work (J).
    ///
    /// The work of a step goes along its normal, and disks that pass each other by s turn it: the gap that is then detected
    /// is about s^2/(2 (r_1 + r_2)) wider than the one that the last step left. A loss of the scheme, of first order
    /// over a run: 1.8 % of the energy of a wheel that falls on a layer at 10 m/s in steps of 2e-7 s.
    pub fn turned(&self, k: f64) -> f64 {
        0.5 * k * (self.left.min(0.0).powi(2) - self.gap.min(0.0).powi(2))
    }
}

/// Energy that a contact loses in a step: (impact and numerical, friction) (J).
///
/// Rigid: -r_n u_n and -r_t u_t, at the theta velocity.
/// Compliant: a spring driven implicitly from elongation e_0 to e loses k (e - e_0)^2 / 2; one that closes in the step
/// is pushed over the open gap as well, k |e| g. Of the tangential path h u_t the part d' - d goes into the spring and
/// the rest is slip. What theta < 1 weighs differently is r (1 - theta) du.
pub fn contact_loss(law: &Law, contact: &ContactStep) -> [f64; 2] {
    let ([r_n, r_t], [u_n, u_t], h) = (contact.impulse, contact.velocity, contact.step);
    let behind = 1.0 - contact.theta;
    let correction = [
        r_n * behind * contact.change[0],
        r_t * behind * contact.change[1],
    ];
    let Some(springs) = law.springs else {
        return [-r_n * u_n + correction[0], -r_t * u_t + correction[1]];
    };
    let (before, after) = (contact.gap.min(0.0), -r_n / (h * springs.normal));
    let normal = 0.5 * springs.normal * (after - before).powi(2)
        - springs.normal * after * contact.gap.max(0.0);
    let stretch = contact.spring[1] - contact.spring[0];
    let tangential = 0.5 * springs.tangential * stretch.powi(2);
    let slip = h * u_t - stretch;
    [
        contact.turned(springs.normal) + normal + tangential + correction[0] + correction[1],
        -r_t * slip / h,
    ]
}
