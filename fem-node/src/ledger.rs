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
    /// Stored energy of the deformation, less that of a static start: u F(u) / 2, corrected for plastic strain and
    /// rotation. With kinematic hardening that of the back stress is part of it.
    pub strain: f64,
    /// Kinetic energy v M v / 2.
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
    /// Work of the prescribed motions, [`crate::boundary`].
    pub drive_work: f64,
    /// Dissipated by plastic flow, [`crate::material::j2`].
    pub plastic: f64,
}

/// Terms that a body has: only those which the scene requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Terms {
    pub(crate) applied: bool,
    pub(crate) mass_damping: bool,
    pub(crate) stiffness_damping: bool,
    pub(crate) wheel: bool,
    pub(crate) motion: bool,
    pub(crate) plastic: bool,
}

impl Terms {
    /// All terms; that of stiffness damping on request.
    pub(crate) fn all(stiffness_damping: bool) -> Terms {
        Terms {
            applied: true,
            mass_damping: true,
            stiffness_damping,
            wheel: true,
            motion: true,
            plastic: true,
        }
    }

    /// Names and roles, in the order of [`Terms::values`].
    pub(crate) fn names(self) -> Vec<Term> {
        let all = self.select(&Ledger::default()).into_iter();
        all.map(|(term, _)| term).collect()
    }

    /// The values (J).
    pub(crate) fn values(self, ledger: &Ledger) -> Vec<f64> {
        let all = self.select(ledger).into_iter();
        all.map(|(_, value)| value).collect()
    }

    fn select(self, ledger: &Ledger) -> Vec<(Term, f64)> {
        use Role::{Dissipated, InterfaceWork, Stored, Work};
        let (e, w) = (ledger, &ledger.wheel);
        let mass_damping = e.mass_damping + w.mass_damping;
        let (on, stiffness) = (self.wheel, self.stiffness_damping);
        let all = [
            (true, "interface_work", InterfaceWork, e.interface_work),
            (self.applied, "applied_work", Work, e.applied_work),
            (self.motion, "drive_work", Work, e.drive_work),
            (true, "strain", Stored, e.strain),
            (true, "kinetic", Stored, e.kinetic),
            (self.mass_damping, "mass_damping", Dissipated, mass_damping),
            (
                stiffness,
                "stiffness_damping",
                Dissipated,
                e.stiffness_damping,
            ),
            (
                true,
                "numerical_loss",
                Dissipated,
                e.numerical + w.numerical,
            ),
            (self.plastic, "plastic", Dissipated, e.plastic),
            (on, "wheel_load", Work, w.load),
            (on, "wheel_drive", Work, w.drive),
            (on, "wheel_kinetic", Stored, e.wheel_kinetic),
            (on, "friction", Dissipated, w.friction),
            (on, "impact", Dissipated, w.impact),
        ];
        let present = all.into_iter().filter(|(present, ..)| *present);
        let term = |name: &str, role| Term {
            name: name.into(),
            role,
        };
        present
            .map(|(_, name, role, value)| (term(name, role), value))
            .collect()
    }
}
