//! The bounds of the coupler's plausibility checks.

/// The table `run.plausible`.
pub type Plausible = kit::Plausible<RunTable>;

/// Its name where checks are declared.
#[derive(Clone, Debug, PartialEq)]
pub struct RunTable;

impl kit::bounds::Table for RunTable {
    const NAME: &'static str = "run";
}
