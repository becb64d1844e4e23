//! Where the services of a connection are, and how each end makes or opens them.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::prelude::{
    AllocationStrategy, AttributeSpecifier, BackpressureStrategy, Config, FileName, LogLevel,
    NodeBuilder, PortFactory, SemanticString, ServiceName, SignalHandlingMode, set_log_level,
};
use iceoryx2::service::attribute::AttributeKey;
use iceoryx2::service::builder::publish_subscribe::{
    Builder as DataBuilder, PublishSubscribeOpenError,
};

use super::clock::Clock;
use super::rhythm::Rhythm;
use super::{DataService, EventService, Iox, SAMPLE_DOUBLES, ShmLink, failed, sweep};
use crate::frame::Header;
use crate::link::LinkError;

/// Samples that may wait in one direction. Two frames at most are under way; a long one streams through these.
const WAITING_SAMPLES: usize = 4;

/// Bytes that one end takes of shared memory: its data segment, rounded up for the small files.
const ROOM: usize = (WAITING_SAMPLES + 4) * SAMPLE_DOUBLES * 8;

/// How long an end that polls does so before it sleeps: most answers of a solver come earlier.
const POLLING: Duration = Duration::from_millis(2);

/// The same for an end that shares its core. Also what the sleep then costs, so at most that is wasted.
const PEEKING: Duration = Duration::from_micros(20);

/// Longest path of a Unix socket, its terminating zero included.
const SOCKET_PATH: usize = 108;

/// Digits of the number of a port, which names the socket that its event listens to.
const PORT_DIGITS: usize = 39;

/// Replaces iceoryx2's longer one to leave more of the socket's path to the root.
const EVENT_SUFFIX: &str = ".ev";

const REQUEST: &str = "request";
const ANSWER: &str = "answer";
const POLLS: &str = "poll";
const SLEEPS: &str = "event";

/// The attribute of a service that tells the participant how to wait.
fn waiting() -> Result<AttributeKey, LinkError> {
    "waiting".try_into().map_err(failed)
}

/// Whether the coordinator that created this service polls.
pub(super) fn polls(service: &DataService) -> Result<bool, LinkError> {
    Ok(service
        .attributes()
        .key_value(&waiting()?, 0)
        .is_some_and(|value| value.as_bytes() == POLLS.as_bytes()))
}

/// Where the services of one participant are.
pub(super) struct Place {
    node: Node<Iox>,
    broom: Broom,
    participant: String,
}

impl Place {
    pub(super) fn new(root: &Path, prefix: &str, participant: &str) -> Result<Place, LinkError> {
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

    pub(super) fn each_way<T>(
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

    pub(super) fn create_data(&self, way: &str, polls: bool) -> Result<DataService, LinkError> {
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

    pub(super) fn open_data(&self, way: &str, clock: &Clock) -> Result<DataService, LinkError> {
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

    pub(super) fn create_event(&self, way: &str) -> Result<EventService, LinkError> {
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

    pub(super) fn open_event(&self, way: &str) -> Result<EventService, LinkError> {
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
    pub(super) fn join(
        self,
        outbound: DataService,
        inbound: DataService,
        events: [EventService; 2],
        polls: bool,
    ) -> Result<ShmLink, LinkError> {
        let [wakes_other, wakes_us] = &events;
        let rhythm = (!polls).then(Rhythm::default);
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
            rhythm,
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
pub(super) struct Broom {
    root: PathBuf,
    prefix: String,
}

impl Drop for Broom {
    fn drop(&mut self) {
        sweep::remove_shared(&self.root, &self.prefix);
    }
}

fn transport<E: Display>(what: impl Display) -> impl FnOnce(E) -> LinkError {
    move |error| LinkError::Transport(format!("{what}: {error}"))
}
