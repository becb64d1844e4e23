//! Reports: signals of each report, results of the run.

use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;
use crate::geometry::range;
use crate::state::{State, WheelState};
use crate::step::StepSummary;
use crate::structure;
use crate::wheel::WheelProgram;

/// The signals of a step under their names. `wheel_fn_n` and `wheel_ft_n` are the force of the grains on the wheel (upwards, and
/// towards +x); `glued_f*_n` their force on the compliant boundary; overlaps are over the mean radius.
pub fn signals(bodies: &Bodies, state: &State, step: &StepSummary) -> [(&'static str, f64); 16] {
    let radius = bodies.mean_radius();
    let momentum = state.momentum(bodies);
    [
        ("wheel_x_m", state.wheel.position[0]),
        ("wheel_y_m", state.wheel.position[1]),
        ("wheel_fn_n", step.on_wheel[1]),
        ("wheel_ft_n", step.on_wheel[0]),
        ("glued_fx_n", step.on_boundary[0]),
        ("glued_fy_n", step.on_boundary[1]),
        ("momentum_x_kg_m_per_s", momentum[0]),
        ("momentum_y_kg_m_per_s", momentum[1]),
        ("momentum_defect_n", step.momentum_defect),
        ("contacts", step.closed as f64),
        ("iterations", step.convergence.iterations as f64),
        ("true_residual", step.convergence.residual),
        ("overlap_mean_rel", step.overlap[0] / radius),
        ("overlap_max_rel", step.overlap[1] / radius),
        ("speed_max_m_per_s", top_speed(state)),
        ("lost_grains", lost_grains(bodies, state) as f64),
    ]
}

fn top_speed(state: &State) -> f64 {
    let squares = state.velocities.iter().map(|v| v[0] * v[0] + v[1] * v[1]);
    squares.fold(0.0, f64::max).sqrt()
}

/// Free grains that left the glued rows: beside the base unless it repeats, or more than a diameter of the widest disk
/// below it or above the lid.
pub fn lost_grains(bodies: &Bodies, state: &State) -> usize {
    let (base, lid) = bodies.reference.split_at(bodies.base);
    let (Some(first), Some(last)) = (base.first(), base.last()) else {
        return 0;
    };
    let widest = bodies.radii.iter().copied().fold(0.0, f64::max);
    let heights = |row: &[[f64; 2]]| range(row.iter().map(|c| c[1]));
    let lowest = heights(base)[0] - 2.0 * widest;
    let highest = if lid.is_empty() {
        f64::INFINITY
    } else {
        heights(lid)[1] + 2.0 * widest
    };
    let beside = |x: f64| bodies.period.is_none() && !(first[0]..=last[0]).contains(&x);
    let inside = |c: &&[f64; 2]| !beside(c[0]) && (lowest..=highest).contains(&c[1]);
    bodies.free - state.centres[..bodies.free].iter().filter(inside).count()
}

/// Mean overlap of rigid contacts over the mean radius above which the geometry is no longer that of rigid grains.
const OVERLAP_BUDGET: f64 = 1e-3;

/// Tolerated distance of the wheel's force from its load in the second half of the hold, over the load.
const SETTLED: f64 = 0.1;
/// Half-width of a layer over that of 98 % of the wheel's force, below which the ends give way: against the rail alone, two
/// loads that rub with partial slip lost 6 % of their friction loop at 1.38 and 17 % at 1.21, and 1 to 4 % at 1.51.
const ENDS: f64 = 1.4;

/// A mean that is filled value by value.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Mean {
    sum: f64,
    count: u64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

/// Times and work of a committed step.
#[derive(Clone, Copy, Debug)]
pub struct StepSpan {
    /// Start of the step (s).
    pub start: f64,
    /// End of the step (s).
    pub end: f64,
    /// Work of the sideways drive in the step (J).
    pub drive_work: f64,
}

/// Gathers results over the committed steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RunStatistics {
    first_height: f64,
    height_at_motion_start: Option<f64>,
    /// Force on the wheel and its height over the second half of the hold: it still rings on a layer on a rail, by 0.9 um of
    /// 53 at 4 kN, so that a moment says less than the mean.
    held_force: Mean,
    held_height: Mean,
    /// Least and largest force on the wheel in the second half of the hold (N).
    held_range: Option<[f64; 2]>,
    /// Vertical velocity of the wheel at the end of the hold (m/s).
    held_velocity: f64,
    friction: Mean,
    height_range: Option<[f64; 2]>,
    loop_work: f64,
    residual_max: f64,
    quad_max: f64,
    defect_max: f64,
    /// Largest overlap, and largest mean overlap, of any step (m).
    overlap_max: f64,
    overlap_mean_max: f64,
    last: StepSummary,
}

impl RunStatistics {
    /// A journal that begins with the wheel at this height (m).
    pub fn new(wheel_height: f64) -> RunStatistics {
        RunStatistics {
            first_height: wheel_height,
            ..RunStatistics::default()
        }
    }

    /// Takes note of a committed step.
    pub fn record(
        &mut self,
        program: Option<&WheelProgram>,
        state: &State,
        step: &StepSummary,
        moment: &StepSpan,
    ) {
        self.residual_max = self.residual_max.max(step.convergence.residual);
        self.quad_max = self.quad_max.max(step.convergence.quad);
        self.defect_max = self.defect_max.max(step.momentum_defect);
        self.overlap_mean_max = self.overlap_mean_max.max(step.overlap[0]);
        self.overlap_max = self.overlap_max.max(step.overlap[1]);
        self.last = *step;
        if let Some(program) = program {
            self.record_wheel(program, state.wheel, step.on_wheel, moment);
        }
    }

