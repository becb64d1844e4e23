//! The protocol between a coupler and its solvers, and nothing else.
//!
//! A *participant* is a process (or, for tests and small scenes, a thread) that holds one solver, a [`Node`].
//! The coordinator speaks to each participant over a [`Link`]: each request [`Frame`] has one answer, and answers come in the
//! order of the requests. At most one request is sent ahead, while the answer to the one before is still to come: a
//! participant then need not wait between the two.
//!
//! # Symbols
//!
//! Requests and answers carry plain doubles in SI, two components a point: (x0, y0, x1, y1, ...). n points are exchanged, the
//! window has the length H and holds m steps of the continuum.
//!
//! | symbol | meaning | unit | shape | where |
//! |---|---|---|---|---|
//! | lambda | force on the points of a continuum, constant in the window | N | 2 n | [`Node::advance`] |
//! | du | their displacement from the window's start to its end | m | 2 n | its answer |
//! | C | compliance over the window: du of a unit force | m/N | 2 n x 2 n, column after column | [`Node::columns`] |
//! | D | impedance: force at the end of a velocity that grows in a straight line to one | kg/s | 2 n x 2 n | [`Node::impedance`] |
//! | W_g, a_g | compliance of glued points, N C N^T / H^2; their velocity without contact forces | 1/kg, m/s | 2 n x 2 n, 2 n | [`Node::set_boundary`], [`Node::solve`] |
//! | F_g, v_g | force on the glued points, and their velocity v_g = a_g + H W_g F_g | N, m/s | 2 n each | [`BoundaryAnswer`] |
//!
//! # A conversation
//!
//! ```text
//! Hello -> Welcome                    versions, run, units; the node's Description
//! Couple, Select -> Surface, Ready    points of a named set; those that are exchanged
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
//! 2. [`serve()`] checks the greeting, builds the [`Node`], and turns each [`Frame`] into a call of it.
//! 3. [`link`] carries frames, in memory or over shared memory; both bring the same bits.
//!
//! # Checks
//!
//! - Each frame has a checksum (XXH3) over header and payload and its turn in the conversation; damage, loss and repetition end the run.
//! - Each wait has a deadline, and its end names the peer, its request and the window.
//! - Energies are told as [`Term`]s, each with its [`Role`], so that the coupler adds up work, stored and dissipated energy of
//!   solvers that it does not know.
//! - A [`Finding`] is a value that is not plausible: it says value, bound and what to do.
//!
//! # Limits
//!
//! Links of this crate join processes of one host; those between hosts are in the crate `network` beside it. Points of a line in the plane. A node answers one request at a time. Bytes on the wire are
//! described in `protocol/WIRE.md`, the log in `protocol/README.md`.
//!
//! # Modules
//!
//! In reading order:
//! - [`frame`]: the fixed header and its payload of doubles;
//! - [`session`]: what a participant is launched with;
//! - [`cause`]: causes of errors, a word for each that has a cure of its own;
//! - [`node`]: the requests that a solver answers, and the types of its answers;
//! - [`finding`]: values that are not plausible;
//! - [`cure`]: errors of the system, with what to do about them;
//! - [`checkpoint`]: a node's state as bytes;
//! - [`busy`]: stretches of time in which a process was at work;
//! - [`link`]: the ways a frame travels: an in-process channel or shared memory;
//! - [`serve`](mod@serve): the loop that turns frames into calls of a [`Node`];
//! - [`participate`](mod@participate): the whole life of a participant in a process of its own.
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
