//! Heartbeats of tasks that other processes run, watched for silence.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// The latest heartbeats and when each was first seen, by the watcher's own clock: clocks of other machines may differ.
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

    /// True once the heartbeat of a task has stayed the same for too long.
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

    /// Restarts the watch of a task.
    pub fn forget(&mut self, task: &str) {
        self.seen.remove(task);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_is_silent_without_new_heartbeats_until_it_is_forgotten() {
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
