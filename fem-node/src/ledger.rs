//! The energy ledger: every term from its own formula, none the remainder.

use protocol::{Role, Term};
use serde::{Deserialize, Serialize};

use crate::wheel::Energies;

/// Cumulative energies since the start (J); their formulas are derived in [`crate::integrate`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Work of the interface force, lambda du.
    pub interface_work: f64,
    /// Work of the tractions, [(1-b) f + b f'] du.
    pub applied_work: f64,
    /// Stored energy of the deformation, less that of a static start: u F(u) / 2, and what plastic strain and rotation
    /// change in it. With kinematic hardening that of the back stress is part of it.
    pub strain: f64,
    /// Kinetic energy v M v / 2.
    pub kinetic: f64,
    /// Dissipated by mass damping, [(1-b) c v + b c' v'] M du.
    pub mass_damping: f64,
    /// Dissipated by stiffness damping, [(1-b) d + b d'] du.
    pub stiffness_damping: f64,
    /// Dissipated by the scheme, (b-1/2) (du dF - b h^2/2 da M da) - (b h^2/4) d(a M a).
    pub numerical: f64,
    /// What the wheel and its contact have moved and dissipated.
    pub wheel: Energies,
    /// Kinetic energy of the wheel's vertical motion, m v^2 / 2.
    pub wheel_kinetic: f64,
    /// Work of the prescribed motions, [`crate::boundary`].
    pub drive_work: f64,
    /// Dissipated by plastic flow, [`crate::material::j2`].
    pub plastic: f64,
}

/// Which terms a body has: only what the scene requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Terms {
    pub(crate) applied: bool,
    pub(crate) mass_damping: bool,
    pub(crate) stiffness_damping: bool,
    pub(crate) wheel: bool,
    pub(crate) driven: bool,
    pub(crate) plastic: bool,
}

impl Terms {
    /// Names and roles, in the order of [`Terms::values`].
    pub(crate) fn names(self) -> Vec<Term> {
        self.select(&Ledger::default())
            .into_iter()
            .map(|(name, role, _)| Term {
                name: name.into(),
                role,
            })
            .collect()
    }

    /// The values (J).
    pub(crate) fn values(self, ledger: &Ledger) -> Vec<f64> {
        self.select(ledger)
            .into_iter()
            .map(|(_, _, value)| value)
            .collect()
    }

    fn select(self, ledger: &Ledger) -> Vec<(&'static str, Role, f64)> {
        let wheel = &ledger.wheel;
        let all = [
            (
                true,
                "interface_work",
                Role::InterfaceWork,
                ledger.interface_work,
            ),
            (
                self.applied,
                "applied_work",
                Role::Work,
                ledger.applied_work,
            ),
            (self.driven, "drive_work", Role::Work, ledger.drive_work),
            (true, "strain", Role::Stored, ledger.strain),
            (true, "kinetic", Role::Stored, ledger.kinetic),
            (
                self.mass_damping,
                "mass_damping",
                Role::Dissipated,
                ledger.mass_damping + wheel.mass_damping,
            ),
            (
                self.stiffness_damping,
                "stiffness_damping",
                Role::Dissipated,
                ledger.stiffness_damping,
            ),
            (
                true,
                "numerical_loss",
                Role::Dissipated,
                ledger.numerical + wheel.numerical,
            ),
            (self.plastic, "plastic", Role::Dissipated, ledger.plastic),
            (self.wheel, "wheel_load", Role::Work, wheel.load),
            (self.wheel, "wheel_drive", Role::Work, wheel.drive),
            (
                self.wheel,
                "wheel_kinetic",
                Role::Stored,
                ledger.wheel_kinetic,
            ),
            (self.wheel, "friction", Role::Dissipated, wheel.friction),
            (self.wheel, "impact", Role::Dissipated, wheel.impact),
        ];
        let kept = all.into_iter().filter(|(present, ..)| *present);
        kept.map(|(_, name, role, value)| (name, role, value))
            .collect()
    }
}
