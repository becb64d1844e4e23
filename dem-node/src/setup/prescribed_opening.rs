//! A pair of disks that is pulled apart, or pressed together, at a prescribed velocity.

use dem_kernel::bodies::Bodies;
use dem_kernel::step::state::GrainState;
use kit::ConfigError;

use crate::config::DriveConfig;

/// Steps of a run. The pair then opens by 3e-4 of delta_0 in a step: the first-order error of the implicit adhesion stays below 0.2 % of the stress
/// for every viscosity.
const STEPS: u64 = 100_000;
/// Openings delta_0 at the end of a run; with h' = 1 and no viscosity, 1 / 1 800 of w is then left.
const END: f64 = 30.0;

/// The program of the pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrescribedOpening {
    /// Opening velocity (m/s), negative when it closes.
    velocity: f64,
    critical: f64,
    area: f64,
    /// Distance of the centres at the start (m).
    distance: f64,
}

impl PrescribedOpening {
    /// The program of a scenario with `drive`: one grain, one glued disk, a cohesive law.
    pub fn new(
        config: &DriveConfig,
        bodies: &Bodies,
        state: &GrainState,
    ) -> Result<PrescribedOpening, ConfigError> {
        let law = bodies.law.cohesion.ok_or_else(|| {
            ConfigError::new("drive", "opens a bond, and the law has none")
                .help("choose law.kind = \"cohesion\"")
        })?;
        Ok(PrescribedOpening {
            velocity: config.velocity_m_per_s,
            critical: law.critical_opening(),
            area: law.area([bodies.radii[0], bodies.radii[1]]),
            distance: distance(state),
        })
    }

    /// The time in which the pair opens (or closes) by 30 delta_0, divided by 100 000 (s).
    pub fn step(&self) -> f64 {
        END * self.critical / (self.velocity.abs() * STEPS as f64)
    }

    /// End of the run (s).
    pub fn end(&self) -> f64 {
        self.step() * STEPS as f64
    }

    /// Velocity of the grain at the start, away from the glued disk (m/s).
    pub fn velocity(&self, state: &GrainState) -> [f64; 2] {
        let [grain, glued] = [state.centres[0], state.centres[1]];
        let (dx, dy) = (grain[0] - glued[0], grain[1] - glued[1]);
        [dx, dy].map(|d| self.velocity * d / self.distance)
    }

    /// Opening, adhesion, stress -r_n/l with r_n as a force (tension positive), and work of the drive over l.
    ///
    /// The drive works against the force at the end of each step; the trapezoidal rule takes the mean of both ends. They differ by half a step of the
    /// last stress, as the first stress is 0.
    pub fn signals(&self, state: &GrainState) -> [(&'static str, f64); 4] {
        let force = state.list.slots.first().map_or(0.0, |slot| slot.force[0]);
        let stress = -force / self.area;
        let adhesion = state.bonds.first().map_or(0.0, |bond| bond.adhesion);
        let work = state.ledger.drive / self.area - 0.5 * self.velocity * self.step() * stress;
        [
            ("opening_m", distance(state) - self.distance),
            ("adhesion", adhesion),
            ("stress_pa", stress),
            ("work_j_per_m2", work),
        ]
    }
}

fn distance(state: &GrainState) -> f64 {
    let [grain, glued] = [state.centres[0], state.centres[1]];
    (grain[0] - glued[0]).hypot(grain[1] - glued[1])
}
