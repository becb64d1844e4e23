//! The endpoint for participants on other hosts, and the hosts of a Slurm job.

use std::process::Command;

use kit::ConfigError;
use protocol::Cause;

use scenario::error::{Code, Refusal, Result};
use scenario::keys::TransportKind;
use scenario::load::Loaded;

#[cfg(not(feature = "zenoh"))]
mod absent;
#[cfg(feature = "zenoh")]
mod zenoh;

#[cfg(not(feature = "zenoh"))]
use self::absent as built;
#[cfg(feature = "zenoh")]
use self::zenoh as built;

pub(crate) use built::Network;

/// Environment variable with the hosts of a Slurm job, in Slurm's notation.
const NODES: &str = "SLURM_JOB_NODELIST";

/// Refuses faults before a run starts anything: a program without the feature, or unusable keys of the endpoint.
pub fn check(loaded: &Loaded) -> Result<()> {
    let scenario = &loaded.scenario;
    let mut participants = scenario.participant.iter();
    let remote = participants.position(|p| scenario.transport(p) == TransportKind::Zenoh);
    let Some(first) = remote else {
        return Ok(());
    };
    let mut key = "run.transport".to_string();
    if scenario.participant[first].transport.is_some() {
        key = format!("participant[{first}].transport");
    }
    if !cfg!(feature = "zenoh") {
        let problem = "`zenoh` needs the feature `zenoh`, which this program was built without";
        let help =
            "build it with cargo install --locked --path coupler --features zenoh; or take \"shm\"";
        return refuse(loaded, &key, ConfigError::new(&key, problem).help(help));
    }
    built::check(loaded)
}

fn refuse<T>(loaded: &Loaded, key: &str, error: ConfigError) -> Result<T> {
    Err(loaded.source.error(key, error.because(Cause::InvalidValue)))
}

/// Hosts of the coordinator's Slurm job, given to participants in turn.
#[derive(Default)]
pub struct Hosts {
    names: Vec<String>,
    given: usize,
}

impl Hosts {
    /// The words of a launcher, with the next host in place of `{host}`.
    pub fn filled_in(&mut self, participant: &str, words: &[String]) -> Result<Vec<String>> {
        if !words.iter().any(|word| word.contains("{host}")) {
            return Ok(words.to_vec());
        }
        if self.names.is_empty() {
            self.names = hosts_of_job().map_err(|why| {
                let text = format!("participant `{participant}`: `{{host}}` in its launch stands for a host of a Slurm job: {why}");
                Refusal::other(Code::CommandNotFound, text)
            })?;
        }
        let host = &self.names[self.given % self.names.len()];
        self.given += 1;
        let filled_in = words.iter().map(|word| word.replace("{host}", host));
        Ok(filled_in.collect())
    }
}

fn hosts_of_job() -> Result<Vec<String>, String> {
    let nodes = std::env::var(NODES).map_err(|_| {
        format!("{NODES} is not set: run inside a job (salloc, sbatch), or write the host's name")
    })?;
    let mut scontrol = Command::new("scontrol");
    let output = scontrol.args(["show", "hostnames", &nodes]).output();
    let output = output.map_err(|error| format!("scontrol: {error}"))?;
    let hosts = String::from_utf8_lossy(&output.stdout);
    let hosts: Vec<String> = hosts.split_whitespace().map(String::from).collect();
    if hosts.is_empty() {
        let why = String::from_utf8_lossy(&output.stderr);
        return Err(format!("scontrol show hostnames {nodes}: {}", why.trim()));
    }
    Ok(hosts)
}
