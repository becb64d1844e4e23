//! Participants: their start, their life, and the ways to speak to them.
//!
//! - [`registry`]: the solvers that the binary ships; [`watch`]: signals that end a run;
//! - [`process`], [`printed`], [`peer`], [`launch`]: one participant, its words, its connection and its life, and its start;
//! - [`communicator`]: requests and answers of all of them; [`journal`], [`recorded`]: the same written down, or compared with
//!   a log;
//! - [`network`]: the endpoint that participants on other hosts connect to, in a program that is built with the feature `zenoh`;
//! - [`handshake`]: the greeting; [`admission`]: what a participant says of itself, checked; [`farewell`]: its last
//!   words, read leniently;
//! - [`remote`]: participants behind frames, as schemes see them; in memory they are
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
