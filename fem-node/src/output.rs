//! What a run reports and writes.
//!
//! - [`ledger`]: the energies that are reported;
//! - `reduced_ledger`: the energies of a reduced body;
//! - [`profile`]: the pressure between wheel and body;
//! - [`probe`]: signals, stresses and pressures;
//! - `plausible`: checks of plausibility;
//! - `bending`: energy of the elements in bending;
//! - `vtu`: fields as files for ParaView;
//! - `snapshot`: fields and contact profiles as files.

mod bending;
pub mod ledger;
pub(crate) mod plausible;
pub mod probe;
pub mod profile;
pub(crate) mod reduced_ledger;
pub(crate) mod snapshot;
pub(crate) mod vtu;
