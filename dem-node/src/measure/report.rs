//! Reports: signals of each report, results of the run.

use dem_kernel::bodies::Bodies;
use dem_kernel::bodies::faces::{Face, depth_behind};
use dem_kernel::bodies::geometry::range;
use dem_kernel::contact::bond;
use dem_kernel::contact::graph::first_bodies;
use dem_kernel::step::StepSummary;
use dem_kernel::step::state::GrainState;
use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::measure::structure;
use crate::measure::trend::Trend;
use crate::measure::wheel_contacts;
use kit::bounds::wider;
use kit::cycle_drift::{CycleDrift, Mean};
use kit::traction::TractionRatio;
use kit::wheel::WheelProgram;

kit::results! {
    /// # Load and approach
    /// - `wheel_contacts`: Contacts that press on the wheel, mean over the last half of the hold.
    /// - `wheel_contacts_90`: The smallest number of contacts that carry 90 % of the normal force on the wheel, mean over the last half of the hold.
    ///   With few contacts, friction and pressure describe single grains, not the layer.
    /// - `wheel_contacts_90_motion`: The smallest number of contacts that carry 90 % of the normal force on the wheel, mean over its motion.
    /// # Friction and sliding
    /// - `wheel_y_range_over_r`: Range of the height of the wheel during its motion, over the mean
    ///   radius of the grains.
    /// # Grains
    /// - `disks`: Free disks in the sample, without glued disks.
    /// - `glued_disks`: Disks that are glued to the coupled surface.
    /// - `ejected_grains`: Grains that left the sample: lost grains, and grains on a surface beside it.
    /// - `lost_grains`: Grains beyond the ends of every surface.
    /// - `inside_grains`: Grains whose centre is behind the face of a body that carries them by
    ///   more than 0.3 of their radius.
    /// - `contacts`: Closed contacts at the end.
    /// - `overlap_mean_rel`: Mean overlap of grains over their mean radius, at the end.
    /// - `overlap_max_rel`: The largest overlap of the run over the mean radius.
    /// # Quality of the solution
    /// - `true_residual_max`: Largest residual of the contact laws after the solve of a step.
    /// - `quad_max`: Largest residual of the contact laws after the solve of a step, by the criterion Quad of LMGC90.
    /// - `rounding_limited_rel`: Share of the loaded steps whose contact solve stopped at rounding errors.
    /// - `momentum_defect_max_n`: Largest difference between the change of momentum in a step and the forces on the grains.
    /// # Signals
    /// - `glued_fx_n`: Force along x of the grains on the boundary that they are glued to or lie
    ///   on.
    /// - `glued_fy_n`: Force along y of the grains on the same boundary: negative where they press down. A layer with a lid has one sum over both rows;
    ///   the columns of its interfaces have the force of each.
    /// - `momentum_x_kg_m_per_s`: Momentum of the grains and the wheel along x, with scaled masses.
    /// - `momentum_y_kg_m_per_s`: Momentum of the grains and the wheel along y, with scaled masses.
    /// - `momentum_defect_n`: Difference between the change of momentum and the forces on the grains in the step.
    /// - `iterations`: Iterations of the contact solver in the last solve of the window.
    /// - `true_residual`: Residual of the contact laws after the last solve of the window.
    /// - `speed_max_m_per_s`: Speed of the centre of the fastest disk, alone or in a cluster.
}

