//! Links between hosts, over [zenoh](https://zenoh.io): the same frames, checksums, deadlines and bits as over shared memory.
//!
//! The coordinator is a [`Host`], which listens at one endpoint; a participant calls [`connect`] with the session that its launcher passed
//! to it. Each pair of them has a [`NetworkLink`].
//!
//! # What zenoh does, and what it does not
//!
//! zenoh makes connections (QUIC, TCP) and makes them again, keeps strangers without certificate out, and carries
//! messages. Here its messages are numbered, signed, confirmed and repeated, since zenoh gives nothing again that was lost with a connection,
//! and anybody who may connect may publish: see [`link`]. Scouting, gossip and listening at participants are off: nothing is open but the
//! endpoint of the coordinator.
//!
//! # Credentials
//!
//! | endpoint | who gets in | data |
//! |---|---|---|
//! | `quic/` | who has a certificate of the run | encrypted |
//! | `tcp/`, loopback only | anybody on this host, to whom nobody listens: messages have signatures | in clear |
//!
//! Certificates and keys are made by the coordinator for each run. A participant gets its own with its session, through its launcher, and
//! no file holds them that others may read.
//!
//! # Limits
//!
//! TLS over TCP is refused: zenoh 1.10 shares a connection of rustls between two threads (its issue 2557), and processes crash.
//!
//! The two clocks are compared once, at the start: clocks that drift by 50 ppm are 0.2 s apart after an hour, and so are the times
//! at which participants say that they worked. Results do not depend on it.
//!
//! # Modules
//!
//! - [`message`]: signed pieces of frames, pings and pongs;
//! - [`link`]: one end of a connection;
//! - [`endpoint`]: the address that the coordinator listens at;
//! - [`credentials`]: the certificates of both ends;
//! - `complaints`: what zenoh says of connections that failed;
//! - [`host`]: the side of the coordinator, and [`connect`].

mod complaints;
pub mod credentials;
pub mod endpoint;
pub mod host;
pub mod link;
pub mod message;

pub use host::{Access, Host, connect};
pub use link::NetworkLink;
