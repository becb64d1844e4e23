//! The protocol between a coupler and its solvers, and nothing else.
//!
//! A *participant* is a process (or, for tests and small scenes, a thread) that holds one solver, a [`Node`].
//! The coordinator speaks to each participant over a [`Link`]. Each request [`Frame`] has one answer, and answers come in the
//! order of the requests. The coordinator sends at most one request ahead, before the answer to the previous one arrives, so
//! that the participant need not wait between the two.
//!
//! # Symbols
//!
//! Requests and answers carry plain doubles in SI, two components a point: (x0, y0, x1, y1, ...). n points are exchanged, the
//! window has the length H and holds m steps of the continuum.
//!
//! | symbol | meaning | unit | shape | where |
//! |---|---|---|---|---|
//! | lambda | force on the points of a continuum, constant in the window | N | 2 n | [`Node::advance`] |
//! | du | displacement of these points from the window's start to its end | m | 2 n | its answer |
//! | C | compliance over the window: du under a unit force | m/N | 2 n x 2 n, column by column | [`Node::columns`] |
//! | D | impedance: force at the end of a window in which a velocity grows linearly to one | kg/s | 2 n x 2 n | [`Node::impedance`] |
//! | W_g, a_g | compliance of glued points, N C N^T / H^2; their velocity without contact forces | 1/kg, m/s | 2 n x 2 n, 2 n | [`Node::set_boundary`], [`Node::solve`] |
//! | F_g, v_g | force on the glued points, and their velocity v_g = a_g + H W_g F_g | N, m/s | 2 n each | [`BoundaryAnswer`] |
//!
//! # A conversation
//!
//! ```text
//! Hello -> Welcome                    versions, run, units; the node's Description
//! Couple, Select -> Surface, Ready    points of a named set; the exchanged points
//! Columns -> Compliance               of a continuum
//! CompliantBoundary -> Ready          of grains
//! per window, as often as the scheme wants, from the committed state:
//!   Advance(lambda) -> Motion(du)     a continuum
//!   Solve(a_g) -> Force(F_g, v_g)     grains
//! Commit -> Report                    the answers become the state; signals, energies
//! Finish -> Finished                  results, hash of the state
//! ```
//!
//! 1. A coordinator launches a participant, which reads its [`Session`] and calls [`participate()`].
//! 2. [`serve()`] checks the greeting, builds the [`Node`], and turns each [`Frame`] into a call of the node.
//! 3. [`link`] carries frames, in memory or over shared memory; both deliver the same bits.
//!
//! # Checks
//!
//! - Each frame has a checksum (XXH3) over header, payload and its turn in the conversation; damage, loss and repetition end the run.
//! - Each wait has a deadline; the error at the deadline names the peer, its request and the window.
//! - Nodes report energies as [`Term`]s, each with its [`Role`], so that the coupler can balance work, stored and dissipated
//!   energy of solvers that it does not know.
//! - A [`Finding`] is an implausible value: it states value, bound and what to do.
//!
//! # Limits
//!
//! Links of this crate join processes of one host; the crate `network` has links between hosts. Points lie on a line in the plane.
//! A node answers one request at a time. `protocol/WIRE.md` describes the bytes on the wire, `protocol/README.md` the log.
//!
//! # Modules
//!
//! In reading order:
//! - [`frame`]: the fixed header and its payload of doubles;
//! - [`session`]: the data that a participant is launched with;
//! - [`cause`]: causes of errors, one word for each that has its own cure;
//! - [`node`]: the requests that a solver answers, and the types of its answers;
//! - [`finding`]: implausible values;
//! - [`cure`]: errors of the system, with what to do about them;
//! - [`checkpoint`]: a node's state as bytes;
//! - [`busy`]: spans of time in which a process was at work;
//! - [`link`]: the ways a frame travels: an in-process channel or shared memory;
//! - [`serve`](mod@serve): the loop that turns frames into calls of a [`Node`];
//! - [`participate`](mod@participate): the whole life of a participant in its own process.
//!
//! # Example
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
pub mod link;
pub mod node;
pub mod participate;
pub mod serve;
pub mod session;

pub use cause::{Cause, FaultCode};
pub use cure::WithCure;
pub use finding::{Finding, larger};
pub use frame::{Frame, FrameError, Header, Kind, PROTOCOL_VERSION};
pub use link::{Link, LinkError};
pub use node::{
    AccuracyLimit, BoundaryAnswer, BoundaryInertia, Capabilities, Description, HeldLoad, Node,
    NodeError, Outcome, Phase, PreparedSample, Reaction, Role, Surface, Term, Tolerance, Window,
};
pub use participate::{ParticipateError, participate, participate_over};
pub use serve::{ServeError, serve};
pub use session::{Session, Setting, Transport};