/// The signals of a step under their names. `wheel_fn_n` and `wheel_ft_n` are the force of the grains on the wheel (upwards, and
/// towards +x); `glued_f*_n` their force on the compliant boundary; overlaps are over the mean radius.
pub fn signals(
    bodies: &Bodies,
    state: &GrainState,
    step: &StepSummary,
) -> [(&'static str, f64); 16] {
    let radius = bodies.mean_radius();
    let momentum = state.momentum(bodies);
    let wheel_x = state.wheel.position[0];
    let strip = bodies.period.filter(|_| bodies.rolls);
    let wheel_x = strip.map_or(wheel_x, |strip| strip.inside(wheel_x));
    [
        ("wheel_x_m", wheel_x),
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
        ("speed_max_m_per_s", top_speed(bodies, state)),
        ("lost_grains", lost_grains(bodies, state) as f64),
    ]
}

fn top_speed(bodies: &Bodies, state: &GrainState) -> f64 {
    let velocities = (0..bodies.free).map(|disk| state.velocity_of(bodies, disk));
    let squares = velocities.map(|v| v[0] * v[0] + v[1] * v[1]);
    squares.fold(0.0, larger).sqrt()
}

/// True for a lost position: more than the radius of the widest disk beside the base, its surfaces and the ends of the sample, unless it repeats, or
/// more than that disk's diameter below the base or above the lid. Beside and below are meant along a base that slopes, and across it; which side of
/// an upright base is below is unknown.
fn is_lost(bodies: &Bodies) -> impl Fn(&[f64; 2]) -> bool {
    let (base, lid) = bodies.reference.split_at(bodies.base);
    let (below, above) = bodies.surface.points.split_at(bodies.surface.base);
    let (widest, [tx, ty]) = (widest(bodies), along_base(bodies));
    let turned = move |[x, y]: &[f64; 2]| [tx * x + ty * y, tx * y - ty * x];
    let along = |row: &[[f64; 2]], surface: &[[f64; 2]], axis: usize| {
        range(row.iter().chain(surface).map(|c| turned(c)[axis]))
    };
    let lowest = along(base, below, 1)[0] - 2.0 * widest;
    // Infinite without a lid.
    let highest = match along(lid, above, 1)[1] + 2.0 * widest {
        f64::NEG_INFINITY => f64::INFINITY,
        highest => highest,
    };
    let [first, last] = along(base, below, 0);
    let [left, right] = level_ends(bodies).unwrap_or([first, last]);
    let reach = first.min(left) - widest..=last.max(right) + widest;
    let (has_base, has_ends) = (first <= last, bodies.period.is_none());
    move |centre| {
        let [s, n] = turned(centre);
        let across = tx > 0.0 && !(lowest..=highest).contains(&n);
        has_base && (has_ends && !reach.contains(&s) || across)
    }
}

/// Width over height up to which a line is upright.
const ROUNDING: f64 = 1e-9;
/// Slope below which a line counts as level.
const LEVEL: f64 = 0.1;

/// Unit vector from one end of the base to the other, along x where it is level, like a crown.
fn along_base(bodies: &Bodies) -> [f64; 2] {
    let (base, below) = (bodies.base, bodies.surface.base);
    let line = || {
        bodies.reference[..base]
            .iter()
            .chain(&bodies.surface.points[..below])
    };
    let first = line().min_by(|a, b| a[0].total_cmp(&b[0]));
    let last = line().max_by(|a, b| a[0].total_cmp(&b[0]));
    let (Some([x_0, y_0]), Some([x_1, y_1])) = (first, last) else {
        return [1.0, 0.0];
    };
    let [low, high] = range(line().map(|point| point[1]));
    let [dx, dy] = [x_1 - x_0, y_1 - y_0];
    if ROUNDING * (high - low) > dx {
        return [0.0, 1.0];
    }
    if dy.abs() <= LEVEL * dx {
        return [1.0, 0.0];
    }
    [dx / dx.hypot(dy), dy / dx.hypot(dy)]
}

/// The ends of the sample (m), which are meant along x.
fn level_ends(bodies: &Bodies) -> Option<[f64; 2]> {
    bodies.ends.filter(|_| along_base(bodies) == [1.0, 0.0])
}

fn widest(bodies: &Bodies) -> f64 {
    bodies.radii.iter().copied().fold(0.0, f64::max)
}

/// Free grains beyond base, surfaces and lid.
pub fn lost_grains(bodies: &Bodies, state: &GrainState) -> usize {
    let is_lost = is_lost(bodies);
    let lost = |grain: &usize| is_lost(&state.centres[*grain]);
    without_hanging(bodies, state, state.grains(bodies).filter(lost).collect())
}

/// Number of these grains that no chain of bonds connects with a glued disk: the others have not left, wherever they hang.
fn without_hanging(bodies: &Bodies, state: &GrainState, gone: Vec<usize>) -> usize {
    if gone.is_empty() {
        return 0;
    }
    let bonds = Vec::from_iter(bond::holding(&state.bonds));
    let hangs = first_bodies(bodies.free, &bonds);
    gone.iter().filter(|grain| !hangs[**grain]).count()
}

/// Free grains that left the sample: lost grains, and grains on a surface beside it.
pub fn ejected_grains(bodies: &Bodies, state: &GrainState) -> usize {
    let (is_lost, widest) = (is_lost(bodies), widest(bodies));
    let ends = level_ends(bodies);
    let is_beside =
        |x: f64| ends.is_some_and(|[left, right]| !(left - widest..=right + widest).contains(&x));
    let gone = |centre: &[f64; 2]| is_beside(centre[0]) || is_lost(centre);
    let ejected = |grain: &usize| gone(&state.centres[*grain]);
    let gone = state.grains(bodies).filter(ejected).collect();
    without_hanging(bodies, state, gone)
}

/// Part of its radius by which the centre of a grain may lie behind a surface.
const BEYOND: f64 = 0.3;

/// Free grains whose centres are behind the present faces of the bodies below or above by more than 0.3 of their radius.
pub fn inside_grains(bodies: &Bodies, state: &GrainState) -> usize {
    let glued = &state.centres[bodies.free..bodies.first_face()];
    let now: Vec<&[f64; 2]> = glued.iter().chain(&state.surface).collect();
    let lines = [0, 1].map(|side| {
        let line = bodies.lines[side].iter().map(|(number, [x, y])| {
            let ([x_now, y_now], [x_0, y_0]) = (now[*number], bodies.boundary_point(*number));
            [x + x_now - x_0, y + y_now - y_0]
        });
        line.collect::<Vec<[f64; 2]>>()
    });
    let height = |line: &[[f64; 2]], x: f64| {
        let x = bodies.period.map_or(x, |period| period.inside(x));
        let next = line.partition_point(|point| point[0] <= x);
        let [a, b] = [line.get(next.checked_sub(1)?)?, line.get(next)?];
        Some(a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]))
    };
    let inside = state.grains(bodies).filter(|grain| {
        let ([x, y], radius) = (state.centres[*grain], bodies.radii[*grain]);
        let below = height(&lines[0], x).is_some_and(|line| y < line - BEYOND * radius);
        below || height(&lines[1], x).is_some_and(|line| y > line + BEYOND * radius)
    });
    inside.count()
}

