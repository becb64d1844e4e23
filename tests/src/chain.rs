//! Masses and springs along x, implicit theta scheme, one step per window; the first mass, the last one or both are glued
//! to the wall.
//!
//! With (M + (theta H)^2 K) v = M v_0 - H K (q_0 + theta (1 - theta) H v_0) + impulses for the free masses. A glued
//! mass moves by H v_g, so it enters the springs at q_0 + theta H v_g; the wall's impulse -p gives the rest of its momentum
//! balance, and v_g = a_g + W_g p. Component 1 follows a_g and carries no force.

use kit::read_table;
use nalgebra::{DMatrix, DVector};
use protocol::{
    BoundaryAnswer, BoundaryInertia, Capabilities, Description, Node, NodeError, Outcome, Role,
    Session, Surface, Term, Window,
};
use serde::{Deserialize, Serialize};

/// The chain's keys.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Place of the glued mass (m).
    pub x_m: f64,
    /// Mass of the first one, set `end` (kg).
    pub glued_mass_kg: f64,
    /// Mass of the last one, set `far` (kg); a free mass when absent.
    pub far_mass_kg: Option<f64>,
    /// Distance between neighbours (m); it only places the set `far`.
    #[serde(default)]
    pub spacing_m: f64,
    /// Free masses.
    #[serde(default)]
    pub count: usize,
    /// Mass of a free one (kg).
    #[serde(default)]
    pub mass_kg: f64,
    /// Stiffness of the springs between neighbours (N/m).
    #[serde(default)]
    pub stiffness_n_per_m: f64,
    /// 0.5 to 1.
    pub theta: f64,
    /// Velocity of all masses at the start (m/s).
    #[serde(default)]
    pub velocity_m_per_s: f64,
    /// End of the run (s).
    pub end_s: f64,
    /// Answer NaN in windows longer than this (s), to test the reaction.
    #[serde(default)]
    pub nan_above_window_s: Option<f64>,
    /// Masses of the glued points that are not in the equations here (kg), declared in the greeting.
    #[serde(default)]
    pub point_mass_kg: Option<f64>,
    /// Report a wrong number in some windows, to test the reaction.
    #[serde(default)]
    pub misreport: Option<Misreport>,
    /// From this window on, claim that the contact solve was starved, to test the refusal.
    #[serde(default)]
    pub starve_from_window: Option<u64>,
}

/// A wrong number in the reports of some windows.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Misreport {
    /// First window, and the one after the last.
    pub windows: [u64; 2],
    /// Index of the number: four signals, interface work, energy.
    pub entry: usize,
    /// The number; NaN when absent.
    pub value: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    interface_work_j: f64,
}

/// The chain.
pub struct Chain {
    config: Config,
    mass: Vec<f64>,
    /// Glued masses in the order in which their sets were coupled.
    glued: Vec<usize>,
    window_s: f64,
    /// W_g over both components of the glued masses.
    wall: DMatrix<f64>,
    committed: State,
    trial: State,
    energy_0_j: f64,
    steps: u64,
}

/// Makes a chain from a session.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    Ok(Box::new(Chain::new(read_table(&session.config)?)))
}

impl Chain {
    /// A chain at its initial state.
    pub fn new(config: Config) -> Chain {
        let mut mass = vec![config.mass_kg; config.count + 1];
        mass[0] = config.glued_mass_kg;
        if let Some(far) = config.far_mass_kg {
            mass[config.count] = far;
        }
        let state = State {
            q: vec![0.0; mass.len()],
            v: vec![config.velocity_m_per_s; mass.len()],
            interface_work_j: 0.0,
        };
        let mut chain = Chain {
            config,
            mass,
            glued: Vec::new(),
            window_s: 0.0,
            wall: DMatrix::zeros(0, 0),
            committed: state.clone(),
            trial: state,
            energy_0_j: 0.0,
            steps: 0,
        };
        chain.energy_0_j = chain.energy_j(&chain.committed);
        chain
    }

    fn energy_j(&self, state: &State) -> f64 {
        let kinetic: f64 = self
            .mass
            .iter()
            .zip(&state.v)
            .map(|(m, v)| 0.5 * m * v * v)
            .sum();
        let stiffness = self.config.stiffness_n_per_m;
        kinetic
            + state
                .q
                .windows(2)
                .map(|q| 0.5 * stiffness * (q[1] - q[0]).powi(2))
                .sum::<f64>()
    }

    /// Spring forces (N) at positions q.
    fn springs(&self, q: &[f64]) -> Vec<f64> {
        let mut force = vec![0.0; q.len()];
        for i in 0..q.len() - 1 {
            let tension = self.config.stiffness_n_per_m * (q[i + 1] - q[i]);
            force[i] += tension;
            force[i + 1] -= tension;
        }
        force
    }

    /// Motion of a mass as a factor on its end velocity (s), and the rest of its motion (m).
    fn motion(&self, mass: usize) -> (f64, f64) {
        let (h, theta) = (self.window_s, self.config.theta);
        match self.glued.contains(&mass) {
            true => (h, 0.0),
            false => (theta * h, (1.0 - theta) * h * self.committed.v[mass]),
        }
    }

