//! Frames between processes, through shared memory (iceoryx2).
//!
//! Each participant has two publish-subscribe services, one a direction, with one publisher and one
//! subscriber each; the frame's header travels as the user header, its payload as a slice of doubles.
//! A frame that is longer than one sample travels as several, the last of them not full. So samples have
//! one fixed size, a 4 000 x 4 000 matrix needs no more shared memory than a greeting does, and a container
//! with 64 MiB of `/dev/shm` is enough. Letting iceoryx2 grow its data segment instead was rejected: it
//! loses the sample when the sender leaves before the receiver has mapped the new segment.
//!
//! A waiting end polls for a while and then sleeps on an iceoryx2 event. The event is a hint: sleep is cut
//! into slices after each of which the end looks again, so a lost wake-up costs a slice and nothing hangs.
//!
//! The signal handlers of the process stay as they are: those of iceoryx2 come only with waits that are not
//! used here.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use iceoryx2::node::Node;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{
    AllocationStrategy, AttributeSpecifier, BackpressureStrategy, Config, FileName, LogLevel,
    NodeBuilder, PortFactory, SemanticString, ServiceName, SignalHandlingMode, ipc_threadsafe,
    set_log_level,
};
use iceoryx2::service::attribute::AttributeKey;
use iceoryx2::service::builder::publish_subscribe::{
    Builder as DataBuilder, PublishSubscribeOpenError,
};
use iceoryx2::service::port_factory::{event, publish_subscribe};

use crate::frame::{Frame, Header};
use crate::link::{Link, LinkError};

mod sweep;

pub use sweep::{run_prefix, run_root, sweep, sweep_dead};

/// The most doubles that one frame can hold: 1 GiB, a square matrix of 11 585 rows.
pub const MAX_DOUBLES: usize = 1 << 27;

/// Doubles in one sample. 128 KiB: a usual window fits, and the buffers of both directions stay in cache.
const SAMPLE_DOUBLES: usize = 1 << 14;

/// Samples that may wait in one direction. Two frames at most are under way; a long one streams through these.
const WAITING_SAMPLES: usize = 4;

/// Bytes that one end takes of shared memory: its data segment, rounded up for the small files.
const ROOM: usize = (WAITING_SAMPLES + 4) * SAMPLE_DOUBLES * 8;

/// How long an end that polls does so before it sleeps: most answers of a solver come earlier.
const POLLING: Duration = Duration::from_millis(2);

/// The same for an end that shares its core. Also what the sleep then costs, so at most that is wasted.
const PEEKING: Duration = Duration::from_micros(20);

/// Longest sleep before looking again, whatever the event says.
const SLICE: Duration = Duration::from_millis(20);

/// Longest path of a Unix socket, its terminating zero included.
const SOCKET_PATH: usize = 108;

/// Digits of the number of a port, which names the socket that its event listens to.
const PORT_DIGITS: usize = 39;

/// Replaces iceoryx2's longer one to leave more of the socket's path to the root.
const EVENT_SUFFIX: &str = ".ev";

type Iox = ipc_threadsafe::Service;
type DataService = publish_subscribe::PortFactory<Iox, [f64], Header>;
type EventService = event::PortFactory<Iox>;

/// How an end waits for the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaitMode {
    /// Polls for a while, giving way to other threads, and then sleeps.
    Poll,
    /// Sleeps almost at once: right when processes share cores.
    Event,
    /// `Poll` if every process of the run can have a core to itself, `Event` otherwise.
    Auto {
        /// Processes of the run that compute or wait, the coordinator included.
        processes: usize,
    },
}

impl WaitMode {
    fn polls(self) -> bool {
        match self {
            WaitMode::Poll => true,
            WaitMode::Event => false,
            WaitMode::Auto { processes } => {
                processes <= thread::available_parallelism().map_or(1, usize::from)
            }
        }
    }
}

/// One end of a connection through shared memory. Whatever it created goes when both ends are dropped.
pub struct ShmLink {
    // Ports go before their services, services before the node, and the broom sweeps last.
    publisher: Publisher<Iox, [f64], Header>,
    subscriber: Subscriber<Iox, [f64], Header>,
    notifier: Notifier<Iox>,
    listener: Listener<Iox>,
    outbound: DataService,
    inbound: DataService,
    polling_time: Duration,
    /// Both ports of the other end were seen: from now on their absence means that it left.
    connected: bool,
    /// A frame was cut off half-way, the other end would take the next one for its rest.
    cut: bool,
    /// What has arrived of a frame of several samples.
    arriving: Vec<f64>,
    _events: [EventService; 2],
    _node: Node<Iox>,
    _broom: Broom,
}

