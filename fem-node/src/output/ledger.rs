//! The energy ledger: every term has its own formula, and no term is the remainder.

use fem_kernel::wheel::state::Energies;
use protocol::Role;
use serde::{Deserialize, Serialize};

kit::results! {
    /// # Signals of the ledger
    /// - `interface_work_j`: Work of the interface on the body, since the start.
    /// - `applied_work_j`: Work of loads, tractions and thermal stresses on the body, since the start.
    /// - `drive_work_j`: Work of prescribed motions of the body since the start, without the mass of the moved nodes.
    /// - `strain_j`: Change of the strain energy of the body since the start.
    /// - `numerical_loss_j`: Energy that the time scheme of the body took since the start.
    /// - `mass_damping_j`: Energy dissipated by mass damping since the start.
    /// - `stiffness_damping_j`: Energy dissipated by stiffness damping since the start.
    /// - `plastic_j`: Energy dissipated by plastic flow since the start.
}

/// Cumulative energies since the start (J); their formulas are derived in [`fem_kernel::integrate`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Work of the interface force, lambda du.
    pub interface_work: f64,
    /// Work of the tractions and of the forces of thermal stresses, [(1-b) f + b f'] du.
    pub applied_work: f64,
    /// Stored energy of the deformation since the start: u F(u) / 2, corrected for plastic strain and rotation. With kinematic hardening it includes
    /// the energy of the back stress.
    pub strain: f64,
    /// Kinetic energy v M v / 2, less its value at the start.
    pub kinetic: f64,
    /// Dissipated by mass damping, [(1-b) c v + b c' v'] M du.
    pub mass_damping: f64,
    /// Dissipated by stiffness damping, [(1-b) d + b d'] du.
    pub stiffness_damping: f64,
    /// Dissipated by the scheme, (b-1/2) (du dF - b h^2/2 da M da) - (b h^2/4) d(a M a).
    pub numerical: f64,
    /// Energies that the wheel and its contact have moved and dissipated.
    pub wheel: Energies,
    /// Kinetic energy of the wheel's vertical motion, m v^2 / 2.
    pub wheel_kinetic: f64,
    /// Work of the prescribed motions, [`crate::model::boundary`].
    pub drive_work: f64,
    /// Dissipated by plastic flow, [`fem_kernel::material::j2`].
    pub plastic: f64,
}

/// One term: its role, name and value (J).
pub(crate) type NamedTerm = (Role, &'static str, f64);

impl Ledger {
    /// All terms, in the order of a report.
    pub(crate) fn terms(&self) -> [NamedTerm; 14] {
        use Role::{Dissipated, InterfaceWork, Stored, Work};
        let (e, w) = (self, &self.wheel);
        let mass_damping = e.mass_damping + w.mass_damping;
        [
            (InterfaceWork, "interface_work", e.interface_work),
            (Work, "applied_work", e.applied_work),
            (Work, "drive_work", e.drive_work),
            (Stored, "strain", e.strain),
            (Stored, "kinetic", e.kinetic),
            (Dissipated, "mass_damping", mass_damping),
            (Dissipated, "stiffness_damping", e.stiffness_damping),
            (Dissipated, "numerical_loss", e.numerical + w.numerical),
            (Dissipated, "plastic", e.plastic),
            (Work, "wheel_load", w.load),
            (Work, "wheel_drive", w.drive),
            (Stored, "wheel_kinetic", e.wheel_kinetic),
            (Dissipated, "friction", w.friction),
            (Dissipated, "impact", w.impact),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stored and dissipated energies have the same sign in the balance, so that no balance shows a confusion of the two.
    #[test]
    fn recoverable_energies_are_stored_and_others_are_dissipated() {
        let of = |wanted: Role| {
            let terms = Ledger::default().terms().into_iter();
            let names = terms.filter(|(role, ..)| *role == wanted);
            names.map(|(_, name, _)| name).collect::<Vec<_>>()
        };
        assert_eq!(of(Role::Stored), ["strain", "kinetic", "wheel_kinetic"]);
        let dissipated = [
            "mass_damping",
            "stiffness_damping",
            "numerical_loss",
            "plastic",
            "friction",
            "impact",
        ];
        assert_eq!(of(Role::Dissipated), dissipated);
    }
}
