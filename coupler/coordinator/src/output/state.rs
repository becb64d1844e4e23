//! The memory of the outputs, as a checkpoint keeps it.

use serde::{Deserialize, Serialize};

use protocol::Finding;

use super::running_balance::RunningBalance;
use super::sample::SampledMeans;
use scheme::window::InterfaceSignals;

/// Memory of the outputs from window to window. Checkpoints keep it by the order of its fields.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OutputState {
    /// Latest energies of each participant (J).
    pub energies: Vec<Vec<f64>>,
    /// The latest report of each participant.
    pub reports: Vec<Vec<f64>>,
    /// The latest signals of each interface.
    pub interfaces: Vec<InterfaceSignals>,
    /// Means over the sampled phase.
    pub sampled: SampledMeans,
    /// Simulated times at which fields were written (s).
    pub snapshots_s: Vec<f64>,
    /// Size of signals.csv.
    pub signals_bytes: u64,
    /// Balances of the participants, of the interfaces and of all together.
    pub balances: Vec<RunningBalance>,
    /// What each participant dissipates.
    pub losses: Vec<RunningBalance>,
    /// Participant and index of each signal that was no number.
    pub odd_signals: Vec<[usize; 2]>,
    /// Participants, interfaces or the run, and what was found about them on the way.
    pub findings: Vec<(String, Finding)>,
}
