//! The accepted state of a body in motion.

use fem_kernel::integrate::state::NodalState;
use fem_kernel::wheel::state::WheelState;
use serde::{Deserialize, Serialize};

use crate::model::heat::HeatState;
use crate::output::ledger::Ledger;
use crate::output::probe::{HoldRecord, PressureMaxima};

/// Everything that accepted windows change; the rest of a body follows from configuration and handshake.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Committed {
    pub(crate) state: NodalState,
    pub(crate) wheel: Option<WheelState>,
    pub(crate) ledger: Ledger,
    /// Own steps since the start.
    pub(crate) steps: u64,
    /// Steps of all windows, repeated ones included.
    pub(crate) steps_done: u64,
    /// Computed element steps of all windows, repeats included.
    pub(crate) element_steps: u64,
    /// Steps for all columns of condensed matrices.
    pub(crate) column_steps: u64,
    /// Largest pressures at the snapshot of the hold.
    pub(crate) hold_maxima: Option<PressureMaxima>,
    /// Contact and pressures just before the wheel starts to move sideways.
    pub(crate) hold_record: Option<HoldRecord>,
    /// Force of each prescribed motion on the body (N).
    pub(crate) reactions: Vec<[f64; 2]>,
    /// Temperatures, where the body has them.
    pub(crate) heat: HeatState,
    /// Largest strain at the ends of the phases so far.
    pub(crate) strain_max: f64,
}
