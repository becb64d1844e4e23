//! The scenes of simulated schedules: two bodies so small that a run takes a millisecond.
//!
//! - `spring`: a mass of 1 kg on a spring of 1 N/m, velocity Verlet, for the force-driven side;
//! - `block`: a mass of 1 kg for each coupled set, implicit Euler, for the side whose boundary is compliant:
//!   v = a + W p with m (v_0 - v) = p.

use kit::read_table;
use nalgebra::{DMatrix, DVector};
use protocol::{
    BoundaryAnswer, BoundaryInertia, Description, Node, NodeError, Outcome, Surface, Window,
};
use serde::{Deserialize, Serialize};

use coordinator::participants::{Registry, ShippedSolver};
use scenario::error::Error;
use scenario::load::{Loaded, parse};
use scenario::source::ScenarioSource;

/// Longest wait of a simulated run (s).
pub const DEADLINE_S: f64 = 2.0;

/// A block between two springs: with checkpoints, with halved windows, and with a fixed point.
const SCENES: [(&str, &str); 3] = [
    (
        "exchange = true",
        "scheme = \"dual-schur\"\nsubsteps = 3\ntolerance_rel = 1e-9",
    ),
    (
        "exchange = false",
        "scheme = \"dual-schur\"\nsubsteps = 8\ntolerance_rel = 1e-9\non_not_converged = \"halve\"",
    ),
    (
        "exchange = false",
        "scheme = \"fixed-point-serial\"\nsubsteps = 3\ntolerance_rel = 1e-6\nrepeats_max = 60",
    ),
];

/// The scenes, each read once.
pub fn scenes() -> Result<Vec<Loaded>, Error> {
    let texts = SCENES.iter().map(|(output, scheme)| text(output, scheme));
    let sources = texts.map(|text| ScenarioSource::new("simulated.toml", text, &[]));
    sources.map(parse).collect()
}

fn text(output: &str, scheme: &str) -> String {
    let every = if output.ends_with("true") { 4 } else { 0 };
    let mut text = format!(
        "[run]\nname = \"simulated\"\nthickness_m = 1.0\ntransport = \"channel\"\ncheckpoint_every_windows = {every}\n\
         deadlines = {{ setup_s = {DEADLINE_S}, answer_s = {DEADLINE_S} }}\n[run.output]\n{output}\n\
         [[participant]]\nname = \"block\"\nkind = \"block\"\n"
    );
    for name in ["left", "right"] {
        text += &format!(
            "[[participant]]\nname = \"{name}\"\nkind = \"spring\"\n\
             [[interface]]\nname = \"{name}-joint\"\nbetween = [\"{name}.end\", \"block.{name}\"]\n{scheme}\n"
        );
    }
    text
}

