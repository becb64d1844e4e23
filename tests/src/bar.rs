//! An elastic bar of two-node elements with lumped masses, Newmark with beta_N = 0 and gamma = damping.
//!
//! The interfaces are its right end node, set `end`, and its left one, set `start`; component 1 is not moved and has no
//! compliance.

mod follow;

use kit::read_table;
use protocol::{
    Capabilities, Description, Node, NodeError, Outcome, Reaction, Role, Session, Surface, Term,
    Window,
};
use serde::{Deserialize, Serialize};

/// The bar's keys.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Place of the left end (m).
    #[serde(default)]
    pub x_m: f64,
    /// Elements.
    pub elements: usize,
    /// Length of one (m).
    pub spacing_m: f64,
    /// Mass of one (kg).
    pub element_mass_kg: f64,
    /// Stiffness of one (N/m).
    pub element_stiffness_n_per_m: f64,
    /// Elongation of an element at which it yields (m); elastic when absent.
    pub yield_elongation_m: Option<f64>,
    /// Tangent stiffness of a yielding element over its elastic one.
    #[serde(default)]
    pub hardening_ratio: f64,
    /// Step (s).
    pub step_s: f64,
    /// Newmark's gamma, 0.5 to 1.
    pub damping: f64,
    /// Additional mass on the right end (kg).
    #[serde(default)]
    pub end_mass_kg: f64,
    /// True for a held left end.
    #[serde(default)]
    pub left_fixed: bool,
    /// Velocity of the whole bar at the start (m/s).
    #[serde(default)]
    pub velocity_m_per_s: f64,
    /// A pulse exp(-((x - centre) / width)^2) (m) that travels right at the start.
    pub pulse: Option<Pulse>,
    /// Answer NaN in windows of more steps than this, to test the reaction.
    #[serde(default)]
    pub nan_above_substeps: Option<u32>,
    /// Order of operations in a step.
    #[serde(default)]
    pub grouping: Grouping,
}

/// A travelling pulse.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pulse {
    /// Position of its crest (m).
    pub centre_m: f64,
    /// Its width (m).
    pub width_m: f64,
}

/// Order of operations in a step; the two are the same scheme for a force without jumps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Grouping {
    /// State (u, v) at t_n: a new force acts from t_n on.
    #[default]
    Synchronised,
    /// State (u_n, v_{n-1}, a_{n-1}): a new force acts half a step early. Wrong on purpose.
    Staggered,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    u: Vec<f64>,
    v: Vec<f64>,
    /// Acceleration of the step before; only the staggered grouping has it.
    a: Vec<f64>,
    /// Plastic elongation of each element (m).
    plastic: Vec<f64>,
    interface_work_j: f64,
}

/// The bar.
pub struct Bar {
    config: Config,
    mass: Vec<f64>,
    /// Coupled nodes in the order in which their sets were coupled.
    coupled: Vec<usize>,
    committed: State,
    trial: State,
    energy_0_j: f64,
    steps: u64,
}

/// Makes a bar from a session.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    Ok(Box::new(Bar::new(read_table(&session.config)?)))
}

impl Bar {
    /// A bar at its initial state.
    pub fn new(config: Config) -> Bar {
        let nodes = config.elements + 1;
        let mut mass = vec![config.element_mass_kg; nodes];
        mass[0] *= 0.5;
        mass[nodes - 1] = 0.5 * mass[nodes - 1] + config.end_mass_kg;
        let (u, v) = initial(&config);
        let state = State {
            u,
            v,
            a: vec![0.0; nodes],
            plastic: vec![0.0; config.elements],
            interface_work_j: 0.0,
        };
        let mut bar = Bar {
            config,
            mass,
            coupled: Vec::new(),
            committed: state.clone(),
            trial: state,
            energy_0_j: 0.0,
            steps: 0,
        };
        bar.energy_0_j = bar.energy_j(&bar.committed);
        bar
    }

    /// The same bar without yielding, for the columns: a unit force would make a soft bar yield.
    fn elastic(&self) -> Bar {
        let mut elastic = Bar::new(Config {
            yield_elongation_m: None,
            ..self.config.clone()
        });
        elastic.coupled.clone_from(&self.coupled);
        elastic
    }

    fn at_rest(&self) -> State {
        let zeros = vec![0.0; self.mass.len()];
        State {
            u: zeros.clone(),
            v: zeros.clone(),
            a: zeros,
            plastic: vec![0.0; self.config.elements],
            interface_work_j: 0.0,
        }
    }

    /// omega_1 (1/s) of the bar with its far end held: 2 sqrt(k/m) sin(pi / (4 n)).
    fn lowest_frequency(&self) -> f64 {
        let c = &self.config;
        let angle = std::f64::consts::FRAC_PI_4 / c.elements as f64;
        2.0 * (c.element_stiffness_n_per_m / c.element_mass_kg).sqrt() * angle.sin()
    }

