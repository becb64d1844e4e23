//! Heartbeats of tasks that other processes do, watched for silence.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// The latest heartbeats and when each was first seen. Counted by the watcher's own clock, so that those of other machines need not
/// agree with it.
#[derive(Debug)]
pub struct HeartbeatWatch {
    longest: Duration,
    seen: BTreeMap<String, (String, Instant)>,
}

impl HeartbeatWatch {
    /// A watch that allows a silence of this length.
    pub fn new(longest: Duration) -> HeartbeatWatch {
        HeartbeatWatch {
            longest,
            seen: BTreeMap::new(),
        }
    }

    /// True once the heartbeat of a task has been the same for too long.
    pub fn is_over(&mut self, task: &str, heartbeat: String) -> bool {
        let now = Instant::now();
        match self.seen.get(task) {
            Some((known, since)) if *known == heartbeat => now - *since > self.longest,
            _ => {
                self.seen.insert(task.to_string(), (heartbeat, now));
                false
            }
        }
    }

    /// Begins anew with a task.
    pub fn forget(&mut self, task: &str) {
        self.seen.remove(task);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patience_lasts_while_the_heart_beats_and_begins_anew_when_told() {
        let mut heartbeats = HeartbeatWatch::new(Duration::from_millis(20));
        assert!(!heartbeats.is_over("a", "1".into()));
        std::thread::sleep(Duration::from_millis(30));
        assert!(!heartbeats.is_over("a", "2".into()));
        assert!(!heartbeats.is_over("b", "1".into()));
        std::thread::sleep(Duration::from_millis(30));
        assert!(heartbeats.is_over("a", "2".into()));
        heartbeats.forget("a");
        assert!(!heartbeats.is_over("a", "2".into()));
    }
}
