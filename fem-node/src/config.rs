//! The keys of `[participant.config]`, read and checked once.

mod boundary;
mod choice;
mod consistency;
mod initial;
mod keys;
mod material;
mod mesh;
mod number;
mod plausible;
mod probe;
mod statics;
mod time;
mod wheel;

pub use boundary::{BoundaryConfig, Component, SetConfig};
pub(crate) use boundary::{SetLoad, SetMotion};
pub use choice::{Analysis, Base, ElementKind, Kinematics, Plane, Sides, Start};
pub(crate) use initial::BODY;
pub use initial::{InitialConfig, InitialSetConfig};
pub use keys::Config;
pub use material::{MaterialConfig, MaterialKind};
pub use mesh::{GmshConfig, MeshConfig, MeshSource};
pub(crate) use number::positive;
pub use plausible::PlausibleConfig;
pub use probe::ProbeConfig;
pub use statics::{INCREMENTS, StaticsConfig};
pub use time::{StepChoice, TimeConfig};
pub use wheel::{ContactConfig, WheelConfig};
