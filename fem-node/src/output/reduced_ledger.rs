//! The energy ledger of a reduced body.

use fem_kernel::reduced::surface::ReducedEnergies;
use protocol::{Role, larger};
use serde::{Deserialize, Serialize};

use super::ledger::NamedTerm;

kit::results! {
    /// # Signals of the ledger
    /// - `residual_loss_j`: Energy that the massless flexibility of a reduced body took when its force jumped.
    /// - `far_field_j`: Energy that a reduced body took because distant points follow one window late; of either sign.
}

/// Cumulative energies since the start (J); [`ReducedEnergies`] states their formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ReducedLedger {
    interface_work: f64,
    applied_work: f64,
    strain: f64,
    pub(crate) kinetic: f64,
    mass_damping: f64,
    numerical: f64,
    residual_loss: f64,
    far_field: f64,
    /// Energy that the far field gave, without what it took.
    pub(crate) far_given: f64,
    /// Largest work so far.
    pub(crate) supplied: f64,
}

impl ReducedLedger {
    /// Adds a window.
    pub(crate) fn add(&mut self, window: &ReducedEnergies) {
        self.interface_work += window.interface_work;
        self.applied_work += window.applied_work;
        self.mass_damping += window.losses.mass_damping;
        self.numerical += window.losses.numerical;
        self.residual_loss += window.residual_loss;
        self.far_field += window.lag;
        self.far_given += (-window.lag).max(0.0);
        (self.strain, self.kinetic) = (window.strain, window.kinetic);
        self.supplied = larger(self.supplied, self.interface_work + self.applied_work);
    }

    /// All terms, in the order of a report.
    pub(crate) fn terms(&self) -> [NamedTerm; 8] {
        use Role::{Dissipated, InterfaceWork, Stored, Work};
        [
            (InterfaceWork, "interface_work", self.interface_work),
            (Work, "applied_work", self.applied_work),
            (Stored, "strain", self.strain),
            (Stored, "kinetic", self.kinetic),
            (Dissipated, "mass_damping", self.mass_damping),
            (Dissipated, "numerical_loss", self.numerical),
            (Dissipated, "residual_loss", self.residual_loss),
            (Dissipated, "far_field", self.far_field),
        ]
    }
}
