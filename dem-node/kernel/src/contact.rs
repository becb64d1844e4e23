//! Contacts: the pairs that may touch, and their memory from step to step.
//!
//! In reading order:
//! - [`cells`], [`detect`]: disks near a disk, and the list of pairs that may touch;
//! - [`loss`]: energy that a contact loses in a step;
//! - [`bond`], [`initial_bonds`]: bonds between grains, and the bonds at the start;
//! - [`graph`]: agglomerates and first bodies by the graph of bonds;
//! - [`boundary`]: the compliant boundary of the glued disks;
//! - [`hand_over`], [`shared`]: a disk that passes from one segment of a surface to the next, and springs of a disk that lies on several.

pub mod bond;
pub mod boundary;
pub mod cells;
pub mod detect;
pub mod graph;
pub mod hand_over;
pub mod initial_bonds;
pub mod loss;
pub mod shared;
