use super::*;

/// A link that returns one frame for each call, after some calls without a frame.
struct Slow {
    empty: u32,
    frames: VecDeque<Frame>,
}

impl Link for Slow {
    fn send(&mut self, _frame: &Frame, _patience: Duration) -> Result<(), LinkError> {
        Ok(())
    }

    fn receive(&mut self, _patience: Duration) -> Result<Option<Frame>, LinkError> {
        if self.empty > 0 {
            self.empty -= 1;
            return Ok(None);
        }
        Ok(self.frames.pop_front())
    }
}

const ASKED: Header = Header {
    kind: Kind::Advance as u32,
    protocol: PROTOCOL_VERSION,
    run_id: 1,
    interface: 2,
    iteration: 3,
    window: 4,
    step: 5,
    substeps: 6,
    count: 0,
    t0_s: 7.0,
    t1_s: 8.0,
    checksum: 0,
};

/// Sends two requests; the first answer is right, the second has this header and this turn. With `ended` the peer has
/// ended.
fn second_answer(header: Header, turn: u64, empty: u32, ended: bool) -> Result<Frame, String> {
    let frame = |header, turn| {
        let mut frame = Frame::new(header, vec![1.0]);
        frame.stamp(turn);
        frame
    };
    let answer = |header: Header| Header {
        kind: Kind::Motion as u32,
        ..header
    };
    let frames = VecDeque::from([frame(answer(ASKED), 0), frame(answer(header), turn)]);
    let end = Arc::new(OnceLock::new());
    let mut peer = Peer::new(
        "rail",
        Box::new(Slow { empty: 0, frames }),
        OtherEnd::Simulated(Arc::clone(&end)),
    );
    let wait = Wait {
        listener: None,
        seconds: 1.0,
        key: "answer_s",
        watch: &Watch::default(),
    };
    let ask = |peer: &mut Peer| {
        peer.send(ASKED, vec![2.0].into(), &wait)?;
        peer.receive(Kind::Motion, &wait)
    };
    ask(&mut peer).expect("the first is right");
    let frames = VecDeque::from([frame(answer(header), turn)]);
    peer.link = Box::new(Slow { empty, frames });
    if ended {
        end.set("it ended".into()).expect("once");
    }
    ask(&mut peer).map_err(|error| error.to_string())
}

#[test]
fn an_answer_repeats_the_whole_header_of_its_request() {
    assert!(second_answer(ASKED, 1, 0, false).is_ok());
    let others = [
        Header {
            interface: 9,
            ..ASKED
        },
        Header {
            iteration: 9,
            ..ASKED
        },
        Header { window: 9, ..ASKED },
        Header { step: 9, ..ASKED },
        Header {
            substeps: 9,
            ..ASKED
        },
        Header { t0_s: 9.0, ..ASKED },
        Header { t1_s: 9.0, ..ASKED },
    ];
    for other in others {
        let refused = second_answer(other, 1, 0, false).expect_err("another subject");
        assert!(refused.contains("answered for window"), "{refused}");
    }
}

#[test]
fn an_answer_of_another_kind_or_protocol_is_refused() {
    let peer = || {
        let link = Slow {
            empty: 0,
            frames: VecDeque::new(),
        };
        let mut peer = Peer::new("rail", Box::new(link), OtherEnd::Tape);
        peer.open.push_back(Asked {
            header: ASKED,
            at_ns: 0,
        });
        peer
    };
    let answer = |kind: Kind, protocol: u32| {
        let header = Header {
            kind: kind as u32,
            protocol,
            ..ASKED
        };
        let mut frame = Frame::new(header, vec![1.0]);
        frame.stamp(0);
        let taken = peer().accept(frame, Kind::Motion);
        taken.map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(answer(Kind::Motion, PROTOCOL_VERSION), Ok(()));
    let other = answer(Kind::Report, PROTOCOL_VERSION).expect_err("another kind");
    assert!(
        other.contains("answered Report instead of Motion"),
        "{other}"
    );
    let version = PROTOCOL_VERSION + 1;
    let newer = answer(Kind::Motion, version).expect_err("another protocol");
    assert!(
        newer.contains(&format!("speaks protocol version {version}")),
        "{newer}"
    );
}

#[test]
fn an_answer_to_an_earlier_equal_request_is_refused() {
    let refused = second_answer(ASKED, 0, 0, false).expect_err("it is the first again");
    assert!(refused.contains("message 0") && refused.contains("lost, repeated or overtaken"));
}

#[test]
fn the_last_answer_of_a_peer_that_has_ended_is_received() {
    assert!(second_answer(ASKED, 1, 1, true).is_ok());
    let lost = second_answer(ASKED, 1, 2, true).expect_err("it said nothing");
    assert!(lost.contains("lost participant `rail`"), "{lost}");
}

#[test]
fn waits_are_counted_in_slices_and_not_by_the_clock() {
    // 20 slices of 50 ms count as one second, even if they took longer.
    assert!(second_answer(ASKED, 1, 19, false).is_ok());
    let late = second_answer(ASKED, 1, 21, false).expect_err("too late");
    assert!(late.contains("did not answer within 1.0 s"), "{late}");
}
