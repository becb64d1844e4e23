//! The greeting of all participants, and the check that everybody speaks of the same run.

use protocol::serve::{Hello, Welcome};
use protocol::{Description, Kind, PROTOCOL_VERSION};

use super::communicator::Communicator;
use crate::error::Error;
use crate::scenario::load::Loaded;

/// A participant that answered the greeting.
#[derive(Clone, Debug)]
pub struct Greeted {
    /// Its process.
    pub pid: u32,
    /// Its description.
    pub description: Description,
}

/// Greets all participants at once, so that their set-ups run side by side, and checks that everybody
/// speaks of the same run.
pub fn greet(
    communicator: &mut dyn Communicator,
    loaded: &Loaded,
    run_id: u64,
) -> Result<Vec<Greeted>, Error> {
    let count = communicator.peers().count();
    for peer in 0..count {
        let hello = Hello {
            protocol: PROTOCOL_VERSION,
            run_id,
            scenario_hash: loaded.hash.clone(),
            participant: communicator.peers().name(peer).to_string(),
            units: "SI".into(),
        };
        let text = serde_json::to_string(&hello).expect("our own types always serialise");
        communicator.tell_text(peer, Kind::Hello, &text)?;
    }
    (0..count)
        .map(|peer| welcome(communicator, peer, loaded))
        .collect()
}

fn welcome(
    communicator: &mut dyn Communicator,
    peer: usize,
    loaded: &Loaded,
) -> Result<Greeted, Error> {
    let frame = communicator.receive(peer, Kind::Welcome)?;
    let name = communicator.peers().name(peer).to_string();
    let welcome: Welcome = frame
        .text()
        .map_err(|error| error.to_string())
        .and_then(|text| serde_json::from_str(&text).map_err(|error| error.to_string()))
        .map_err(|why| {
            let why = format!("sent a greeting that cannot be read: {why}");
            communicator.peers().protocol_error(peer, why)
        })?;
    let refuse = |what: &str, theirs: String, ours: String| {
        Err(Error::Refused(format!(
            "participant `{name}` {what} {theirs}, the coordinator {ours}: build both from the same release and launch both for the same run"
        )))
    };
    if welcome.protocol != PROTOCOL_VERSION {
        return refuse(
            "speaks protocol version",
            welcome.protocol.to_string(),
            PROTOCOL_VERSION.to_string(),
        );
    }
    if welcome.scenario_hash != loaded.hash {
        return refuse(
            "was launched with scenario",
            welcome.scenario_hash,
            loaded.hash.clone(),
        );
    }
    if welcome.units != "SI" {
        return refuse("speaks units", welcome.units, "SI".into());
    }
    Ok(Greeted {
        pid: welcome.pid,
        description: welcome.description,
    })
}
