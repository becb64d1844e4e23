//! The protocol between a coupler and its solvers, and nothing else.
//!
//! A *participant* is a process (or, for tests and small scenes, a thread) that holds one solver, a [`Node`].
//! The coordinator speaks to each participant over a [`Link`]: each request [`Frame`] has one answer, and answers come in the
//! order of the requests. At most one request is sent ahead, while the answer to the one before is still to come: a
//! participant then need not wait between the two.
//!
//! Modules, in reading order:
//! - [`frame`]: the fixed header and its payload of doubles;
//! - [`setting`]: the setting that a participant is launched with, and the checked reading of its own keys;
//! - [`input_file`]: files that a scenario names;
//! - [`table`]: loads over time, a key of several solvers;
//! - [`cause`]: causes of errors, a word for each that has a cure of its own;
//! - [`schema`]: the keys of a configuration as a JSON Schema;
//! - [`node`]: the requests that a solver answers, and the types of its answers;
//! - [`finding`]: values that are not plausible, and the bounds of a check;
//! - [`cure`]: errors of the system, with what to do about them;
//! - [`checkpoint`]: a node's state as bytes;
//! - [`busy`]: stretches of time in which a process was at work;
//! - [`link`]: the ways a frame travels: an in-process channel or shared memory;
//! - [`serve`](mod@serve): the loop that turns frames into calls of a [`Node`];
//! - [`participate`](mod@participate): the whole life of a participant in a process of its own.
//!
//! ```
//! use protocol::{Frame, Header, Kind};
//! let frame = Frame::new(Header::of(Kind::Motion), vec![1.0, 2.0]);
//! assert!(frame.verify().is_ok());
//! ```

pub mod busy;
pub mod cause;
pub mod checkpoint;
pub mod cure;
pub mod finding;
pub mod frame;
pub mod input_file;
pub mod link;
pub mod node;
pub mod participate;
pub mod schema;
pub mod serve;
pub mod setting;
pub mod table;

pub use cause::{Cause, FaultCode};
pub use cure::WithCure;
pub use finding::{Bounds, Finding, larger};
pub use frame::{Frame, FrameError, Header, Kind, PROTOCOL_VERSION};
pub use link::{Link, LinkError};
pub use node::{
    BoundaryAnswer, BoundaryInertia, Capabilities, Description, HeldLoad, Node, NodeError, Outcome,
    Phase, PreparedSample, Reaction, Role, Surface, Term, Tolerance, Window,
};
pub use participate::{ParticipateError, participate};
pub use serve::{ServeError, serve};
pub use setting::{ConfigError, Session, Setting, Transport, read_config, read_part};
