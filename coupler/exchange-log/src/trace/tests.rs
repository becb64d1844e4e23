//! Traces of an invented run with known times.

use protocol::busy::BusyTimes;

use super::*;
use kit::scratch::Scratch;

fn request(kind: Kind, window: u64, times: [u64; 3]) -> RequestTimes {
    let [asked_ns, awaited_ns, answered_ns] = times;
    RequestTimes {
        kind: kind as u32,
        window,
        iteration: 1,
        asked_ns,
        awaited_ns,
        answered_ns,
    }
}

/// A rail that begins at 1 000, waits for 50, sets up for 150, and works in these spans.
fn rail(spans_ns: Vec<[u64; 2]>) -> ParticipantTimes {
    let worked: u64 = spans_ns.iter().map(|[from, to]| to - from).sum();
    ParticipantTimes {
        name: "rail".into(),
        requests: vec![
            request(Kind::Hello, 0, [1050, 1060, 1210]),
            request(Kind::Advance, 0, [1300, 1310, 1420]),
            // Sent while the rail still works on the request before.
            request(Kind::Commit, 0, [1350, 1430, 1500]),
            request(Kind::Advance, 1, [1600, 1600, 1700]),
        ],
        own: Some(OwnTimes {
            solve_wall_s: 1e-9 * worked as f64,
            setup_wall_s: 150e-9,
            wait_s: 1e-9 * (690 - 150 - worked) as f64,
            busy: BusyTimes { every: 1, spans_ns },
        }),
    }
}

fn spans() -> Vec<[u64; 2]> {
    vec![[1305, 1400], [1402, 1490], [1610, 1690]]
}

fn times(spans: &[Span]) -> Vec<[u64; 2]> {
    spans.iter().map(|one| [one.from_ns, one.to_ns]).collect()
}

#[test]
fn work_is_the_participants_report_and_waits_are_the_rest() {
    let (process, note) = process(&rail(spans()));
    assert_eq!(note, None);
    let setup = [[1050, 1200]];
    assert_eq!(times(&process.work), [&setup[..], &spans()].concat());
    let waits = [[1000, 1050], [1200, 1305], [1400, 1402], [1490, 1610]];
    assert_eq!(times(&process.wait), waits);
    assert_eq!(process.work[2].name, "Commit");
    assert_eq!(process.work[3].args, json!({ "window": 1, "iteration": 1 }));
}

#[test]
fn a_sample_another_clock_and_no_farewell_are_drawn_from_request_to_answer() {
    let mut sampled = rail(spans());
    sampled.own.as_mut().expect("it is there").busy.every = 2;
    let silent = ParticipantTimes {
        own: None,
        ..rail(spans())
    };
    let other_clock = rail(vec![[5, 9], [10, 12], [13, 20]]);
    let one_less = rail(spans()[1..].to_vec());
    for (participant, why) in [
        (sampled, "one of 2 slots"),
        (silent, "ended early"),
        (other_clock, "clock"),
        (one_less, "reports 2 requests, but answered 3"),
    ] {
        let (process, note) = process(&participant);
        let note = note.expect("a note");
        assert!(note.contains(why) && note.contains("`rail`"), "{note}");
        let seen = [[1050, 1210], [1300, 1420], [1420, 1500], [1600, 1700]];
        assert_eq!(times(&process.work), seen);
        assert_eq!(process.work[1].args["seen_by"], "coordinator");
    }
}

#[test]
fn the_coordinator_works_when_it_does_not_wait() {
    let timing = Timing {
        participants: vec![rail(spans())],
        cut_off: None,
    };
    let process = coordinator(&timing);
    let waits = [[1060, 1210], [1310, 1420], [1430, 1500], [1600, 1700]];
    assert_eq!(times(&process.wait), waits);
    let work = [[1050, 1060], [1210, 1310], [1420, 1430], [1500, 1600]];
    assert_eq!(times(&process.work), work);
}

#[test]
fn windows_cut_the_time_and_unknown_ones_are_refused() {
    let scratch = Scratch::new("trace", 1);
    fs::create_dir_all(scratch.path()).expect("it can be made");
    let timing = Timing {
        participants: vec![rail(spans())],
        cut_off: None,
    };
    let out = scratch.path().join("trace.json");
    let traced = write(&timing, Some([1, 1]), &out).expect("window 1 is there");
    let text = fs::read_to_string(&out).expect("it was written");
    let value: Value = serde_json::from_str(&text).expect("it is JSON");
    let events = value["traceEvents"].as_array().expect("a list");
    let events: Vec<_> = events.iter().filter(|one| one["ph"] == "X").collect();
    assert_eq!(events.len() as u64, traced.events);
    assert_eq!(traced.bytes, text.len() as u64);
    // From 1 600 to 1 700 the rail waits 10 and works 80; the coordinator waits.
    let drawn = |pid: u64, tid: u64| -> Vec<[f64; 2]> {
        let of = events
            .iter()
            .filter(|one| one["pid"] == pid && one["tid"] == tid);
        of.map(|one| ["ts", "dur"].map(|key| one[key].as_f64().expect("a number")))
            .collect()
    };
    assert_eq!(drawn(1, 1), [[0.010, 0.080]]);
    assert_eq!(drawn(1, 2), [[0.0, 0.010]]);
    assert_eq!(drawn(0, 2), [[0.0, 0.100]]);
    assert!(drawn(0, 1).is_empty());
    let refused = write(&timing, Some([7, 9]), &out).expect_err("no such window");
    assert!(refused.to_string().contains("up to 1"), "{refused}");
}
