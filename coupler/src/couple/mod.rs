//! Joining a continuum to a solver on a wall, window by window.
//!
//! - [`conversation`]: requests and answers, recorded and hashed;
//! - [`handshake`]: who takes part, what is exchanged, and on which bounds;
//! - [`mapping`]: glued points as weighted means of surface nodes;
//! - [`clock`]: windows in integer steps;
//! - [`scheme`]: one window of each coupling scheme;
//! - [`ledger`]: work, momentum and gap of the interface, energies of both sides;
//! - [`run`]: the loop over all windows.

pub mod clock;
pub mod conversation;
pub mod handshake;
pub mod ledger;
pub mod mapping;
pub mod run;
pub mod scheme;
