//! The coupler again, against tapes of all participants.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use super::tape::{Seen, TapeLink, turns};
use super::{Recording, Replayed};
use crate::error::Error;
use crate::log::COUPLER;
use crate::participants::handshake::{self, Greeted};
use crate::participants::remote::Remote;
use crate::participants::{Launcher, Life, Peer, Peers, Watch};
use crate::run::checkpoint::RestartPoint;
use crate::run::time_loop::{each_window, groups_at_start};
use crate::scenario::Scenario;
use crate::scheme::join::join;
use crate::scheme::predict::inputs::foresee;

/// Runs the coupling loop against tapes, from the start or from a checkpoint. What participants say of themselves is not part of the log, so each
/// is started once for its greeting.
pub fn replay(
    recording: &Recording,
    launcher: &Launcher,
    watch: &Watch,
    from: Option<&RestartPoint>,
) -> Result<Replayed, Error> {
    let greeted = greetings(recording, launcher, watch)?;
    let scenario = &recording.loaded.scenario;
    let mut peers = Vec::new();
    let mut tapes: Vec<Arc<Mutex<Seen>>> = Vec::new();
    for participant in &scenario.participant {
        let mut tape = match from {
            None => Vec::new(),
            Some(_) => turns(
                &recording.messages[..recording.handshake()],
                &participant.name,
            ),
        };
        let later = &recording.messages[recording.messages_before(from)..];
        tape.extend(turns(later, &participant.name));
        let (link, seen) = TapeLink::new(tape);
        peers.push(Peer::new(&participant.name, Box::new(link), Life::Tape));
        tapes.push(seen);
    }
    let mut peers = Peers::new(
        peers,
        launcher.run_id,
        scenario.labels(),
        &scenario.run.deadlines,
        watch.clone(),
    );
    let start = Instant::now();
    let result = windows(&mut peers, scenario, &greeted, from);
    let mut replayed = Replayed::of(COUPLER);
    replayed.wall_s = start.elapsed().as_secs_f64();
    let mut ended = false;
    for tape in &tapes {
        let seen = tape
            .lock()
            .map_err(|_| Error::Refused("a tape broke".into()))?;
        replayed.equal += seen.equal;
        replayed.last_window = replayed.last_window.max(seen.last_window);
        ended |= seen.ended;
        if replayed.mismatch.is_none() {
            replayed.mismatch.clone_from(&seen.mismatch);
        }
    }
    match result {
        // The lost peer is the tape: at its end, or where the coupler departed from it.
        Err(Error::PeerLost { .. }) if ended || replayed.mismatch.is_some() => Ok(replayed),
        Err(error) => Err(error),
        Ok(()) => Ok(replayed),
    }
}

fn greetings(
    recording: &Recording,
    launcher: &Launcher,
    watch: &Watch,
) -> Result<Vec<Greeted>, Error> {
    let memory = launcher.shared_memory();
    let scenario = &recording.loaded.scenario;
    let peers: Result<Vec<Peer>, Error> = scenario
        .participant
        .iter()
        .map(|participant| launcher.start(participant, &memory))
        .collect();
    let mut peers = Peers::new(
        peers?,
        launcher.run_id,
        scenario.labels(),
        &scenario.run.deadlines,
        watch.clone(),
    );
    handshake::greet(&mut peers, &recording.loaded, launcher.run_id)
}

/// The whole coupled exchange without outputs.
fn windows(
    peers: &mut Peers,
    scenario: &Scenario,
    greeted: &[Greeted],
    from: Option<&RestartPoint>,
) -> Result<(), Error> {
    if scenario.interface.is_empty() {
        return Err(Error::Refused(
            "a solver that ran alone has no coupler to replay".into(),
        ));
    }
    let remote = &mut Remote::new(peers, greeted);
    let mut groups = groups_at_start(scenario, greeted, join(remote, scenario)?)?;
    match from {
        Some(restart) => restart.place(&mut groups)?,
        None => {
            for group in &mut groups {
                foresee(&mut group.coupling, remote)?;
            }
        }
    }
    each_window(peers, greeted, &mut groups, |_, _, _| Ok(()))
}
