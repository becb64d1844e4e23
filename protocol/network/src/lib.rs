//! Links between hosts, over [zenoh](https://zenoh.io): the same frames, checksums, deadlines and bits as over shared memory.
//!
//! The coordinator is a [`Host`], which listens at one endpoint; a participant calls [`connect`] with the session from its launcher.
//! A [`NetworkLink`] joins each participant with the coordinator.
//!
//! # What zenoh does, and what it does not
//!
//! zenoh makes and restores connections (QUIC, TCP), refuses programs without a certificate, and carries messages. This crate
//! numbers, signs, confirms and repeats messages, because zenoh does not repeat messages lost with a connection, and any program that
//! may connect may publish: see [`link`]. Scouting, gossip and listening at participants are off: only the coordinator's endpoint
//! is open.
//!
//! # Credentials
//!
//! | endpoint | who gets in | data |
//! |---|---|---|
//! | `quic/` | holders of a certificate of the run | encrypted |
//! | `tcp/`, loopback only | any program on this host; messages without a valid signature are dropped | in clear |
//!
//! The coordinator makes certificates and keys for each run. A participant gets its own with its session, through its launcher; no
//! file that other users may read holds them.
//!
//! # Limits
//!
//! TLS over TCP is refused: zenoh 1.10 shares a connection of rustls between two threads (zenoh issue 2557), and processes crash.
//!
//! The two clocks are compared once, at the start. Clocks that drift by 50 ppm are 0.2 s apart after an hour, and so are the working
//! times that participants report. Results do not depend on the clocks.
//!
//! # Modules
//!
//! - [`message`]: signed pieces of frames, pings and pongs;
//! - [`link`]: one end of a connection;
//! - [`endpoint`]: the address where the coordinator listens;
//! - [`credentials`]: the certificates of both ends;
//! - `complaints`: zenoh's warnings about failed connections;
//! - [`host`]: the coordinator's side, and [`connect`].

mod complaints;
pub mod credentials;
pub mod endpoint;
pub mod host;
pub mod link;
pub mod message;

pub use host::{Access, Host, connect};
pub use link::NetworkLink;
