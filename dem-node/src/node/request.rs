//! Refusals of requests of a coordinator.

use kit::ConfigError;
use protocol::Window;

use super::dem::Dem;
use crate::error::DemError;
use kit::keys::refuse_if;

impl Dem {
    pub(super) fn check_window(
        &self,
        window: &Window,
        free_velocity: &[f64],
    ) -> Result<f64, DemError> {
        let (false, Some(step)) = (self.interface.disks.is_empty(), self.window) else {
            return request("a window needs a glued row coupled and the wall announced first");
        };
        let length = window.t1_s - window.t0_s;
        if (length - step).abs() > 1e-6 * step {
            return request(format!(
                "window {} is {length:e} s long, the wall was announced for {step:e} s: announce the wall again",
                window.index
            ));
        }
        if free_velocity.len() != 2 * self.interface.disks.len() {
            return request(format!(
                "window {} brings {} velocities for {} glued disks of two components",
                window.index,
                free_velocity.len(),
                self.interface.disks.len()
            ));
        }
        require_numbers("a velocity of a glued disk", window, free_velocity)?;
        Ok(step)
    }

    pub(super) fn refuse_when_coupled(&self) -> Result<(), ConfigError> {
        refuse_if(
            self.time.theta != 1.0,
            "time.theta",
            format!(
                "a coupled participant needs 1, got {}: the glued velocity is the window's mean and the end velocity only then",
                self.time.theta
            ),
            "remove the key or write theta = 1",
        )?;
        refuse_if(
            self.time.own_step.is_some(),
            "time.step_s",
            "a coupled participant steps by the windows of its interface and has no step of its own",
            "remove the key",
        )
    }
}

/// Refuses NaN and infinite values of a message, before they reach the state.
pub(super) fn require_numbers(what: &str, window: &Window, values: &[f64]) -> Result<(), DemError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => request(format!(
            "window {} brings {} as {what}, component {index}: the other side has diverged",
            window.index, values[index]
        )),
    }
}

pub(super) fn request<T>(message: impl Into<String>) -> Result<T, DemError> {
    Err(DemError::Request(message.into()))
}

/// Refuses a compliance that is no square matrix over this many disks, or that moves a disk against its force.
pub(super) fn refuse_misfit(glued: usize, compliance: &[f64]) -> Result<(), DemError> {
    let components = 2 * glued;
    if compliance.len() != components * components {
        return request(format!(
            "the wall's compliance holds {} numbers, {glued} glued disks need {components} x {components}",
            compliance.len()
        ));
    }
    if let Some(i) = compliance.iter().position(|w| !w.is_finite()) {
        return request(format!(
            "the wall's compliance holds {} at component {i}, NaN or infinite",
            compliance[i]
        ));
    }
    if let Some(i) = (0..components).find(|i| compliance[i * (components + 1)] < 0.0) {
        return request(format!(
            "the wall's compliance has {:e} on its diagonal at component {i}: a wall cannot move against its force",
            compliance[i * (components + 1)]
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_of_another_size_is_refused() {
        let error = refuse_misfit(2, &[0.0; 4]).expect_err("2 disks need 16 numbers");
        assert!(error.to_string().contains("4 x 4"), "{error}");
    }
}
