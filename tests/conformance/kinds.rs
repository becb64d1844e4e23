//! The tables of kinds in `protocol/README.md` give the numbers, words and answers of the code: foreign participants and readers of
//! a log rely on them.

use std::collections::BTreeSet;
use std::thread;
use std::time::Duration;

use protocol::frame::packed;
use protocol::link::channel;
use protocol::{
    BoundaryAnswer, Description, Frame, Header, Kind, Link, Node, NodeError, Outcome,
    PROTOCOL_VERSION, Reaction, Session, Setting, Surface, Transport, Window, serve,
};
use serde_json::json;

const README: &str = include_str!("../../protocol/README.md");

/// A row of the tables: a request and its answer, each by number and word. Faults answer any request.
struct Row {
    request: Option<(u32, String)>,
    answer: (u32, String),
}

/// The rows of each table of kinds: the kinds in the log, then the others.
fn tables() -> Vec<Vec<Row>> {
    let parts = README
        .split("| kind | | from the coupler | | answer |")
        .skip(1);
    parts
        .map(|part| part.lines().skip(2).map_while(row).collect())
        .collect()
}

fn row(line: &str) -> Option<Row> {
    let cells: Vec<&str> = line.strip_prefix('|')?.split('|').map(str::trim).collect();
    let kind = |number: &str, word: &str| {
        let word = word.split('`').nth(1).unwrap_or_default();
        Some((number.parse().ok()?, word.to_string()))
    };
    Some(Row {
        request: kind(cells[0], cells[1]),
        answer: kind(cells[3], cells[4]).expect("each request has an answer"),
    })
}

fn kinds(rows: &[Row]) -> BTreeSet<(u32, String)> {
    let answers = rows.iter().map(|row| row.answer.clone());
    rows.iter()
        .filter_map(|row| row.request.clone())
        .chain(answers)
        .collect()
}

#[test]
fn the_tables_hold_every_kind_by_its_number_and_word() {
    let tables = tables();
    let [logged, others] = tables.as_slice() else {
        panic!("{} tables of kinds", tables.len());
    };
    let of_enum = |is_exchange: bool| -> BTreeSet<(u32, String)> {
        let kinds = Kind::WORDS.into_iter();
        let chosen = kinds.filter(|(kind, _)| kind.is_exchange() == is_exchange);
        chosen
            .map(|(kind, word)| (kind as u32, word.into()))
            .collect()
    };
    assert_eq!(kinds(logged), of_enum(true));
    assert_eq!(kinds(others), of_enum(false));
}

#[test]
fn every_request_has_the_answer_of_the_tables() {
    let (mut link, mut other_end) = channel::pair();
    let participant = thread::spawn(move || {
        let build = |_: &Session| -> Result<Box<dyn Node>, NodeError> { Ok(Box::new(Willing)) };
        serve(&session(), &mut other_end, build).is_ok()
    });
    let rows = tables().into_iter().flatten();
    let mut requests: Vec<(Kind, u32)> = rows
        .filter_map(|row| Some((Kind::from_number(row.request?.0)?, row.answer.0)))
        .collect();
    // The first request must be the greeting, and nothing follows the last.
    requests.sort_by_key(|(kind, _)| (*kind != Kind::Hello, *kind == Kind::Finish));
    for (turn, (kind, answer)) in (0..).zip(requests) {
        let mut asked = request(kind);
        asked.stamp(turn);
        link.send(&asked, PATIENCE).expect("it is taken");
        let mut frame = link
            .receive(PATIENCE)
            .expect("it lives")
            .expect("it answers");
        assert_eq!(frame.open(turn), Ok(()), "{kind:?}");
        assert_eq!(frame.header.kind, answer, "{kind:?}: {:?}", frame.text());
    }
    assert!(participant.join().expect("it ends"));
}

const PATIENCE: Duration = Duration::from_secs(60);

/// A request of this kind that a willing node can follow.
fn request(kind: Kind) -> Frame {
    let header = Header::of(kind);
    match kind {
        Kind::Hello => {
            let hello = json!({
                "protocol": PROTOCOL_VERSION, "run_id": 0, "scenario_hash": "", "participant": "a", "units": "SI",
            });
            Frame::new(header, packed(hello.to_string()))
        }
        Kind::Couple | Kind::Snapshot | Kind::Restore => Frame::new(header, packed("name")),
        // Loads have all components of the selected point.
        Kind::Advance | Kind::Solve | Kind::PrescribeVelocity => Frame::new(header, vec![1.0, 0.0]),
        _ => Frame::new(header, vec![1.0]),
    }
}

fn session() -> Session {
    Session {
        protocol: PROTOCOL_VERSION,
        run_id: 0,
        scenario_hash: String::new(),
        coordinator_pid: std::process::id(),
        setting: Setting {
            participant: "a".into(),
            seed: 0,
            thickness_m: 1.0,
            threads: 1,
            fields: None,
            cache: None,
        },
        transport: Transport::Channel,
        idle_deadline_s: PATIENCE.as_secs_f64(),
        config: json!({}),
    }
}

/// A node that follows every request and does nothing.
struct Willing;

impl Node for Willing {
    fn describe(&self) -> Description {
        Description::default()
    }

    fn couple(&mut self, _: &str) -> Result<Surface, NodeError> {
        Ok(Surface::default())
    }

    fn select(&mut self, _: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn columns(&mut self, _: &Window) -> Result<Vec<f64>, NodeError> {
        Ok(Vec::new())
    }

    fn set_boundary(&mut self, _: f64, _: &[f64]) -> Result<(), NodeError> {
        Ok(())
    }

    fn advance(&mut self, _: &Window, _: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(Vec::new())
    }

    fn impedance(&mut self, _: &Window) -> Result<Vec<f64>, NodeError> {
        Ok(Vec::new())
    }

    fn prescribe_velocity(&mut self, _: &Window, _: &[f64]) -> Result<Reaction, NodeError> {
        Ok(Reaction::default())
    }

    fn solve(&mut self, _: &Window, _: &[f64]) -> Result<BoundaryAnswer, NodeError> {
        Ok(BoundaryAnswer::default())
    }

    fn commit(&mut self, _: &Window, _: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(Vec::new())
    }

    fn take_heat(&mut self, _: &Window, _: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(Vec::new())
    }

    fn take_temperatures(&mut self, _: &Window, _: &[f64]) -> Result<Vec<f64>, NodeError> {
        Ok(Vec::new())
    }

    fn advance_alone(&mut self, _: &Window) -> Result<Vec<f64>, NodeError> {
        Ok(Vec::new())
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        Ok(Vec::new())
    }

    fn restore(&mut self, _: &[u8]) -> Result<(), NodeError> {
        Ok(())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome::default())
    }
}
