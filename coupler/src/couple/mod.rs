//! Joining a continuum to a solver on a wall, window by window.
//!
//! - [`conversation`]: requests and answers, recorded and hashed;
//! - [`handshake`]: who takes part; [`greeting`]: the same without a run;
//! - [`mapping`]: glued points as weighted means of surface nodes, and `nodal_mass`: what they weigh on these;
//! - [`clock`]: windows in integer steps;
//! - [`group`]: interfaces that are solved together, and [`join`]: what they exchange, and on which bounds;
//! - [`scheme`]: one window of a group by each coupling scheme;
//! - [`predict`]: whether it is stable, and [`volume`]: how much will be said, told before the run;
//! - [`ledger`]: work, momentum and gap of the interface, energies of both sides;
//! - [`course`]: the loop over all windows, and `outputs`, what becomes of them;
//! - [`run`]: a run from the launch to the farewells.

pub mod clock;
pub mod conversation;
pub mod course;
pub mod greeting;
pub mod group;
pub mod handshake;
pub mod join;
pub mod ledger;
pub mod mapping;
pub mod minutes;
mod nodal_mass;
mod outputs;
pub mod predict;
pub mod run;
pub mod scheme;
pub mod volume;