/// Grains that overlap walls of points from behind.
fn grains_behind(bodies: &Bodies, state: &GrainState) -> usize {
    if bodies.walls.is_empty() {
        return 0;
    }
    let of_grain = state.list.slots.chunk_by(|one, next| one.a == next.a);
    let behind = of_grain.filter(|slots| {
        let walls = slots.iter().map(|slot| slot.b as usize);
        let walls = walls.filter_map(|body| bodies.wall_of(body));
        let grain = slots[0].a as usize;
        let depth = depth_behind(walls, state.centres[grain], state.wall_motion_time);
        depth.is_some_and(|depth| depth < bodies.radii[grain])
    });
    behind.count()
}

/// Depth of a smooth wheel below the points of the bare surface (m), which holds grains only.
fn wheel_depth(bodies: &Bodies, state: &GrainState) -> f64 {
    if bodies.wheel().is_none() || !bodies.face.is_empty() {
        return 0.0;
    }
    let positions = state.positions(bodies);
    let below = state.surface.iter().take(bodies.surface.base);
    let depths = below.map(|point| -positions.under_wheel(*point, 0.0).gap);
    depths.fold(0.0, larger)
}

/// Largest depth of the centre of a glued disk behind a plane wall in front of which it began, over its radius: walls hold grains only.
fn glued_depth(bodies: &Bodies, state: &GrainState) -> f64 {
    let planes = bodies.walls.iter();
    let planes = planes.filter(|wall| matches!(wall.face, Face::HalfPlane { .. }));
    let depths = planes.flat_map(|wall| {
        let glued = (bodies.free..bodies.first_face()).zip(&bodies.reference);
        let in_front = glued.filter(|(_, start)| wall.distance(**start) > 0.0);
        in_front.map(|(disk, _)| {
            let now = wall.frame(state.centres[disk], state.wall_motion_time);
            -wall.distance(now) / bodies.radii[disk]
        })
    });
    depths.fold(0.0, larger)
}

