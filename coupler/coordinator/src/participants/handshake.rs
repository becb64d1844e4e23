//! The greeting of all participants, and the check that they belong to the same run.

use protocol::frame::packed;
use protocol::serve::{Hello, Welcome};
use protocol::{Cause, Description, Kind, PROTOCOL_VERSION, Window};

use super::admission::fault_of_description;
use super::communicator::Communicator;
use super::peer::read_json;
use scenario::error::{Code, Refusal, Result};
use scenario::load::Loaded;

/// A participant that answered the greeting.
#[derive(Clone, Debug)]
pub struct Greeted {
    /// Its process.
    pub pid: u32,
    /// Its host, for a participant that may run on another host.
    pub host: String,
    /// Its description.
    pub description: Description,
}

impl Greeted {
    /// Its process id, if it runs on this host.
    pub fn local_pid(&self) -> Option<u32> {
        self.host.is_empty().then_some(self.pid)
    }
}

/// Greets all participants at once, so that their set-ups run in parallel, and checks that they belong to the same run.
pub fn greet(
    communicator: &mut dyn Communicator,
    loaded: &Loaded,
    run_id: u64,
) -> Result<Vec<Greeted>> {
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
        communicator.send(peer, Kind::Hello, &Window::default(), packed(&text))?;
    }
    let welcomed = (0..count).map(|peer| welcome(communicator, peer, loaded));
    welcomed.collect()
}

fn welcome(communicator: &mut dyn Communicator, peer: usize, loaded: &Loaded) -> Result<Greeted> {
    let frame = communicator.receive(peer, Kind::Welcome)?;
    let welcome: Welcome = read_json(&frame).map_err(|why| {
        let why = format!("sent a greeting that cannot be read: {why}");
        communicator.peers().protocol_error(peer, why)
    })?;
    let protocol = [welcome.protocol, PROTOCOL_VERSION].map(|version| version.to_string());
    let scenario = [welcome.scenario_hash, loaded.hash.clone()];
    let claims = [
        ("speaks protocol version", protocol),
        ("was launched with scenario", scenario),
        ("speaks units", [welcome.units, "SI".into()]),
    ];
    for (what, [theirs, ours]) in claims {
        if theirs != ours {
            let participant = communicator.peers().name(peer);
            let text = format!(
                "participant `{participant}` {what} {theirs}, the coordinator {ours}: build both from the same release and launch both for the same run"
            );
            return Err(Refusal::other(Code::Of(Cause::OtherRelease), text).into());
        }
    }
    communicator.peers_mut().peer(peer).is_at(&welcome.host);
    if welcome.apart {
        refuse_apart(communicator.peers().name(peer), &welcome.host, loaded)?;
    }
    if let Some(why) = fault_of_description(&welcome.description) {
        return Err(communicator.peers().protocol_error(peer, why));
    }
    Ok(Greeted {
        pid: welcome.pid,
        host: welcome.host,
        description: welcome.description,
    })
}

/// Refuses a participant that must read or write files of the coordinator's host but does not see them.
fn refuse_apart(participant: &str, host: &str, loaded: &Loaded) -> Result<()> {
    let cure = "share the folder between the hosts";
    let (what, cure) = match (loaded.files.first(), loaded.scenario.run.output.fields) {
        (Some(file), _) => (format!("the scenario reads {file}"), cure.to_string()),
        (None, true) => (
            "its fields belong in the folder of the run".into(),
            format!("{cure}, or set run.output.fields = false"),
        ),
        (None, false) => return Ok(()),
    };
    let problem =
        format!("does not see the files of this host from its host `{host}`, but {what}: {cure}");
    Err(Refusal::participant(participant, problem).into())
}
