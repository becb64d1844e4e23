//! Growth of a disturbance in every cell of a grid of set-ups.

use protocol::{BoundaryInertia, larger};

use super::bar::UnitBar;
use super::setup::{MOVING, StabilitySetup, keys, largest, word};
use crate::cores::on_all_cores;
use scenario::error::Error;
use scheme::keys::{CouplingScheme, Dirichlet, SchemeKeys, SchemeWord};
use scheme::predict::growth::{Disturbance, forces_of_map, growth};
use scheme::predict::linear_pair::LinearPair;
use scheme::predict::prediction::{StabilityInputs, compliance, predict};
use scheme::predict::response::Response;
use scheme::window::InterfaceState;

/// Gap of a fixed point, as a part of the largest force.
const REPEATED: f64 = 1e-9;

/// Elements of the bar.
pub const ELEMENTS: usize = 10;

/// The grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Axes {
    /// Schemes; schemes with roles in both roles.
    pub schemes: Vec<SchemeKeys>,
    /// Theta of the masses behind the boundary.
    pub thetas: Vec<f64>,
    /// Mass behind the boundary over the bar's mass.
    pub mass_ratios: Vec<f64>,
    /// Steps in a window.
    pub substeps: Vec<u32>,
    /// Step over its limit.
    pub cfls: Vec<f64>,
    /// Stiffness of the spring in front of the mass over an element's; infinite for a glued mass.
    pub stiffness_ratios: Vec<f64>,
}

/// Schemes whose sides can swap roles.
const WITH_ROLES: [SchemeWord; 4] = [
    SchemeWord::StaggeredSerial,
    SchemeWord::StaggeredParallel,
    SchemeWord::FixedPointSerial,
    SchemeWord::FixedPointParallel,
];

/// All schemes; schemes with roles in both roles.
fn all_schemes() -> Vec<SchemeKeys> {
    use SchemeWord::{DualSchur, DualSchurCheap, DualSchurSecant, Velocity};
    let words = [DualSchur, DualSchurSecant, DualSchurCheap].into_iter();
    let words = words.chain(WITH_ROLES).chain([Velocity]);
    let wall = words.map(|word| keys(word, Dirichlet::MotionDriven));
    let continuum = WITH_ROLES.map(|word| keys(word, Dirichlet::ForceDriven));
    wall.chain(continuum).collect()
}

impl Axes {
    /// The whole map.
    pub fn full() -> Axes {
        Axes {
            schemes: all_schemes(),
            thetas: vec![0.5, 0.55, 0.7, 1.0],
            mass_ratios: vec![1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3],
            substeps: vec![1, 3, 10, 30, 100, 1_000, 10_000],
            cfls: vec![0.1, 0.3, 0.5, 0.7, 0.9, 0.99],
            stiffness_ratios: vec![0.01, 1.0, 100.0, f64::INFINITY],
        }
    }
}

/// One set-up with its growth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The set-up.
    pub setup: StabilitySetup,
    /// Mass behind the boundary over the bar's mass.
    pub mass_ratio: f64,
    /// Growth factor of a disturbance per window, or per repeat if the repeats of a window do not converge.
    pub growth: f64,
    /// Prediction from the numbers of the handshake alone.
    pub predicted_stable: bool,
}

/// All cells, in the order of the axes: scheme, theta, mass ratio, substeps, CFL, stiffness ratio.
pub fn map(axes: &Axes) -> Result<Vec<Cell>, Error> {
    let cells: usize = axes.lengths().iter().product();
    let cells = on_all_cores(cells as u64, |index| axes.cell(index as usize));
    cells.into_iter().collect()
}

/// The bar with a CFL number.
pub fn bar(cfl: f64) -> UnitBar {
    UnitBar {
        elements: ELEMENTS,
        step_s: cfl,
    }
}

impl Axes {
    fn lengths(&self) -> [usize; 6] {
        [
            self.schemes.len(),
            self.thetas.len(),
            self.mass_ratios.len(),
            self.substeps.len(),
            self.cfls.len(),
            self.stiffness_ratios.len(),
        ]
    }

