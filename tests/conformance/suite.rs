//! The suite that any link passes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use protocol::{Frame, Header, Kind, Link, LinkError};

/// Longer than any step here takes on a busy machine.
pub const AMPLE: Duration = Duration::from_secs(60);
pub const SHORT: Duration = Duration::from_millis(50);

pub type Pair = (Box<dyn Link>, Box<dyn Link>);

/// All duties of a link of any kind.
pub fn check(pair: impl Fn() -> Pair) {
    frames_arrive_in_order_once_and_whole(pair());
    every_bit_of_a_payload_arrives(pair());
    every_length_arrives(pair());
    a_frame_that_was_cut_off_goes_on(pair());
    a_header_arrives_as_it_was_sent(pair());
    silence_ends_with_the_patience(pair());
    a_peer_that_takes_nothing_ends_with_the_patience(pair());
    last_words_arrive_before_the_end_is_noticed(pair());
    a_peer_that_left_is_noticed(pair());
    a_peer_that_leaves_while_we_wait_is_noticed(pair());
    a_peer_that_never_spoke_and_left_holds_nobody_up(pair());
    ten_thousand_requests_have_ten_thousand_answers(pair());
    endless_patience_is_allowed(pair());
}

pub fn numbered(number: u64, payload: Vec<f64>) -> Frame {
    let header = Header {
        window: number,
        ..Header::of(Kind::Motion)
    };
    Frame::new(header, payload)
}

pub fn receive(link: &mut dyn Link) -> Frame {
    link.receive(AMPLE)
        .expect("the link works")
        .expect("a frame comes")
}

fn bits(frame: &Frame) -> Vec<u64> {
    frame.payload.iter().map(|value| value.to_bits()).collect()
}

fn frames_arrive_in_order_once_and_whole((mut left, mut right): Pair) {
    let sender = thread::spawn(move || {
        for number in 0..500 {
            let frame = numbered(number, vec![number as f64; number as usize % 7]);
            left.send(&frame, AMPLE).expect("it is taken");
        }
        left
    });
    for number in 0..500 {
        let frame = receive(&mut *right);
        assert_eq!(frame.header.window, number);
        assert_eq!(frame.payload, vec![number as f64; number as usize % 7]);
        assert_eq!(frame.verify(), Ok(()));
    }
    let left = sender.join().expect("the sender ends");
    assert_eq!(right.receive(SHORT), Ok(None), "nothing arrives twice");
    drop(left);
}

fn every_bit_of_a_payload_arrives((mut left, mut right): Pair) {
    let payload = vec![
        0.0,
        -0.0,
        f64::MIN_POSITIVE / 2.0,
        f64::from_bits(1),
        f64::MAX,
        f64::NEG_INFINITY,
        f64::NAN,
        f64::from_bits(0x7ff0_0000_0000_0001),
        f64::from_bits(0xfff8_dead_beef_cafe),
    ];
    let frame = numbered(0, payload);
    left.send(&frame, AMPLE).expect("it is taken");
    let arrived = receive(&mut *right);
    assert_eq!(bits(&arrived), bits(&frame));
    assert_eq!(arrived.verify(), Ok(()));
}

/// A link that cuts frames into pieces tends to fail at sizes around a power of two.
fn every_length_arrives((mut left, mut right): Pair) {
    let lengths = [
        0,
        1,
        16_383,
        16_384,
        16_385,
        32_768,
        480 * 480,
        1_000 * 1_000 + 7,
        0,
        3,
    ];
    let payload = |length: usize| (0..length).map(|i| i as f64 + 0.25).collect::<Vec<_>>();
    let sender = thread::spawn(move || {
        for length in lengths {
            let frame = numbered(length as u64, payload(length));
            left.send(&frame, AMPLE).expect("it is taken");
        }
        left
    });
    for length in lengths {
        let frame = receive(&mut *right);
        assert_eq!(frame.header.window, length as u64);
        assert!(frame.payload == payload(length), "{length} doubles");
    }
    sender.join().expect("the sender ends");
}

/// The sender tries for two milliseconds at a time and the receiver looks every eight, while other threads occupy all cores.
/// A piece of a link over shared memory holds 16 384 doubles, and four pieces may wait.
fn a_frame_that_was_cut_off_goes_on((left, right): Pair) {
    const LENGTHS: [usize; 13] = [
        0, 1, 16_383, 16_384, 16_385, 32_767, 32_768, 32_769, 65_535, 65_536, 65_537, 81_920,
        300_000,
    ];
    const LOOK: Duration = Duration::from_millis(2);
    let frame = |length: usize| {
        let payload = (0..length).map(|i| i as f64 - 0.25);
        numbered(length as u64, payload.collect())
    };
    let one_way = |mut from: Box<dyn Link>, mut to: Box<dyn Link>| {
        let sender = thread::spawn(move || {
            let mut cut = 0;
            for frame in LENGTHS.map(frame) {
                while let Err(error) = from.send(&frame, LOOK) {
                    assert!(matches!(error, LinkError::Full { .. }), "{error}");
                    cut += 1;
                }
            }
            (from, cut)
        });
        for expected in LENGTHS.map(frame) {
            let start = Instant::now();
            let arrived = loop {
                thread::sleep(4 * LOOK);
                match to.receive(Duration::ZERO).expect("the link works") {
                    Some(arrived) => break arrived,
                    None => assert!(start.elapsed() < AMPLE, "it never arrives"),
                }
            };
            assert!(arrived == expected, "{} doubles", expected.payload.len());
        }
        let (from, cut) = sender.join().expect("the sender ends");
        println!("cut off {cut} times");
        assert!(cut > 0, "no frame was cut off");
        (from, to)
    };
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while !ended.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let _ended = SetWhenDropped(&ended);
        let (left, right) = one_way(left, right);
        one_way(right, left);
    });
}

