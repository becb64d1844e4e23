//! The network of a program built with links between hosts.

use std::path::Path;
use std::time::Duration;

use kit::ConfigError;
use network::endpoint::Endpoint;
use network::{Access, Host};
use nix::unistd::gethostname;
use protocol::{Link, LinkError, Transport};

use super::{NODES, refuse};
use scenario::error::{Refusal, Result};
use scenario::load::Loaded;

/// The endpoint of a run.
pub(crate) struct Network(Host);

/// Refuses unusable keys of the endpoint.
pub fn check(loaded: &Loaded) -> Result<()> {
    let fault = access(loaded)?.fault();
    let key = "run.remote.listen";
    fault.map_or(Ok(()), |fault| {
        refuse(loaded, key, ConfigError::new(key, fault))
    })
}

fn access(loaded: &Loaded) -> Result<Access> {
    let keys = &loaded.scenario.run.remote;
    let read = |key: &str, text: &str| {
        Endpoint::read(text).or_else(|problem| refuse(loaded, key, ConfigError::new(key, problem)))
    };
    let connect = keys.connect.as_ref();
    let connect = connect.map(|text| read("run.remote.connect", text));
    let listen = keys.listen.clone().unwrap_or_else(default_endpoint);
    Ok(Access {
        listen: read("run.remote.listen", &listen)?,
        connect: connect.transpose()?,
        lost_after: Duration::from_secs_f64(loaded.scenario.run.deadlines.link_s),
    })
}

/// The name of this host inside a Slurm job, where participants may be on other hosts; loopback elsewhere.
fn default_endpoint() -> String {
    let in_job = std::env::var_os(NODES).is_some();
    let name = gethostname().ok().filter(|_| in_job);
    let name = name.and_then(|name| name.into_string().ok());
    format!("quic/{}:0", name.unwrap_or_else(|| "127.0.0.1".into()))
}

impl Network {
    /// Listens for this number of participants.
    pub fn listen(loaded: &Loaded, run_id: u64, participants: usize) -> Result<Network> {
        let host = Host::listen(&access(loaded)?, run_id, participants);
        let host = host.map_err(|why| Refusal::argument("run.remote", why))?;
        Ok(Network(host))
    }

    /// The coordinator's end of the connection to a participant.
    pub fn link(&self, participant: &str) -> Result<Box<dyn Link>, LinkError> {
        Ok(Box::new(self.0.link(participant)?))
    }

    /// The transport to it, for the session of a participant of the run in this folder.
    pub fn transport(&self, participant: &str, run: &Path) -> Transport {
        self.0.transport(participant, &run.join("manifest.json"))
    }

    /// Complaints about refused connections.
    pub fn complaints(&self) -> Vec<String> {
        self.0.complaints()
    }

    /// The endpoint, in words.
    pub fn endpoint(&self) -> &str {
        &self.0.endpoint
    }
}
