//! Bounds on the step, which is the window in a coupled run.

use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::geometry::range;
use dem_kernel::step::state::GrainState;
use kit::ConfigError;
use protocol::Cause;

use crate::config::DemConfig;
use crate::error::DemError;

/// Part of t_i below which coupled trials were clean.
const CLEAN: f64 = 0.05;
/// Part of the smallest radius that the wheel may travel in a step.
const WHEEL_TRAVEL: f64 = 0.01;
/// Part of the smallest radius that a driven cluster may travel in a step: at a third, the friction of plane shear differed by 0.3 % from the
/// friction with half the step.
const CLUSTER_TRAVEL: f64 = 0.5;

/// Steps that a period of the wheel's motion must have; 20 chords follow a sine within 1.3 % of its amplitude.
const STEPS_PER_PERIOD: f64 = 20.0;

/// The bounds of a scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepBounds {
    /// t_i = d sqrt(rho / P) (s): in this time the mean stress P moves an unbalanced grain of the scaled density rho
    /// by about its diameter d. A scheme that takes unbalanced grains for resting ones fails in longer steps.
    pub inertial_time: f64,
    /// Highest sideways speed of the wheel (m/s).
    top_speed: f64,
    /// Speed of the fastest driven cluster (m/s).
    driven_speed: f64,
    /// Frequency of the wheel's motion (1/s), 0 without one.
    frequency: f64,
    /// Smallest radius (m).
    smallest: f64,
    unsafe_step: bool,
}

impl StepBounds {
    /// Name of the bound that no step may exceed.
    pub const NAME: &str = "inertial time t_i = d sqrt(rho/P)";

    /// The bounds of a valid configuration.
    pub fn new(config: &DemConfig) -> StepBounds {
        let (mean, smallest) = config.sample.radii();
        let density = config.density_kg_per_m3 * config.mass_scale;
        let wheel = config.wheel.as_ref();
        let moved = wheel.filter(|wheel| wheel.cycles > 0.0);
        StepBounds {
            inertial_time: 2.0 * mean * (density / config.time.pressure_pa).sqrt(),
            top_speed: config.program().map_or(0.0, |program| program.top_speed()),
            driven_speed: config.sample.driven_speed(),
            frequency: moved.map_or(0.0, |wheel| wheel.frequency_hz),
            smallest,
            // A prescribed motion has no inertia.
            unsafe_step: config.time.unsafe_step || config.drive.is_some(),
        }
    }

    /// The longest step that is accepted (s).
    pub fn limit(&self) -> Option<f64> {
        (!self.unsafe_step).then_some(self.inertial_time)
    }

    /// Refuses a step (s) above t_i or too long for the motion of the wheel. Returns warnings of other bounds that it exceeds.
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
        for (moves, travel, speed) in [
            ("the wheel moves", WHEEL_TRAVEL, self.top_speed),
            (
                "the fastest driven cluster moves",
                CLUSTER_TRAVEL,
                self.driven_speed,
            ),
        ] {
            let longest = travel * self.smallest / speed;
            if step > longest {
                warnings.push(format!(
                    "in a step of {step:e} s {moves} {:.3} of the smallest radius; keep it below {travel} with a step of at most {longest:e} s",
                    step * speed / self.smallest
                ));
            }
        }
        Ok(warnings)
    }
}

/// Largest distance from the origin, in radii of the smallest grain, that leaves the digits for contacts: gaps are then exact to 2e-10 of the radius.
const FAR: f64 = 1e6;

/// Advice on grains so far from the origin that rounding errors of their positions reach the size of overlaps.
pub fn advice_on_positions(bodies: &Bodies, state: &GrainState) -> Option<String> {
    let free = 0..bodies.free;
    let radius = range(free.clone().map(|i| bodies.radii[i]))[0];
    let places = free.flat_map(|i| state.centres[i]);
    let far = places.map(f64::abs).fold(0.0, f64::max);
    (far > FAR * radius).then(|| {
        let rounding = f64::EPSILON * far / radius;
        format!("sample: a grain lies {far:e} m from the origin, {:.1e} times the smallest radius; its position is rounded to {rounding:.1e} of this radius and contacts lose as many digits: move the sample towards the origin", far / radius)
    })
}

/// Advice on a step (s) in which grains may move by more than `bound` of the smallest radius past each other or towards a wall. Velocities are the
/// grains' at the start; a loose grain has its velocity when it reaches the wall, or without walls at the end (s). Shear between driven clusters has
/// a bound of its own.
pub fn advice_on_travel(
    bodies: &Bodies,
    state: &GrainState,
    [step, end, bound]: [f64; 3],
) -> Option<String> {
    let (positions, [gx, gy]) = (state.positions(bodies), bodies.gravity);
    let at = |a: usize, b: usize| positions.proximity(a, b);
    let velocity = |i: usize| state.velocity_of(bodies, i);
    let mut touching = vec![false; bodies.count()];
    for slot in &state.list.slots {
        let [a, b] = [slot.a as usize, slot.b as usize];
        let near = at(a, b).gap < bodies.alert;
        (touching[a], touching[b]) = (touching[a] || near, touching[b] || near);
    }
    let present = positions.present;
    let disks = (0..present).chain(bodies.free..bodies.first_face());
    let ends = [0, 1].map(|k| range(disks.clone().map(|i| velocity(i)[k])));
    let [x, y] = ends.map(|[low, high]| (high - low).max(0.0));
    let mut fastest = x.hypot(y);
    for (i, touches) in touching.iter().enumerate().take(present) {
        let loose = f64::from(u8::from(!touches));
        for wall in bodies.first_wall()..bodies.count() {
            let ([vx, vy, _], [wx, wy, _], at) = (velocity(i), velocity(wall), at(i, wall));
            let speed = ((vx - wx) * at.normal[0] + (vy - wy) * at.normal[1]).abs();
            let pull = -loose * (gx * at.normal[0] + gy * at.normal[1]).min(0.0);
            // The way to a segment of a wall that lies elsewhere is infinite.
            let way = if at.gap.is_finite() { at.gap } else { 0.0 };
            let there = (speed * speed + 2.0 * pull * way.max(0.0)).sqrt();
            fastest = fastest.max(there.min(speed + pull * end));
        }
        if bodies.walls.is_empty() {
            fastest = fastest.max(loose * gx.hypot(gy) * end);
        }
    }
    let way = step * fastest / range(bodies.radii[..bodies.free].iter().copied())[0];
    (way > bound && bodies.clusters.driven().next().is_none()).then(|| {
        format!(
            "grains may come to move at {fastest:.2e} m/s past each other or to a wall, {way:.3} of the smallest radius in a step of {step:e} s: grains or walls that they only pass may stop them, and they may fall too far; keep it below {bound} with a step of at most {:.2e} s",
            step * bound / way
        )
    })
}
