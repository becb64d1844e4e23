//! The keys of `[participant.config]`, read and checked once.
//!
//! - [`choice`]: keys with a few words to choose from;
//! - [`mesh`], [`material`], [`time`], [`boundary`], [`motion`], [`initial`], [`wheel`], [`statics`], [`reduced`], [`probe`], [`heat`]: the
//!   tables;
//! - [`keys`]: all of them, [`keys::FemConfig`];
//! - `consistency`: keys that must go together.

pub mod boundary;
pub mod choice;
mod consistency;
pub mod heat;
pub mod initial;
pub mod keys;
pub mod material;
pub mod mesh;
pub mod motion;
pub mod probe;
pub mod reduced;
pub mod statics;
pub mod time;
pub mod wheel;