/// Part of its strength above which a bond is close to breaking.
const HALF_STRENGTH: f64 = 0.5;

/// Ratio of two sums over the last half to three quarters of all steps: the beginning of a run says little about its course.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct RecentRatio {
    steps: u64,
    /// Sums since the number of steps was last a power of two, and between this power and the one before.
    recent: [f64; 2],
    before: [f64; 2],
}

impl RecentRatio {
    fn add(&mut self, over: f64, under: f64) {
        if self.steps.is_power_of_two() {
            self.before = std::mem::take(&mut self.recent);
        }
        self.steps += 1;
        self.recent[0] += over;
        self.recent[1] += under;
    }

    /// The ratio; `None` where the second sum is 0.
    pub fn value(&self) -> Option<f64> {
        let [over, under] = [0, 1].map(|k| self.recent[k] + self.before[k]);
        (under > 0.0).then(|| over / under)
    }
}

/// The wheel over the second half of the hold: on a layer on a rail it still rings, by 0.9 um of 53 at 4 kN, so that the mean says more than a
/// moment.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Hold {
    /// Force on the wheel (N).
    pub force: Mean,
    height: Mean,
    trend: Trend,
    /// Force of the grains on the boundary (N), downwards.
    pub boundary: Mean,
    /// Least and largest force on the wheel (N).
    range: Option<[f64; 2]>,
    /// Its vertical velocity at the end (m/s).
    pub velocity: f64,
    /// Contacts that press on the wheel, and the fewest that carry 0.9 of its force.
    contacts: [Mean; 2],
}

/// The wheel over its motion.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Motion {
    height: Option<[f64; 2]>,
    ratio: TractionRatio,
    /// Contacts that press on the wheel, and the fewest that carry 0.9 of its force.
    contacts: [Mean; 2],
}

/// The largest values of all steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Largest {
    /// Residual of a contact solve that was accepted.
    pub residual: f64,
    quad: f64,
    defect: f64,
    /// Overlap (m).
    pub overlap: f64,
    /// Mean overlap of a step (m).
    pub overlap_mean: f64,
    /// See [`StepSummary::travel`].
    pub travel: f64,
    /// Kinetic energy at the end of a step (J).
    pub kinetic: f64,
    /// Grains at once that overlap a wall of points from behind.
    pub behind: usize,
    /// Force of a bond over its strength.
    pub bond_load: f64,
    /// Largest step in which a bond bore more than half its strength (s).
    pub bond_step: f64,
    /// Step (s).
    pub step: f64,
    /// Depth of the wheel in the bare surface (m).
    pub wheel_depth: f64,
    /// Depth of a glued disk behind a wall, over its radius.
    pub glued_depth: f64,
}

