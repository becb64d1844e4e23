//! Step, damping and end of the run.

use schemars::JsonSchema;
use serde::Deserialize;

/// Time step, damping and end of the run.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FemTimeConfig {
    /// Time step (s), or `"auto"`: `safety` times the stability limit.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step_s: StepChoice,
    /// Damping parameter b of the scheme, 0.5 (none) to 1.
    #[schemars(range(min = 0.5, max = 1.0))]
    pub damping: f64,
    /// Share of the stability limit that `"auto"` takes, in (0, 1]; 0.9 when absent, the usual margin for
    /// effects that a linear bound cannot see.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1.0))]
    pub safety: Option<f64>,
    /// Damping force per mass and velocity (1/s), >= 0; none when absent.
    #[schemars(range(min = 0.0))]
    pub mass_damping_per_s: Option<f64>,
    /// Rayleigh damping in proportion to the stiffness (s), >= 0, C = mass_damping_per_s M + stiffness_damping_s K: a mode omega gets the damping
    /// ratio (mass_damping_per_s/omega + stiffness_damping_s omega)/2. It shortens the stable step; none when absent.
    #[schemars(range(min = 0.0))]
    pub stiffness_damping_s: Option<f64>,
    /// Mass damping on body and wheel until the wheel starts to move sideways (1/s), so that it has stopped bouncing by
    /// then; none when absent. A static analysis does not use it.
    #[schemars(range(min = 0.0))]
    pub start_mass_damping_per_s: Option<f64>,
    /// True accepts a step above the stability limit, to show how the run diverges.
    #[serde(default)]
    pub unsafe_step: bool,
    /// End of the body's history (s), without a wheel, whose history ends the run. When absent, `run.end_s` or another participant ends the run.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end_s: Option<f64>,
}

kit::number_or_word! {
    /// The step as written: given (s), or a share of the stability limit.
    StepChoice, "auto", "a step in seconds or \"auto\""
}
