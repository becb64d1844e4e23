//! The outcome of a replay.

use protocol::{Frame, Header, Kind};

use exchange_log::Mismatch;

/// The distance between an answer and its logged twin, see [`Ruler`](super::deviation::Ruler).
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
    /// Name of the participant, or of the coupler.
    pub who: String,
    /// Messages that were compared and equal.
    pub equal: u64,
    /// The last window with an equal message.
    pub last_window: u64,
    /// The first message that differed.
    pub mismatch: Option<Mismatch>,
    /// Wall-clock time (s) from the first message to the last, without the start of solvers and the reading of the log.
    pub wall_s: f64,
    /// Time of the solver at work (s), as it reports itself; `None` for the coupler and after a departure.
    pub solve_wall_s: Option<f64>,
    /// Drift of every answer, if the replay continued after the first departure.
    pub drift: Vec<Drift>,
    /// [`protocol::Outcome::state_hash`] of a solver that received all requests.
    pub state_hash: Option<String>,
}

impl Replayed {
    /// A replay before its first message.
    pub fn of(who: &str) -> Replayed {
        Replayed {
            who: who.to_string(),
            ..Replayed::default()
        }
    }

    /// Compares the final state of a solver with the logged one. An earlier departure takes precedence.
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
