//! Links between hosts: the duties of every `Link`, and three more of a network. Frames lost with a connection are sent again, strangers
//! cannot connect or are ignored, and an end notices that the other is gone. Nothing is asserted about speed.

mod suite;

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use network::endpoint::Endpoint;
use network::message::{Key, Message, Purpose, Refused, Sender};
use network::{Access, Host, NetworkLink, connect};
use protocol::{Link, LinkError, PROTOCOL_VERSION, Session, Setting, Transport};
use serde_json::{Value, json};
use suite::{AMPLE, SHORT, numbered, receive};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

/// Number of the run.
const RUN: u64 = 7;

fn access(listen: &str) -> Access {
    Access {
        listen: Endpoint::read(listen).expect("it is one"),
        connect: None,
        lost_after: Duration::from_secs(10),
    }
}

fn host(access: &Access) -> Host {
    Host::listen(access, RUN, 1).expect("it listens")
}

fn session(transport: Transport) -> Session {
    Session {
        protocol: PROTOCOL_VERSION,
        run_id: RUN,
        scenario_hash: String::new(),
        coordinator_pid: std::process::id(),
        setting: Setting {
            participant: "rail".into(),
            seed: 0,
            thickness_m: 1e-3,
            threads: 1,
            fields: None,
            cache: None,
        },
        transport,
        idle_deadline_s: 60.0,
        config: json!({}),
    }
}

fn transport(host: &Host) -> Transport {
    host.transport("rail", Path::new(""))
}

fn pair(host: &Host) -> (NetworkLink, NetworkLink) {
    let ours = host.link("rail").expect("it is made");
    let theirs = connect(&session(transport(host))).expect("it connects");
    (ours, theirs)
}

/// Requests and answers until all have passed.
fn converse(ours: &mut dyn Link, theirs: &mut dyn Link, rounds: u64) {
    thread::scope(|scope| {
        scope.spawn(|| {
            for _ in 0..rounds {
                let frame = receive(theirs);
                theirs.send(&frame, AMPLE).expect("it is taken");
            }
        });
        for number in 0..rounds {
            let request = numbered(number, vec![number as f64; 5000]);
            ours.send(&request, AMPLE).expect("it is taken");
            assert_eq!(receive(ours), request);
        }
    });
}

#[test]
fn a_network_is_a_link() {
    for listen in ["tcp/127.0.0.1:0", "quic/127.0.0.1:0"] {
        let access = access(listen);
        suite::check(|| {
            let (ours, theirs) = pair(&host(&access));
            (Box::new(ours), Box::new(theirs))
        });
    }
}

#[test]
fn a_frame_beyond_the_capacity_is_refused_before_anything_is_sent() {
    let (mut ours, mut theirs) = pair(&host(&access("tcp/127.0.0.1:0")));
    let (capacity, doubles) = (1 << 27, (1 << 27) + 1);
    let mut frame = numbered(1, vec![]);
    frame.payload = vec![0.0; doubles];
    let refused = Err(LinkError::TooLong { doubles, capacity });
    assert_eq!(ours.send(&frame, AMPLE), refused);
    ours.send(&numbered(2, vec![]), AMPLE)
        .expect("the link still works");
    assert_eq!(receive(&mut theirs).header.window, 2);
}

/// A relay between both ends whose connections can be cut: frames under way are lost.
struct Relay {
    port: u16,
    open: Arc<Mutex<Vec<TcpStream>>>,
    ended: Arc<AtomicBool>,
}

impl Relay {
    fn to(port: u16) -> Relay {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
        let relay = Relay {
            port: listener.local_addr().expect("it has one").port(),
            open: Arc::default(),
            ended: Arc::default(),
        };
        let (open, ended) = (Arc::clone(&relay.open), Arc::clone(&relay.ended));
        thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                if ended.load(Ordering::Relaxed) {
                    return;
                }
                let Ok(beyond) = TcpStream::connect(("127.0.0.1", port)) else {
                    continue;
                };
                for (from, to) in [(&stream, &beyond), (&beyond, &stream)] {
                    // Otherwise the last bytes of a piece wait until the other host confirms the bytes before them.
                    to.set_nodelay(true).expect("it is open");
                    let [from, to] = [from, to].map(|end| end.try_clone().expect("it is open"));
                    thread::spawn(move || pass_on(from, to));
                }
                let mut open = open.lock().expect("nobody panics");
                open.extend([stream, beyond]);
            }
        });
        relay
    }

    fn cut(&self) {
        for stream in self.open.lock().expect("nobody panics").drain(..) {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        self.cut();
        let _ = TcpStream::connect(("127.0.0.1", self.port));
    }
}

fn pass_on(mut from: TcpStream, mut to: TcpStream) {
    let mut bytes = [0; 4096];
    while let Ok(length @ 1..) = from.read(&mut bytes) {
        if to.write_all(&bytes[..length]).is_err() {
            return;
        }
    }
}

