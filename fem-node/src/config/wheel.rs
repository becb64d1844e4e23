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
    /// True where friction acts while the load is applied, before t_s; true when absent. Without it the hydrostatic
    /// pressure of the paper's rail is 784 MPa instead of 671.
    #[serde(default = "yes")]
    pub friction_while_loading: bool,
}

fn yes() -> bool {
    true
}
