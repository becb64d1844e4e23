//! Contacts: which pairs may touch, and what they remember from step to step.
//!
//! In reading order:
//! - [`cells`], [`detect`]: disks near a disk, and the list of pairs that may touch;
//! - [`loss`]: energy that a contact loses in a step;
//! - [`bond`], [`initial_bonds`]: bonds between grains, and those of the start;
//! - [`boundary`]: the compliant boundary of the glued disks;
//! - [`shared`]: springs of a disk that lies on several segments of a surface.

pub mod bond;
pub mod boundary;
pub mod cells;
pub mod detect;
pub mod initial_bonds;
pub mod loss;
pub mod shared;
