//! Condensed compliance of the coupled components over a window.

use rayon::prelude::*;

use crate::follow::Ramp;
use crate::integrate::{Integrator, Load, RowSums, State};
use crate::model::Model;

/// C (m/N), square, column after column: column j holds the displacements of all `components` after `substeps`
/// steps from rest under a unit force in component j and no other. C(1) = h^2/2 M^-1. A mode phi of frequency
/// omega adds phi phi^T (1 - cos(omega H))/omega^2 in the limit of small steps, the response of an undamped
/// oscillator to a constant force: never negative, so that C is positive definite.
///
/// They are those of linear elasticity in small strain: a plastic body that yields within the window is softer, and a
/// coupler that needs more than one repeat then takes more of them.
///
/// The columns are independent, so they are what the threads share; each is computed by one of them.
pub(crate) fn compliance(model: &Model, components: &[usize], substeps: u32) -> Vec<f64> {
    each_column(model, components, |run, component| {
        run.column(model, components, component, substeps)
    })
}

/// D (kg/s), square, column after column: column j holds the forces on all `components` at the end of `substeps` steps from
/// rest in which the velocity of component j grows in a straight line to one and the others are held. With the
/// acceleration 1/H and the modes of the body with held components, of frequency omega and participation L,
///
/// ```text
/// H D = M_i + H^2/2 K_i + sum L L^T (1 - cos(omega H))
/// ```
///
/// M_i being the lumped masses of the components and K_i their static stiffness: it is never less than M_i, so that D has
/// an inverse for any H. A component that cannot move has zeros in its row and column. As for [`compliance`], of linear
/// elasticity, and shared among the threads.
pub(crate) fn impedance(model: &Model, components: &[usize], substeps: u32) -> Vec<f64> {
    each_column(model, components, |run, component| {
        run.reactions(model, components, component, substeps)
    })
}

fn each_column(
    model: &Model,
    components: &[usize],
    column: impl Fn(&mut ColumnRun, usize) -> Vec<f64> + Sync,
) -> Vec<f64> {
    let columns: Vec<Vec<f64>> = components
        .par_iter()
        .map_init(|| ColumnRun::new(model), |run, at| column(run, *at))
        .collect();
    columns.concat()
}

/// Rows that have moved: a step carries the motion from one row to the next, and what it has not reached is at rest.
fn reached(source: usize, step: usize, rows: usize) -> [usize; 2] {
    [source.saturating_sub(step), (source + step + 1).min(rows)]
}

/// Room for one column at a time.
struct ColumnRun {
    rest: State,
    state: State,
    load: Load,
    sums: Vec<RowSums>,
    integrator: Integrator,
}

impl ColumnRun {
    fn new(model: &Model) -> ColumnRun {
        let rest = State::at_rest(&model.body);
        ColumnRun {
            state: rest.clone(),
            rest,
            load: Load::none(&model.body),
            sums: vec![RowSums::default(); model.body.layout().node_rows()],
            integrator: Integrator::new(&model.body, model.scheme, model.mesh.elements(), 1),
        }
    }

    fn column(
        &mut self,
        model: &Model,
        all: &[usize],
        component: usize,
        substeps: u32,
    ) -> Vec<f64> {
        let layout = model.body.layout();
        self.load.clear();
        self.load.add(component, 1.0);
        self.state.restore(&self.rest);
        self.state
            .accelerate(&model.body, model.scheme.mass_damping, &self.load);
        let source = layout.row_of(component);
        for step in 1..=substeps as usize {
            let reached = reached(source, step, layout.node_rows());
            let body = &model.body;
            self.integrator
                .step_rows(body, &mut self.state, &self.load, &mut self.sums, reached);
        }
        all.iter().map(|index| self.state.u[*index]).collect()
    }

    fn reactions(
        &mut self,
        model: &Model,
        all: &[usize],
        component: usize,
        substeps: u32,
    ) -> Vec<f64> {
        let body = &model.body;
        if body.inverse_mass[component] == 0.0 {
            return vec![0.0; all.len()];
        }
        let layout = body.layout();
        self.load.clear();
        self.state.restore(&self.rest);
        self.state.a.fill(0.0);
        let speed = |index: &usize| if *index == component { 1.0 } else { 0.0 };
        let follow: Vec<(usize, f64)> = all.iter().map(|index| (*index, speed(index))).collect();
        let window_s = model.scheme.step * f64::from(substeps);
        let mut ramp = Ramp::start(body, &mut self.state, &follow, window_s);
        let source = layout.row_of(component);
        for step in 1..=substeps as usize {
            let reached = reached(source, step, layout.node_rows());
            let rule = self.integrator.rule();
            self.integrator
                .step_rows(body, &mut self.state, &self.load, &mut self.sums, reached);
            let share = step as f64 / f64::from(substeps);
            ramp.step(body, &rule, &mut self.state, &mut self.sums[0], share);
        }
        ramp.force
    }
}