impl ShmLink {
    /// Creates the connection to a participant below `root`, with `prefix` before every name.
    pub fn coordinator(
        root: &Path,
        prefix: &str,
        participant: &str,
        wait: WaitMode,
    ) -> Result<ShmLink, LinkError> {
        let place = Place::new(root, prefix, participant)?;
        let polls = wait.polls();
        // The services of the data come last: the participant waits for them and then finds the others.
        let events = place.each_way(|way| place.create_event(way))?;
        let [request, answer] = place.each_way(|way| place.create_data(way, polls))?;
        place.join(request, answer, events, polls)
    }

    /// Opens the connection that the coordinator has created, or creates within `patience`.
    /// The participant waits as the coordinator does.
    pub fn participant(
        root: &Path,
        prefix: &str,
        participant: &str,
        patience: Duration,
    ) -> Result<ShmLink, LinkError> {
        let place = Place::new(root, prefix, participant)?;
        let clock = Clock::new(patience);
        let [request, answer] = place.each_way(|way| place.open_data(way, &clock))?;
        let [request_event, answer_event] = place.each_way(|way| place.open_event(way))?;
        let polls = request
            .attributes()
            .key_value(&waiting()?, 0)
            .is_some_and(|value| value.as_bytes() == POLLS.as_bytes());
        place.join(answer, request, [answer_event, request_event], polls)
    }

    /// Waits for both ports of the other end and connects to them, so that nothing it says is lost even if
    /// it says it and leaves before we listen.
    fn connect(&mut self, clock: &Clock) -> Result<(), LinkError> {
        while !self.connected {
            if self.outbound.dynamic_config().number_of_subscribers() > 0
                && self.inbound.dynamic_config().number_of_publishers() > 0
            {
                self.subscriber.has_samples().map_err(failed)?;
                self.connected = true;
            } else {
                clock.pause(self.polling_time)?;
            }
        }
        Ok(())
    }

    /// Whether the other end was dropped. A killed one is not noticed here: its process is what to look at.
    fn has_left(&self) -> bool {
        self.connected && self.inbound.dynamic_config().number_of_publishers() == 0
    }

    fn send_sample(
        &mut self,
        header: Header,
        doubles: &[f64],
        clock: &Clock,
    ) -> Result<(), LinkError> {
        loop {
            let mut sample = self
                .publisher
                .loan_slice_uninit(doubles.len())
                .map_err(failed)?;
            *sample.user_header_mut() = header;
            let receivers = sample.write_from_slice(doubles).send().map_err(failed)?;
            if receivers > 0 {
                // A failed wake-up delays the other end by a slice at most.
                let _ = self.notifier.notify();
                return Ok(());
            }
            if self.has_left() {
                return Err(LinkError::Closed);
            }
            clock.pause(self.polling_time)?;
        }
    }

    /// The next frame, if all of it is there.
    fn take(&mut self) -> Result<Option<Frame>, LinkError> {
        while let Some(sample) = self.subscriber.receive().map_err(failed)? {
            let doubles = sample.payload();
            let length = self.arriving.len() + doubles.len();
            if length > MAX_DOUBLES {
                return Err(too_long(length));
            }
            self.arriving.extend_from_slice(doubles);
            if doubles.len() < SAMPLE_DOUBLES {
                return Ok(Some(Frame {
                    header: *sample.user_header(),
                    payload: std::mem::take(&mut self.arriving),
                }));
            }
        }
        Ok(None)
    }

    fn sleep(&self, time: Duration) -> Result<(), LinkError> {
        match self.listener.timed_wait(|_| {}, time.min(SLICE)) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(error) => Err(failed(error)),
        }
    }
}