fn through_a_relay(lost_after: Duration) -> (Host, Relay) {
    let listen = Endpoint::read("tcp/127.0.0.1:0").and_then(Endpoint::with_port);
    let listen = listen.expect("a port is free");
    let relay = Relay::to(listen.port);
    let connect = Endpoint::read(&format!("tcp/127.0.0.1:{}", relay.port));
    let host = host(&Access {
        connect: Some(connect.expect("it is one")),
        lost_after,
        ..access(&listen.text())
    });
    (host, relay)
}

#[test]
fn frames_lost_with_a_connection_are_sent_again() {
    let (host, relay) = through_a_relay(Duration::from_secs(60));
    let (mut ours, mut theirs) = pair(&host);
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            for _ in 0..10 {
                thread::sleep(Duration::from_millis(150));
                relay.cut();
            }
            ended.store(true, Ordering::Relaxed);
        });
        while !ended.load(Ordering::Relaxed) {
            converse(&mut ours, &mut theirs, 100);
        }
    });
}

#[test]
fn a_link_waits_across_a_cut_for_the_last_answer_of_a_participant() {
    let (host, relay) = through_a_relay(Duration::from_secs(60));
    let (mut ours, mut theirs) = pair(&host);
    converse(&mut ours, &mut theirs, 3);
    relay.cut();
    let last = numbered(9, vec![1.0; 10_000]);
    theirs.send(&last, AMPLE).expect("it is taken");
    let leaver = thread::spawn(move || drop(theirs));
    assert_eq!(receive(&mut ours), last);
    leaver.join().expect("it leaves");
    assert_eq!(ours.receive(AMPLE), Err(LinkError::Closed));
}

#[test]
fn an_end_notices_in_time_that_the_other_is_gone() {
    let seconds = 1.0;
    let (host, relay) = through_a_relay(Duration::from_secs_f64(seconds));
    let (mut ours, mut theirs) = pair(&host);
    converse(&mut ours, &mut theirs, 3);
    drop(relay);
    for end in [&mut ours, &mut theirs] {
        let start = Instant::now();
        let mut heard = Ok(None);
        // Waits in slices count as one.
        while heard == Ok(None) {
            heard = end.receive(SHORT);
        }
        assert_eq!(heard, Err(LinkError::Lost { seconds }));
        assert!(start.elapsed() >= Duration::from_secs_f64(seconds));
    }
}

#[test]
fn a_round_trip_measures_the_offset_of_the_clocks() {
    let host = host(&access("quic/127.0.0.1:0"));
    let (mut ours, mut theirs) = pair(&host);
    for end in [&mut ours, &mut theirs] {
        let trip = end.round_trip().expect("the other end answers");
        // Both read the same clock.
        assert!(
            trip.offset_ns.unsigned_abs() <= trip.time.as_nanos() as u64,
            "{trip:?}"
        );
    }
}

/// The settings of a participant, as a stranger may have obtained them.
fn settings(host: &Host) -> (Value, Key) {
    let Transport::Zenoh { config, key, .. } = transport(host) else {
        unreachable!("it is no other");
    };
    let byte = |at: usize| u8::from_str_radix(&key[2 * at..2 * at + 2], 16).expect("two digits");
    (config, std::array::from_fn(byte))
}

fn open(config: &Value) -> zenoh::Session {
    let config = zenoh::Config::from_json5(&config.to_string()).expect("zenoh knows them");
    zenoh::open(config).wait().expect("it opens")
}

/// True once the coordinator has let the session in.
fn gets_in(stranger: &zenoh::Session) -> bool {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(3) {
        if stranger.info().peers_zid().wait().next().is_some() {
            return true;
        }
        thread::sleep(SHORT);
    }
    false
}

#[test]
fn strangers_without_the_certificate_of_the_run_cannot_connect() {
    let host = host(&access("quic/127.0.0.1:0"));
    let (mut ours, mut theirs) = pair(&host);
    let (config, _) = settings(&host);
    assert!(
        gets_in(&open(&config)),
        "the participant itself can connect"
    );
    let mut without = config.clone();
    let tls = without["transport"]["link"]["tls"]
        .as_object_mut()
        .expect("it has one");
    tls.retain(|key, _| key.starts_with("root"));
    assert!(!gets_in(&open(&without)));
    // The certificate of another run.
    let other = Host::listen(&access("quic/127.0.0.1:0"), 8, 1).expect("it listens");
    let (mut foreign, _) = settings(&other);
    foreign["connect"] = config["connect"].clone();
    foreign["transport"]["link"]["tls"]["root_ca_certificate_base64"] =
        config["transport"]["link"]["tls"]["root_ca_certificate_base64"].clone();
    assert!(!gets_in(&open(&foreign)));
    converse(&mut ours, &mut theirs, 3);
}

