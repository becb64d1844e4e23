//! What the node tells: signals of each report, results of the run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;
use crate::state::State;
use crate::step::Summary;
use crate::structure::Structure;
use crate::wheel::Program;

/// Names of the signals, in the order of [`signals`].
pub const SIGNALS: [&str; 16] = [
    "wheel_x_m",
    "wheel_y_m",
    "wheel_fn_n",
    "wheel_ft_n",
    "glued_fx_n",
    "glued_fy_n",
    "momentum_x_kg_m_per_s",
    "momentum_y_kg_m_per_s",
    "momentum_defect_n",
    "contacts",
    "iterations",
    "true_residual",
    "overlap_mean_rel",
    "overlap_max_rel",
    "speed_max_m_per_s",
    "lost_grains",
];

/// Name of the signal that cohesive laws add: bonds above 0.01 of adhesion.
pub const BONDS: &str = "bonds";

/// The signals of a step. `wheel_fn_n` and `wheel_ft_n` are the force of the grains on the wheel (upwards, and
/// towards +x); `glued_f*_n` their force on the wall; overlaps are over the mean radius.
pub fn signals(bodies: &Bodies, state: &State, step: &Summary) -> [f64; 16] {
    let radius = bodies.mean_radius();
    let momentum = state.momentum(bodies);
    [
        state.wheel.position[0],
        state.wheel.position[1],
        step.on_wheel[1],
        step.on_wheel[0],
        step.on_wall[0],
        step.on_wall[1],
        momentum[0],
        momentum[1],
        step.momentum_defect,
        step.closed as f64,
        step.verdict.iterations as f64,
        step.verdict.residual,
        step.overlap[0] / radius,
        step.overlap[1] / radius,
        top_speed(state),
        lost_grains(bodies, state) as f64,
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
    let heights = |row: &[[f64; 2]], start, pick: fn(f64, f64) -> f64| {
        row.iter().map(|c| c[1]).fold(start, pick)
    };
    let lowest = heights(base, f64::INFINITY, f64::min) - 2.0 * widest;
    let highest = match lid.is_empty() {
        true => f64::INFINITY,
        false => heights(lid, f64::NEG_INFINITY, f64::max) + 2.0 * widest,
    };
    let beside = |x: f64| bodies.period.is_none() && !(first[0]..=last[0]).contains(&x);
    let inside = |c: &&[f64; 2]| !beside(c[0]) && (lowest..=highest).contains(&c[1]);
    bodies.free - state.centres[..bodies.free].iter().filter(inside).count()
}

/// Mean overlap of rigid contacts over the mean radius above which the geometry is no longer that of rigid grains.
const OVERLAP_BUDGET: f64 = 1e-3;

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

/// What a committed step is told with.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Start of the step (s).
    pub start: f64,
    /// End of the step (s).
    pub end: f64,
    /// Work of the sideways drive in the step (J).
    pub drive_work: f64,
}

/// Gathers results over the committed steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Journal {
    first_height: f64,
    height_at_motion_start: Option<f64>,
    held_force: Mean,
    friction: Mean,
    height_range: Option<[f64; 2]>,
    loop_work: f64,
    residual_max: f64,
    quad_max: f64,
    defect_max: f64,
    /// Largest overlap, and largest mean overlap, of any step (m).
    overlap_max: f64,
    overlap_mean_max: f64,
    last: Summary,
}

impl Journal {
    /// A journal that begins with the wheel at this height (m).
    pub fn new(wheel_height: f64) -> Journal {
        Journal {
            first_height: wheel_height,
            ..Journal::default()
        }
    }

    /// Takes note of a committed step.
    pub fn record(
        &mut self,
        program: Option<&Program>,
        state: &State,
        step: &Summary,
        moment: &Moment,
    ) {
        self.residual_max = self.residual_max.max(step.verdict.residual);
        self.quad_max = self.quad_max.max(step.verdict.quad);
        self.defect_max = self.defect_max.max(step.momentum_defect);
        self.overlap_mean_max = self.overlap_mean_max.max(step.overlap[0]);
        self.overlap_max = self.overlap_max.max(step.overlap[1]);
        self.last = *step;
        if let Some(program) = program {
            self.record_wheel(program, state.wheel.position[1], step.on_wheel, moment);
        }
    }

    fn record_wheel(&mut self, program: &Program, height: f64, force: [f64; 2], moment: &Moment) {
        let middle = 0.5 * (moment.start + moment.end);
        let motion = program.motion_start();
        if middle <= motion {
            self.height_at_motion_start = Some(height);
            if middle > 0.5 * (program.ramp_end() + motion) {
                self.held_force.add(force[1]);
            }
            return;
        }
        let [low, high] = self.height_range.unwrap_or([height, height]);
        self.height_range = Some([low.min(height), high.max(height)]);
        if force[1] > 0.0 {
            self.friction.add(force[0].abs() / force[1]);
        }
        if let Some((start, end)) = program.last_full_cycle() {
            let shared = moment.end.min(end) - moment.start.max(start);
            self.loop_work += moment.drive_work * shared.max(0.0) / (moment.end - moment.start);
        }
    }

    /// Whether rigid contacts kept their budget of overlap.
    pub fn warnings(&self, bodies: &Bodies) -> Vec<String> {
        let mean = self.overlap_mean_max / bodies.mean_radius();
        if bodies.law.springs.is_some() || mean <= OVERLAP_BUDGET {
            return Vec::new();
        }
        vec![format!(
            "the mean overlap of rigid contacts reached {mean:.2e} of the mean radius, the budget is {OVERLAP_BUDGET:e}: lower time.step_s or solver.tolerance, or write law.penetration = \"split\""
        )]
    }

    /// The results so far.
    pub fn results(
        &self,
        program: Option<&Program>,
        bodies: &Bodies,
        state: &State,
    ) -> BTreeMap<String, f64> {
        let radius = bodies.mean_radius();
        let mut results = BTreeMap::new();
        let mut put = |name: &str, value: f64| {
            results.insert(name.to_string(), value);
        };
        for (name, value) in Structure::new(bodies, state).results() {
            put(&name, value);
        }
        put("disks", bodies.free as f64);
        put("glued_disks", bodies.glued() as f64);
        put("contacts", self.last.closed as f64);
        put("true_residual_max", self.residual_max);
        put("quad_max", self.quad_max);
        put("momentum_defect_max_n", self.defect_max);
        put("overlap_mean_rel", self.last.overlap[0] / radius);
        put("overlap_max_rel", self.overlap_max / radius);
        put("ejected_grains", lost_grains(bodies, state) as f64);
        let Some(program) = program else {
            return results;
        };
        let mut put_some = |name: &str, value: Option<f64>| {
            value.into_iter().for_each(|value| put(name, value));
        };
        put_some("load_n", Some(program.load));
        put_some(
            "approach_m",
            self.height_at_motion_start.map(|y| self.first_height - y),
        );
        put_some("wheel_force_n", self.held_force.value());
        put_some("friction_coefficient", self.friction.value());
        put_some(
            "wheel_y_range_over_r",
            self.height_range.map(|[low, high]| (high - low) / radius),
        );
        put_some(
            "loop_area_j",
            program.last_full_cycle().map(|_| self.loop_work),
        );
        results
    }
}
