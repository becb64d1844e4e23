//! Growth of a disturbance under a scheme, from running the scheme itself on a linear pair.
//!
//! Once its compliance is learnt, a scheme on linear participants is a linear map of its state. A window from each unit
//! disturbance gives one column of the map, and the spectral radius is the growth per window in the long run. A fixed
//! point is converged first; if its constant relaxation does not contract, its growth is the growth of a repeat.

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

/// Gap (m) to which fixed points converge, under disturbances that move the interface by about 1 m.
const CONVERGED_M: f64 = 1e-14;

/// Repeats in which quasi-Newton converges a fixed point with one unknown, with a wide margin.
const REPEATS: u32 = 50;

/// Growth per window of a scheme on two linear sides, or per repeat where the repeats of a window do not converge.
pub fn growth(scheme: &CouplingScheme, model: LinearModel) -> Result<f64> {
    match growth_of_repeats(scheme, model)? {
        Some(repeats) if repeats >= 1.0 => Ok(repeats),
        _ => Ok(spectral_radius(Probe::learnt(scheme, model)?.map()?)),
    }
}

/// Factor of the residual per repeat, for a fixed point with constant relaxation. The other accelerations find their
/// own relaxation: with one unknown they need two answers.
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
    // Not a rigid motion, which would need no repeat.
    let disturbance = DVector::from_fn(probe.size(), |i, _| 1.0 + 0.5 * (i as f64).sin());
    let pair = probe.window(&disturbance)?;
    let velocities = match scheme.dirichlet() {
        Dirichlet::MotionDriven => &pair.free_velocities,
        Dirichlet::ForceDriven => &pair.prescribed_velocities,
    };
    // The first answer of a parallel window belongs to the motion of the previous window.
    let pairs = velocities.windows(2).skip(1);
    let changes: Vec<f64> = pairs.map(|pair| pair[1] - pair[0]).collect();
    Ok(Some(match changes.as_slice() {
        [first, second, ..] if *first != 0.0 => (second / first).abs(),
        _ => 0.0,
    }))
}

/// Forces (N) in `windows` windows after a disturbance, by the map of a window.
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

/// The scheme with the exact compliance of the model. A fixed point uses the order and the acceleration that converge
/// fastest: the solution depends on neither. (Quasi-Newton can stall in parallel order, whose first answer belongs to
/// the motion of the previous window and has no information on the slope.)
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

/// A coupling and a pair, to set a state, run a window and read the result.
struct Probe<'a> {
    coupling: Coupling,
    /// The coupling at the start of every window, with its compliance.
    start: Coupling,
    pair: LinearPair<'a>,
    model: LinearModel<'a>,
    /// Unit of each number of the state: each moves the interface by about 1 m in a window.
    units: DVector<f64>,
    /// True if the coupler's velocity and displacement belong to the state; otherwise the velocity is unused and the
    /// displacement is the continuum's.
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
        // displacement if the scheme uses them.
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

    /// A converged scheme after a window in which the masses arrive with their unit velocity; later windows use the
    /// compliance at its end.
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

    /// The map of a window as a matrix over the numbers of the state.
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

/// rho = lim |M^k|^(1/k) (Gelfand 1941) with k = 2^40, by squaring. Unlike eigenvalues it is exact for pairs on the
/// unit circle too, which undamped schemes have: their rounding is divided by k as well.
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
