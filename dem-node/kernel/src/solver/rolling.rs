//! Rolling resistance: couples between bodies that touch, bounded by their normal forces.
//!
//! ```text
//!     |M| <= mu_r r r_n        no relative spin below the bound, opposed to it on it: as Coulomb's law has it of slip,
//!                              without a spring (Jiang, Yu and Harris 2005, rigid-plastic; Estrada, Taboada and Radjai 2008)
//! ```
//!
//! r = r_1 r_2 / (r_1 + r_2), or the radius of the grain on walls, surfaces and wheels. A sweep over the couples follows each sweep over the
//! contacts; each couple takes the value that its law wants under the present spins. Slip and roll of unequal disks act on each other through these
//! spins, and a fixed point of both sweeps is a solution.

use super::contact::{BodyRecord, Contact};

/// The couple of a contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct Couple {
    /// The contact.
    pub contact: u32,
    /// Spins of its bodies over their velocity (1/m): 1/radius, or 0 for a body that does not turn.
    pub curvature: [f64; 2],
    /// Changes of these velocities by a unit impulse (1/(kg m)).
    pub inverse: [f64; 2],
    /// r (m).
    pub radius: f64,
    /// mu_r.
    pub coefficient: f64,
    /// Impulse of the couple on the first body, opposite on the second (N m s).
    pub impulse: f64,
}

impl Couple {
    /// Spin of the first body against the second (rad/s), from spins times radii (m/s).
    pub fn spin(&self, [a, b]: [f64; 2]) -> f64 {
        self.curvature[0] * a - self.curvature[1] * b
    }

    /// The impulse that the law wants under the present spins, and the factor from such impulses to speeds of the surfaces (1/(kg m)); `None` where
    /// nothing turns.
    fn wanted(&self, contact: &Contact, bodies: &[BodyRecord]) -> Option<[f64; 2]> {
        let [a, b] = [0, 1].map(|side| self.curvature[side] * self.inverse[side]);
        let mobility = a + b;
        let turning = [contact.a, contact.b].map(|body| bodies[body as usize].velocity[2]);
        let spin = self.spin(turning);
        let limit = self.coefficient * self.radius * contact.impulse[0].max(0.0);
        let wanted = (self.impulse - spin / mobility).clamp(-limit, limit);
        (mobility > 0.0).then_some([wanted, mobility * self.radius])
    }

    /// Adds an impulse of the couple to the spins.
    fn apply(&self, contact: &Contact, bodies: &mut [BodyRecord], impulse: f64) {
        let sides = [(contact.a, impulse), (contact.b, -impulse)];
        for ((body, impulse), inverse) in sides.into_iter().zip(self.inverse) {
            bodies[body as usize].velocity[2] += inverse * impulse;
        }
    }
}

/// Applies the first guesses of couples.
pub(super) fn apply(couples: &[Couple], contacts: &[Contact], bodies: &mut [BodyRecord]) {
    for couple in couples {
        let contact = &contacts[couple.contact as usize];
        couple.apply(contact, bodies, couple.impulse);
    }
}

/// One pass over couples; adds the squares of the changes and of the values, as speeds of the surfaces.
pub(super) fn sweep(
    couples: &mut [Couple],
    contacts: &[Contact],
    bodies: &mut [BodyRecord],
    [changed, size]: &mut [f64; 2],
) {
    for couple in couples {
        let contact = &contacts[couple.contact as usize];
        let Some([wanted, scale]) = couple.wanted(contact, bodies) else {
            continue;
        };
        *changed += (scale * (wanted - couple.impulse)).powi(2);
        *size += (scale * wanted).powi(2);
        couple.apply(contact, bodies, wanted - couple.impulse);
        couple.impulse = wanted;
    }
}

/// Adds the squares of the defects of couples, and of their sizes, to the squares of the contacts.
pub(super) fn add_defects(
    couples: &[Couple],
    contacts: &[Contact],
    bodies: &[BodyRecord],
    [defect, size]: &mut [f64; 2],
) {
    for couple in couples {
        let contact = &contacts[couple.contact as usize];
        if let Some([wanted, scale]) = couple.wanted(contact, bodies) {
            *defect += (scale * (wanted - couple.impulse)).powi(2);
            *size += (scale * couple.impulse).powi(2);
        }
    }
}