    /// Kinetic and strain energy (J).
    fn mechanical_j(&self, state: &State) -> f64 {
        let kinetic: f64 = self
            .mass
            .iter()
            .zip(&state.v)
            .map(|(m, v)| 0.5 * m * v * v)
            .sum();
        let stiffness = self.config.element_stiffness_n_per_m;
        let strain: f64 = state
            .u
            .windows(2)
            .map(|u| 0.5 * stiffness * (u[1] - u[0]).powi(2))
            .sum();
        kinetic + strain
    }

    /// The mechanical energy less b h^2 a.M a / 4, which the scheme conserves at b = 0.5: the free vibration of velocity Verlet
    /// keeps it to rounding, while kinetic plus strain energy oscillates by (omega h)^2 / 4.
    fn energy_j(&self, state: &State) -> f64 {
        let a = self.acceleration(&state.u, &state.plastic, &[]);
        let inertia: f64 = self.mass.iter().zip(&a).map(|(m, a)| m * a * a).sum();
        let (h, b) = (self.config.step_s, self.config.damping);
        self.mechanical_j(state) - 0.25 * b * h * h * inertia
    }

    /// Updates the plastic elongations until the stress is admissible: return mapping of a bar with kinematic
    /// hardening, |k (e - e_p) - k' e_p| <= k e_y with k' = k r / (1 - r).
    fn yield_where_due(&self, u: &[f64], plastic: &mut [f64]) {
        let Some(limit) = self.config.yield_elongation_m else {
            return;
        };
        let ratio = self.config.hardening_ratio;
        let back = ratio / (1.0 - ratio);
        for (e_p, pair) in plastic.iter_mut().zip(u.windows(2)) {
            let relative = pair[1] - pair[0] - *e_p - back * *e_p;
            if relative.abs() > limit {
                *e_p += relative.signum() * (relative.abs() - limit) / (1.0 + back);
            }
        }
    }

    fn acceleration(&self, u: &[f64], plastic: &[f64], force: &[f64]) -> Vec<f64> {
        let last = u.len() - 1;
        let mut f = vec![0.0; u.len()];
        for i in 0..last {
            let tension = self.config.element_stiffness_n_per_m * (u[i + 1] - u[i] - plastic[i]);
            f[i] += tension;
            f[i + 1] -= tension;
        }
        for (node, pair) in self.coupled.iter().zip(force.chunks_exact(2)) {
            f[*node] += pair[0];
        }
        let mut a: Vec<f64> = f.iter().zip(&self.mass).map(|(f, m)| f / m).collect();
        if self.config.left_fixed {
            a[0] = 0.0;
        }
        a
    }

    /// `substeps` steps under a constant force on the coupled nodes.
    fn run(&self, state: &mut State, force: &[f64], substeps: u32) {
        match self.config.grouping {
            Grouping::Synchronised => self.synchronised(state, force, substeps),
            Grouping::Staggered => self.staggered(state, force, substeps),
        }
    }

    fn synchronised(&self, state: &mut State, force: &[f64], substeps: u32) {
        let (h, b) = (self.config.step_s, self.config.damping);
        let mut a = self.acceleration(&state.u, &state.plastic, force);
        for _ in 0..substeps {
            for (u, (v, a)) in state.u.iter_mut().zip(state.v.iter().zip(&a)) {
                *u += h * v + 0.5 * h * h * a;
            }
            self.yield_where_due(&state.u, &mut state.plastic);
            let next = self.acceleration(&state.u, &state.plastic, force);
            for (v, (old, new)) in state.v.iter_mut().zip(a.iter().zip(&next)) {
                *v += h * ((1.0 - b) * old + b * new);
            }
            a = next;
        }
    }

    fn staggered(&self, state: &mut State, force: &[f64], substeps: u32) {
        let (h, b) = (self.config.step_s, self.config.damping);
        for _ in 0..substeps {
            let a = self.acceleration(&state.u, &state.plastic, force);
            let motion = state.u.iter_mut().zip(&mut state.v);
            for ((u, v), (old, new)) in motion.zip(state.a.iter().zip(&a)) {
                *u += h * *v + h * h * ((1.0 - b) * old + (b + 0.5) * new);
                *v += h * ((1.0 - b) * old + b * new);
            }
            state.a = a;
        }
    }
}

fn initial(config: &Config) -> (Vec<f64>, Vec<f64>) {
    let nodes = config.elements + 1;
    let mut u = vec![0.0; nodes];
    let mut v = vec![config.velocity_m_per_s; nodes];
    if let Some(pulse) = &config.pulse {
        let speed =
            config.spacing_m * (config.element_stiffness_n_per_m / config.element_mass_kg).sqrt();
        for i in 0..nodes {
            let s = (i as f64 * config.spacing_m - pulse.centre_m) / pulse.width_m;
            u[i] += (-s * s).exp();
            // v = -c du/dx: the pulse travels right.
            v[i] += speed * 2.0 * s / pulse.width_m * (-s * s).exp();
        }
    }
    if config.left_fixed {
        v[0] = 0.0;
    }
    (u, v)
}

