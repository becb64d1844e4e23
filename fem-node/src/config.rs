//! The keys of `[participant.config]`, read and checked once.

mod boundary;
mod choice;
mod consistency;
mod keys;
mod material;
mod mesh;
mod number;
mod plausible;
mod statics;
mod time;
mod wheel;

pub(crate) use boundary::SetLoad;
pub use boundary::{BoundaryConfig, Component, SetConfig};
pub use choice::{Analysis, Base, ElementKind, Kinematics, Plane, Sides, Start};
pub use keys::Config;
pub use material::{MaterialConfig, MaterialKind};
pub use mesh::{GmshConfig, MeshConfig, MeshSource};
pub(crate) use number::positive;
pub use plausible::PlausibleConfig;
pub use statics::{INCREMENTS, StaticsConfig};
pub use time::{StepChoice, TimeConfig};
pub use wheel::{ContactConfig, WheelConfig};
