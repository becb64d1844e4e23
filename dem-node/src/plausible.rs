//! Plausibility of the grains' results: values of a run beyond the bounds of its scenario.

use protocol::{Finding, HeldLoad};

use crate::bodies::Bodies;
use crate::config::PlausibleConfig;
use crate::geometry::larger;
use crate::report::{RunStatistics, lost_grains};
use crate::state::State;
use crate::wheel::WheelProgram;

/// Settling of the grains that counts as rest whatever the approach is, over the mean radius.
const SETTLING: f64 = 0.01;

/// A run that is judged.
pub struct Judged<'a> {
    /// The bounds.
    pub bounds: PlausibleConfig,
    /// The bodies.
    pub bodies: &'a Bodies,
    /// The last state.
    pub state: &'a State,
    /// Energies stored since its start (J).
    pub stored: [f64; 4],
    /// Statistics over its steps.
    pub statistics: &'a RunStatistics,
    /// The wheel, where there is one.
    pub program: Option<WheelProgram>,
    /// Ends of a layer that does not repeat, in |x| (m).
    pub half_width: Option<f64>,
}

impl Judged<'_> {
    /// All checks that the scene has a value for.
    pub fn findings(&self) -> Vec<Finding> {
        let all = [
            self.overlap(),
            self.ejected(),
            self.wheel_at_rest(),
            self.layer_at_rest(),
            self.wheel_drift(),
            self.added_inertia(),
            self.detection(),
            self.contact_width(),
            self.contact_residual(),
        ];
        all.into_iter().flatten().collect()
    }

    /// The load that the boundary must carry in the second half of the hold: the wheel's, and the weight of the grains.
    pub fn held_load(&self) -> Option<HeldLoad> {
        let wanted = self.program?.0.load_n;
        let mean = self.statistics.held_force()?;
        let masses = self.bodies.masses.iter().sum::<f64>();
        let weight = -masses * self.bodies.gravity[1];
        Some(HeldLoad {
            wanted_n: wanted + weight,
            mean_n: mean + weight,
        })
    }

    fn overlap(&self) -> Option<Finding> {
        let [largest, largest_mean] = self.statistics.overlaps();
        let radius = self.bodies.mean_radius();
        if self.bodies.law.springs.is_some() {
            let value = largest / radius;
            return self.bounds.overlap_rel.judge("overlap", value, || {
                format!("two bodies overlapped by {value:.3} of the mean radius, where a contact law between disks means nothing: lower the load, or raise law.contact_stiffness_pa")
            });
        }
        let value = largest_mean / radius;
        let bounds = self.bounds.overlap_rigid_rel;
        bounds.judge("overlap_rigid", value, || {
            format!("the mean overlap of rigid contacts reached {value:.2e} of the mean radius: lower time.step_s or solver.tolerance, or write law.penetration = \"split\"")
        })
    }

    fn ejected(&self) -> Option<Finding> {
        let lost = lost_grains(self.bodies, self.state);
        let value = lost as f64 / self.bodies.free as f64;
        self.bounds.ejected_rel.judge("ejected", value, || {
            format!(
                "{lost} of {} grains have left the layer: it is not the one that the scenario describes; lower the load, the amplitude or the step, or make sample.half_width_m larger",
                self.bodies.free
            )
        })
    }

    /// The wheel must be at rest when its results are taken.
    fn wheel_at_rest(&self) -> Option<Finding> {
        let program = self.program.filter(|program| program.0.load_n > 0.0)?;
        let [low, high] = self.statistics.held_range()?;
        let load = program.0.load_n;
        let value = larger(high - load, load - low) / load;
        let bounds = self.bounds.wheel_force_rel;
        bounds.judge("wheel_at_rest", value, || {
            format!(
                "the wheel is not at rest before its motion: it moves at {:.2e} m/s, and over the second half of the hold (without one, at its end) the grains carried {low:.0} to {high:.0} N of its {load} N: make wheel.hold_s or wheel.ramp_s longer, or bring wheel.vy_m_per_s closer to 0",
                self.statistics.held_velocity()
            )
        })
    }

    /// A wheel that bears its load may still sink with all that carries it.
    fn wheel_drift(&self) -> Option<Finding> {
        self.program.filter(|program| program.0.load_n > 0.0)?;
        let [lost, approach] = self.statistics.held_drift()?;
        let value = lost.abs() / (approach.abs() + SETTLING * self.bodies.mean_radius());
        let bounds = self.bounds.wheel_drift_rel;
        bounds.judge("wheel_drift", value, || {
            format!(
                "over the second half of the hold the wheel sank by {lost:.2e} m, of {approach:.2e} m in all: what carries it is not at rest; make wheel.hold_s or wheel.ramp_s longer, or lower densities and masses"
            )
        })
    }

    /// Between wheel and boundary nothing must move then.
    fn layer_at_rest(&self) -> Option<Finding> {
        let load = self.held_load().filter(|load| load.wanted_n > 0.0)?;
        let borne = self.statistics.held_boundary_force()?;
        let value = (borne - load.mean_n).abs() / load.wanted_n;
        let bounds = self.bounds.boundary_force_rel;
        let judged = bounds.judge("layer_at_rest", value, || {
            format!(
                "over the second half of the hold the wheel pressed with {:.5e} N and {borne:.5e} N came out below: the grains were not at rest; lower mass_scale, or make wheel.hold_s or wheel.ramp_s longer",
                load.mean_n
            )
        });
        // Rigid walls and a wheel without glued disks bear what they bear.
        judged.filter(|_| self.bodies.walls.is_empty() && self.bodies.glued() > 0)
    }

    fn added_inertia(&self) -> Option<Finding> {
        let value = self.statistics.added_inertia()?;
        let bounds = self.bounds.added_inertia_rel;
        bounds.judge("added_inertia", value, || {
            format!("moving the mass that mass_scale adds to the grains took {value:.3} of the force that goes through them: lower mass_scale, or load more slowly")
        })
    }

    fn contact_residual(&self) -> Option<Finding> {
        let value = self.statistics.largest_residual();
        let bounds = self.bounds.contact_residual;
        bounds.judge("contact_residual", value, || {
            format!("the contact solve of a step was left with a residual of {value:.1e}, and friction is off by per cents: lower solver.tolerance")
        })
    }

    /// Springs must be found as they were left.
    fn detection(&self) -> Option<Finding> {
        let accounts = &self.state.accounts;
        let lost = [accounts.impact, accounts.friction, accounts.cohesion];
        let kept = self.stored.iter().chain(&lost);
        let kept: f64 = kept.map(|energy| energy.abs()).sum();
        let jumps = accounts.detection_size;
        // No springs, no jumps.
        let value = if jumps == 0.0 { 0.0 } else { jumps / kept };
        self.bounds.detection_rel.judge("detection", value, || {
            format!("detection found the springs between the grains otherwise than the steps had left them, by {value:.3e} of what the grains stored and lost: they pass each other too far in a step; lower time.step_s or, where there are windows, substeps")
        })
    }

    fn contact_width(&self) -> Option<Finding> {
        let half_width = self.half_width?;
        let pressed = pressed_half_width(self.bodies, self.state)?;
        let bounds = self.bounds.contact_width_rel;
        bounds.judge("contact_width", pressed / half_width, || {
            format!(
                "98 % of the wheel's force lies within {:.2} mm of the middle and the layer ends at {:.2} mm, where it gives way sideways: results of slip are off by several per cent; make sample.half_width_m at least {:.2e}",
                1e3 * pressed,
                1e3 * half_width,
                pressed / bounds.warn
            )
        })
    }
}

/// Half-width of 98 % of the force on the wheel (m), `None` where nothing touches it.
fn pressed_half_width(bodies: &Bodies, state: &State) -> Option<f64> {
    let on_wheel = state
        .list
        .slots
        .iter()
        .filter(|slot| Some(slot.b as usize) == bodies.wheel() && slot.force[0] > 0.0);
    let mut forces: Vec<(f64, f64)> = on_wheel
        .map(|slot| (state.centres[slot.a as usize][0].abs(), slot.force[0]))
        .collect();
    forces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = forces.iter().map(|(_, force)| force).sum();
    let mut sum = 0.0;
    let within = forces.iter().find(|(_, force)| {
        sum += force;
        sum >= 0.98 * total
    });
    within.map(|(x, _)| *x)
}
