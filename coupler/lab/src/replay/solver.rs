//! Runs one solver again, against the logged requests of the coupler.

use std::time::Instant;

use protocol::serve::window_of;
use protocol::{Frame, Kind, Window};

use super::Recording;
use super::deviation::Ruler;
use super::replayed::{Drift, Replayed};
use super::tape::{Turn, turns};
use crate::quiet::participant_index;
use coordinator::participants::farewell::read_farewell;
use coordinator::participants::{Communicator, Launcher, Watch, handshake};
use coordinator::run::checkpoint::RestartPoint;
use exchange_log::Mismatch;
use exchange_log::mismatch::Difference;
use scenario::error::{Error, Refusal};
use terminal::Count;

/// Conditions of a solver's replay.
#[derive(Clone, Copy, Default)]
pub struct ReplayOptions<'a> {
    /// Begin after this checkpoint instead of at the start.
    pub from: Option<&'a RestartPoint>,
    /// Accept answers that deviate by at most this, see [`Ruler`]; every bit counts if absent.
    pub tolerance_rel: Option<f64>,
    /// Continue after a departure and record the drift of the answers: the other side still sends what it sent to the logged solver.
    pub open_loop: bool,
}

/// Starts the participant `name` alone, sends it all requests in the log, and compares its answers.
pub fn replay(
    recording: &Recording,
    launcher: &Launcher,
    name: &str,
    watch: &Watch,
    how: &ReplayOptions,
) -> Result<Replayed, Error> {
    let scenario = &recording.loaded.scenario;
    let index = participant_index(scenario, name)?;
    let alone = &scenario.participant[index..=index];
    let mut peers = launcher.start(alone, watch.clone())?;
    let communicator: &mut dyn Communicator = &mut peers;
    handshake::greet(communicator, &recording.loaded, launcher.run_id)?;
    let mut comparison = Comparison {
        replayed: Replayed::of(name),
        ruler: Ruler::default(),
        how,
    };
    // A log may be as long as the run, so its turns are extracted before the clock starts.
    let past = recording.messages_before(how.from);
    let later = turns(&recording.messages[past..], name);
    let start = Instant::now();
    if let Some(origin) = how.from {
        for turn in handshake_turns(turns(&recording.messages[..past], name)) {
            comparison.ask(communicator, &turn, None)?;
        }
        origin.restore_node(communicator, 0, index)?;
    }
    let mut asked = 0;
    let mut count = Count::new(format!("replay of `{name}`"), "messages", later.len());
    while let Some(turn) = later.get(asked)
        && comparison.ask(communicator, turn, later.get(asked + 1))?
    {
        asked += 1;
        count.at(asked);
    }
    drop(count);
    let mut replayed = comparison.replayed;
    replayed.wall_s = start.elapsed().as_secs_f64();
    let left = later.len() - asked;
    if left > recording.open_turns(name).min(1) && replayed.mismatch.is_none() {
        let request = &later[asked].request;
        let found = Mismatch::at(name, request, "no answer, and continues", "its end");
        replayed.mismatch = Some(found);
    }
    if left == 0 {
        let kinds = (Kind::Finish, Kind::Finished);
        let outcome = communicator.ask(0, kinds, &Window::default(), &[])?;
        // The farewell of a foreign solver may be unreadable, which does not affect the replay.
        if let Ok(farewell) = read_farewell(&outcome) {
            replayed.solve_wall_s = Some(farewell.solve_wall_s);
            replayed.state_hash = Some(farewell.outcome.state_hash);
        }
    }
    Ok(replayed)
}

/// The requests that a solver needs before its state is restored: the coupled sets, and the last compliant boundary.
fn handshake_turns(past: Vec<Turn>) -> Vec<Turn> {
    let kind = |turn: &Turn| turn.request.kind();
    let mut boundaries = past.iter();
    let last = boundaries.rposition(|turn| kind(turn) == Ok(Kind::CompliantBoundary));
    let needed = past.into_iter().enumerate().filter(|(index, turn)| {
        matches!(kind(turn), Ok(Kind::Couple | Kind::Select)) || Some(*index) == last
    });
    needed.map(|(_, turn)| turn).collect()
}

struct Comparison<'a> {
    replayed: Replayed,
    ruler: Ruler,
    how: &'a ReplayOptions<'a>,
}

impl Comparison<'_> {
    /// Sends a request again and compares the answer, with the next request already sent; false if no further request follows.
    fn ask(
        &mut self,
        communicator: &mut dyn Communicator,
        turn: &Turn,
        next: Option<&Turn>,
    ) -> Result<bool, Error> {
        let Some(answer) = &turn.answer else {
            return Ok(false);
        };
        let ours = ask_again(communicator, turn, answer, next)?;
        let mismatch = self.compare(answer, &ours);
        if mismatch.is_none() {
            self.replayed.equal += 1;
            self.replayed.last_window = answer.header.window;
        } else if self.replayed.mismatch.is_none() {
            self.replayed.mismatch = mismatch;
        }
        Ok(self.how.open_loop || self.replayed.mismatch.is_none())
    }

    fn compare(&mut self, logged: &Frame, ours: &Frame) -> Option<Mismatch> {
        let exact = Mismatch::between(&self.replayed.who, logged, ours);
        if logged.payload.len() != ours.payload.len() {
            return exact;
        }
        let deviation = self.ruler.measure(logged, ours);
        if self.how.open_loop {
            self.replayed.drift.push(Drift {
                window: logged.header.window,
                kind: logged.header.kind,
                rel: deviation.rel,
            });
        }
        match (self.how.tolerance_rel, &exact.as_ref()?.difference) {
            (None, _) | (_, Difference::Message { .. }) => exact,
            (Some(tolerance), _) if deviation.rel <= tolerance => None,
            _ => exact.map(|mismatch| mismatch.at_entry(logged, ours, deviation.entry)),
        }
    }
}

fn ask_again(
    communicator: &mut dyn Communicator,
    turn: &Turn,
    answer: &Frame,
    next: Option<&Turn>,
) -> Result<Frame, Error> {
    let request = &turn.request;
    let kind = request.kind().map_err(Refusal::from)?;
    let window = window_of(&request.header);
    communicator.send(0, kind, &window, &request.payload)?;
    if let Some(Turn { request, .. }) = next.filter(|next| next.answer.is_some()) {
        let kind = request.kind().map_err(Refusal::from)?;
        let (peers, window) = (communicator.peers_mut(), window_of(&request.header));
        peers.send_early(0, kind, &window, &request.payload)?;
    }
    let kind = answer.kind().map_err(Refusal::from)?;
    communicator.receive(0, kind)
}
