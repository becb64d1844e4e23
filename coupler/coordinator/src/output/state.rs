//! The memory of the outputs, as stored in a checkpoint.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};

use protocol::Finding;

use super::running_balance::RunningBalance;
use super::sample::SampledMeans;
use runs::signals::SIGNALS;
use runs::written::Written;
use scenario::content::changed;
use scheme::window::InterfaceSignals;

/// Memory of the outputs from window to window. Checkpoints store its fields in this order.
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
    /// The file signals.csv up to here.
    pub signals: Written,
    /// blake3 of the fields and profiles that were written, by their paths in the run directory.
    pub files: BTreeMap<String, String>,
    /// Balances of the participants, of the interfaces and of all together.
    pub balances: Vec<RunningBalance>,
    /// Losses of each participant, which never decrease.
    pub losses: Vec<RunningBalance>,
    /// Participant and index of each signal that was NaN or infinite.
    pub odd_signals: Vec<[usize; 2]>,
    /// Findings during the run, each with its participant or interface, or `run`.
    pub findings: Vec<(String, Finding)>,
}

impl OutputState {
    /// The first file of a run directory that differs from what its run had written so far.
    pub fn damaged(&self, run: &Path) -> Option<&str> {
        let signals = head(&run.join(SIGNALS), self.signals.bytes);
        if !signals.is_ok_and(|rows| Written::of(&rows) == self.signals) {
            return Some(SIGNALS);
        }
        changed(&self.files, run)
    }
}

/// The first bytes of a file.
pub fn head(path: &Path, bytes: u64) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    File::open(path)?.take(bytes).read_to_end(&mut head)?;
    Ok(head)
}
