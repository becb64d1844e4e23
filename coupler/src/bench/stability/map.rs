//! Growth of a disturbance in every cell of a grid of set-ups.

use std::thread;

use protocol::BoundaryInertia;

use super::nodes::{Bar, BodyNode};
use super::trial::{Trial, Way, word};
use crate::couple::predict::operator::{Joint, Operator, Tie};
use crate::couple::predict::response::Response;
use crate::couple::predict::wall::{Masses, Wall};
use crate::couple::predict::{Choice, Facts, growth, predict, tie};
use crate::couple::scheme::CHEAP_FACTOR;
use crate::error::Error;
use crate::scenario::{Acceleration, Dirichlet, Scheme};
use nalgebra::DVector;

/// Part of the largest force to which a fixed point is repeated.
const REPEATED: f64 = 1e-9;

/// Elements of the bar.
pub const ELEMENTS: usize = 10;

/// The grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Axes {
    /// Schemes, those with roles in both of them.
    pub ways: Vec<Way>,
    /// Theta of the masses on the wall.
    pub thetas: Vec<f64>,
    /// Mass on the wall over that of the bar.
    pub mass_ratios: Vec<f64>,
    /// Steps in a window.
    pub substeps: Vec<u32>,
    /// Step over its limit.
    pub cfls: Vec<f64>,
    /// Stiffness of the spring in front of the mass over that of an element; infinite for a mass that is glued itself.
    pub stiffness_ratios: Vec<f64>,
}

impl Axes {
    /// The whole map.
    pub fn full() -> Axes {
        Axes {
            ways: vec![
                Scheme::DualSchur.into(),
                Scheme::DualSchurSecant.into(),
                Scheme::DualSchurCheap.into(),
                Scheme::StaggeredSerial.into(),
                Scheme::StaggeredParallel.into(),
                Scheme::FixedPointSerial.into(),
                Scheme::FixedPointParallel.into(),
                Scheme::Velocity.into(),
                Way::swapped(Scheme::StaggeredSerial),
                Way::swapped(Scheme::StaggeredParallel),
                Way::swapped(Scheme::FixedPointSerial),
                Way::swapped(Scheme::FixedPointParallel),
            ],
            thetas: vec![0.5, 0.55, 0.7, 1.0],
            mass_ratios: vec![1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3],
            substeps: vec![1, 3, 10, 30, 100, 1_000, 10_000],
            cfls: vec![0.1, 0.3, 0.5, 0.7, 0.9, 0.99],
            stiffness_ratios: vec![0.01, 1.0, 100.0, f64::INFINITY],
        }
    }

    /// Every scheme and the ends of every axis.
    pub fn reduced() -> Axes {
        Axes {
            thetas: vec![0.5, 1.0],
            mass_ratios: vec![1e-3, 1.0, 1e3],
            substeps: vec![1, 10, 10_000],
            cfls: vec![0.1, 0.9],
            stiffness_ratios: vec![1.0, f64::INFINITY],
            ..Axes::full()
        }
    }
}

/// One set-up and what becomes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The set-up.
    pub trial: Trial,
    /// Mass on the wall over that of the bar.
    pub mass_ratio: f64,
    /// Factor of a disturbance a window; a repeat, where the repeats of a window do not converge.
    pub growth: f64,
    /// What the handshake's numbers alone say.
    pub predicted_stable: bool,
}

/// All cells, in the order of the axes: scheme, theta, mass ratio, substeps, CFL, stiffness ratio.
pub fn map(axes: &Axes) -> Vec<Cell> {
    let bars: Vec<Vec<Response>> = axes
        .substeps
        .iter()
        .map(|m| axes.cfls.iter().map(|cfl| bar(*cfl).response(*m)).collect())
        .collect();
    let places: Vec<[usize; 6]> = (0..axes.cells()).map(|index| axes.place(index)).collect();
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let share = places.len().div_ceil(workers).max(1);
    let cell = |place: &[usize; 6]| axes.cell(place, &bars[place[3]][place[4]]);
    thread::scope(|scope| {
        let threads: Vec<_> = places
            .chunks(share)
            .map(|part| scope.spawn(move || part.iter().map(cell).collect::<Vec<_>>()))
            .collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().expect("the map does not panic"))
            .collect()
    })
}

/// The bar of a CFL number.
pub fn bar(cfl: f64) -> Bar {
    Bar {
        elements: ELEMENTS,
        step_s: cfl,
    }
}

impl Axes {
    fn lengths(&self) -> [usize; 6] {
        [
            self.ways.len(),
            self.thetas.len(),
            self.mass_ratios.len(),
            self.substeps.len(),
            self.cfls.len(),
            self.stiffness_ratios.len(),
        ]
    }

    fn cells(&self) -> usize {
        self.lengths().iter().product()
    }

    /// Index along each axis; the last one runs fastest.
    fn place(&self, index: usize) -> [usize; 6] {
        let mut place = [0; 6];
        let mut rest = index;
        for (axis, length) in self.lengths().into_iter().enumerate().rev() {
            place[axis] = rest % length;
            rest /= length;
        }
        place
    }

    fn cell(&self, place: &[usize; 6], response: &Response) -> Cell {
        let [way, theta, mass, substeps, cfl, stiffness] = *place;
        let mass_ratio = self.mass_ratios[mass];
        let trial = Trial {
            bar: bar(self.cfls[cfl]),
            substeps: self.substeps[substeps],
            way: self.ways[way],
            boundary_inertia: boundary_inertia(
                mass_ratio,
                self.stiffness_ratios[stiffness],
                self.thetas[theta],
            ),
        };
        Cell {
            trial,
            mass_ratio,
            growth: measured(&trial, response),
            predicted_stable: predicted(&trial, response),
        }
    }
}

