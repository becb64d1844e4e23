//! Frames between threads of one process.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::frame::Frame;
use crate::link::waiting::Waiting;
use crate::link::{Link, LinkError};

/// Frames that may wait: a request, and one sent ahead.
const WAITING_FRAMES: usize = 2;

/// One end of an in-process connection.
///
/// It waits as an end over shared memory does. A library's channel yields a few times before it sleeps, and loses as
/// many time slices to a busy neighbour at each frame.
pub struct ChannelLink {
    outbound: Arc<Way>,
    inbound: Arc<Way>,
    waiting: Waiting,
}

/// One direction.
#[derive(Default)]
struct Way {
    frames: Mutex<Frames>,
    changed: Condvar,
}

/// Frames of one direction.
#[derive(Default)]
struct Frames {
    waiting: VecDeque<Frame>,
    closed: bool,
    /// One end sleeps until something changes.
    asleep: bool,
}

impl Way {
    fn frames(&self) -> MutexGuard<'_, Frames> {
        // Nothing that holds the lock can panic half-way.
        self.frames.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Releases the lock after a change and wakes a sleeping end.
    fn wake(&self, mut frames: MutexGuard<'_, Frames>) {
        let asleep = std::mem::take(&mut frames.asleep);
        drop(frames);
        if asleep {
            self.changed.notify_all();
        }
    }

    fn sleep<'a>(
        &self,
        mut frames: MutexGuard<'a, Frames>,
        time: Duration,
    ) -> MutexGuard<'a, Frames> {
        frames.asleep = true;
        let woken = self.changed.wait_timeout(frames, time);
        woken.unwrap_or_else(PoisonError::into_inner).0
    }

    fn close(&self) {
        let mut frames = self.frames();
        frames.closed = true;
        self.wake(frames);
    }
}

/// Both ends of an in-process connection.
pub fn pair() -> (ChannelLink, ChannelLink) {
    let (to_left, to_right) = (Arc::<Way>::default(), Arc::<Way>::default());
    let end = |outbound: &Arc<Way>, inbound: &Arc<Way>| ChannelLink {
        outbound: outbound.clone(),
        inbound: inbound.clone(),
        waiting: Waiting::new(false),
    };
    (end(&to_right, &to_left), end(&to_left, &to_right))
}

impl Link for ChannelLink {
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError> {
        let start = Instant::now();
        let mut sent = Some(frame.clone());
        let mut frames = self.outbound.frames();
        loop {
            if frames.closed {
                return Err(LinkError::Closed);
            }
            if frames.waiting.len() < WAITING_FRAMES {
                frames.waiting.extend(sent.take());
                self.outbound.wake(frames);
                return Ok(());
            }
            let left = patience.saturating_sub(start.elapsed());
            if left.is_zero() {
                return Err(LinkError::Full {
                    seconds: patience.as_secs_f64(),
                });
            }
            frames = self.outbound.sleep(frames, left);
        }
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        let start = Instant::now();
        self.waiting.begin();
        let mut frames = self.inbound.frames();
        loop {
            if let Some(frame) = frames.waiting.pop_front() {
                self.inbound.wake(frames);
                self.waiting.arrived(&frame.header);
                return Ok(Some(frame));
            }
            if frames.closed {
                return Err(LinkError::Closed);
            }
            let left = patience.saturating_sub(start.elapsed());
            if left.is_zero() {
                return Ok(None);
            }
            drop(frames);
            let awake = self.waiting.give_way();
            frames = self.inbound.frames();
            if !awake && frames.waiting.is_empty() && !frames.closed {
                frames = self.inbound.sleep(frames, left);
            }
        }
    }
}

impl Drop for ChannelLink {
    /// The other end still receives frames that were sent.
    fn drop(&mut self) {
        self.outbound.close();
        self.inbound.close();
    }
}
