//! The two sides of the bench as participants of the real coupler: the bar, and masses on the wall.

use protocol::{
    BoundaryAnswer, BoundaryInertia, Capabilities, Description, Node, NodeError, Outcome, Reaction,
    Surface, Window,
};

pub use super::bar::Bar;
use super::bar::{END_MASS_KG, State};
use crate::scheme::predict::sprung_mass::{Masses, Motion, SprungMass};

/// The bar as a participant.
pub struct BarNode {
    bar: Bar,
    committed: State,
    trial: State,
}

impl BarNode {
    /// A bar at rest.
    pub fn new(bar: Bar) -> BarNode {
        let rest = State {
            u: vec![0.0; bar.elements],
            v: vec![0.0; bar.elements],
        };
        BarNode {
            bar,
            committed: rest.clone(),
            trial: rest,
        }
    }
}

fn end_of(set: &str, mass_kg: f64) -> Result<Surface, NodeError> {
    match set {
        "end" => Ok(Surface {
            x_m: vec![0.0],
            y_m: vec![0.0],
            mass_kg: vec![mass_kg],
            radius_m: vec![0.0],
            length_m: vec![1.0],
        }),
        other => Err(NodeError::configuration(format!("no set `{other}`"))),
    }
}

impl Node for BarNode {
    fn describe(&self) -> Description {
        Description {
            kind: "bar".into(),
            capabilities: Capabilities {
                rollback: true,
                advance: true,
                columns: true,
                prescribed_velocity: true,
                ..Capabilities::default()
            },
            step_s: Some(self.bar.step_s),
            step_limit_s: Some(Bar::LIMIT_S),
            step_limit_name: "stability limit 2/omega_max".into(),
            first_period_s: Some(self.bar.first_period_s()),
            sets: vec!["end".into()],
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        end_of(set, END_MASS_KG)
    }

    fn select(&mut self, _points: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn columns(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        let mut state = BarNode::new(self.bar).committed;
        self.bar.run(&mut state, 1.0, substeps);
        Ok(vec![state.u[self.bar.elements - 1], 0.0, 0.0, 0.0])
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.trial.clone_from(&self.committed);
        self.bar.run(&mut self.trial, force[0], window.substeps);
        let end = self.bar.elements - 1;
        Ok(vec![self.trial.u[end] - self.committed.u[end], 0.0])
    }

    fn impedance(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        let mut state = BarNode::new(self.bar).committed;
        let window_s = self.bar.step_s * f64::from(substeps);
        let (force, _) = self
            .bar
            .run_prescribed(&mut state, 1.0 / window_s, substeps);
        Ok(vec![force, 0.0, 0.0, 0.0])
    }

    fn prescribe_velocity(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, NodeError> {
        self.trial.clone_from(&self.committed);
        let end = self.bar.elements - 1;
        let window_s = self.bar.step_s * f64::from(window.substeps);
        let acceleration = (velocity[0] - self.committed.v[end]) / window_s;
        let (force, work) = self
            .bar
            .run_prescribed(&mut self.trial, acceleration, window.substeps);
        let increment = self.trial.u[end] - self.committed.u[end];
        Ok(Reaction {
            force: vec![force, 0.0],
            increment: vec![increment, 0.0],
            work: vec![work, 0.0],
        })
    }

    fn commit(&mut self, _window: &Window, _displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.committed.clone_from(&self.trial);
        Ok(Vec::new())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome::default())
    }
}

/// The masses as a participant; they start with 1 m/s.
pub struct BodyNode {
    boundary_inertia: BoundaryInertia,
    /// Mass of the point (kg) that is not in the equations here.
    point_mass_kg: f64,
    window_s: f64,
    compliance: f64,
    place: f64,
    committed: Masses,
    trial: Masses,
}

impl BodyNode {
    /// Masses on their way.
    pub fn new(boundary_inertia: BoundaryInertia, point_mass_kg: f64) -> BodyNode {
        let start = BodyNode::start();
        BodyNode {
            boundary_inertia,
            point_mass_kg,
            window_s: 0.0,
            compliance: 0.0,
            place: 0.0,
            committed: start,
            trial: start,
        }
    }

    /// Both masses with 1 m/s.
    pub fn start() -> Masses {
        Masses {
            glued_velocity: 1.0,
            place: 0.0,
            velocity: 1.0,
        }
    }
}

impl Node for BodyNode {
    fn describe(&self) -> Description {
        Description {
            kind: "body".into(),
            capabilities: Capabilities {
                rollback: true,
                compliant_boundary: true,
                ..Capabilities::default()
            },
            boundary_inertia: Some(self.boundary_inertia),
            point_mass_kg: [("end".into(), vec![self.point_mass_kg])].into(),
            sets: vec!["end".into()],
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        end_of(set, 0.0)
    }

    fn select(&mut self, _points: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn set_boundary(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        (self.window_s, self.compliance) = (window_s, compliance[0]);
        Ok(())
    }

    fn solve(
        &mut self,
        _window: &Window,
        free_velocity: &[f64],
    ) -> Result<BoundaryAnswer, NodeError> {
        let motion = Motion {
            free: free_velocity[0],
            compliance: self.compliance,
        };
        let mass = SprungMass::new(&self.boundary_inertia, self.window_s);
        let solved = mass.window(&self.committed, self.place, motion);
        self.trial = solved.masses;
        Ok(BoundaryAnswer {
            force: vec![solved.force, 0.0],
            velocity: vec![solved.masses.glued_velocity, free_velocity[1]],
            iterations: 1,
            residual: 0.0,
            converged: true,
        })
    }

    fn commit(&mut self, _window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.committed = self.trial;
        self.place = displacement[0];
        Ok(Vec::new())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome::default())
    }
}
