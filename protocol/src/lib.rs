//! The words of the conversation between a coupler and its solvers, and nothing else.
//!
//! A *participant* is a process (or, for tests and small scenes, a thread) that holds one solver, a [`Node`].
//! The coordinator speaks to each participant over a [`Link`]: it sends one request [`Frame`] and waits for one
//! answer, so that on a link there is never more than one frame under way.
//!
//! Modules, in reading order:
//! - [`frame`]: the fixed header and its payload of doubles;
//! - [`setting`]: what a participant is told when it is launched, and the checked reading of its own keys;
//! - [`node`]: what a solver can be asked, and what it answers;
//! - [`checkpoint`]: a node's state as bytes;
//! - [`serve`](mod@serve): the loop that turns frames into calls of a [`Node`];
//! - [`link`]: the ways a frame travels: shared memory or an in-process channel;
//! - [`participate`](mod@participate): the whole life of a participant in a process of its own.
//!
//! ```
//! use protocol::{Frame, Header, Kind};
//! let frame = Frame::new(Header::of(Kind::Motion), vec![1.0, 2.0]);
//! assert!(frame.verify().is_ok());
//! ```

pub mod checkpoint;
pub mod frame;
pub mod link;
pub mod node;
pub mod participate;
pub mod serve;
pub mod setting;

pub use frame::{Frame, FrameError, Header, Kind, PROTOCOL_VERSION};
pub use link::{Link, LinkError};
pub use node::{
    BoundaryAnswer, BoundaryInertia, Capabilities, Description, FaultCode, Node, NodeError,
    Outcome, Phase, Reaction, Role, Surface, Term, Tolerance, Window,
};
pub use participate::{ParticipateError, participate};
pub use serve::{ServeError, serve};
pub use setting::{ConfigError, Session, Setting, Transport, read_config, read_part};
