//! Coupling of the bar and the masses, window by window.

use protocol::{BoundaryInertia, larger};

use super::bar::UnitBar;
use scheme::clock::Clock;
use scheme::coupling::Coupling;
use scheme::error::SchemeError;
use scheme::keys::{Acceleration, Dirichlet, Policy, SchemeKeys, SchemeWord};
use scheme::predict::growth::Disturbance;
use scheme::predict::linear_pair::{LinearModel, LinearPair};
use scheme::predict::response::Response;
use scheme::predict::sprung_mass::Masses;

/// One set-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilitySetup {
    /// The continuum.
    pub bar: UnitBar,
    /// Steps in a window.
    pub substeps: u32,
    /// The scheme; a fixed point has the constant relaxation [`RELAXATION`].
    pub keys: SchemeKeys,
    /// The masses behind the boundary.
    pub boundary_inertia: BoundaryInertia,
}

/// Constant relaxation of the fixed-point schemes.
pub const RELAXATION: f64 = 0.5;
/// Mass of the point over the mass behind it; a force-driven point announces it.
const POINT: f64 = 0.01;

/// Masses that arrive with 1 m/s.
pub const MOVING: Masses = Masses {
    glued_velocity: 1.0,
    position: 0.0,
    velocity: 1.0,
};

/// A scheme of the bench, in which this side is driven by motion.
pub fn keys(word: SchemeWord, dirichlet: Dirichlet) -> SchemeKeys {
    SchemeKeys {
        dirichlet: Some(dirichlet),
        acceleration: Some(Acceleration::Constant),
        relaxation: Some(RELAXATION),
        repeats_max: Some(4000),
        ..SchemeKeys::of(word)
    }
}

/// The windows of a run.
#[derive(Debug, Default)]
pub struct StabilityRun {
    /// Interface force (N) in each accepted window.
    pub forces: Vec<f64>,
    /// State of both sides after the first window.
    pub after_first: Option<Disturbance>,
    /// Reason of an early end.
    pub error: Option<SchemeError>,
}

impl StabilitySetup {
    /// Mass of the point (kg); 0 if it is driven by motion.
    pub fn point_mass_kg(&self) -> f64 {
        match self.keys.dirichlet() {
            Dirichlet::MotionDriven => 0.0,
            Dirichlet::ForceDriven => POINT * self.boundary_inertia.mass_kg,
        }
    }

    /// The steps of a window.
    pub fn clock(&self) -> Clock {
        Clock {
            step_s: self.bar.step_s,
            substeps: self.substeps,
        }
    }

    /// The bar's window as matrices.
    pub fn response(&self) -> Response {
        self.bar.response(self.substeps)
    }

    /// The bar, as matrices of its window, with the masses.
    pub fn model<'a>(&self, response: &'a Response) -> LinearModel<'a> {
        LinearModel {
            response,
            inertia: self.boundary_inertia,
            point_mass_kg: self.point_mass_kg(),
            window_s: self.clock().window_s(),
        }
    }

    /// Runs windows to a gap (m), with masses that start at 1 m/s.
    pub fn run(&self, response: &Response, windows: u64, gap_m: f64) -> StabilityRun {
        let model = self.model(response);
        let (scheme, group) = (self.keys.scheme(), model.group(gap_m));
        let mut coupling = Coupling::new("glue", scheme, Policy::Stop, group);
        let mut pair = LinearPair::new(model, MOVING);
        let mut run = StabilityRun::default();
        for index in 0..windows {
            let window = coupling.group().clock.window(index, index, 1);
            match coupling.window(&mut pair, window, |_| None) {
                Ok(_) => run.forces.push(coupling.state.lambda[0]),
                Err(error) => {
                    run.error = Some(error);
                    break;
                }
            }
            let after = || Disturbance {
                pair: pair.state.clone(),
                interface: coupling.state.clone(),
            };
            run.after_first.get_or_insert_with(after);
        }
        run
    }
}

/// The largest |f|.
pub fn largest(forces: &[f64]) -> f64 {
    forces.iter().map(|f| f.abs()).fold(0.0, larger)
}

/// The word for a choice in a scenario.
pub fn word(choice: impl serde::Serialize) -> String {
    let word = serde_json::to_value(choice).expect("choices are words");
    word.as_str().expect("choices are words").to_string()
}
