//! A counter of finished runs, messages or windows on stderr: a bar on a terminal, one line per minute elsewhere, objects for a program.

use std::time::Instant;

use serde_json::{Value, json};

use coordinator::output::pace::Remaining;
use coordinator::summary::known;

use crate::run::{LINE_EVERY_S, OBJECT_EVERY_S, bar, lasting};
use crate::stderr::{StderrMode, columns, draw, print_event, stderr_mode};

/// Time between two updates of the bar (s).
const UPDATE_EVERY_S: f64 = 0.2;

/// A count that proceeds to its total.
pub struct Count {
    /// Name of the activity: replay of `rail`.
    what: String,
    /// Plural of the counted things: messages.
    things: &'static str,
    total: usize,
    begun: Instant,
    shown_s: f64,
    every_s: f64,
    drawn: bool,
    remaining: Remaining,
}

impl Count {
    /// A count at zero.
    pub fn new(what: String, things: &'static str, total: usize) -> Count {
        let drawn = stderr_mode() == StderrMode::Progress && columns().is_some();
        Count {
            what,
            things,
            total,
            begun: Instant::now(),
            shown_s: 0.0,
            every_s: match stderr_mode() {
                StderrMode::Quiet => f64::INFINITY,
                StderrMode::JsonLines => OBJECT_EVERY_S,
                StderrMode::Progress if drawn => UPDATE_EVERY_S,
                StderrMode::Progress => LINE_EVERY_S,
            },
            drawn,
            remaining: Remaining::from(0.0),
        }
    }

    /// Sets the number of things done. Shows it if an update is due; a program also gets the last number.
    pub fn at(&mut self, done: usize) {
        let spent_s = self.begun.elapsed().as_secs_f64();
        let last = done == self.total && stderr_mode() == StderrMode::JsonLines;
        if spent_s - self.shown_s < self.every_s && !last {
            return;
        }
        self.shown_s = spent_s;
        self.remaining.add(done as f64, spent_s);
        let left_s = self.remaining.until(self.total as f64);
        match columns().filter(|_| self.drawn) {
            Some(columns) => draw(&[self.line(done, left_s)], columns),
            None => print_event("count", self.object(done, left_s), || {
                self.line(done, left_s)
            }),
        }
    }

    fn line(&self, done: usize, left_s: Option<f64>) -> String {
        let bar = bar(done as f64 / self.total.max(1) as f64);
        let clock = match left_s {
            None => format!("{} spent", lasting(self.shown_s)),
            Some(left_s) => format!("{} left", lasting(left_s)),
        };
        let (what, total, things) = (&self.what, self.total, self.things);
        format!("{what} [{bar}] {done} of {total} {things}, {clock}")
    }

    fn object(&self, done: usize, left_s: Option<f64>) -> Value {
        let object = json!({
            "what": self.what,
            "things": self.things,
            "done": done,
            "total": self.total,
            "spent_wall_s": self.shown_s,
            "left_wall_s": left_s,
        });
        known(object).into()
    }
}

impl Drop for Count {
    /// Removes the bar from the terminal.
    fn drop(&mut self) {
        if self.drawn {
            draw(&[], 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_shows_what_is_done_and_left() {
        let mut count = Count::new("replay of `rail`".into(), "messages", 400);
        count.shown_s = 5.0;
        let start = "replay of `rail` [#####---------------] 100 of 400 messages, ";
        assert_eq!(count.line(100, None), format!("{start}5.0 s spent"));
        assert_eq!(count.line(100, Some(15.0)), format!("{start}15 s left"));
        assert_eq!(count.object(100, None)["done"], 100);
        assert!(count.object(100, None).get("left_wall_s").is_none());
    }
}
