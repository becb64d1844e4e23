//! Participants: their start, their life, and the communication with them.
//!
//! - [`registry`]: the built-in solvers; [`watch`]: signals that end a run;
//! - [`process`], [`printed`], [`peer`], [`launch`]: one participant, its printed output, its connection and life, and
//!   its start;
//! - [`communicator`]: requests and answers of all participants; [`journal`], [`recorded`]: the same, recorded or
//!   compared with a log;
//! - [`network`]: the endpoint for participants on other hosts, in a program built with the feature `zenoh`;
//! - [`handshake`]: the greeting; [`admission`]: checks of a participant's description; [`farewell`]: its last message,
//!   read leniently;
//! - [`remote`]: participants behind frames, as schemes see them; their counterpart in memory is
//!   [`LinearPair`](scheme::predict::linear_pair::LinearPair).

pub mod admission;
pub mod communicator;
pub mod farewell;
pub mod handshake;
pub mod journal;
pub mod launch;
pub mod network;
pub mod peer;
pub mod printed;
pub mod process;
pub mod recorded;
pub mod registry;
pub mod remote;
pub mod watch;

pub use communicator::{Communicator, Peers};
pub use launch::Launcher;
pub use peer::{OtherEnd, Peer};
pub use registry::{Registry, ShippedSolver};
pub use watch::Watch;