/// Gathers results over the committed steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RunStatistics {
    first_height: f64,
    height_at_motion_start: Option<f64>,
    /// Force on the wheel in the last step before the motion, 0 without such a step (N).
    before_motion: Option<f64>,
    /// Before the motion.
    pub hold: Hold,
    motion: Motion,
    /// Height of the wheel from cycle to cycle.
    pub drift: CycleDrift,
    /// The largest values.
    pub largest: Largest,
    /// Sums of [`StepSummary::shared_damping`].
    pub shared_damping: [f64; 4],
    /// Impulse that moved the added mass of the grains over the impulse that went through them, after the ramp of a wheel.
    pub added_inertia: RecentRatio,
    /// Number of steps with a load, and of loaded steps whose residual was measured against rounding.
    loaded_steps: u64,
    rounding_steps: u64,
    /// Number of all steps, and of steps that were accepted without having converged.
    pub steps: u64,
    /// See `steps`.
    pub accepted_steps: u64,
    last: StepSummary,
}

impl RunStatistics {
    /// Statistics of a run that begins with the wheel at this height (m).
    pub fn new(wheel_height: f64) -> RunStatistics {
        RunStatistics {
            first_height: wheel_height,
            ..RunStatistics::default()
        }
    }

    /// Records a committed step, from `start` to `end` (s).
    pub fn record(
        &mut self,
        program: Option<&WheelProgram>,
        grains: (&Bodies, &GrainState),
        step: &StepSummary,
        [start, end]: [f64; 2],
    ) {
        let largest = &mut self.largest;
        for (value, of_step) in [
            (&mut largest.residual, step.convergence.residual),
            (&mut largest.quad, step.convergence.quad),
            (&mut largest.defect, step.momentum_defect),
            (&mut largest.overlap_mean, step.overlap[0]),
            (&mut largest.overlap, step.overlap[1]),
            (&mut largest.travel, step.travel),
            (&mut largest.kinetic, grains.1.kinetic(grains.0)),
            (&mut largest.step, end - start),
            (&mut largest.wheel_depth, wheel_depth(grains.0, grains.1)),
            (&mut largest.glued_depth, glued_depth(grains.0, grains.1)),
        ] {
            *value = larger(*value, of_step);
        }
        for (sum, of_step) in self.shared_damping.iter_mut().zip(step.shared_damping) {
            *sum += of_step;
        }
        if grains.0.has_joints() {
            let behind = grains_behind(grains.0, grains.1);
            largest.behind = largest.behind.max(behind);
        }
        let h = end - start;
        let bond_load = step.bond_load_squared.sqrt().min(1.0);
        largest.bond_load = larger(largest.bond_load, bond_load);
        if bond_load > HALF_STRENGTH {
            largest.bond_step = larger(largest.bond_step, h);
        }
        let loading = program.is_some_and(|program| start < program.ramp_s);
        if !loading {
            self.added_inertia
                .add(step.added_inertia * h, step.transmitted * h);
        }
        if step.transmitted > 0.0 {
            self.loaded_steps += 1;
            self.rounding_steps += u64::from(step.convergence.rounding);
        }
        self.steps += 1;
        self.accepted_steps += u64::from(!step.convergence.converged);
        self.last = *step;
        if let Some(program) = program {
            self.record_wheel(program, grains, step, [start, end]);
        }
    }

    fn record_wheel(
        &mut self,
        program: &WheelProgram,
        (bodies, state): (&Bodies, &GrainState),
        step: &StepSummary,
        [start, end]: [f64; 2],
    ) {
        let force = step.on_wheel;
        let height = state.wheel.position[1];
        let middle = 0.5 * (start + end);
        let motion = program.motion_start();
        if middle <= motion {
            self.height_at_motion_start = Some(height);
            if middle > 0.5 * (program.ramp_s + motion) {
                let hold = &mut self.hold;
                hold.force.add(force[1]);
                hold.height.add(height);
                hold.trend.add(middle, height);
                hold.boundary.add(-step.on_boundary[1]);
                hold.range = Some(wider(hold.range, force[1]));
                add_contacts(&mut hold.contacts, bodies, state);
            }
            if 2.0 * end - middle >= motion {
                self.before_motion = Some(force[1]);
            }
            self.hold.velocity = state.wheel.velocity[1];
            return;
        }
        self.before_motion.get_or_insert(0.0);
        self.motion.height = Some(wider(self.motion.height, height));
        self.drift.record(program, end, height);
        add_contacts(&mut self.motion.contacts, bodies, state);
        self.motion.ratio.record(force, program.load_n);
    }

