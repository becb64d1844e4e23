//! Works of tractions and of prescribed motions over a window.
//!
//! The displacements of loaded components and the reactions of driven components are kept for each step: a repeat of the window replaces only those
//! within its reach.

use fem_kernel::integrate::fields::StepFields;
use fem_kernel::integrate::state::NodalState;

use super::extent::Extent;
use crate::model::Model;
use crate::model::boundary::Traction;
use crate::model::motion::PrescribedMotion;

/// Works since the start of the window, and the values from which they are computed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Works {
    /// Components under tractions, traction after traction.
    loaded: Vec<TrackedComponent>,
    /// Prescribed components, motion after motion.
    driven: Vec<TrackedComponent>,
    /// Displacements (m) of the loaded components, at the start and after each step.
    displacements: Vec<f64>,
    /// Reactions (N) of the driven components, at the start and after each step.
    reactions: Vec<f64>,
    /// Work of the tractions (J).
    pub(super) applied: f64,
    /// Work of the drives (J).
    pub(super) drive: f64,
}

/// A component, and the first step that steps it; `None` if no step does.
#[derive(Clone, Copy, Debug)]
struct TrackedComponent {
    index: usize,
    from: Option<u32>,
}

impl TrackedComponent {
    fn new((index, _): &(usize, f64)) -> TrackedComponent {
        TrackedComponent {
            index: *index,
            from: Some(0),
        }
    }

    fn is_stepped(&self, k: u32) -> bool {
        self.from.is_some_and(|from| from <= k)
    }
}

impl Works {
    pub(super) fn new(model: &Model) -> Works {
        let loaded = model.tractions.iter().flat_map(|traction| &traction.forces);
        let driven = model.motions.iter().flat_map(|motion| &motion.components);
        Works {
            loaded: loaded.map(TrackedComponent::new).collect(),
            driven: driven.map(TrackedComponent::new).collect(),
            ..Works::default()
        }
    }

    /// Begins a window; a repeat reaches only a part.
    pub(super) fn begin(&mut self, fields: &StepFields, extent: &Extent) {
        (self.applied, self.drive) = (0.0, 0.0);
        for tracked in self.loaded.iter_mut().chain(&mut self.driven) {
            tracked.from = match extent {
                Extent::Part(region) => region.reached_at(tracked.index),
                Extent::Whole | Extent::Recorded(_) => Some(0),
            };
        }
        if !extent.is_part() {
            self.displacements.clear();
            self.reactions.clear();
        }
        // Nodes that the first step reaches begin under the changed force.
        self.follow(fields, 0, 1);
    }

    /// Enters displacements and reactions after step `k`, for the components that step `reached` steps.
    fn follow(&mut self, fields: &StepFields, k: u32, reached: u32) {
        let u = |at: &TrackedComponent| fields.state.u[at.index];
        enter(&mut self.displacements, &self.loaded, k, reached, u);
        let reaction = |at: &TrackedComponent| reaction(fields, at.index);
        enter(&mut self.reactions, &self.driven, k, reached, reaction);
    }

    /// Sets the velocities that bring the prescribed components to their displacements at the end of the step that begins at `step`, the `k`th of the
    /// window.
    pub(super) fn move_to(&self, model: &Model, state: &mut NodalState, step: u64, k: u32) {
        let h = model.scheme.step;
        let ends = |motion: &PrescribedMotion| motion.history.displacement((step + 1) as f64 * h);
        self.set_rates(model, state, k, ends, |u, end| (end - u) / h);
    }

    /// Gives the prescribed components their velocities after the step.
    pub(super) fn settle(&self, model: &Model, state: &mut NodalState, step: u64, k: u32) {
        let t = (step + 1) as f64 * model.scheme.step;
        let velocities = |motion: &PrescribedMotion| motion.history.velocity(t);
        self.set_rates(model, state, k, velocities, |_, velocity| velocity);
    }

