//! Components that a body exchanges with a coupler.
//!
//! - [`prescribed_velocity`]: components whose velocity a coupler prescribes;
//! - [`compliance`](mod@compliance): condensed compliance and impedance of the exchanged components.

pub mod compliance;
pub mod prescribed_velocity;
