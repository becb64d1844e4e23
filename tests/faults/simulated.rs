//! Runs over a simulated network: [`harness::campaign::simulated::schedule`] defines a right end.

use std::collections::VecDeque;
use std::time::Duration;

use coordinator::participants::Watch;
use harness::campaign::simulated::{Counts, run_schedules};
use protocol::{Frame, FrameError, Header, Link, LinkError};

/// Schedules in an ordinary run of this suite; more with THIRDBODY_SCHEDULES.
const SCHEDULES: u64 = 2000;

fn asked(variable: &str, default: u64) -> u64 {
    std::env::var(variable).map_or(default, |n| n.parse().expect("a number"))
}

fn counts(wrap: fn(Box<dyn Link>) -> Box<dyn Link>, count: u64) -> Counts {
    let seed = asked("THIRDBODY_SEED", 0);
    run_schedules(seed, count, wrap, &Watch::default())
        .expect("a network without faults changes nothing")
}

#[test]
fn thousands_of_schedules_end_bit_equal_or_with_a_named_fault() {
    let counts = counts(|link| link, asked("THIRDBODY_SCHEDULES", SCHEDULES));
    println!(
        "{} completed, {} named, {} of them resumed, {} wrong, {:.0} a minute",
        counts.completed,
        counts.named,
        counts.resumed,
        counts.wrong.len(),
        counts.per_minute
    );
    let first = counts.wrong.iter().take(10).cloned().collect::<Vec<_>>();
    assert!(counts.wrong.is_empty(), "{}", first.join("\n"));
    assert!(counts.completed > 100 && counts.named > 100 && counts.resumed > 100);
}

/// An end of a connection that takes any frame for the expected one: the planted bug of a program that ignores turns and headers.
struct Credulous {
    link: Box<dyn Link>,
    /// True for the asking end: it sends before it receives.
    asks: Option<bool>,
    asked: VecDeque<Header>,
    heard: u64,
}

impl Link for Credulous {
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError> {
        if *self.asks.get_or_insert(true) {
            self.asked.push_back(frame.header);
        }
        self.link.send(frame, patience)
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        self.asks.get_or_insert(false);
        let Some(mut frame) = self.link.receive(patience)? else {
            return Ok(None);
        };
        let mut opened = frame.clone();
        let turn = match opened.open(self.heard) {
            Err(FrameError::Turn { turn, .. }) => turn,
            _ => self.heard,
        };
        let asked = self.asked.pop_front();
        opened.clone_from(&frame);
        if opened.open(turn).is_ok() {
            let Header {
                kind,
                count,
                checksum,
                ..
            } = opened.header;
            let own = opened.header;
            opened.header = Header {
                kind,
                count,
                checksum,
                ..asked.unwrap_or(own)
            };
            opened.stamp(self.heard);
            frame = opened;
        }
        self.heard += 1;
        Ok(Some(frame))
    }
}

#[test]
fn a_program_that_accepts_any_frame_is_detected() {
    let credulous = |link| -> Box<dyn Link> {
        Box::new(Credulous {
            link,
            asks: None,
            asked: VecDeque::new(),
            heard: 0,
        })
    };
    let counts = counts(credulous, SCHEDULES);
    println!("{} wrong of {}", counts.wrong.len(), counts.schedules());
    let others = |why: &String| why.contains("with other hashes");
    assert!(
        counts.wrong.iter().any(others),
        "{:?}",
        counts.wrong.first()
    );
}