    fn record_wheel(
        &mut self,
        program: &WheelProgram,
        wheel: WheelState,
        force: [f64; 2],
        moment: &StepSpan,
    ) {
        let height = wheel.position[1];
        let middle = 0.5 * (moment.start + moment.end);
        let motion = program.motion_start();
        if middle <= motion {
            self.height_at_motion_start = Some(height);
            if middle > 0.5 * (program.0.ramp_s + motion) {
                self.held_force.add(force[1]);
                self.held_height.add(height);
                self.held_range = Some(wider(self.held_range, force[1]));
                self.held_velocity = wheel.velocity[1];
            }
            return;
        }
        self.height_range = Some(wider(self.height_range, height));
        if force[1] > 0.0 {
            self.friction.add(force[0].abs() / force[1]);
        }
        if let Some((start, end)) = program.last_full_cycle() {
            let shared = moment.end.min(end) - moment.start.max(start);
            self.loop_work += moment.drive_work * shared.max(0.0) / (moment.end - moment.start);
        }
    }

    /// Warnings that belong beside the results.
    pub fn warnings(
        &self,
        program: Option<&WheelProgram>,
        bodies: &Bodies,
        state: &State,
        half_width: Option<f64>,
    ) -> Vec<String> {
        let overlaps = self.overlaps(bodies);
        let unsettled = program.and_then(|program| self.unsettled(program));
        let ends = half_width.and_then(|half_width| close_to_the_ends(bodies, state, half_width));
        [overlaps, unsettled, ends].into_iter().flatten().collect()
    }

    /// A warning if the wheel was not at rest when its results were taken.
    fn unsettled(&self, program: &WheelProgram) -> Option<String> {
        let [low, high] = self.held_range?;
        let (load, slack) = (program.0.load_n, SETTLED * program.0.load_n);
        (low < load - slack || high > load + slack).then(|| {
            format!(
                "the wheel is not at rest at the end of its hold: it moves at {:.2e} m/s, and over the second half of the hold the grains carried {low:.0} to {high:.0} N of its {load} N: make wheel.hold_s or wheel.ramp_s longer, or bring wheel.vy_m_per_s closer to 0",
                self.held_velocity
            )
        })
    }

    /// A warning if rigid contacts overlapped beyond their budget.
    fn overlaps(&self, bodies: &Bodies) -> Option<String> {
        let mean = self.overlap_mean_max / bodies.mean_radius();
        if bodies.law.springs.is_some() || mean <= OVERLAP_BUDGET {
            return None;
        }
        Some(format!(
            "the mean overlap of rigid contacts reached {mean:.2e} of the mean radius, the budget is {OVERLAP_BUDGET:e}: lower time.step_s or solver.tolerance, or write law.penetration = \"split\""
        ))
    }

    /// The results so far.
    pub fn results(
        &self,
        program: Option<&WheelProgram>,
        bodies: &Bodies,
        state: &State,
    ) -> Vec<(&'static str, f64)> {
        let radius = bodies.mean_radius();
        let mut results = structure::results(bodies, state).to_vec();
        results.extend([
            ("disks", bodies.free as f64),
            ("glued_disks", bodies.glued() as f64),
            ("contacts", self.last.closed as f64),
            ("true_residual_max", self.residual_max),
            ("quad_max", self.quad_max),
            ("momentum_defect_max_n", self.defect_max),
            ("overlap_mean_rel", self.last.overlap[0] / radius),
            ("overlap_max_rel", self.overlap_max / radius),
            ("ejected_grains", lost_grains(bodies, state) as f64),
        ]);
        let Some(program) = program else {
            return results;
        };
        let height = self.held_height.value().or(self.height_at_motion_start);
        let range = self.height_range.map(|[low, high]| (high - low) / radius);
        let loop_area = program.last_full_cycle().map(|_| self.loop_work);
        results.extend(given([
            ("load_n", Some(program.0.load_n)),
            ("approach_m", height.map(|y| self.first_height - y)),
            ("wheel_force_n", self.held_force.value()),
            ("friction_coefficient", self.friction.value()),
            ("wheel_y_range_over_r", range),
            ("loop_area_j", loop_area),
        ]));
        results
    }
}

/// The numbers that there are, under their names.
pub fn given<const N: usize>(
    named: [(&'static str, Option<f64>); N],
) -> impl Iterator<Item = (&'static str, f64)> {
    let named = named.into_iter();
    named.filter_map(|(name, value)| Some((name, value?)))
}

fn wider(range: Option<[f64; 2]>, value: f64) -> [f64; 2] {
    let [low, high] = range.unwrap_or([value; 2]);
    [low.min(value), high.max(value)]
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

/// A warning if the wheel presses so near to the ends of a layer that they give way.
fn close_to_the_ends(bodies: &Bodies, state: &State, half_width: f64) -> Option<String> {
    let pressed = pressed_half_width(bodies, state)?;
    (half_width < ENDS * pressed).then(|| {
        format!(
            "98 % of the wheel's force lies within {:.2} mm of the middle and the layer ends at {:.2} mm, where it gives way sideways: results of slip are off by several per cent; make sample.half_width_m at least {:.2e}",
            1e3 * pressed,
            1e3 * half_width,
            ENDS * pressed
        )
    })
}