    /// Least and largest force on the wheel in the second half of the hold, or the last force before the motion without a hold (N).
    pub fn held_range(&self) -> Option<[f64; 2]> {
        self.hold
            .range
            .or(self.before_motion.map(|force| [force; 2]))
    }

    /// Height that the wheel lost in the second half of the hold, by its trend, and before (m).
    pub fn held_drift(&self) -> Option<[f64; 2]> {
        let lost = -self.hold.trend.change()?;
        let height = self.hold.height.value()?;
        Some([lost, self.first_height - height])
    }

    /// Smallest number of contacts that carry 0.9 of the wheel's force: means over the second half of the hold, and over the motion.
    pub fn carrying_contacts(&self) -> [Option<f64>; 2] {
        [&self.hold.contacts, &self.motion.contacts].map(|means| means[1].value())
    }

    /// The results so far.
    pub fn results(
        &self,
        program: Option<&WheelProgram>,
        bodies: &Bodies,
        state: &GrainState,
    ) -> Vec<(&'static str, f64)> {
        let radius = bodies.mean_radius();
        let mut results = structure::results(bodies, state);
        results.extend([
            ("disks", state.grains(bodies).count() as f64),
            ("glued_disks", bodies.glued() as f64),
            ("contacts", self.last.closed as f64),
            ("true_residual_max", self.largest.residual),
            ("quad_max", self.largest.quad),
            ("momentum_defect_max_n", self.largest.defect),
            ("overlap_mean_rel", self.last.overlap[0] / radius),
            ("overlap_max_rel", self.largest.overlap / radius),
            ("ejected_grains", ejected_grains(bodies, state) as f64),
            ("lost_grains", lost_grains(bodies, state) as f64),
            ("inside_grains", inside_grains(bodies, state) as f64),
        ]);
        // Share of the loaded steps in which rounding decided that the contact solve had converged.
        let share = self.rounding_steps as f64 / self.loaded_steps as f64;
        let rounding = (self.rounding_steps > 0).then_some(share);
        results.extend(given([("rounding_limited_rel", rounding)]));
        let Some(program) = program else {
            return results;
        };
        let height = self.hold.height.value().or(self.height_at_motion_start);
        let range = self.motion.height.map(|[low, high]| (high - low) / radius);
        let [held_90, moved_90] = self.carrying_contacts();
        results.extend(given([
            ("load_n", Some(program.load_n)),
            ("approach_m", height.map(|y| self.first_height - y)),
            ("wheel_force_n", self.hold.force.value()),
            ("wheel_y_range_over_r", range),
            ("wheel_contacts", self.hold.contacts[0].value()),
            ("wheel_contacts_90", held_90),
            ("wheel_contacts_90_motion", moved_90),
        ]));
        results.extend(given(self.motion.ratio.results()));
        results
    }
}

/// The numbers that are not `None`, under their names.
pub fn given<const N: usize>(
    named: [(&'static str, Option<f64>); N],
) -> impl Iterator<Item = (&'static str, f64)> {
    let named = named.into_iter();
    named.filter_map(|(name, value)| Some((name, value?)))
}

/// A step in which nothing presses on the wheel does not count in the means.
fn add_contacts(means: &mut [Mean; 2], bodies: &Bodies, state: &GrainState) {
    let counts = wheel_contacts::count(bodies, state).into_iter().flatten();
    for (mean, count) in means.iter_mut().zip(counts) {
        mean.add(count as f64);
    }
}
