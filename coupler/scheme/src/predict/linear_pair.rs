//! Two linear participants in memory: a continuum and masses on its boundary, with one motion of their interface.
//!
//! The first component of the one node and the one point is this motion; the second component never moves.

use nalgebra::{DMatrix, DVector};
use protocol::{BoundaryAnswer, BoundaryInertia, Description, Reaction, Surface, Window};

use super::response::Response;
use super::sprung_mass::{Masses, Motion, SprungMass};
use crate::clock::Clock;
use crate::error::{Result, SchemeError, Unfit};
use crate::group::{Group, Offset, Patch, Side};
use crate::keys::MappingKind;
use crate::mapping::Mapping;
use crate::participants::{Participants, Request};

/// The force-driven participant of a pair.
pub const CONTINUUM: usize = 0;
/// The motion-driven one.
pub const BOUNDARY: usize = 1;

/// The two sides of an interface in one motion.
#[derive(Clone, Copy, Debug)]
pub struct LinearModel<'a> {
    /// A window of the continuum.
    pub response: &'a Response,
    /// The masses on the boundary.
    pub inertia: BoundaryInertia,
    /// Mass of the point (kg), which is in none of their equations.
    pub point_mass_kg: f64,
    /// Length H of the window (s).
    pub window_s: f64,
}

impl LinearModel<'_> {
    /// The same with all masses and springs on the boundary multiplied by a factor.
    pub fn times(mut self, factor: f64) -> Self {
        self.inertia.glued_mass_kg *= factor;
        self.inertia.mass_kg *= factor;
        self.inertia.stiffness_n_per_m = self.inertia.stiffness_n_per_m.map(|k| factor * k);
        self.point_mass_kg *= factor;
        self
    }

    /// The masses and the point's mass as one body behind the interface.
    pub fn whole(&self) -> SprungMass {
        let inertia = BoundaryInertia {
            glued_mass_kg: self.inertia.glued_mass_kg + self.point_mass_kg,
            ..self.inertia
        };
        SprungMass::new(&inertia, self.window_s)
    }

    /// The one node and the one point as a group whose windows are one step long. A gap (m) up to `tolerance_m` counts as
    /// closed.
    pub fn group(&self, tolerance_m: f64) -> Group {
        let surface = |mass_kg| Surface::of_columns([0.0, 0.0, mass_kg, 0.0, 1.0].map(|x| vec![x]));
        let side = |peer: usize| Side {
            peer,
            range: 0..1,
            steps: 1,
        };
        Group {
            patches: vec![Patch {
                offset: Offset::default(),
                period_m: None,
                index: 0,
                name: "model".into(),
                force_driven: 0,
                motion_driven: 0,
                nodes: 0..1,
                points: 0..1,
                outward_y: 1.0,
                outward: [0.0, 1.0],
                spacing_m: 1.0,
                tolerance_rel: tolerance_m,
                energy_defect_max_rel: None,
            }],
            force_driven: vec![side(CONTINUUM)],
            motion_driven: vec![side(BOUNDARY)],
            nodes: surface(0.0),
            points: surface(self.point_mass_kg),
            mapping: Mapping::new(MappingKind::Linear, &[[0.0; 2]], &[[0.0; 2]], None)
                .expect("one node carries all"),
            clock: Clock {
                step_s: self.window_s,
                substeps: 1,
            },
            heat_every: None,
        }
    }
}

/// State of a pair between two windows.
#[derive(Clone, Debug, PartialEq)]
pub struct PairState {
    /// Displacements and velocities of the continuum.
    pub continuum: DVector<f64>,
    /// The masses.
    pub masses: Masses,
    /// Position of the interface as sent to the boundary (m).
    pub position: f64,
}

/// A pair as participants.
pub struct LinearPair<'a> {
    model: LinearModel<'a>,
    mass: SprungMass,
    description: Description,
    /// The accepted state.
    pub state: PairState,
    trial: PairState,
    /// W_g (1/kg).
    compliance: f64,
    /// The value in the request begun.
    asked: f64,
    /// Free velocities (m/s) sent to the boundary since this was emptied.
    pub free_velocities: Vec<f64>,
    /// Velocities (m/s) prescribed to the continuum since this was emptied.
    pub prescribed_velocities: Vec<f64>,
}

