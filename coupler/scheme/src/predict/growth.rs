//! Growth of a disturbance under a scheme, found by running the scheme itself on a linear pair.
//!
//! A scheme on linear participants is a linear map of its state once its compliance is learnt: each unit disturbance of the
//! state is a window, its end a column of the map, and the growth a window in the long run is the spectral radius. A fixed
//! point is converged first; where its constant relaxation does not contract, its growth is that of a repeat.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{DMatrix, DVector};

use super::linear_pair::{LinearModel, LinearPair, PairState};
use super::sprung_mass::Masses;
use crate::coupling::Coupling;
use crate::error::Result;
use crate::keys::{
    Acceleration, CompliancePrior, CouplingScheme, Dirichlet, Order, Policy, Update,
};
use crate::window::InterfaceState;

/// Gap (m) to which fixed points are converged, under disturbances that move the interface by about 1 m.
const CONVERGED_M: f64 = 1e-14;

/// Repeats in which a fixed point of one unknown is converged by quasi-Newton, with plenty to spare.
const REPEATS: u32 = 50;

/// Growth a window of a scheme on two linear sides, or a repeat where the repeats of a window do not converge.
pub fn growth(scheme: &CouplingScheme, model: LinearModel) -> Result<f64> {
    match growth_of_repeats(scheme, model)? {
        Some(repeats) if repeats >= 1.0 => Ok(repeats),
        _ => Ok(spectral_radius(Probe::learnt(scheme, model)?.map()?)),
    }
}

/// Factor of the residual a repeat, of a fixed point with constant relaxation; the others find their own: one unknown takes
/// them two answers.
pub fn growth_of_repeats(scheme: &CouplingScheme, model: LinearModel) -> Result<Option<f64>> {
    let mut few = *scheme;
    let CouplingScheme::FixedPoint {
        acceleration: Acceleration::Constant,
        repeats_max,
        ..
    } = &mut few
    else {
        return Ok(None);
    };
    *repeats_max = 5;
    let mut probe = Probe::new(&few, model, 0.0);
    // No rigid motion, which would leave nothing to repeat for.
    let disturbance = DVector::from_fn(probe.size(), |i, _| 1.0 + 0.5 * (i as f64).sin());
    let pair = probe.window(&disturbance)?;
    let told = match scheme.dirichlet() {
        Dirichlet::MotionDriven => &pair.free_velocities,
        Dirichlet::ForceDriven => &pair.prescribed_velocities,
    };
    // The first answer of a parallel window is to the motion of the window before.
    let changes: Vec<f64> = told.windows(2).skip(1).map(|two| two[1] - two[0]).collect();
    Ok(Some(match changes.as_slice() {
        [first, second, ..] if *first != 0.0 => (second / first).abs(),
        _ => 0.0,
    }))
}

/// Forces (N) of `windows` windows that begin with a disturbance, by the window's map.
pub fn forces_of_map(
    scheme: &CouplingScheme,
    model: LinearModel,
    start: &Disturbance,
    windows: usize,
) -> Result<Vec<f64>> {
    let mut probe = Probe::learnt(scheme, model)?;
    let map = probe.map()?;
    let mut numbers = probe.numbers(start);
    let lambda = model.response.push.len() + 3;
    let window = |_| {
        numbers = &map * &numbers;
        numbers[lambda] * probe.units[lambda]
    };
    Ok((0..windows).map(window).collect())
}

/// A state of both sides and of the coupler between them.
#[derive(Clone, Debug)]
pub struct Disturbance {
    /// The participants.
    pub pair: PairState,
    /// The coupler.
    pub interface: InterfaceState,
}

/// The scheme with the exact compliance of the model, and a fixed point by the order and the acceleration that converge fastest:
/// the fixed point itself depends on neither. (Quasi-Newton can stall in parallel order, whose first answer is to the motion of
/// the window before and says nothing of the slope.)
fn converged(scheme: &CouplingScheme) -> CouplingScheme {
    match *scheme {
        CouplingScheme::DualSchur { update, .. } => CouplingScheme::DualSchur {
            update,
            compliance: CompliancePrior::Columns,
            repeats_max: REPEATS,
        },
        CouplingScheme::FixedPoint {
            dirichlet,
            relaxation,
            ..
        } => CouplingScheme::FixedPoint {
            order: Order::Serial,
            dirichlet,
            acceleration: Acceleration::IqnIls,
            relaxation,
            repeats_max: REPEATS,
        },
        other => other,
    }
}

/// A coupling and a pair that are put into a state, run for a window, and read.
struct Probe<'a> {
    coupling: Coupling,
    /// The coupling at the beginning of every window: with the compliance that it goes by.
    start: Coupling,
    pair: LinearPair<'a>,
    model: LinearModel<'a>,
    /// Unit of each number of the state: each moves the interface by about 1 m in a window.
    units: DVector<f64>,
    /// True if velocity and displacement of the coupler are numbers of the state; otherwise the one is not used, and the other is
    /// the continuum's.
    prescribes_velocity: bool,
}

