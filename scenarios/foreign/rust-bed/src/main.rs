//! A rail as a bed of independent springs with dashpots (Kelvin and Voigt), in its own crate.
//!
//! Under a constant force f the displacement goes to f / k as exp(-t / tau). Put your own physics into `after` and `Bed::new`,
//! its configuration into `Config`, and leave the rest.

use std::process::ExitCode;

use kit::read_table;
use protocol::{
    Capabilities, Description, Node, NodeError, Outcome, Role, Session, Surface, Term, Window,
};
use serde::Deserialize;

/// The keys of `participant.<name>.config`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Config {
    /// Step in which windows are counted (s).
    step_s: f64,
    spacing_m: f64,
    width_m: f64,
    /// Radius of the crown (m).
    crown_radius_m: f64,
    /// Stiffness of the bed per area.
    stiffness_pa_per_m: f64,
    /// Mass of the surface per area, for predictions of stability.
    mass_kg_per_m2: f64,
    /// Time in which the bed relaxes (s).
    relaxation_s: f64,
}

/// The quantities that a window changes.
#[derive(Clone, PartialEq)]
struct State {
    /// Displacement of each exchanged component (m).
    u: Vec<f64>,
    interface_work_j: f64,
    dissipated_j: f64,
}

struct Bed {
    config: Config,
    surface: Surface,
    /// Stiffness of a point (N/m).
    stiffness: f64,
    committed: State,
    /// The state after the last answer, with its steps.
    candidate: Option<(State, u64)>,
    steps: u64,
}

impl Bed {
    fn new(config: Config, thickness_m: f64) -> Bed {
        let (width, spacing) = (config.width_m, config.spacing_m);
        let count = (width / spacing).round() as usize + 1;
        let x_m: Vec<f64> = (0..count)
            .map(|i| spacing * (i as f64 - 0.5 * (count - 1) as f64))
            .collect();
        let crown = config.crown_radius_m;
        let mut length_m = vec![spacing; count];
        length_m[0] *= 0.5;
        length_m[count - 1] *= 0.5;
        let surface = Surface {
            y_m: x_m
                .iter()
                .map(|x| (crown * crown - x * x).sqrt() - crown)
                .collect(),
            x_m,
            mass_kg: vec![config.mass_kg_per_m2 * spacing * thickness_m; count],
            radius_m: vec![0.0; count],
            length_m,
        };
        Bed {
            stiffness: config.stiffness_pa_per_m * spacing * thickness_m,
            committed: State {
                u: vec![0.0; 2 * count],
                interface_work_j: 0.0,
                dissipated_j: 0.0,
            },
            config,
            surface,
            candidate: None,
            steps: 0,
        }
    }

    /// The state `substeps` steps after this one, under a force (N) on each exchanged component.
    fn after(&self, state: &State, force: &[f64], substeps: u32) -> State {
        let (k, time_s) = (self.stiffness, self.config.step_s * f64::from(substeps));
        let left = (-time_s / self.config.relaxation_s).exp();
        let mut next = state.clone();
        for (u, f) in next.u.iter_mut().zip(force) {
            let (before, rest) = (*u, f / k);
            *u = rest + (before - rest) * left;
            next.interface_work_j += f * (*u - before);
            // The integral of the dashpot's force times its velocity.
            next.dissipated_j += 0.5 * k * (before - rest).powi(2) * (1.0 - left * left);
        }
        next
    }

    fn stored_j(&self) -> f64 {
        let squares = self.committed.u.iter().map(|u| u * u);
        0.5 * self.stiffness * squares.sum::<f64>()
    }

    fn accept(&mut self, (state, steps): (State, u64)) -> Vec<f64> {
        self.committed = state;
        self.steps += steps;
        let state = &self.committed;
        vec![state.interface_work_j, self.stored_j(), state.dissipated_j]
    }
}

impl Node for Bed {
    fn describe(&self) -> Description {
        let term = |name: &str, role| Term {
            name: name.into(),
            role,
        };
        Description {
            kind: "bed".into(),
            software: concat!("rust-bed ", env!("CARGO_PKG_VERSION")).into(),
            capabilities: Capabilities {
                rollback: true,
                advance: true,
                columns: true,
                alone: true,
                resume: true,
                ..Capabilities::default()
            },
            step_s: Some(self.config.step_s),
            sets: vec!["top".into()],
            ledger: vec![
                term("interface_work", Role::InterfaceWork),
                term("springs", Role::Stored),
                term("dashpots", Role::Dissipated),
            ],
            outward: [("top".to_string(), [0.0, 1.0])].into(),
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        match set {
            "top" => Ok(self.surface.clone()),
            _ => Err(NodeError::configuration(format!(
                "no set `{set}`; the only set is `top`"
            ))),
        }
    }

    /// Points that are not exchanged carry no force and never move: the bed keeps only the exchanged ones.
    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        self.committed.u = vec![0.0; 2 * points.len()];
        Ok(())
    }

    fn columns(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let size = self.committed.u.len();
        let rest = State {
            u: vec![0.0; size],
            ..self.committed.clone()
        };
        let column = |j| {
            let unit: Vec<f64> = (0..size).map(|i| f64::from(i == j)).collect();
            self.after(&rest, &unit, window.substeps).u
        };
        Ok((0..size).flat_map(column).collect())
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        let next = self.after(&self.committed, force, window.substeps);
        let pairs = next.u.iter().zip(&self.committed.u);
        let increments = pairs.map(|(after, before)| after - before).collect();
        self.candidate = Some((next, window.substeps.into()));
        Ok(increments)
    }

    fn commit(&mut self, window: &Window, _displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        let fault = || NodeError::protocol(format!("window {} has no answer", window.index));
        let candidate = self.candidate.take().ok_or_else(fault)?;
        Ok(self.accept(candidate))
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let none = vec![0.0; self.committed.u.len()];
        let next = self.after(&self.committed, &none, window.substeps);
        Ok(self.accept((next, window.substeps.into())))
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        let state = &self.committed;
        let sums = [state.interface_work_j, state.dissipated_j];
        let numbers = state
            .u
            .iter()
            .chain(&sums)
            .flat_map(|number| number.to_le_bytes());
        Ok(numbers.chain(self.steps.to_le_bytes()).collect())
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        let size = self.committed.u.len();
        let words: Vec<[u8; 8]> = state
            .chunks_exact(8)
            .flat_map(<[u8; 8]>::try_from)
            .collect();
        if state.len() != 8 * (size + 3) {
            let why = format!(
                "the checkpoint has {} bytes instead of {}",
                state.len(),
                8 * (size + 3)
            );
            return Err(NodeError::configuration(why));
        }
        let number = |i: usize| f64::from_le_bytes(words[i]);
        self.committed = State {
            u: (0..size).map(number).collect(),
            interface_work_j: number(size),
            dissipated_j: number(size + 1),
        };
        self.steps = u64::from_le_bytes(words[size + 2]);
        self.candidate = None;
        Ok(())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        let deepest = self
            .committed
            .u
            .iter()
            .fold(0.0, |most: f64, u| most.max(-u));
        Ok(Outcome {
            steps: self.steps,
            work: [("steps".to_string(), self.steps as f64)].into(),
            results: [("deepest_m".to_string(), deepest)].into(),
            state_hash: blake3::hash(&self.checkpoint()?).to_hex().to_string(),
            ..Outcome::default()
        })
    }
}

fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: Config = read_table(&session.config)?;
    Ok(Box::new(Bed::new(config, session.setting.thickness_m)))
}

fn main() -> ExitCode {
    match protocol::participate(build) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
