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
        let wheel = &ledger.wheel;
        let mass_damping = ledger.mass_damping + wheel.mass_damping;
        let (stiffness_damping, strain) = (ledger.stiffness_damping, ledger.strain);
        let numerical = ledger.numerical + wheel.numerical;
        let mut terms = Vec::new();
        let mut add = |present: bool, name: &str, role: Role, value: f64| {
            let name = name.into();
            terms.extend(present.then_some((Term { name, role }, value)));
        };
        let on = self.wheel;
        add(true, "interface_work", InterfaceWork, ledger.interface_work);
        add(self.applied, "applied_work", Work, ledger.applied_work);
        add(self.motion, "drive_work", Work, ledger.drive_work);
        add(true, "strain", Stored, strain);
        add(true, "kinetic", Stored, ledger.kinetic);
        add(self.mass_damping, "mass_damping", Dissipated, mass_damping);
        let present = self.stiffness_damping;
        add(present, "stiffness_damping", Dissipated, stiffness_damping);
        add(true, "numerical_loss", Dissipated, numerical);
        add(self.plastic, "plastic", Dissipated, ledger.plastic);
        add(on, "wheel_load", Work, wheel.load);
        add(on, "wheel_drive", Work, wheel.drive);
        add(on, "wheel_kinetic", Stored, ledger.wheel_kinetic);
        add(on, "friction", Dissipated, wheel.friction);
        add(on, "impact", Dissipated, wheel.impact);
        terms
    }
}