    /// Velocities at the end of the window and the impulses p of the chain on the wall, by one linear system in
    /// (v_0, v_1, ..., v_n, p): momentum of each mass, then the wall.
    fn step(&self, free_velocity: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (h, theta) = (self.window_s, self.config.theta);
        let (n, k) = (self.mass.len(), self.glued.len());
        let start = &self.committed;
        // Positions at theta, without the part of the unknown velocities.
        let known: Vec<f64> = (0..n)
            .map(|i| start.q[i] + theta * self.motion(i).1)
            .collect();
        let force = self.springs(&known);
        let mut matrix = DMatrix::zeros(n + k, n + k);
        let mut right = DVector::zeros(n + k);
        for column in 0..n {
            let mut unit = vec![0.0; n];
            unit[column] = theta * self.motion(column).0;
            let springs = self.springs(&unit);
            for row in 0..n {
                matrix[(row, column)] = -h * springs[row];
            }
            matrix[(column, column)] += self.mass[column];
            right[column] = self.mass[column] * start.v[column] + h * force[column];
        }
        for (i, mass) in self.glued.iter().enumerate() {
            matrix[(*mass, n + i)] = 1.0;
            matrix[(n + i, *mass)] = 1.0;
            for j in 0..k {
                matrix[(n + i, n + j)] = -self.wall[(2 * i, 2 * j)];
            }
            right[n + i] = free_velocity[2 * i];
        }
        let solution = matrix.lu().solve(&right).expect("masses are positive");
        let (velocity, impulse) = solution.as_slice().split_at(n);
        (velocity.to_vec(), impulse.to_vec())
    }

    fn place_of(&self, set: &str) -> Option<usize> {
        match set {
            "end" => Some(0),
            "far" => Some(self.config.count),
            _ => None,
        }
    }
}

impl Node for Chain {
    fn describe(&self) -> Description {
        Description {
            kind: "chain".into(),
            software: "verification chain".into(),
            capabilities: Capabilities {
                rollback: true,
                compliant_boundary: true,
                rigid_boundary: true,
                resume: true,
                ..Capabilities::default()
            },
            end_s: Some(self.config.end_s),
            boundary_inertia: Some(BoundaryInertia {
                glued_mass_kg: self.config.glued_mass_kg,
                mass_kg: self.config.mass_kg * self.config.count as f64,
                stiffness_n_per_m: (self.config.count > 0).then_some(self.config.stiffness_n_per_m),
                theta: self.config.theta,
                may_part: false,
            }),
            point_mass_kg: match self.config.point_mass_kg {
                Some(mass) => ["end", "far"].map(|set| (set.into(), vec![mass])).into(),
                None => Default::default(),
            },
            sets: vec!["end".into(), "far".into()],
            signals: ["q_m", "v_m_per_s", "far_m", "momentum_kg_m_per_s"]
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
        let mass = self
            .place_of(set)
            .ok_or_else(|| NodeError::configuration(format!("the chain has no set `{set}`")))?;
        self.glued.push(mass);
        Ok(Surface {
            x_m: vec![self.config.x_m + mass as f64 * self.config.spacing_m],
            y_m: vec![0.0],
            mass_kg: vec![0.0],
            radius_m: vec![0.0],
            length_m: vec![1.0],
        })
    }

    fn select(&mut self, _points: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn set_boundary(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        let size = 2 * self.glued.len();
        self.window_s = window_s;
        self.wall = DMatrix::from_column_slice(size, size, compliance);
        Ok(())
    }

    fn solve(
        &mut self,
        window: &Window,
        free_velocity: &[f64],
    ) -> Result<BoundaryAnswer, NodeError> {
        let (velocity, impulse) = self.step(free_velocity);
        let mut state = self.committed.clone();
        for (i, v) in velocity.iter().enumerate() {
            let (time_s, besides) = self.motion(i);
            state.q[i] += time_s * v + besides;
        }
        state.v.clone_from(&velocity);
        let mut answer = BoundaryAnswer {
            force: vec![0.0; free_velocity.len()],
            velocity: free_velocity.to_vec(),
            iterations: 1,
            residual: 0.0,
            converged: true,
        };
        for (i, mass) in self.glued.iter().enumerate() {
            state.interface_work_j -= impulse[i] * velocity[*mass];
            answer.force[2 * i] = impulse[i] / self.window_s;
            answer.velocity[2 * i] = velocity[*mass];
        }
        self.trial = state;
        self.steps += 1;
        if self
            .config
            .nan_above_window_s
            .is_some_and(|most| self.window_s > most)
        {
            answer.force[0] = f64::NAN;
        }
        if self
            .config
            .starve_from_window
            .is_some_and(|from| window.index >= from)
        {
            (answer.residual, answer.converged) = (0.3, false);
        }
        Ok(answer)
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.committed.clone_from(&self.trial);
        for (i, mass) in self.glued.iter().enumerate() {
            self.committed.q[*mass] = displacement[2 * i];
        }
        let state = &self.committed;
        let mut report = vec![
            state.q[0],
            state.v[0],
            state.q[self.config.count],
            self.mass.iter().zip(&state.v).map(|(m, v)| m * v).sum(),
            state.interface_work_j,
            self.energy_j(state) - self.energy_0_j,
        ];
        if let Some(misreport) = &self.config.misreport {
            let [first, after] = misreport.windows;
            if (first..after).contains(&window.index) {
                report[misreport.entry] = misreport.value.unwrap_or(f64::NAN);
            }
        }
        Ok(report)
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
            state_hash: crate::runs::bits_hash(self.committed.q.iter().chain(&self.committed.v)),
            ..Outcome::default()
        })
    }
}
