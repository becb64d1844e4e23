//! The rigid wheel on the upper edge and the contact with it.

use schemars::JsonSchema;
use serde::Deserialize;

kit::wheel_keys! {
    /// A rigid wheel that is pressed on the upper edge and moved sideways.
    FemWheelConfig {}
}

/// Contact of wheel and body: unilateral, with Coulomb friction, neither regularised.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactConfig {
    /// Coefficient of friction, at least 0.
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// True lets friction act while the load is applied, before t_s; true when absent. With false, a static analysis takes at most 20 load
    /// increments, and the hydrostatic pressure of the rail of Renouf, Saulot and Berthier (2006) is 784 MPa instead of 671.
    #[serde(default = "yes")]
    pub friction_while_loading: bool,
}

fn yes() -> bool {
    true
}
