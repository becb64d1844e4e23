//! The session that a participant is launched with.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The environment variable that holds the path of a launched participant's session file, or [`STANDARD_INPUT`].
pub const SESSION_VARIABLE: &str = "THIRDBODY_SESSION";

/// In place of a path: the session is the first line of standard input, which ends when the coordinator does.
pub const STANDARD_INPUT: &str = "-";

/// Values for a participant that do not depend on its solver.
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
    /// Folder that keeps expensive preparations for later runs; nothing is kept when absent. Results never depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cache: Option<PathBuf>,
}

/// Connection from the participant to the coordinator.
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
        /// Settings of zenoh, as in its configuration files; they hold secrets.
        config: serde_json::Value,
        /// Key of the signatures, 64 hexadecimal digits.
        key: String,
        /// Time without a sign of life after which the other end counts as lost (s).
        lost_after_s: f64,
        /// A file in the run's folder that holds the run's number: a process that can read it sees the coordinator's files.
        mark: PathBuf,
    },
}

/// Everything that a participant needs before the first frame. The coordinator writes it as JSON; the environment
/// variable [`SESSION_VARIABLE`] holds its path.
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
    /// Values that do not depend on the solver.
    pub setting: Setting,
    /// Connection to the coordinator.
    pub transport: Transport,
    /// Time without a frame after which a participant ends (s).
    pub idle_deadline_s: f64,
    /// The participant's own keys; only the participant reads them.
    pub config: serde_json::Value,
}

impl Session {
    /// True if the process sees the folder of its run, and so the files that the coordinator names.
    pub fn sees_run(&self) -> bool {
        let Transport::Zenoh { mark, .. } = &self.transport else {
            return true;
        };
        let text = std::fs::read_to_string(mark);
        text.is_ok_and(|text| text.contains(&format!("{:016x}", self.run_id)))
    }
}