impl<'a> Probe<'a> {
    fn new(scheme: &CouplingScheme, model: LinearModel<'a>, tolerance_m: f64) -> Probe<'a> {
        let coupling = Coupling::new("model", *scheme, Policy::Accept, model.group(tolerance_m));
        let n = model.response.push.len();
        let speed = 1.0 / model.window_s;
        let force = 1.0 / model.response.compliance();
        let continuum = (0..n).map(|i| if i < n / 2 { 1.0 } else { speed });
        let prescribes_velocity = matches!(scheme, CouplingScheme::Velocity { .. })
            || scheme.dirichlet() == Dirichlet::ForceDriven;
        // Masses (glued velocity, position, velocity), then lambda and last motion of the coupler, and its velocity and
        // displacement where the scheme goes by them.
        let mut rest = vec![speed, 1.0, speed, force, 1.0];
        if prescribes_velocity {
            rest.extend([speed, 1.0]);
        }
        Probe {
            start: coupling.clone(),
            coupling,
            pair: LinearPair::new(model, Masses::default()),
            units: DVector::from_iterator(n + rest.len(), continuum.chain(rest)),
            model,
            prescribes_velocity,
        }
    }

    fn size(&self) -> usize {
        self.units.len()
    }

    /// A converged scheme after a window in which the masses arrive with their unit velocity: the compliance at its end is the one
    /// of later windows.
    fn learnt(scheme: &CouplingScheme, model: LinearModel<'a>) -> Result<Probe<'a>> {
        let mut probe = Probe::new(&converged(scheme), model, CONVERGED_M);
        if matches!(scheme, CouplingScheme::DualSchur { update, .. } if *update != Update::None) {
            let inner = model.response.push.len();
            let mut moving = DVector::zeros(probe.size());
            moving[inner] = 1.0;
            moving[inner + 2] = 1.0;
            probe.window(&moving)?;
            probe.start = probe.coupling.clone();
        }
        Ok(probe)
    }

    /// The window as a matrix over the numbers of the state.
    fn map(&mut self) -> Result<DMatrix<f64>> {
        let size = self.size();
        let mut map = DMatrix::zeros(size, size);
        for column in 0..size {
            let mut unit = DVector::zeros(size);
            unit[column] = 1.0;
            let pair = self.window(&unit)?.state.clone();
            let interface = self.coupling.state.clone();
            let end = Disturbance { pair, interface };
            map.set_column(column, &self.numbers(&end));
        }
        Ok(map)
    }

    /// A window from the state with these numbers, in its units.
    fn window(&mut self, numbers: &DVector<f64>) -> Result<&LinearPair<'a>> {
        let state = numbers.component_mul(&self.units);
        let inner = self.model.response.push.len();
        let continuum = state.rows(0, inner).into_owned();
        let at = |k: usize| state[inner + k];
        let (velocity, displacement) = if self.prescribes_velocity {
            (at(5), at(6))
        } else {
            (0.0, self.model.response.interface.dot(&continuum))
        };
        self.pair.state = PairState {
            continuum,
            masses: Masses {
                glued_velocity: at(0),
                position: at(1),
                velocity: at(2),
            },
            position: displacement,
        };
        self.pair.free_velocities.clear();
        self.pair.prescribed_velocities.clear();
        self.coupling.clone_from(&self.start);
        self.coupling.state = InterfaceState {
            lambda: vec![at(3), 0.0],
            last_motion: vec![at(4), 0.0],
            velocity: vec![velocity, 0.0],
            displacement: vec![displacement, 0.0],
        };
        let window = self.coupling.group().clock.window(0, 0, 1);
        self.coupling.window(&mut self.pair, window, |_| None)?;
        Ok(&self.pair)
    }

    /// The numbers of a state, in its units.
    fn numbers(&self, state: &Disturbance) -> DVector<f64> {
        let Disturbance { pair, interface } = state;
        let rest = [
            pair.masses.glued_velocity,
            pair.masses.position,
            pair.masses.velocity,
            interface.lambda[0],
            interface.last_motion[0],
            interface.velocity[0],
            interface.displacement[0],
        ];
        let numbers = pair.continuum.iter().copied().chain(rest);
        let all = DVector::from_iterator(self.size(), numbers.take(self.size()));
        all.component_div(&self.units)
    }
}

/// rho = lim |M^k|^(1/k) (Gelfand 1941) with k = 2^40, by squaring. Unlike eigenvalues this is as exact for the pairs on
/// the unit circle that undamped schemes have: their rounding is divided by k as well.
pub fn spectral_radius(mut matrix: DMatrix<f64>) -> f64 {
    balance_parlett_reinsch(&mut matrix);
    let mut logarithm = 0.0;
    let mut weight = 1.0;
    for _ in 0..40 {
        let norm = matrix.norm();
        if norm == 0.0 || !norm.is_finite() {
            return norm;
        }
        matrix /= norm;
        logarithm += weight * norm.ln();
        weight *= 0.5;
        matrix = &matrix * &matrix;
    }
    logarithm.exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_radius_of_known_matrices() {
        let turn = DMatrix::from_row_slice(2, 2, &[0.6, -8.0, 0.08, 0.6]);
        assert!((spectral_radius(turn) - 1.0).abs() < 1e-12);
        let drift = DMatrix::from_row_slice(2, 2, &[1.0, 5.0, 0.0, 1.0]);
        assert!((spectral_radius(drift) - 1.0).abs() < 1e-9);
        let grows = DMatrix::from_row_slice(2, 2, &[0.5, 1e6, 0.0, 1.25]);
        assert!((spectral_radius(grows) - 1.25).abs() < 1e-9);
    }
}
