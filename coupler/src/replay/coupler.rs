//! The coupler again, against tapes of all participants.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use super::tape::{Seen, TapeLink, turns};
use super::{Recording, Replayed};
use crate::checkpoint::Origin;
use crate::couple::conversation::{COUPLER, Conversation};
use crate::couple::course::windows;
use crate::couple::handshake::{self, Greeted};
use crate::error::Error;
use crate::launch::{Launcher, Life, Peer, Watch};

/// Runs the coupling loop against tapes, from the start or from a checkpoint. What participants say of themselves is not part of the log, so each
/// is started once for its greeting.
pub fn replay(
    recording: &Recording,
    launcher: &Launcher,
    watch: &Watch,
    from: Option<&Origin>,
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
    let deadlines = &scenario.run.deadlines;
    let mut conversation = Conversation::new(
        peers,
        launcher.run_id,
        scenario.labels(),
        deadlines,
        watch.clone(),
        None,
    );
    let start = Instant::now();
    let result = windows(&mut conversation, scenario, &greeted, from);
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
        if replayed.departure.is_none() {
            replayed.departure.clone_from(&seen.departure);
        }
    }
    match result {
        // The lost peer is the tape: at its end, or where the coupler departed from it.
        Err(Error::PeerLost { .. }) if ended || replayed.departure.is_some() => Ok(replayed),
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
    let deadlines = &scenario.run.deadlines;
    let mut conversation = Conversation::new(
        peers?,
        launcher.run_id,
        scenario.labels(),
        deadlines,
        watch.clone(),
        None,
    );
    handshake::greet(&mut conversation, &recording.loaded, launcher.run_id)
}
