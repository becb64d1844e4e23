//! What came of a replay.

use protocol::{Frame, Header, Kind};

use exchange_log::Mismatch;

/// The distance of an answer from its logged twin, see [`Ruler`](super::deviation::Ruler).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Window.
    pub window: u64,
    /// [`protocol::Kind`] as its number.
    pub kind: u32,
    /// Largest deviation, relative.
    pub rel: f64,
}

/// Outcome of replaying one participant or the coupler.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replayed {
    /// Name of the participant, or the coupler's.
    pub who: String,
    /// Messages that were compared and equal.
    pub equal: u64,
    /// The last window with an equal message.
    pub last_window: u64,
    /// The first that was not.
    pub mismatch: Option<Mismatch>,
    /// Wall-clock time (s) from the first message to the last, without the start of solvers and the reading of the log.
    pub wall_s: f64,
    /// The part of it that the solver was at work (s), as it says itself; none for the coupler, nor after a departure.
    pub solve_wall_s: Option<f64>,
    /// Every answer, where the replay went on after the first departure.
    pub drift: Vec<Drift>,
    /// [`protocol::Outcome::state_hash`] of a solver that was asked everything.
    pub state_hash: Option<String>,
}

impl Replayed {
    /// Nothing yet.
    pub fn of(who: &str) -> Replayed {
        Replayed {
            who: who.to_string(),
            ..Replayed::default()
        }
    }

    /// Compares the state that a solver ended in with the one that the run says it ended in. An answer that had departed
    /// before comes first.
    pub fn compare_state(&mut self, logged: &str) {
        let differs = |ours: &&String| *ours != logged;
        if let Some(ours) = self.state_hash.as_ref().filter(differs) {
            let header = Header {
                window: self.last_window,
                ..Header::of(Kind::Finished)
            };
            let [logged, ours] = [logged, ours].map(|hash| format!("the final state {hash}"));
            let found = Mismatch::at(&self.who, &Frame::new(header, Vec::new()), &logged, &ours);
            self.mismatch.get_or_insert(found);
        }
    }
}
