//! Measurements and output of a run.
//!
//! In reading order:
//! - [`loads`], [`tiles`]: forces of the contacts on each grain, and the part of the plane that belongs to it;
//! - [`stress`], [`structure`], [`profile`]: stress in cells, arrangement of the contacts, means over slices and intervals;
//! - [`flow`]: the flows of third body;
//! - [`accommodation`], [`cycles`]: the parts of the wheel's motion in slip, base and layer, and its full cycles;
//! - [`rolled`]: the way of a rolling wheel;
//! - [`wheel_contacts`]: the contacts that carry the wheel;
//! - `trend`, [`force_means`], [`report`]: signals and results;
//! - [`plausible`]: checks of plausibility;
//! - [`snapshot`]: the fields.

pub mod accommodation;
pub mod cycles;
pub mod flow;
pub mod force_means;
pub mod loads;
pub mod plausible;
pub mod profile;
pub mod report;
pub mod rolled;
pub mod rolled_layer;
pub mod snapshot;
pub mod stress;
pub mod structure;
pub mod tiles;
pub(crate) mod trend;
pub mod wheel_contacts;