/// Without certificates any program on this host may connect and publish: its messages are dropped and counted by reason.
#[test]
fn messages_of_strangers_are_refused_and_harm_nothing() {
    let host = host(&access("tcp/127.0.0.1:0"));
    let (mut ours, mut theirs) = pair(&host);
    let (config, key) = settings(&host);
    let stranger = open(&config);
    assert!(gets_in(&stranger));
    let place = format!("thirdbody/{RUN:016x}/rail/answer");
    let captured = Arc::new(Mutex::new(Vec::new()));
    let heap = Arc::clone(&captured);
    let _spy = stranger
        .declare_subscriber("thirdbody/**")
        .callback(move |sample| {
            let message = (
                sample.key_expr().to_string(),
                sample.payload().to_bytes().to_vec(),
            );
            heap.lock().expect("nobody panics").push(message);
        })
        .wait()
        .expect("it listens");
    converse(&mut ours, &mut theirs, 3);
    let again = captured.lock().expect("nobody panics").clone();
    let say = |place: &str, bytes: Vec<u8>| {
        let put = stranger.put(place, bytes);
        // A full queue blocks instead of dropping messages.
        let put = put.congestion_control(CongestionControl::Block);
        put.wait().expect("it is sent");
    };
    let message = |purpose| Message {
        purpose,
        number: 4,
        received: 99,
        taken: 99,
        clock_ns: u64::MAX,
        echo_ns: u64::MAX,
    };
    let forged = numbered(3, vec![6.66]);
    let piece = || message(Purpose::Piece(forged.header, forged.payload.clone()));
    say(&place, Vec::new());
    say(&place, vec![0; 100_000]);
    say(&place, piece().signed(&[0; 32], Sender::Participant));
    say(
        &place,
        message(Purpose::Left).signed(&[0; 32], Sender::Participant),
    );
    // A message of the coordinator as the answer of its participant.
    say(&place, piece().signed(&key, Sender::Coordinator));
    // A message of the participant, repeated.
    let said = Message {
        number: 1,
        clock_ns: 1,
        echo_ns: 0,
        received: 0,
        taken: 0,
        ..piece()
    };
    say(&place, said.signed(&key, Sender::Participant));
    for (place, bytes) in again {
        say(&place, bytes);
    }
    // A flood.
    for _ in 0..2_000 {
        say(&place, vec![0; 1_000]);
    }
    converse(&mut ours, &mut theirs, 50);
    assert_eq!(
        ours.receive(SHORT),
        Ok(None),
        "only the participant's frames arrive"
    );
    let refused = ours.refusals();
    let count = |reason| refused.get(&reason).copied().unwrap_or(0);
    assert!(count(Refused::Signature) == 2_004, "{refused:?}");
    assert!(count(Refused::Form) == 1, "{refused:?}");
    assert!(count(Refused::Repeated) == 1, "{refused:?}");
}

/// A participant of this test: pieces are taken in their order, in any order of arrival, and a repeated ping gets no answer.
#[test]
fn pieces_are_taken_in_their_order_and_pings_answered_once() {
    let host = host(&access("tcp/127.0.0.1:0"));
    let mut ours = host.link("rail").expect("it is made");
    let (config, key) = settings(&host);
    let participant = open(&config);
    let (sender, heard) = std::sync::mpsc::channel();
    let _subscriber = participant
        .declare_subscriber(format!("thirdbody/{RUN:016x}/rail/request"))
        .callback(move |sample| {
            let message = Message::read(&sample.payload().to_bytes(), &key, Sender::Coordinator);
            let _ = sender.send(message.expect("it is signed"));
        })
        .wait()
        .expect("it listens");
    let say = |purpose, number, clock_ns| {
        let message = Message {
            purpose,
            number,
            received: 0,
            taken: 0,
            clock_ns,
            echo_ns: 0,
        };
        let bytes = message.signed(&key, Sender::Participant);
        let put = participant.put(format!("thirdbody/{RUN:016x}/rail/answer"), bytes);
        let put = put.congestion_control(CongestionControl::Block);
        put.wait().expect("it is sent");
    };
    let is_pong = |message: &Message| message.purpose == Purpose::Pong;
    // Messages before both ends have met are lost.
    let met = (1..1_000).find(|clock_ns| {
        say(Purpose::Ping, 0, *clock_ns);
        heard
            .recv_timeout(SHORT)
            .is_ok_and(|message| is_pong(&message))
    });
    let met = met.expect("pings are answered");
    for clock_ns in [met + 1, met + 1, met + 2, met + 1, met + 3] {
        say(Purpose::Ping, 0, clock_ns);
    }
    let mut answered = Vec::new();
    while answered.last() != Some(&(met + 3)) {
        let message = heard.recv_timeout(AMPLE).expect("pings are answered");
        let is_new = is_pong(&message) && message.echo_ns > met;
        answered.extend(is_new.then_some(message.echo_ns));
    }
    assert_eq!(answered, [met + 1, met + 2, met + 3]);
    let frames = [1, 2].map(|number| numbered(number, vec![number as f64]));
    for number in [2, 1, 2, 2] {
        let frame = &frames[number as usize - 1];
        say(
            Purpose::Piece(frame.header, frame.payload.clone()),
            number,
            4,
        );
    }
    for frame in frames {
        assert_eq!(receive(&mut ours), frame);
    }
    assert_eq!(ours.receive(SHORT), Ok(None));
}