impl<'a> LinearPair<'a> {
    /// A continuum at rest, with these masses.
    pub fn new(model: LinearModel<'a>, masses: Masses) -> LinearPair<'a> {
        let state = PairState {
            continuum: DVector::zeros(model.response.push.len()),
            masses,
            position: 0.0,
        };
        LinearPair {
            model,
            mass: SprungMass::new(&model.inertia, model.window_s),
            description: Description::default(),
            trial: state.clone(),
            state,
            compliance: 0.0,
            asked: 0.0,
            free_velocities: Vec::new(),
            prescribed_velocities: Vec::new(),
        }
    }

    /// Motion of the interface in the window tried (m).
    fn increment(&self) -> f64 {
        let interface = &self.model.response.interface;
        interface.dot(&self.trial.continuum) - interface.dot(&self.state.continuum)
    }

    /// An n x n matrix with the moving component alone.
    fn moving(value: f64, n: usize) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(n, n);
        matrix[(0, 0)] = value;
        matrix
    }
}

impl Participants for LinearPair<'_> {
    fn count(&self) -> usize {
        2
    }

    fn name(&self, peer: usize) -> &str {
        ["continuum", "masses"][peer]
    }

    fn description(&self, _peer: usize) -> &Description {
        &self.description
    }

    fn couple(&mut self, _peer: usize, set: &str) -> Result<Surface> {
        Err(Unfit::interface("model", format!("no set `{set}`")).into())
    }

    fn select(&mut self, _peer: usize, _points: &[usize]) -> Result<()> {
        Ok(())
    }

    fn compliance(&mut self, _: usize, _: &Window, n: usize) -> Result<DMatrix<f64>> {
        Ok(LinearPair::moving(self.model.response.compliance(), n))
    }

    fn impedance(&mut self, _: usize, _: &Window, n: usize) -> Result<DMatrix<f64>> {
        let window_s = self.model.window_s;
        let yields = self.model.response.prescribed_compliance(window_s);
        Ok(LinearPair::moving(window_s / yields, n))
    }

    fn set_boundary(
        &mut self,
        _peer: usize,
        _window: &Window,
        _window_s: f64,
        compliance: &DMatrix<f64>,
    ) -> Result<()> {
        self.compliance = compliance[(0, 0)];
        Ok(())
    }

    fn begin(&mut self, _: usize, _: &Window, request: Request) -> Result<()> {
        match request {
            Request::Advance(force) => self.asked = force[0],
            Request::PrescribeVelocity(velocity) => {
                self.asked = velocity[0];
                self.prescribed_velocities.push(velocity[0]);
            }
            Request::Solve(free_velocity) => self.free_velocities.push(free_velocity[0]),
        }
        Ok(())
    }

    fn finish_advance(&mut self, _: usize, _: &Window, _: usize) -> Result<Vec<f64>> {
        let response = self.model.response;
        self.trial.continuum =
            &response.carry * &self.state.continuum + &response.push * self.asked;
        Ok(vec![finite(self.increment())?, 0.0])
    }

    /// The works are left at zero: no ledger is read here.
    fn finish_prescribed_velocity(&mut self, _: usize, _: &Window, _: usize) -> Result<Reaction> {
        let (response, start) = (self.model.response, &self.state.continuum);
        let acceleration = (self.asked - response.speed(start)) / self.model.window_s;
        let (continuum, force) = response.prescribed(start, acceleration);
        self.trial.continuum = continuum;
        Ok(Reaction {
            force: vec![finite(force)?, 0.0],
            increment: vec![self.increment(), 0.0],
            work: vec![0.0; 2],
        })
    }

    fn finish_solve(&mut self, _: usize, _: &Window, _: usize) -> Result<BoundaryAnswer> {
        let motion = Motion {
            free: *self.free_velocities.last().expect("a solve was begun"),
            compliance: self.compliance,
        };
        let start = &self.state;
        let solved = self.mass.window(&start.masses, start.position, motion);
        self.trial.masses = solved.masses;
        Ok(BoundaryAnswer {
            force: vec![finite(solved.force)?, 0.0],
            velocity: vec![solved.masses.glued_velocity, 0.0],
            iterations: 1,
            residual: 0.0,
            converged: true,
        })
    }

    fn accept(&mut self, peer: usize, _: &Window, displacement: &[f64]) -> Result<()> {
        if peer == CONTINUUM {
            self.state.continuum.clone_from(&self.trial.continuum);
        } else {
            self.state.masses = self.trial.masses;
            self.state.position = displacement[0];
        }
        Ok(())
    }

    fn report(&mut self, _peer: usize) -> Result<Vec<f64>> {
        Ok(Vec::new())
    }
}

/// Refuses an answer that is NaN or infinite.
fn finite(value: f64) -> Result<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(SchemeError::NotFinite(format!(
        "the model answered {value}"
    )))
}
