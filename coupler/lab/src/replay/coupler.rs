//! Runs the coupler again, against tapes of all participants.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use super::Recording;
use super::replayed::Replayed;
use super::tape::{TapeLink, TapeProgress, turns};
use coordinator::participants::handshake::{Greeted, greet};
use coordinator::participants::remote::Remote;
use coordinator::participants::{Launcher, OtherEnd, Peer, Peers, Watch};
use coordinator::run::checkpoint::RestartPoint;
use coordinator::run::time_loop::{each_window, groups_at_start};
use exchange_log::COUPLER;
use scenario::error::{Code, Error, Refusal};
use scenario::keys::Scenario;
use scheme::join::join;
use scheme::predict::inputs::foresee;
use terminal::Count;

/// Runs the coupling loop against tapes, from the start or from a checkpoint. The log does not contain the participants' descriptions, so
/// each participant starts once for its greeting.
pub fn replay(
    recording: &Recording,
    launcher: &Launcher,
    watch: &Watch,
    from: Option<&RestartPoint>,
) -> Result<Replayed, Error> {
    let scenario = &recording.loaded.scenario;
    let mut launched = launcher.start(&scenario.participant, watch.clone())?;
    let greeted = greet(&mut launched, &recording.loaded, launcher.run_id)?;
    drop(launched);
    let seen = Arc::new(Mutex::new(TapeProgress {
        replayed: Replayed::of(COUPLER),
        ended: false,
    }));
    // A run that continues from a checkpoint joins its interfaces once more.
    let joined = from.map_or(0, |_| recording.handshake());
    let past = recording.messages_before(from);
    let peers = scenario.participant.iter().map(|participant| {
        let mut tape = turns(&recording.messages[..joined], &participant.name);
        tape.extend(turns(&recording.messages[past..], &participant.name));
        let open = recording.open_turns(&participant.name);
        let link = TapeLink::new(tape, open, Arc::clone(&seen));
        Peer::new(&participant.name, Box::new(link), OtherEnd::Tape)
    });
    let run_id = launcher.run_id;
    let mut peers = Peers::new(peers.collect(), None, run_id, scenario, watch.clone());
    let start = Instant::now();
    // The handshake is a separate block.
    let passed = from.map_or(1, |origin| origin.checkpoint.log_blocks as usize);
    let left = recording.ends.len().saturating_sub(passed);
    let mut count = Count::new("replay of the coupler".into(), "windows", left);
    let result = windows(&mut peers, scenario, &greeted, from, &mut count);
    drop(count);
    let wall_s = start.elapsed().as_secs_f64();
    // A tape records its remaining turns when it is dropped.
    drop(peers);
    let seen = seen.lock();
    let seen = seen.map_err(|_| Refusal::other(Code::ReplayBroken, "a tape broke"))?;
    let replayed = Replayed {
        wall_s,
        ..seen.replayed.clone()
    };
    match result {
        // The lost peer is the tape: at its end, or at a departure of the coupler.
        Err(Error::PeerLost { .. }) if seen.ended || replayed.mismatch.is_some() => Ok(replayed),
        Err(error) => Err(error),
        Ok(()) => Ok(replayed),
    }
}

/// The whole coupled exchange without outputs.
fn windows(
    peers: &mut Peers,
    scenario: &Scenario,
    greeted: &[Greeted],
    from: Option<&RestartPoint>,
    count: &mut Count,
) -> Result<(), Error> {
    if scenario.interface.is_empty() {
        let text = "a solver that ran alone has no coupler to replay";
        return Err(Refusal::other(Code::NoCoupler, text).into());
    }
    let remote = &mut Remote::new(peers, greeted);
    let mut groups = groups_at_start(scenario, greeted, join(remote, &scenario.interface)?)?;
    match from {
        Some(restart) => restart.restore_coupler(&mut groups)?,
        None => {
            for group in &mut groups {
                foresee(&mut group.coupling, remote)?;
            }
        }
    }
    let mut done = 0;
    let run_from = |_: &mut _, _: &_, _: &_, _| {
        done += 1;
        count.at(done);
        Ok(ControlFlow::Continue(()))
    };
    each_window(peers, greeted, &mut groups, run_from)
}