/// A mass behind a massless glued point, as grains stand on glued disks.
pub fn boundary_inertia(mass_ratio: f64, stiffness_ratio: f64, theta: f64) -> BoundaryInertia {
    BoundaryInertia {
        glued_mass_kg: 0.0,
        mass_kg: mass_ratio * ELEMENTS as f64,
        stiffness_n_per_m: stiffness_ratio.is_finite().then_some(stiffness_ratio),
        theta,
        may_part: false,
    }
}

pub(super) fn choice(way: Way) -> Choice {
    Choice {
        scheme: way.scheme,
        dirichlet: way.dirichlet,
        acceleration: Acceleration::Constant,
        relaxation: Trial::RELAXATION,
    }
}

/// Growth under the window matrix of the bar itself.
fn measured(trial: &Trial, response: &Response) -> f64 {
    let window_s = trial.bar.step_s * f64::from(trial.substeps);
    let wall = Wall::new(&trial.whole(), window_s);
    growth(choice(trial.way), response, &wall, window_s)
}

/// What the coupler knows after the handshake: the bar by four numbers.
pub(super) fn facts(trial: &Trial, response: &Response) -> Facts {
    let window_s = trial.bar.step_s * f64::from(trial.substeps);
    Facts {
        step_s: trial.bar.step_s,
        substeps: trial.substeps,
        step_limit: Some((Bar::LIMIT_S, "stability limit".into())),
        first_period_s: Some(trial.bar.first_period_s()),
        window_limit: None,
        compliance: match trial.way.dirichlet {
            Dirichlet::Wall => response.compliance(),
            Dirichlet::Continuum => response.led_compliance(window_s),
        },
        definite: true,
        boundary_inertia: Some(trial.whole()),
    }
}

fn predicted(trial: &Trial, response: &Response) -> bool {
    let facts = facts(trial, response);
    predict(&facts, choice(trial.way)).stable() == Some(true)
}

/// How far the real coupler's forces are from those of the window matrix, over the largest so far, in the first windows
/// of a cell; infinite where only one of the two finds that a fixed point does not converge.
pub fn departure(cell: &Cell, windows: usize) -> Result<f64, Error> {
    let trial = &cell.trial;
    let response = trial.bar.response(trial.substeps);
    let expected = forces(trial, &response, windows);
    let largest = |part: &[f64]| part.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
    let repeated = matches!(
        trial.way.scheme,
        Scheme::FixedPointSerial | Scheme::FixedPointParallel
    );
    // A fixed point is as exact as its gap; the others end after one repeat whatever the gap.
    let gap_m = match repeated {
        true => REPEATED * facts(trial, &response).compliance * largest(&expected),
        false => 1e-6,
    };
    let run = trial.run(windows as u64, gap_m)?;
    let repelling = repeated && cell.growth >= 1.0 + 1e-6;
    if repelling || run.error.is_some() {
        return Ok(match repelling == run.error.is_some() {
            true => 0.0,
            false => f64::INFINITY,
        });
    }
    let apart = run.forces.iter().zip(&expected).enumerate();
    Ok(apart.fold(0.0, |most: f64, (index, (force, expected))| {
        most.max((force - expected).abs() / largest(&run.forces[..=index]))
    }))
}

/// Force (N) in each of the first windows under the window matrix.
fn forces(trial: &Trial, response: &Response, windows: usize) -> Vec<f64> {
    let window_s = trial.bar.step_s * f64::from(trial.substeps);
    let (start, whole) = (BodyNode::start(), trial.whole());
    // The point is at rest at the start, what is glued to it is not.
    let moving = match trial.boundary_inertia.stiffness_n_per_m {
        Some(_) => trial.boundary_inertia.glued_mass_kg,
        None => trial.boundary_inertia.glued_mass_kg + trial.boundary_inertia.mass_kg,
    };
    let glued = moving + trial.point_mass_kg();
    let mut joint = Joint {
        continuum: DVector::zeros(2 * ELEMENTS),
        masses: Masses {
            glued_velocity: match glued > 0.0 {
                true => start.glued_velocity * moving / glued,
                false => start.glued_velocity,
            },
            ..start
        },
        lambda: 0.0,
        motion: 0.0,
        place: 0.0,
    };
    let window = |index: usize| {
        joint = Operator {
            response,
            wall: Wall::new(&whole, window_s),
            window_s,
            tie: match trial.way.scheme {
                // It has not learnt anything yet.
                Scheme::DualSchurCheap if index == 0 => Tie::Believed(CHEAP_FACTOR),
                _ => tie(choice(trial.way)),
            },
        }
        .advance(&joint);
        joint.lambda
    };
    (0..windows).map(window).collect()
}

/// The map as CSV.
pub fn csv(cells: &[Cell]) -> String {
    let mut text = String::from(
        "scheme,theta,mass_ratio,substeps,cfl,stiffness_ratio,growth,predicted_stable,dirichlet\n",
    );
    for cell in cells {
        let boundary_inertia = &cell.trial.boundary_inertia;
        text.push_str(&format!(
            "{},{},{},{},{},{},{:.12e},{},{}\n",
            word(cell.trial.way.scheme),
            boundary_inertia.theta,
            cell.mass_ratio,
            cell.trial.substeps,
            cell.trial.bar.step_s,
            boundary_inertia.stiffness_n_per_m.unwrap_or(f64::INFINITY),
            cell.growth,
            cell.predicted_stable,
            word(cell.trial.way.dirichlet)
        ));
    }
    text
}
