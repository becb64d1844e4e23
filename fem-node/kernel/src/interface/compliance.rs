//! Condensed compliance and impedance of the coupled components over a window.

use rayon::prelude::*;

use crate::element::body::Body;
use crate::integrate::dissipation::Mechanisms;
use crate::integrate::fields::StepFields;
use crate::integrate::integrator::Integrator;
use crate::integrate::state::NodalState;
use crate::interface::prescribed_velocity::PrescribedVelocity;
use crate::scheme::NewmarkScheme;

/// C (m/N), n x n, column-major: column j holds the displacements of all n `components` after `substeps` steps from rest
/// under a unit force in component j and no other. C(1) = h^2/2 M^-1. A mode phi of frequency omega adds
/// phi phi^T (1 - cos(omega H))/omega^2 in the limit of small steps, the response of an undamped oscillator to a constant
/// force: never negative, so that C is positive definite.
///
/// The columns hold for linear elasticity in small strain: a plastic body that yields within the window is softer, and a coupler then needs more
/// repeats.
///
/// The columns are independent, so the threads share them; each is computed by one thread.
pub fn compliance(
    body: &Body,
    scheme: NewmarkScheme,
    components: &[usize],
    substeps: u32,
) -> Vec<f64> {
    each_column(body, scheme, components, |run, component| {
        run.fields.load.add(component, 1.0);
        run.fields.accelerate(body, scheme.mass_damping);
        run.steps(body, component, substeps, None);
        let u = &run.fields.state.u;
        components.iter().map(|index| u[*index]).collect()
    })
}

/// D (kg/s), n x n, column-major: column j holds the reactions on all n `components` at the end of `substeps` steps from
/// rest in which the velocity of component j grows linearly to one and the others stay at rest. With the acceleration 1/H and the modes of the body
/// with fixed components, of frequency omega and participation L,
///
/// ```text
/// H D = M_i + H^2/2 K_i + sum L L^T (1 - cos(omega H))
/// ```
///
/// M_i being the lumped masses of the components and K_i their static stiffness: it is never less than M_i, so that D has
/// an inverse for any H. A component that cannot move has zeros in its row and column. As for [`compliance`], the columns hold for linear elasticity,
/// and the threads share them.
pub fn impedance(
    body: &Body,
    scheme: NewmarkScheme,
    components: &[usize],
    substeps: u32,
) -> Vec<f64> {
    let window_s = scheme.step * f64::from(substeps);
    each_column(body, scheme, components, |run, component| {
        if body.inverse_mass[component] == 0.0 {
            return vec![0.0; components.len()];
        }
        let state = &mut run.fields.state;
        state.a.fill(0.0);
        let speed = |index: &usize| if *index == component { 1.0 } else { 0.0 };
        let ends = components.iter().map(|index| (*index, speed(index)));
        let ends: Vec<(usize, f64)> = ends.collect();
        let mut velocity = PrescribedVelocity::start(body, state, &ends, window_s);
        run.steps(body, component, substeps, Some(&mut velocity));
        velocity.force
    })
}

fn each_column(
    body: &Body,
    scheme: NewmarkScheme,
    components: &[usize],
    column: impl Fn(&mut ColumnRun, usize) -> Vec<f64> + Sync,
) -> Vec<f64> {
    let from_rest = |run: &mut ColumnRun, component: &usize| {
        run.fields.load.clear();
        run.fields.state.restore(&run.rest);
        column(run, *component)
    };
    let columns: Vec<Vec<f64>> = components
        .par_iter()
        .map_init(|| ColumnRun::new(body, scheme), from_rest)
        .collect();
    columns.concat()
}

/// Buffers for one column at a time.
struct ColumnRun {
    rest: NodalState,
    fields: StepFields,
    integrator: Integrator,
}

impl ColumnRun {
    fn new(body: &Body, scheme: NewmarkScheme) -> ColumnRun {
        ColumnRun {
            rest: NodalState::at_rest(body),
            // The energies of a column are not needed.
            fields: StepFields::at_rest(body, None, Mechanisms::default()),
            integrator: Integrator::new(body, scheme, None, 1),
        }
    }

    /// Steps the rows that have moved: a step carries the motion from one row to the next, and the others are at rest.
    fn steps(
        &mut self,
        body: &Body,
        source: usize,
        substeps: u32,
        mut velocity: Option<&mut PrescribedVelocity>,
    ) {
        let layout = body.layout;
        let (row, rows) = (layout.row_of(source), layout.node_rows);
        for step in 1..=substeps as usize {
            let reached = [row.saturating_sub(step), (row + step + 1).min(rows)];
            self.integrator.step(body, &mut self.fields, reached, None);
            if let Some(velocity) = &mut velocity {
                let share = step as f64 / f64::from(substeps);
                let rule = self.integrator.rule;
                velocity.step(body, &rule, &mut self.fields, share);
            }
        }
    }
}