/// Ends the busy threads, also of a test that fails.
struct SetWhenDropped<'a>(&'a AtomicBool);

impl Drop for SetWhenDropped<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Also a wrong header: the reader judges frames, not the link.
fn a_header_arrives_as_it_was_sent((mut left, mut right): Pair) {
    let header = Header {
        kind: 77,
        protocol: 99,
        run_id: u64::MAX,
        interface: 3,
        iteration: 4,
        window: 5,
        step: 6,
        substeps: 7,
        count: 1_000_000,
        t0_s: -0.5,
        t1_s: 1e300,
        checksum: 8,
    };
    let payload = vec![1.0, 2.0];
    let frame = Frame { header, payload };
    left.send(&frame, AMPLE).expect("it is taken");
    assert_eq!(receive(&mut *right), frame);
}

fn silence_ends_with_the_patience((left, mut right): Pair) {
    for patience in [Duration::ZERO, SHORT] {
        let start = Instant::now();
        assert_eq!(right.receive(patience), Ok(None));
        assert!(start.elapsed() >= patience);
    }
    drop(left);
}

fn a_peer_that_takes_nothing_ends_with_the_patience((mut left, right): Pair) {
    let long = numbered(0, vec![1.0; 300_000]);
    let start = Instant::now();
    let refused = (0..64).find_map(|_| left.send(&long, SHORT).err());
    let seconds = SHORT.as_secs_f64();
    assert_eq!(refused, Some(LinkError::Full { seconds }));
    assert!(start.elapsed() >= SHORT);
    drop(right);
}

fn last_words_arrive_before_the_end_is_noticed((mut left, mut right): Pair) {
    left.send(&numbered(1, vec![]), AMPLE).expect("it is taken");
    receive(&mut *right);
    right
        .send(&numbered(2, vec![1.0; 20_000]), AMPLE)
        .expect("it is taken");
    drop(right);
    assert_eq!(receive(&mut *left).header.window, 2);
    assert_eq!(left.receive(AMPLE), Err(LinkError::Closed));
}

fn a_peer_that_left_is_noticed((mut left, mut right): Pair) {
    left.send(&numbered(1, vec![]), AMPLE).expect("it is taken");
    receive(&mut *right);
    drop(right);
    let frame = numbered(2, vec![1.0; 10]);
    assert_eq!(left.send(&frame, AMPLE), Err(LinkError::Closed));
    assert_eq!(left.receive(AMPLE), Err(LinkError::Closed));
}

fn a_peer_that_leaves_while_we_wait_is_noticed((mut left, mut right): Pair) {
    let leaver = thread::spawn(move || {
        receive(&mut *right);
        thread::sleep(SHORT);
    });
    left.send(&numbered(1, vec![]), AMPLE).expect("it is taken");
    assert_eq!(left.receive(Duration::MAX), Err(LinkError::Closed));
    leaver.join().expect("the leaver ends");
}

fn a_peer_that_never_spoke_and_left_holds_nobody_up((mut left, right): Pair) {
    drop(right);
    assert!(left.send(&numbered(1, vec![]), SHORT).is_err());
    assert!(matches!(
        left.receive(SHORT),
        Ok(None) | Err(LinkError::Closed)
    ));
}

fn ten_thousand_requests_have_ten_thousand_answers((mut left, mut right): Pair) {
    const REQUESTS: u64 = 10_000;
    let answerer = thread::spawn(move || {
        for _ in 0..REQUESTS {
            let frame = receive(&mut *right);
            right.send(&frame, AMPLE).expect("it is taken");
        }
        right
    });
    for number in 0..REQUESTS {
        let request = numbered(number, vec![number as f64; 16]);
        left.send(&request, AMPLE).expect("it is taken");
        assert_eq!(receive(&mut *left), request);
    }
    answerer.join().expect("the answerer ends");
}

fn endless_patience_is_allowed((mut left, mut right): Pair) {
    let sender = thread::spawn(move || {
        left.send(&numbered(1, vec![]), Duration::MAX)
            .expect("it is taken");
        left
    });
    let frame = right.receive(Duration::MAX).expect("the link works");
    assert_eq!(frame.map(|frame| frame.header.window), Some(1));
    sender.join().expect("the sender ends");
}
