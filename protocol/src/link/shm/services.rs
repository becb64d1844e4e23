//! The iceoryx2 services of a connection: names and settings, creation by the coordinator, opening by the participant, and
//! the ports of each end.

use std::fmt::Display;
use std::path::Path;
use std::thread;
use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::port::listener::Listener;
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

use super::cleanup::{SharedFile, private_folder, probe_room};
use super::deadline::Deadline;
use crate::frame::Header;
use crate::link::LinkError;

/// Doubles in one sample, 128 KiB: a usual window fits, and the buffers of both directions stay in cache.
pub(super) const SAMPLE_DOUBLES: usize = 1 << 14;

/// Samples that may wait in one direction. Two frames at most are under way; a long one streams through these.
const WAITING_SAMPLES: usize = 4;

/// Bytes of shared memory that one end uses: its data segment, rounded up for the small files.
const ROOM: usize = (WAITING_SAMPLES + 4) * SAMPLE_DOUBLES * 8;

/// Longest path of a Unix socket, its terminating zero included.
const SOCKET_PATH: usize = 108;

/// Digits of a port's number, which names the socket of its event.
const PORT_DIGITS: usize = 39;

/// Replaces iceoryx2's longer suffix to leave more of the socket's path to the root.
const EVENT_SUFFIX: &str = ".ev";

const REQUEST: &str = "request";
const ANSWER: &str = "answer";
const POLLS: &str = "poll";
const SLEEPS: &str = "event";

type Iox = ipc_threadsafe::Service;
pub(super) type DataService = publish_subscribe::PortFactory<Iox, [f64], Header>;
type EventService = event::PortFactory<Iox>;

/// The attribute of a service that holds the coordinator's wait mode for the participant.
fn waiting() -> Result<AttributeKey, LinkError> {
    "waiting".try_into().map_err(failed)
}

/// True if the coordinator that created this service polls.
pub(super) fn polls(service: &DataService) -> Result<bool, LinkError> {
    Ok(service
        .attributes()
        .key_value(&waiting()?, 0)
        .is_some_and(|value| value.as_bytes() == POLLS.as_bytes()))
}

/// The services of one participant.
pub(super) struct Services {
    node: Node<Iox>,
    shared: SharedFile,
    participant: String,
}

impl Services {
    pub(super) fn new(root: &Path, prefix: &str, participant: &str) -> Result<Services, LinkError> {
        // iceoryx2 writes only errors to the terminal.
        set_log_level(LogLevel::Error);
        let config = config(root, prefix)?;
        let folder = root.display();
        private_folder(root).map_err(transport(format!("the folder {folder} cannot be used")))?;
        let lacking = format!("{ROOM} more bytes are needed and not available");
        probe_room(prefix, ROOM).map_err(transport(lacking))?;
        let shared = SharedFile {
            root: root.into(),
            prefix: prefix.into(),
        };
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Iox>()
            .map_err(transport(format!("nothing can be created below {folder}")))?;
        Ok(Services {
            node,
            shared,
            participant: participant.into(),
        })
    }

    /// Makes one thing for the requests and one for the answers.
    pub(super) fn each_way<T>(
        &self,
        mut make: impl FnMut(&str) -> Result<T, LinkError>,
    ) -> Result<[T; 2], LinkError> {
        Ok([make(REQUEST)?, make(ANSWER)?])
    }

    fn name(&self, way: &str) -> Result<ServiceName, LinkError> {
        let participant = &self.participant;
        ServiceName::new(&format!("{participant}/{way}")).map_err(transport(format!(
            "`{participant}` cannot name a participant"
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
        let (how, participant) = (if polls { POLLS } else { SLEEPS }, &self.participant);
        let attributes = AttributeSpecifier::new()
            .define(&waiting()?, &how.try_into().map_err(failed)?)
            .map_err(failed)?;
        self.data(way)?
            .create_with_attributes(&attributes)
            .map_err(transport(format!(
                "the connection to `{participant}` cannot be created"
            )))
    }

    pub(super) fn open_data(
        &self,
        way: &str,
        deadline: &Deadline,
    ) -> Result<DataService, LinkError> {
        loop {
            let error = match self.data(way)?.open() {
                Ok(service) => return Ok(service),
                Err(error) => error,
            };
            // A service that is being created gives these errors too.
            let may_come = matches!(
                error,
                PublishSubscribeOpenError::DoesNotExist
                    | PublishSubscribeOpenError::HangsInCreation
                    | PublishSubscribeOpenError::InsufficientPermissions
                    | PublishSubscribeOpenError::Interrupt
            );
            if !may_come || deadline.left().is_zero() {
                return Err(failed(format!(
                    "`{}` found no connection to the coordinator within {:.1} s: {error}",
                    self.participant,
                    deadline.elapsed().as_secs_f64()
                )));
            }
            thread::sleep(deadline.left().min(Duration::from_millis(1)));
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

    /// Creates the ports of one end: it listens before the other end can send.
    pub(super) fn ports(
        self,
        outbound: DataService,
        inbound: DataService,
        events: [EventService; 2],
    ) -> Result<Ports, LinkError> {
        let [wakes_other, wakes_us] = &events;
        Ok(Ports {
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
            _events: events,
            _node: self.node,
            _shared: self.shared,
        })
    }
}

/// The ports of one end, with their services and their node. Ports are dropped before their services, services before the
/// node, and the shared file last.
pub(super) struct Ports {
    pub(super) publisher: Publisher<Iox, [f64], Header>,
    pub(super) subscriber: Subscriber<Iox, [f64], Header>,
    pub(super) notifier: Notifier<Iox>,
    pub(super) listener: Listener<Iox>,
    outbound: DataService,
    inbound: DataService,
    _events: [EventService; 2],
    _node: Node<Iox>,
    _shared: SharedFile,
}

impl Ports {
    /// True if the other end has both of its ports.
    pub(super) fn other_is_there(&self) -> bool {
        self.outbound.dynamic_config().number_of_subscribers() > 0 && self.other_can_send()
    }

    /// True while the other end has its sending port.
    pub(super) fn other_can_send(&self) -> bool {
        self.inbound.dynamic_config().number_of_publishers() > 0
    }
}

/// The settings of iceoryx2 for one run.
fn config(root: &Path, prefix: &str) -> Result<Config, LinkError> {
    let socket = root.as_os_str().len() + 1 + prefix.len() + PORT_DIGITS + EVENT_SUFFIX.len();
    if socket >= SOCKET_PATH {
        return Err(failed(format!(
            "the paths of sockets below {} would be {socket} bytes long, but at most {} work: choose a shorter folder",
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
    // The coordinator removes the files of dead runs. A scan costs 1 to 2 ms each time, and would remove
    // files that the post-mortem needs.
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

/// An error of the transport, as the transport states it.
pub(super) fn failed(error: impl Display) -> LinkError {
    LinkError::Transport(format!("shared memory: {error}"))
}

fn transport<E: Display>(what: impl Display) -> impl FnOnce(E) -> LinkError {
    move |error| LinkError::Transport(format!("shared memory: {what}: {error}"))
}
