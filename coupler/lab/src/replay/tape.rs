//! The logged conversation with one participant.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use protocol::{Frame, Link, LinkError};

use super::replayed::Replayed;
use exchange_log::{COUPLER, Exchange, Mismatch};

/// A request and its answer.
#[derive(Clone, Debug)]
pub struct Turn {
    /// The frame of the coupler.
    pub request: Frame,
    /// The frame of the participant; absent if the log ends in between.
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

/// The progress of all tapes of a replay, shared with the replay.
#[derive(Debug)]
pub struct TapeProgress {
    /// The outcome of the replay so far.
    pub replayed: Replayed,
    /// True once a tape ran out.
    pub ended: bool,
}

/// A participant that is played from the log. It closes the connection at the first request that is not in the log, and at the end of the
/// log.
pub struct TapeLink {
    turns: VecDeque<Turn>,
    /// Number of last turns that may be left when the coupler meets the end of a tape: the turns of an incomplete window.
    open: usize,
    pending: Option<Frame>,
    /// Number of answered requests.
    turn: u64,
    seen: Arc<Mutex<TapeProgress>>,
}

impl TapeLink {
    /// A tape of these turns; the last `open` turns belong to an incomplete window.
    pub fn new(turns: Vec<Turn>, open: usize, seen: Arc<Mutex<TapeProgress>>) -> TapeLink {
        TapeLink {
            turns: turns.into(),
            open,
            pending: None,
            turn: 0,
            seen,
        }
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
            seen.replayed.mismatch.get_or_insert(mismatch);
            return Err(LinkError::Closed);
        }
        let replayed = &mut seen.replayed;
        replayed.equal += 1;
        replayed.last_window = replayed.last_window.max(logged.header.window);
        Ok(answer)
    }
}

impl Drop for TapeLink {
    /// A coupler that sends fewer requests than the log holds departs from it.
    fn drop(&mut self) {
        let Ok(mut seen) = self.seen.lock() else {
            return;
        };
        let may_be_left = if seen.ended { self.open } else { 0 };
        if let Some(next) = self.turns.front()
            && self.turns.len() > may_be_left
        {
            let left = Mismatch::at(COUPLER, &next.request, "this request", "its end");
            seen.replayed.mismatch.get_or_insert(left);
        }
    }
}

impl Link for TapeLink {
    fn send(&mut self, frame: &Frame, _patience: Duration) -> Result<(), LinkError> {
        let mut answer = self.take(frame)?;
        answer.header.run_id = frame.header.run_id;
        answer.stamp(self.turn);
        self.turn += 1;
        self.pending = Some(answer);
        Ok(())
    }

    fn receive(&mut self, _patience: Duration) -> Result<Option<Frame>, LinkError> {
        Ok(self.pending.take())
    }
}
