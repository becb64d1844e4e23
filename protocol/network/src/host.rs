//! The coordinator's side, and the connection of a participant.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::time::Duration;

use protocol::{LinkError, Session, Transport};
use serde_json::{Value, json};
use zenoh::Wait;

use crate::complaints;
use crate::credentials::certificates;
use crate::endpoint::Endpoint;
use crate::link::{NetworkLink, failed};
use crate::message::{Key, Sender, derived_key};

/// Connections that unknown programs may hold at a time in addition to the participants'.
const STRANGERS: usize = 4;

/// Endpoints by which participants on other hosts reach a coordinator.
#[derive(Clone, Debug)]
pub struct Access {
    /// The endpoint where the coordinator listens.
    pub listen: Endpoint,
    /// The endpoint by which participants reach it, if they need another address.
    pub connect: Option<Endpoint>,
    /// Time without a sign of life after which the other end counts as lost.
    pub lost_after: Duration,
}

impl Access {
    /// What is wrong with the endpoints, if anything.
    pub fn fault(&self) -> Option<String> {
        let listen = self.listen.text();
        if !self.listen.is_encrypted() && !self.listen.is_loopback() {
            return Some(format!(
                "{listen} would carry data in clear beyond this host: take quic/"
            ));
        }
        let unreachable = self.listen.is_unspecified() && self.connect.is_none();
        unreachable.then(|| {
            format!(
                "{listen} is not an address to connect to: give `connect`, or listen at one address"
            )
        })
    }
}

/// The endpoint of a run, and the data that its participants need to connect.
pub struct Host {
    session: zenoh::Session,
    run_id: u64,
    lost_after: Duration,
    key: Key,
    participant: Value,
    /// Text of the endpoint.
    pub endpoint: String,
}

impl Host {
    /// Listens for this many participants of a run.
    pub fn listen(access: &Access, run_id: u64, participants: usize) -> Result<Host, String> {
        let listen = access.listen.clone().with_port()?;
        let mut connect = access.connect.clone().unwrap_or_else(|| listen.clone());
        if connect.port == 0 {
            connect.port = listen.port;
        }
        let mut ours = settings(access.lost_after);
        let mut theirs = ours.clone();
        ours["listen"]["endpoints"] = json!([listen.text()]);
        ours["transport"]["unicast"]["max_sessions"] = json!(participants + STRANGERS);
        theirs["connect"]["endpoints"] = json!([connect.text()]);
        if listen.is_encrypted() {
            let made = certificates(&connect.host).map_err(|error| error.to_string())?;
            [
                ours["transport"]["link"]["tls"],
                theirs["transport"]["link"]["tls"],
            ] = made;
        }
        complaints::listen(complaints::keep);
        let endpoint = listen.text();
        let refused = |error: LinkError| format!("listening at {endpoint}: {error}");
        Ok(Host {
            session: open(&ours).map_err(refused)?,
            run_id,
            lost_after: access.lost_after,
            key: random_key().map_err(|error| format!("/dev/urandom: {error}"))?,
            participant: theirs,
            endpoint,
        })
    }

    /// The coordinator's end of the connection to a participant.
    pub fn link(&self, participant: &str) -> Result<NetworkLink, LinkError> {
        let place = place(self.run_id, participant);
        let from = Sender::Coordinator;
        let key = derived_key(&self.key, participant);
        NetworkLink::new(&self.session, &place, from, key, self.lost_after)
    }

    /// Zenoh's warnings since the last call: mostly connections of unknown programs.
    pub fn complaints(&self) -> Vec<String> {
        complaints::take()
    }

    /// The transport to this host for a participant's session; `mark` is a file in the run's folder that holds the run's number.
    pub fn transport(&self, participant: &str, mark: &Path) -> Transport {
        let key = derived_key(&self.key, participant);
        Transport::Zenoh {
            config: self.participant.clone(),
            key: key.iter().map(|byte| format!("{byte:02x}")).collect(),
            lost_after_s: self.lost_after.as_secs_f64(),
            mark: mark.into(),
        }
    }
}

/// Connects a participant to its coordinator, in the background: the first frame or ping waits for the connection.
pub fn connect(session: &Session) -> Result<NetworkLink, LinkError> {
    let Transport::Zenoh {
        config,
        key,
        lost_after_s,
        ..
    } = &session.transport
    else {
        return Err(failed("the session names another transport"));
    };
    let place = place(session.run_id, &session.setting.participant);
    let key =
        read_key(key).ok_or_else(|| failed("the key of the session has 64 hexadecimal digits"))?;
    let lost_after = Duration::from_secs_f64(*lost_after_s);
    let from = Sender::Participant;
    // The coordinator keeps the participant's output.
    complaints::listen(|said| eprintln!("zenoh: {said}"));
    NetworkLink::new(&open(config)?, &place, from, key, lost_after)
}

/// Key expression of the connection to a participant.
fn place(run_id: u64, participant: &str) -> String {
    format!("thirdbody/{run_id:016x}/{participant}")
}

fn random_key() -> std::io::Result<Key> {
    let mut key = [0; 32];
    File::open("/dev/urandom")?.read_exact(&mut key)?;
    Ok(key)
}

fn read_key(text: &str) -> Option<Key> {
    let mut key = [0; 32];
    let fits = text.len() == 64 && text.is_ascii();
    for (at, byte) in key.iter_mut().enumerate().filter(|_| fits) {
        *byte = u8::from_str_radix(&text[2 * at..2 * at + 2], 16).ok()?;
    }
    fits.then_some(key)
}

/// Zenoh settings of both ends: no discovery, no listening. Zenoh drops a silent connection early enough to connect again before the
/// other end counts as lost.
fn settings(lost_after: Duration) -> Value {
    let third_ms = (lost_after.as_millis() as u64 / 3).clamp(1_000, 10_000);
    json!({
        "mode": "peer",
        "open": { "return_conditions": { "connect_scouted": false } },
        "listen": { "endpoints": [] },
        "connect": {
            "endpoints": [],
            "timeout_ms": -1,
            "exit_on_failure": false,
            "retry": { "period_init_ms": 50, "period_max_ms": 1000, "period_increase_factor": 2 },
        },
        "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
        "transport": {
            "link": { "tx": {
                "lease": third_ms,
                "queue": { "congestion_control": { "block": { "wait_before_close": 1000 * third_ms.min(5000) } } },
            } },
        },
    })
}

fn open(settings: &Value) -> Result<zenoh::Session, LinkError> {
    let config = zenoh::Config::from_json5(&settings.to_string()).map_err(failed)?;
    zenoh::open(config).wait().map_err(failed)
}
