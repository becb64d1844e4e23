//! StepBounds on the step, that is on the windows of a coupled run.

use kit::ConfigError;
use protocol::Cause;

use crate::config::DemConfig;
use crate::error::DemError;

/// Part of t_i below which coupled trials were clean.
const CLEAN: f64 = 0.05;
/// Part of the smallest radius that the wheel may travel in a step.
const WHEEL_TRAVEL: f64 = 0.01;
/// Part of the smallest radius that a driven cluster may travel in a step: at a third, the friction of plane shear was that of half the
/// step within 0.3 %.
const CLUSTER_TRAVEL: f64 = 0.5;

/// Steps that a period of the wheel's motion must have; a sine is drawn within 1.3 % of its amplitude by 20 chords.
const STEPS_PER_PERIOD: f64 = 20.0;

/// The bounds of a scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepBounds {
    /// t_i = d sqrt(rho / P) (s): in this time the mean stress P moves an unbalanced grain of the scaled density rho
    /// by about its diameter d. No scheme that takes unbalanced grains for resting ones survives steps above it.
    pub inertial_time: f64,
    /// Highest sideways speed of the wheel (m/s).
    top_speed: f64,
    /// Speed of the fastest driven cluster (m/s).
    driven_speed: f64,
    /// Frequency of that motion (1/s), 0 without one.
    frequency: f64,
    /// Smallest radius (m).
    smallest: f64,
    unsafe_step: bool,
}

impl StepBounds {
    /// Name of the bound that no step may pass.
    pub const NAME: &str = "inertial time t_i = d sqrt(rho/P)";

    /// The bounds of a valid configuration.
    pub fn new(config: &DemConfig) -> StepBounds {
        let (mean, smallest) = config.sample.radii();
        let density = config.density_kg_per_m3 * config.mass_scale;
        let wheel = config.wheel.as_ref();
        StepBounds {
            inertial_time: 2.0 * mean * (density / config.time.pressure_pa).sqrt(),
            top_speed: wheel.map_or(0.0, |wheel| wheel.program().top_speed()),
            driven_speed: config.sample.driven_speed(),
            frequency: wheel
                .filter(|wheel| wheel.cycles > 0.0)
                .map_or(0.0, |wheel| wheel.frequency_hz),
            smallest,
            // A prescribed motion has no inertia.
            unsafe_step: config.time.unsafe_step || config.drive.is_some(),
        }
    }

    /// The longest step that is accepted (s).
    pub fn limit(&self) -> Option<f64> {
        (!self.unsafe_step).then_some(self.inertial_time)
    }

    /// Refuses a step (s) above t_i or too long for the motion of the wheel, and tells which other bounds it breaks.
    pub fn assess(&self, step: f64) -> Result<Vec<String>, DemError> {
        if self.limit().is_some_and(|limit| step > limit) {
            return Err(DemError::Step {
                step_s: step,
                limit_s: self.inertial_time,
                bound: StepBounds::NAME,
                help: "shorten it, raise mass_scale, or set time.unsafe_step = true",
            });
        }
        if !self.unsafe_step && self.frequency * step * STEPS_PER_PERIOD > 1.0 {
            let problem = format!(
                "a period of {:e} s holds fewer than {STEPS_PER_PERIOD} steps of {step:e} s",
                1.0 / self.frequency
            );
            return Err(ConfigError::new("wheel.frequency_hz", problem)
                .because(Cause::StepTooLong)
                .help("check the unit (1/s), lower it, or shorten the step")
                .into());
        }
        let mut warnings = Vec::new();
        let clean = CLEAN * self.inertial_time;
        if step > clean {
            warnings.push(format!(
                "the step of {step:e} s is {:.3} of the inertial time t_i = {:e} s; below {CLEAN} ({clean:e} s) the contact forces are clean: shorten the step or raise mass_scale",
                step / self.inertial_time,
                self.inertial_time
            ));
        }
        let longest = WHEEL_TRAVEL * self.smallest / self.top_speed;
        if step > longest {
            warnings.push(format!(
                "in a step of {step:e} s the wheel moves {:.3} of the smallest radius; keep it below {WHEEL_TRAVEL} with a step of at most {longest:e} s",
                step * self.top_speed / self.smallest
            ));
        }
        let longest = CLUSTER_TRAVEL * self.smallest / self.driven_speed;
        if step > longest {
            warnings.push(format!(
                "in a step of {step:e} s the fastest driven cluster moves {:.3} of the smallest radius; keep it below {CLUSTER_TRAVEL} with a step of at most {longest:e} s",
                step * self.driven_speed / self.smallest
            ));
        }
        Ok(warnings)
    }
}
