//! A row of masses on a two-dimensional surface, each pressed by its share of a constant traction, glued to the wall.
//!
//! M (v - v_0) = H f - p and v = a_g + W_g p for both components of all points at once.

use kit::read_table;
use nalgebra::{DMatrix, DVector};
use protocol::{
    BoundaryAnswer, Capabilities, Description, Node, NodeError, Outcome, Role, Session, Surface,
    Term, Window,
};
use serde::Deserialize;

/// The plate's keys.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Points, in the middle of equal segments.
    pub points: usize,
    /// From x = 0 to here (m).
    pub width_m: f64,
    /// Height of the row (m).
    pub y_m: f64,
    /// Thickness (m).
    pub thickness_m: f64,
    /// Mass of the whole row (kg).
    pub mass_kg: f64,
    /// Masses of the points that are not in the equations here (kg), declared in the greeting.
    #[serde(default)]
    pub point_mass_kg: Vec<f64>,
    /// Traction on the row (Pa).
    pub traction_pa: [f64; 2],
    /// End of the run (s).
    pub end_s: f64,
}

/// The plate.
pub struct Plate {
    config: Config,
    window_s: f64,
    wall: DMatrix<f64>,
    velocity: DVector<f64>,
    trial: DVector<f64>,
    force: DVector<f64>,
    load_work_j: f64,
    interface_work_j: f64,
    loss_j: f64,
}

/// Makes a plate from a session.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: Config = read_table(&session.config)?;
    let size = 2 * config.points;
    Ok(Box::new(Plate {
        window_s: 0.0,
        wall: DMatrix::zeros(size, size),
        velocity: DVector::zeros(size),
        trial: DVector::zeros(size),
        force: DVector::zeros(size),
        load_work_j: 0.0,
        interface_work_j: 0.0,
        loss_j: 0.0,
        config,
    }))
}

impl Plate {
    fn spacing_m(&self) -> f64 {
        self.config.width_m / self.config.points as f64
    }

    fn point_mass_kg(&self) -> f64 {
        self.config.mass_kg / self.config.points as f64
    }

    fn load(&self) -> DVector<f64> {
        let area = self.spacing_m() * self.config.thickness_m;
        DVector::from_fn(2 * self.config.points, |i, _| {
            area * self.config.traction_pa[i % 2]
        })
    }
}

impl Node for Plate {
    fn describe(&self) -> Description {
        Description {
            kind: "plate".into(),
            software: "verification plate".into(),
            capabilities: Capabilities {
                rollback: true,
                compliant_boundary: true,
                rigid_boundary: true,
                ..Capabilities::default()
            },
            end_s: Some(self.config.end_s),
            point_mass_kg: match self.config.point_mass_kg.as_slice() {
                [] => Default::default(),
                masses => [("row".into(), masses.to_vec())].into(),
            },
            sets: vec!["row".into()],
            signals: vec!["fx_n".into(), "fy_n".into()],
            ledger: [
                ("interface", Role::InterfaceWork),
                ("load", Role::Work),
                ("kinetic", Role::Stored),
                ("numerical_loss", Role::Dissipated),
            ]
            .map(|(name, role)| Term {
                name: name.into(),
                role,
            })
            .to_vec(),
            ..Description::default()
        }
    }

    fn couple(&mut self, _set: &str) -> Result<Surface, NodeError> {
        let n = self.config.points;
        let spacing = self.spacing_m();
        Ok(Surface {
            x_m: (0..n)
                .map(|i| (i as f64 + 0.5) * spacing - 0.5 * self.config.width_m)
                .collect(),
            y_m: vec![self.config.y_m; n],
            mass_kg: vec![0.0; n],
            radius_m: vec![0.0; n],
            length_m: vec![spacing; n],
        })
    }

    fn select(&mut self, _points: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn set_boundary(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        self.window_s = window_s;
        let size = 2 * self.config.points;
        self.wall = DMatrix::from_column_slice(size, size, compliance);
        Ok(())
    }

    fn solve(
        &mut self,
        _window: &Window,
        free_velocity: &[f64],
    ) -> Result<BoundaryAnswer, NodeError> {
        let m = self.point_mass_kg();
        let size = self.velocity.len();
        // (1 + W m) v = a_g + W (m v_0 + H f)
        let drive = &self.velocity * m + self.load() * self.window_s;
        let right = DVector::from_column_slice(free_velocity) + &self.wall * &drive;
        let matrix = DMatrix::identity(size, size) + &self.wall * m;
        let velocity = matrix.lu().solve(&right).expect("the wall is positive");
        self.force = (&drive - &velocity * m) / self.window_s;
        self.trial = velocity;
        Ok(BoundaryAnswer {
            force: self.force.as_slice().to_vec(),
            velocity: self.trial.as_slice().to_vec(),
            iterations: 1,
            residual: 0.0,
            converged: true,
        })
    }

    fn commit(&mut self, _window: &Window, _displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        // Implicit Euler: m v (v - v_0) = m (v^2 - v_0^2) / 2 + m (v - v_0)^2 / 2.
        self.loss_j += 0.5 * self.point_mass_kg() * (&self.trial - &self.velocity).norm_squared();
        self.velocity.clone_from(&self.trial);
        self.load_work_j += self.load().dot(&self.velocity) * self.window_s;
        self.interface_work_j -= self.force.dot(&self.velocity) * self.window_s;
        let sum = |c: usize| self.force.iter().skip(c).step_by(2).sum::<f64>();
        let kinetic = 0.5 * self.point_mass_kg() * self.velocity.norm_squared();
        Ok(vec![
            sum(0),
            sum(1),
            self.interface_work_j,
            self.load_work_j,
            kinetic,
            self.loss_j,
        ])
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        Ok(Outcome {
            state_hash: crate::runs::bits_hash(self.velocity.iter()),
            ..Outcome::default()
        })
    }
}