    /// The cell with this index; the last axis runs fastest.
    fn cell(&self, mut index: usize) -> Result<Cell, Error> {
        let mut indices = self.lengths();
        for axis in indices.iter_mut().rev() {
            let length = *axis;
            *axis = index % length;
            index /= length;
        }
        let [scheme, theta, mass, substeps, cfl, stiffness] = indices;
        let stiffness_ratio = self.stiffness_ratios[stiffness];
        let mass_ratio = self.mass_ratios[mass];
        let setup = StabilitySetup {
            bar: bar(self.cfls[cfl]),
            substeps: self.substeps[substeps],
            keys: self.schemes[scheme],
            boundary_inertia: boundary_inertia(mass_ratio, stiffness_ratio, self.thetas[theta]),
        };
        let response = setup.response();
        let predicted = predict(&inputs(&setup, &response), &setup.keys.scheme())?;
        Ok(Cell {
            setup,
            mass_ratio,
            growth: growth(&setup.keys.scheme(), setup.model(&response))?,
            predicted_stable: predicted.stable() == Some(true),
        })
    }
}

/// A mass behind a massless glued point, like grains on glued disks.
pub fn boundary_inertia(mass_ratio: f64, stiffness_ratio: f64, theta: f64) -> BoundaryInertia {
    BoundaryInertia {
        glued_mass_kg: 0.0,
        mass_kg: mass_ratio * ELEMENTS as f64,
        stiffness_n_per_m: stiffness_ratio.is_finite().then_some(stiffness_ratio),
        theta,
        may_part: false,
    }
}

/// The coupler's inputs after the handshake, which describes the bar by four numbers.
pub(super) fn inputs(setup: &StabilitySetup, response: &Response) -> StabilityInputs {
    StabilityInputs {
        clock: setup.clock(),
        step_limit: Some((UnitBar::LIMIT_S, "stability limit".into())),
        first_period_s: Some(setup.bar.first_period_s()),
        window_limit: None,
        accuracy_limits: Vec::new(),
        compliance: compliance(&setup.keys.scheme(), response, setup.clock().window_s()),
        definite: true,
        boundary_inertia: Some(setup.boundary_inertia),
        point_mass_kg: setup.point_mass_kg(),
    }
}

/// Distance between the forces of a run and of the window matrix, over the largest force so far, in the first windows of a cell. Infinite
/// if only one of them finds that a fixed point does not converge.
pub fn departure(cell: &Cell, windows: usize) -> Result<f64, Error> {
    let setup = &cell.setup;
    let response = setup.response();
    let repeated = matches!(setup.keys.scheme(), CouplingScheme::FixedPoint { .. });
    let model = setup.model(&response);
    let start = Disturbance {
        pair: LinearPair::new(model, MOVING).state,
        interface: InterfaceState::at_rest(1, 1),
    };
    let predicted = forces_of_map(&setup.keys.scheme(), model, &start, windows)?;
    // A fixed point is as exact as its gap; the other schemes end after one repeat for any gap.
    let gap_m = if repeated {
        REPEATED * inputs(setup, &response).compliance * largest(&predicted)
    } else {
        1e-6
    };
    let run = setup.run(&response, windows as u64, gap_m);
    let repelling = repeated && cell.growth >= 1.0 + 1e-6;
    let both_run = !repelling && run.error.is_none();
    let Some(start) = run.after_first.filter(|_| both_run) else {
        let agree = repelling == run.error.is_some();
        return Ok(if agree { 0.0 } else { f64::INFINITY });
    };
    // From the end of the first window, when a learnt compliance is known.
    let expected = forces_of_map(&setup.keys.scheme(), model, &start, windows - 1)?;
    let apart = run.forces.iter().skip(1).zip(&expected).enumerate();
    Ok(apart.fold(0.0, |most, (index, (force, expected))| {
        let off = (force - expected).abs();
        larger(most, off / largest(&run.forces[..=index + 1]))
    }))
}

/// The map as CSV.
pub fn csv(cells: &[Cell]) -> String {
    let mut text = String::from(
        "scheme,theta,mass_ratio,substeps,cfl,stiffness_ratio,growth,predicted_stable,dirichlet\n",
    );
    for cell in cells {
        let inertia = &cell.setup.boundary_inertia;
        text.push_str(&format!(
            "{},{},{},{},{},{},{:.12e},{},{}\n",
            word(cell.setup.keys.scheme),
            inertia.theta,
            cell.mass_ratio,
            cell.setup.substeps,
            cell.setup.bar.step_s,
            inertia.stiffness_n_per_m.unwrap_or(f64::INFINITY),
            cell.growth,
            cell.predicted_stable,
            word(cell.setup.keys.dirichlet())
        ));
    }
    text
}