impl Link for ShmLink {
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError> {
        let clock = Clock::new(patience);
        if frame.payload.len() > MAX_DOUBLES {
            return Err(too_long(frame.payload.len()));
        }
        if self.cut {
            return Err(failed(
                "an earlier frame was cut off half-way, nothing can follow it",
            ));
        }
        self.connect(&clock)?;
        if self.has_left() {
            return Err(LinkError::Closed);
        }
        let mut rest = frame.payload.as_slice();
        loop {
            let (sample, later) = rest.split_at(rest.len().min(SAMPLE_DOUBLES));
            let sent = self.send_sample(frame.header, sample, &clock);
            self.cut = sent.is_err() && rest.len() < frame.payload.len();
            sent?;
            if sample.len() < SAMPLE_DOUBLES {
                return Ok(());
            }
            rest = later;
        }
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        let clock = Clock::new(patience);
        loop {
            if let Some(frame) = self.take()? {
                self.connected = true;
                return Ok(Some(frame));
            }
            if self.has_left() {
                // What it said before it left may have come since we looked.
                return self.take()?.map(Some).ok_or(LinkError::Closed);
            }
            let left = clock.left();
            if left.is_zero() {
                return Ok(None);
            }
            if clock.elapsed() < self.polling_time {
                thread::yield_now();
            } else {
                self.sleep(left)?;
            }
        }
    }
}

/// The time that a call may take.
struct Clock {
    start: Instant,
    patience: Duration,
}

impl Clock {
    fn new(patience: Duration) -> Clock {
        Clock {
            start: Instant::now(),
            patience,
        }
    }

    fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    fn left(&self) -> Duration {
        self.patience.saturating_sub(self.elapsed())
    }

    /// Gives way to others: first for an instant, later for a nap, never beyond the end of the patience.
    fn pause(&self, polling_time: Duration) -> Result<(), LinkError> {
        let left = self.left();
        if left.is_zero() {
            return Err(LinkError::Full {
                seconds: self.patience.as_secs_f64(),
            });
        }
        if self.elapsed() < polling_time {
            thread::yield_now();
        } else {
            thread::sleep(left.min(Duration::from_micros(100)));
        }
        Ok(())
    }
}

const REQUEST: &str = "request";
const ANSWER: &str = "answer";
const POLLS: &str = "poll";
const SLEEPS: &str = "event";

/// The attribute of a service that tells the participant how to wait.
fn waiting() -> Result<AttributeKey, LinkError> {
    "waiting".try_into().map_err(failed)
}

/// Where the services of one participant are.
struct Place {
    node: Node<Iox>,
    broom: Broom,
    participant: String,
}

impl Place {
    fn new(root: &Path, prefix: &str, participant: &str) -> Result<Place, LinkError> {
        quiet();
        let config = config(root, prefix)?;
        sweep::private_folder(root).map_err(transport(format!(
            "the folder {} cannot be used",
            root.display()
        )))?;
        sweep::probe_room(prefix, ROOM).map_err(transport(format!(
            "{ROOM} bytes more are needed and cannot be had"
        )))?;
        let broom = Broom {
            root: root.into(),
            prefix: prefix.into(),
        };
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Iox>()
            .map_err(transport(format!(
                "nothing can be created below {}",
                root.display()
            )))?;
        Ok(Place {
            node,
            broom,
            participant: participant.into(),
        })
    }

    fn each_way<T>(
        &self,
        mut make: impl FnMut(&str) -> Result<T, LinkError>,
    ) -> Result<[T; 2], LinkError> {
        Ok([make(REQUEST)?, make(ANSWER)?])
    }

    fn name(&self, way: &str) -> Result<ServiceName, LinkError> {
        ServiceName::new(&format!("{}/{way}", self.participant)).map_err(transport(format!(
            "`{}` cannot name a participant",
            self.participant
        )))
    }

    fn data(&self, way: &str) -> Result<DataBuilder<[f64], Header, Iox>, LinkError> {
        Ok(self
            .node
            .service_builder(&self.name(way)?)
            .publish_subscribe::<[f64]>()
            .user_header::<Header>()
            .enable_safe_overflow(false)
            .history_size(0)
            .subscriber_max_buffer_size(WAITING_SAMPLES)
            .subscriber_max_borrowed_samples(1)
            .max_publishers(1)
            .max_subscribers(1)
            .max_nodes(2))
    }

    fn create_data(&self, way: &str, polls: bool) -> Result<DataService, LinkError> {
        let how = if polls { POLLS } else { SLEEPS };
        let attributes = AttributeSpecifier::new()
            .define(&waiting()?, &how.try_into().map_err(failed)?)
            .map_err(failed)?;
        self.data(way)?
            .create_with_attributes(&attributes)
            .map_err(transport(format!(
                "the connection to `{}` cannot be created",
                self.participant
            )))
    }