/// The solvers of these scenes.
pub fn registry() -> Registry {
    let solver = |kind, build| ShippedSolver {
        kind,
        check: |config, _| read_table::<NoKeys>(config).map(|_| Vec::new()),
        nonlinear: None,
        schema: None,
        build,
    };
    Registry {
        solvers: vec![
            solver("spring", |_| Ok(Body::spring())),
            solver("block", |_| Ok(Body::block())),
        ],
        ..Registry::default()
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoKeys {}

/// Steps per window from which the spring answers NaN.
const TOO_MANY: u32 = 8;

const STEP_S: f64 = 0.2;

/// Displacements and velocities of both components of each mass.
#[derive(Clone, Default, Serialize, Deserialize)]
struct State {
    u: Vec<f64>,
    v: Vec<f64>,
}

/// A mass on a spring, or masses on a compliant boundary: its description decides which requests it gets.
#[derive(Default)]
struct Body {
    description: Description,
    committed: State,
    trial: State,
    window_s: f64,
    compliance: DMatrix<f64>,
}

impl Body {
    fn spring() -> Box<dyn Node> {
        let mut description = Description {
            step_s: Some(STEP_S),
            step_limit_s: Some(2.0),
            step_limit_name: "stability limit".into(),
            ..Description::default()
        };
        description.capabilities.advance = true;
        description.capabilities.columns = true;
        Body::of("spring", &["end"], description)
    }

    fn block() -> Box<dyn Node> {
        let mut description = Description {
            boundary_inertia: Some(BoundaryInertia {
                glued_mass_kg: 1.0,
                mass_kg: 0.0,
                stiffness_n_per_m: None,
                theta: 1.0,
                may_part: false,
            }),
            ..Description::default()
        };
        description.capabilities.compliant_boundary = true;
        Body::of("block", &["left", "right"], description)
    }

    fn of(kind: &str, sets: &[&str], given: Description) -> Box<dyn Node> {
        let mut description = Description {
            kind: kind.into(),
            software: format!("simulated {kind}"),
            sets: sets.iter().map(|set| set.to_string()).collect(),
            signals: vec!["u_m".into()],
            end_s: Some(24.0 * STEP_S),
            ..given
        };
        description.capabilities.rollback = true;
        description.capabilities.resume = true;
        Box::new(Body {
            description,
            ..Body::default()
        })
    }
}

/// Lets the mass on the spring swing under a force.
fn swing(state: &mut State, force: &[f64], substeps: u32) {
    for (k, force) in force.iter().enumerate() {
        for _ in 0..substeps {
            let a = force - state.u[k];
            state.u[k] += STEP_S * (state.v[k] + 0.5 * STEP_S * a);
            state.v[k] += 0.5 * STEP_S * (a + force - state.u[k]);
        }
    }
}

impl Node for Body {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        // Each mass of the block starts with its own velocity, so that a mix-up of the two would show.
        let (velocity, mass_kg) = match set {
            "left" => (-1.0, 0.0),
            "right" => (0.5, 0.0),
            _ => (0.0, 1.0),
        };
        self.committed.u.extend([0.0; 2]);
        self.committed.v.extend([velocity, 0.25 * velocity]);
        Ok(Surface {
            x_m: vec![0.0],
            y_m: vec![0.0],
            mass_kg: vec![mass_kg],
            radius_m: vec![0.0],
            length_m: vec![1.0],
        })
    }

    fn select(&mut self, _points: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn columns(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let column = |unit: [f64; 2]| {
            let (u, v) = (vec![0.0; 2], vec![0.0; 2]);
            let mut state = State { u, v };
            swing(&mut state, &unit, window.substeps);
            state.u
        };
        Ok([column([1.0, 0.0]), column([0.0, 1.0])].concat())
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.trial.clone_from(&self.committed);
        swing(&mut self.trial, force, window.substeps);
        let pairs = self.trial.u.iter().zip(&self.committed.u);
        let mut increment: Vec<f64> = pairs.map(|(new, old)| new - old).collect();
        if window.substeps >= TOO_MANY {
            increment[0] = f64::NAN;
        }
        Ok(increment)
    }

    fn set_boundary(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        let size = self.committed.u.len();
        if compliance.len() != size * size {
            return Err(NodeError::protocol("a wall of another size"));
        }
        self.window_s = window_s;
        self.compliance = DMatrix::from_column_slice(size, size, compliance);
        Ok(())
    }

    fn solve(
        &mut self,
        _window: &Window,
        free_velocity: &[f64],
    ) -> Result<BoundaryAnswer, NodeError> {
        let size = self.committed.u.len();
        let start = DVector::from_column_slice(&self.committed.v);
        let right = DVector::from_column_slice(free_velocity) + &self.compliance * &start;
        let system = DMatrix::identity(size, size) + &self.compliance;
        let solved = system.lu().solve(&right);
        let velocity = solved.ok_or_else(|| NodeError::diverged("the wall is singular"))?;
        let moved = self.committed.u.iter().zip(velocity.iter());
        self.trial = State {
            u: moved.map(|(u, v)| u + self.window_s * v).collect(),
            v: velocity.as_slice().to_vec(),
        };
        Ok(BoundaryAnswer {
            force: ((start - &velocity) / self.window_s).as_slice().to_vec(),
            velocity: self.trial.v.clone(),
            iterations: 1,
            residual: 0.0,
            converged: true,
        })
    }

    fn commit(&mut self, _window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.committed.clone_from(&self.trial);
        // The spring receives no displacement.
        self.committed.u[..displacement.len()].copy_from_slice(displacement);
        Ok(vec![self.committed.u[0]])
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        protocol::checkpoint::pack(&self.committed)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        self.committed = protocol::checkpoint::unpack(state)?;
        Ok(())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        let mut hasher = blake3::Hasher::new();
        for value in self.committed.u.iter().chain(&self.committed.v) {
            hasher.update(&value.to_le_bytes());
        }
        Ok(Outcome {
            state_hash: hasher.finalize().to_hex().to_string(),
            ..Outcome::default()
        })
    }
}
