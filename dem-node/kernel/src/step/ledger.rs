//! The energy ledger: every term has its own formula, and no term is a remainder.
//!
//! With M dv = H r + h F over a step and v_theta = theta v' + (1 - theta) v, the motion gives dK = v_theta.(H r + h F) - (theta - 1/2) dv.M dv. The
//! first product is work at the contacts, of the loads and at the interface; the second is the numerical loss of the scheme: an impact, where all
//! contacts are rigid. Contacts turn their share into spring energy, friction and impact (see [`crate::contact::loss::contact_loss`]), bonds into
//! bond energy and decohesion as well (see [`crate::contact::bond::end_step`]). Between two steps nothing moves, and yet springs may change:
//! detection may find other gaps than at the end of the step, and a repair of overlaps moves bodies. Both have their own terms, so that neither work
//! nor impact hides an error of the geometry.

use kit::add_fields;
use protocol::Role;
use serde::{Deserialize, Serialize};

use crate::contact::loss::Loss;

kit::results! {
    /// # Signals of the ledger
    /// - `interface_j`: Work of the body below on the grains through the joined rows, since the
    ///   start.
    /// - `weight_j`: Work of the weight of the grains, since the start.
    /// - `walls_j`: Work of moving walls and driven clusters on the grains, since the start.
    /// - `injection_j`: Work of fed grains that grow, since the start.
    /// - `springs_normal_j`: Change of the energy in the normal springs of contacts since the
    ///   start.
    /// - `springs_tangential_j`: Change of the energy in the tangential springs of contacts since the start.
    /// - `bonds_elastic_j`: Change of the elastic energy of the bonds since the start.
    /// - `adhesion_j`: Change of the energy of attraction between grains since the start.
    /// - `damping_j`: Energy dissipated in the dampers of contacts and of driven clusters since the
    ///   start.
    /// - `cohesion_j`: Energy dissipated by bonds that fail since the start.
    /// - `relaxation_j`: Shear energy that healing bonds released since the start.
    /// - `numerical_j`: Energy dissipated by the time scheme of the grains since the start.
    /// - `detection_j`: Energy of springs and bonds lost by detection between two steps, since the start.
    /// - `repair_j`: Work of load and weight in repairs of overlaps since the start.
    /// - `rounding_j`: Energy below which the terms of grains alone are rounding. It is no part of the balance.
}

/// Work and losses since the start (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GrainLedger {
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
    /// Lost in the dampers of contacts and of driven clusters.
    pub damping: f64,
    /// Work of the grains' weight.
    pub weight: f64,
    /// Lost in impacts of rigid contacts.
    pub impact: f64,
    /// Lost by the scheme: less in shorter steps.
    pub numerical: f64,
    /// Lost in slip.
    pub friction: f64,
    /// Lost by falling adhesion.
    pub cohesion: f64,
    /// Lost by shear that healing bonds released.
    pub relaxation: f64,
    /// Surface energy that healing bonds gained, without any work.
    pub healing: f64,
    /// Bonds that healing has made between pairs without one.
    pub bonds_made: u64,
    /// Surface energy that bonds have lost; `cohesion` is close to it in short steps.
    pub surface: f64,
    /// Energy of springs and bonds lost by detection between two steps, gains subtracted.
    pub detection: f64,
    /// Sum of the absolute part of `detection` that the velocities do not predict, contact by contact and step by step: signs do not cancel.
    pub unforeseen: f64,
    /// Energy created by rigid contacts, contact by contact and step by step: losses of other contacts do not hide it.
    pub made: f64,
    /// Energy of grains that were taken out of the plane.
    pub lateral: f64,
    /// Work of load and weight in repairs of overlaps, which nothing stores.
    pub repair: f64,
}

impl GrainLedger {
    /// Names, roles and values of the terms of the balance; `stored` are kinetic, spring and bond energies since the start.
    pub fn terms(&self, stored: [f64; 4]) -> [(&'static str, Role, f64); 13] {
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
            ("numerical", Role::Dissipated, self.numerical),
            ("friction", Role::Dissipated, self.friction),
            ("cohesion", Role::Dissipated, self.cohesion),
            ("detection", Role::Dissipated, self.detection),
        ]
    }

    /// Adds the loss of a contact.
    pub fn lose(&mut self, loss: &Loss) {
        add_fields!(self, loss; impact, damping, numerical, friction, cohesion, relaxation, healing, surface, detection, made);
        self.unforeseen += loss.unforeseen.abs();
    }

    /// Adds the losses of other contacts.
    pub fn join(&mut self, losses: &GrainLedger) {
        add_fields!(self, losses; impact, damping, numerical, friction, cohesion, relaxation, healing, surface, detection, made, bonds_made);
        self.unforeseen += losses.unforeseen;
    }

    /// All dissipated energy (J), without detection and repairs.
    pub fn dissipated(&self) -> f64 {
        self.impact
            + self.damping
            + self.numerical
            + self.friction
            + self.cohesion
            + self.relaxation
    }

    /// Part of the dissipation that is the scheme's and not physical; `None` without dissipation.
    pub fn numerical_share(&self) -> Option<f64> {
        let all = self.dissipated();
        (all > 0.0).then(|| self.numerical / all)
    }

    /// Energy dissipated by decohesion over the surface energy that bonds lost; `None` without such a loss.
    pub fn decohesion_share(&self) -> Option<f64> {
        (self.surface > 0.0).then(|| self.cohesion / self.surface)
    }

    /// Sum of the works that move grains and do not only load them (J).
    pub fn moved(&self) -> f64 {
        self.drive.abs() + self.walls.abs() + self.weight.max(0.0)
    }

    /// Sum of the absolute works done on the grains (J).
    pub fn worked(&self) -> f64 {
        let works = kit::named!(self; interface, load, drive, walls, injection, weight);
        works.iter().map(|(_, work)| work.abs()).sum()
    }

    /// All terms but the work of walls, which rarely move, in order.
    pub fn numbers(&self) -> [f64; 12] {
        let named = kit::named!(self; interface, load, drive, weight, impact, numerical, friction, cohesion, surface, detection, unforeseen, repair);
        named.map(|(_, x)| x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stored and dissipated energies have the same sign in the balance, so that no balance reveals a mix-up.
    #[test]
    fn recoverable_energies_are_stored_and_others_are_dissipated() {
        let of = |wanted: Role| {
            let terms = GrainLedger::default().terms([0.0; 4]).into_iter();
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
        let dissipated = ["impact", "numerical", "friction", "cohesion", "detection"];
        assert_eq!(of(Role::Dissipated), dissipated);
    }

    #[test]
    fn losses_add_up_and_jumps_of_both_signs_do_not_cancel_in_size() {
        let mut ledger = GrainLedger::default();
        for detection in [0.5, -2.0] {
            ledger.lose(&Loss {
                impact: 1.0,
                friction: 2.0,
                cohesion: 3.0,
                surface: 4.0,
                damping: 5.0,
                numerical: 6.0,
                detection: 3.0 * detection,
                unforeseen: detection,
                made: 7.0,
                relaxation: 8.0,
                healing: 9.0,
            });
        }
        let expected = GrainLedger {
            impact: 2.0,
            friction: 4.0,
            cohesion: 6.0,
            surface: 8.0,
            damping: 10.0,
            numerical: 12.0,
            detection: -4.5,
            unforeseen: 2.5,
            made: 14.0,
            relaxation: 16.0,
            healing: 18.0,
            ..GrainLedger::default()
        };
        assert_eq!(ledger, expected);
    }
}