    fn open_data(&self, way: &str, clock: &Clock) -> Result<DataService, LinkError> {
        loop {
            let error = match self.data(way)?.open() {
                Ok(service) => return Ok(service),
                Err(error) => error,
            };
            // A service that is being created looks like these, too.
            let may_come = matches!(
                error,
                PublishSubscribeOpenError::DoesNotExist
                    | PublishSubscribeOpenError::HangsInCreation
                    | PublishSubscribeOpenError::InsufficientPermissions
                    | PublishSubscribeOpenError::Interrupt
            );
            if !may_come || clock.left().is_zero() {
                return Err(failed(format!(
                    "`{}` found no connection of the coordinator within {:.1} s: {error}",
                    self.participant,
                    clock.elapsed().as_secs_f64()
                )));
            }
            thread::sleep(clock.left().min(Duration::from_millis(1)));
        }
    }

    fn create_event(&self, way: &str) -> Result<EventService, LinkError> {
        self.node
            .service_builder(&self.name(way)?)
            .event()
            .max_listeners(1)
            .max_notifiers(1)
            .max_nodes(2)
            .event_id_max_value(0)
            .create()
            .map_err(transport(format!(
                "the wake-up of `{}` cannot be created",
                self.participant
            )))
    }

    fn open_event(&self, way: &str) -> Result<EventService, LinkError> {
        self.node
            .service_builder(&self.name(way)?)
            .event()
            .open()
            .map_err(transport(format!(
                "`{}` cannot open the wake-up of the coordinator",
                self.participant
            )))
    }

    /// Creates the ports of one end: it listens before it can be spoken to.
    fn join(
        self,
        outbound: DataService,
        inbound: DataService,
        events: [EventService; 2],
        polls: bool,
    ) -> Result<ShmLink, LinkError> {
        let [wakes_other, wakes_us] = &events;
        Ok(ShmLink {
            listener: wakes_us.listener_builder().create().map_err(failed)?,
            notifier: wakes_other.notifier_builder().create().map_err(failed)?,
            publisher: outbound
                .publisher_builder()
                .initial_max_slice_len(SAMPLE_DOUBLES)
                .allocation_strategy(AllocationStrategy::Static)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .max_loaned_samples(1)
                .create()
                .map_err(failed)?,
            subscriber: inbound.subscriber_builder().create().map_err(failed)?,
            outbound,
            inbound,
            polling_time: match polls {
                true => POLLING,
                false => PEEKING,
            },
            connected: false,
            cut: false,
            arriving: Vec::new(),
            _events: events,
            _node: self.node,
            _broom: self.broom,
        })
    }
}

/// The settings of iceoryx2 for one run.
fn config(root: &Path, prefix: &str) -> Result<Config, LinkError> {
    let socket = root.as_os_str().len() + 1 + prefix.len() + PORT_DIGITS + EVENT_SUFFIX.len();
    if socket >= SOCKET_PATH {
        return Err(failed(format!(
            "the paths of sockets below {} would be {socket} bytes long, at most {} work: choose a shorter folder",
            root.display(),
            SOCKET_PATH - 1
        )));
    }
    let mut config = Config::default();
    let path = iceoryx2::prelude::Path::new(root.as_os_str().as_encoded_bytes()).map_err(
        transport(format!("{} cannot be used as a folder", root.display())),
    )?;
    config.global.set_root_path(&path);
    config.global.prefix = FileName::new(prefix.as_bytes())
        .map_err(transport(format!("`{prefix}` cannot be used as a prefix")))?;
    config.global.service.event_connection_suffix =
        FileName::new(EVENT_SUFFIX.as_bytes()).map_err(failed)?;
    // The coordinator sweeps up what the dead left. A scan costs 1 to 2 ms each time, and would take away
    // what the post-mortem needs.
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

/// Keeps iceoryx2 from writing anything but errors to the terminal.
fn quiet() {
    set_log_level(LogLevel::Error);
}

/// Removes, after the last end of a prefix, what iceoryx2 shares between ends and leaves behind.
struct Broom {
    root: PathBuf,
    prefix: String,
}

impl Drop for Broom {
    fn drop(&mut self) {
        sweep::remove_shared(&self.root, &self.prefix);
    }
}

fn too_long(doubles: usize) -> LinkError {
    LinkError::TooLong {
        doubles,
        capacity: MAX_DOUBLES,
    }
}

fn failed(error: impl Display) -> LinkError {
    LinkError::Transport(error.to_string())
}

fn transport<E: Display>(what: impl Display) -> impl FnOnce(E) -> LinkError {
    move |error| LinkError::Transport(format!("{what}: {error}"))
}