impl Node for Bar {
    fn describe(&self) -> Description {
        let c = &self.config;
        let omega_max = 2.0 * (c.element_stiffness_n_per_m / c.element_mass_kg).sqrt();
        Description {
            kind: "bar".into(),
            software: "verification bar".into(),
            capabilities: Capabilities {
                rollback: true,
                advance: true,
                columns: true,
                prescribed_velocity: c.grouping == Grouping::Synchronised,
                resume: true,
                ..Capabilities::default()
            },
            step_s: Some(c.step_s),
            step_limit_s: Some((2.0 / c.damping).sqrt() / omega_max),
            step_limit_name: "stability limit".into(),
            first_period_s: Some(2.0 * std::f64::consts::PI / self.lowest_frequency()),
            sets: vec!["end".into(), "start".into()],
            signals: [
                "u_m",
                "v_m_per_s",
                "mechanical_j",
                "start_u_m",
                "momentum_kg_m_per_s",
            ]
            .map(String::from)
            .to_vec(),
            ledger: [("interface", Role::InterfaceWork), ("energy", Role::Stored)]
                .map(|(name, role)| Term {
                    name: name.into(),
                    role,
                })
                .to_vec(),
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        let node = match set {
            "end" => self.config.elements,
            "start" if !self.config.left_fixed => 0,
            _ => {
                return Err(NodeError::configuration(format!(
                    "the bar has no free set `{set}`"
                )));
            }
        };
        self.coupled.push(node);
        Ok(Surface {
            x_m: vec![self.config.x_m + node as f64 * self.config.spacing_m],
            y_m: vec![0.0],
            mass_kg: vec![self.mass[node]],
            radius_m: vec![0.0],
            length_m: vec![self.config.spacing_m],
        })
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        match points.iter().copied().eq(0..self.coupled.len()) {
            true => Ok(()),
            false => Err(NodeError::protocol(format!(
                "the bar has {} points, asked for {points:?}",
                self.coupled.len()
            ))),
        }
    }

    fn columns(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let substeps = window.substeps;
        let elastic = self.elastic();
        let size = 2 * self.coupled.len();
        let mut matrix = vec![0.0; size * size];
        for column in (0..size).step_by(2) {
            let mut unit = vec![0.0; size];
            unit[column] = 1.0;
            let mut rest = elastic.at_rest();
            elastic.run(&mut rest, &unit, substeps);
            for (i, node) in self.coupled.iter().enumerate() {
                matrix[column * size + 2 * i] = rest.u[*node];
            }
        }
        Ok(matrix)
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        let mut state = self.committed.clone();
        self.run(&mut state, force, window.substeps);
        self.steps += u64::from(window.substeps);
        let mut increment = vec![0.0; force.len()];
        for (i, node) in self.coupled.iter().enumerate() {
            let du = state.u[*node] - self.committed.u[*node];
            state.interface_work_j += force[2 * i] * du;
            increment[2 * i] = du;
        }
        self.trial = state;
        let most = self.config.nan_above_substeps.unwrap_or(u32::MAX);
        if window.substeps > most {
            increment[0] = f64::NAN;
        }
        Ok(increment)
    }

    fn impedance(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        let substeps = window.substeps;
        Ok(self.resists(substeps))
    }

    fn prescribe_velocity(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, NodeError> {
        let mut state = self.committed.clone();
        let mut followed = self.lead(&mut state, velocity, window.substeps);
        self.steps += u64::from(window.substeps);
        for (i, node) in self.coupled.iter().enumerate() {
            followed.increment[2 * i] = state.u[*node] - self.committed.u[*node];
        }
        state.interface_work_j += followed.work.iter().sum::<f64>();
        self.trial = state;
        let most = self.config.nan_above_substeps.unwrap_or(u32::MAX);
        if window.substeps > most {
            followed.force[0] = f64::NAN;
        }
        Ok(followed)
    }

    fn commit(&mut self, _window: &Window, _displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.committed.clone_from(&self.trial);
        let state = &self.committed;
        let end = self.config.elements;
        Ok(vec![
            state.u[end],
            state.v[end],
            self.mechanical_j(state),
            state.u[0],
            self.mass.iter().zip(&state.v).map(|(m, v)| m * v).sum(),
            state.interface_work_j,
            self.energy_j(state) - self.energy_0_j,
        ])
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        protocol::checkpoint::pack(&(&self.committed, self.steps))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        (self.committed, self.steps) = protocol::checkpoint::unpack(state)?;
        Ok(())
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome {
            steps: self.steps,
            state_hash: crate::runs::bits_hash(self.committed.u.iter().chain(&self.committed.v)),
            ..Outcome::default()
        })
    }
}
