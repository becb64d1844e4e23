//! The session that a participant is launched with.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The name of the environment variable that holds the path of the session file of a launched participant, or [`STANDARD_INPUT`].
pub const SESSION_VARIABLE: &str = "THIRDBODY_SESSION";

/// In place of a path: the session is the first line of the standard input, which ends with the coordinator.
pub const STANDARD_INPUT: &str = "-";

/// Values that are common to all participants of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting {
    /// Name of the participant, as the scenario gives it.
    pub participant: String,
    /// Seed of everything random in the run.
    pub seed: u64,
    /// Out-of-plane thickness (m).
    pub thickness_m: f64,
    /// Threads of the participant's own pool. Results never depend on it.
    pub threads: usize,
    /// Folder that the participant may write fields to; nothing is written when absent.
    pub fields: Option<PathBuf>,
    /// Folder in which what is long to prepare is kept for later runs; nothing is kept when absent. Results never depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cache: Option<PathBuf>,
}

/// Way from the participant to the coordinator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Transport {
    /// Shared memory: iceoryx2 with its own root and prefix for each run.
    Shm {
        /// Folder of the service files.
        root: PathBuf,
        /// Prefix of everything that the run creates in shared memory.
        prefix: String,
    },
    /// A channel inside the coordinator's process.
    Channel,
    /// Between hosts: zenoh.
    Zenoh {
        /// Settings of zenoh, as its configuration files have them; they hold secrets.
        config: serde_json::Value,
        /// Key of the signatures, 64 hexadecimal digits.
        key: String,
        /// Time without a sign of life after which the other end is gone (s).
        lost_after_s: f64,
        /// A file in the folder of the run with the number of the run in it: who sees it sees the files of the coordinator's host.
        mark: PathBuf,
    },
}

/// Everything that a participant needs before the first frame; written by the coordinator as JSON,
/// its path stands in the environment variable [`SESSION_VARIABLE`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Session {
    /// [`crate::PROTOCOL_VERSION`] of the coordinator.
    pub protocol: u32,
    /// The run that all frames must name.
    pub run_id: u64,
    /// blake3 of the resolved scenario, in hexadecimal.
    pub scenario_hash: String,
    /// Process id of the coordinator.
    pub coordinator_pid: u32,
    /// Values that are common to all participants.
    pub setting: Setting,
    /// Way to the coordinator.
    pub transport: Transport,
    /// A participant that hears nothing for so long ends itself (s).
    pub idle_deadline_s: f64,
    /// The participant's own keys, opaque to everybody else.
    pub config: serde_json::Value,
}

impl Session {
    /// True for a process that sees the folder of its run, and so the files that the coordinator names.
    pub fn sees_run(&self) -> bool {
        let Transport::Zenoh { mark, .. } = &self.transport else {
            return true;
        };
        let text = std::fs::read_to_string(mark);
        text.is_ok_and(|text| text.contains(&format!("{:016x}", self.run_id)))
    }
}
