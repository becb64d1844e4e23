//! The logged conversation with one participant.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use protocol::serve::Farewell;
use protocol::{Frame, Header, Kind, Link, LinkError};

use crate::log::{COUPLER, Exchange, Mismatch};

/// A request and its answer.
#[derive(Clone, Debug)]
pub struct Turn {
    /// What the coupler asked.
    pub request: Frame,
    /// What the participant answered; absent where the log ends in between.
    pub answer: Option<Frame>,
}

/// The turns of one participant, in order.
pub fn turns(messages: &[Exchange], participant: &str) -> Vec<Turn> {
    let mut turns: Vec<Turn> = Vec::new();
    for message in messages {
        if message.sender == COUPLER && message.receiver == participant {
            turns.push(Turn {
                request: message.frame.clone(),
                answer: None,
            });
        } else if message.sender == participant
            && let Some(turn) = turns.last_mut()
        {
            turn.answer = Some(message.frame.clone());
        }
    }
    turns
}

/// What a tape has seen so far; shared with whoever judges the replay.
#[derive(Debug, Default)]
pub struct Seen {
    /// Requests that were equal to the logged ones.
    pub equal: u64,
    /// Window of the last of them.
    pub last_window: u64,
    /// The first request that was not.
    pub mismatch: Option<Mismatch>,
    /// Whether the tape ran out.
    pub ended: bool,
}

/// A participant that is played from the log. It closes the connection at the first request that the log does not
/// hold, and at its end.
pub struct TapeLink {
    turns: VecDeque<Turn>,
    pending: Option<Frame>,
    seen: Arc<Mutex<Seen>>,
}

impl TapeLink {
    /// A tape and what it will have seen.
    pub fn new(turns: Vec<Turn>) -> (TapeLink, Arc<Mutex<Seen>>) {
        let seen = Arc::new(Mutex::new(Seen::default()));
        let link = TapeLink {
            turns: turns.into(),
            pending: None,
            seen: Arc::clone(&seen),
        };
        (link, seen)
    }

    fn take(&mut self, request: &Frame) -> Result<Frame, LinkError> {
        let mut seen = self.seen.lock().map_err(|_| LinkError::Closed)?;
        let Some(Turn {
            request: logged,
            answer: Some(answer),
        }) = self.turns.pop_front()
        else {
            seen.ended = true;
            return Err(LinkError::Closed);
        };
        if let Some(mismatch) = Mismatch::between(COUPLER, &logged, request) {
            seen.mismatch = Some(mismatch);
            return Err(LinkError::Closed);
        }
        seen.equal += 1;
        seen.last_window = logged.header.window;
        Ok(answer)
    }
}

impl Link for TapeLink {
    fn send(&mut self, frame: &Frame, _patience: Duration) -> Result<(), LinkError> {
        let like = |kind: Kind| Header {
            kind: kind as u32,
            ..frame.header
        };
        let mut answer = match Kind::from_number(frame.header.kind) {
            Some(Kind::Snapshot) => Frame::new(like(Kind::Saved), Vec::new()),
            Some(Kind::Finish) => {
                let text = serde_json::to_string(&Farewell::default())
                    .expect("our own types always serialise");
                Frame::with_text(like(Kind::Finished), &text)
            }
            _ => self.take(frame)?,
        };
        answer.header.run_id = frame.header.run_id;
        self.pending = Some(answer);
        Ok(())
    }

    fn receive(&mut self, _patience: Duration) -> Result<Option<Frame>, LinkError> {
        Ok(self.pending.take())
    }
}