    /// Sets the velocities of the prescribed components that step `k` steps, from the prescribed value and the displacement of each, and sets their
    /// accelerations to 0.
    fn set_rates(
        &self,
        model: &Model,
        state: &mut NodalState,
        k: u32,
        prescribed: impl Fn(&PrescribedMotion) -> [f64; 2],
        velocity: impl Fn(f64, f64) -> f64,
    ) {
        let mut driven = self.driven.iter();
        for motion in &model.motions {
            let along = prescribed(motion);
            for (index, value) in &motion.components {
                if driven.next().is_some_and(|driven| driven.is_stepped(k)) {
                    let given = along[model.body.layout.direction(*index)] * value;
                    state.v[*index] = velocity(state.u[*index], given);
                    state.a[*index] = 0.0;
                }
            }
        }
    }

    /// Force of each drive on the body at the end of the window (N), motion after motion.
    pub(crate) fn last_reactions(&self, model: &Model) -> Vec<[f64; 2]> {
        let first = self.reactions.len().saturating_sub(self.driven.len());
        let mut last = self.reactions[first..].iter();
        let layout = model.body.layout;
        let sum = |motion: &PrescribedMotion| {
            let mut sum = [0.0; 2];
            for ((index, _), force) in motion.components.iter().zip(&mut last) {
                sum[layout.direction(*index)] += force;
            }
            sum
        };
        model.motions.iter().map(sum).collect()
    }

    /// Adds the works of the step that began at `step`, the `k`th of the window.
    pub(super) fn add(&mut self, model: &Model, fields: &StepFields, step: u64, k: u32) {
        self.follow(fields, k, k);
        let [before, after] = two_steps(&self.displacements, self.loaded.len(), k);
        self.applied += applied_work(model, step, before, after);
        let [before, after] = two_steps(&self.reactions, self.driven.len(), k);
        self.drive += drive_work(model, step, before, after);
    }
}

/// Values before and after step `k`, of `count` components.
fn two_steps(values: &[f64], count: usize, k: u32) -> [&[f64]; 2] {
    let end = (k as usize + 1) * count;
    let (before, after) = values[end - 2 * count..end].split_at(count);
    [before, after]
}

/// r = F(u) + d - f in a prescribed component (N).
pub(crate) fn reaction(StepFields { state, load, .. }: &StepFields, index: usize) -> f64 {
    let damping = state.damping_force.get(index).unwrap_or(&0.0);
    state.force[index] + damping - load.values[index]
}

/// Enters a value of each component after step `k`; a repeat keeps the values of components that step `reached` does not step.
fn enter(
    values: &mut Vec<f64>,
    tracked: &[TrackedComponent],
    k: u32,
    reached: u32,
    value: impl Fn(&TrackedComponent) -> f64,
) {
    let first = k as usize * tracked.len();
    for (at, tracked) in (first..).zip(tracked) {
        match values.get_mut(at) {
            None => values.push(value(tracked)),
            Some(kept) if tracked.is_stepped(reached) => *kept = value(tracked),
            Some(_) => {}
        }
    }
}

/// [(1-b) f + b f'] du of the tractions over the step that begins at `step` (J).
pub(crate) fn applied_work(model: &Model, step: u64, before: &[f64], after: &[f64]) -> f64 {
    let (b, h) = (model.scheme.damping, model.scheme.step);
    let mut increments = before.iter().zip(after).map(|(old, new)| new - old);
    let of_traction = |traction: &Traction| {
        let [start, end] = [step, step + 1].map(|step| traction.factor(step as f64 * h));
        let products = traction.forces.iter().zip(&mut increments);
        let full: f64 = products.map(|((_, force), du)| force * du).sum();
        ((1.0 - b) * start + b * end) * full
    };
    model.tractions.iter().map(of_traction).sum()
}

/// [(1-b) r + b r'] du of the drives over the step that begins at `step` (J).
fn drive_work(model: &Model, step: u64, before: &[f64], after: &[f64]) -> f64 {
    let (b, h, layout) = (model.scheme.damping, model.scheme.step, model.body.layout);
    let mut reactions = before.iter().zip(after);
    let mut work = 0.0;
    for motion in &model.motions {
        let [start, end] =
            [step, step + 1].map(|step| motion.history.displacement(step as f64 * h));
        let moved = [0, 1].map(|k| end[k] - start[k]);
        for ((index, value), (old, new)) in motion.components.iter().zip(&mut reactions) {
            work += ((1.0 - b) * old + b * new) * moved[layout.direction(*index)] * value;
        }
    }
    work
}
