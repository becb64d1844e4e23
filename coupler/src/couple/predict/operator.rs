//! One window of a scheme as a linear map, and how fast it lets a disturbance grow.

use nalgebra::DMatrix;
use nalgebra::DVector;
use nalgebra::linalg::balancing::balance_parlett_reinsch;

use super::response::Response;
use super::wall::{Masses, Motion, Wall};

/// What distinguishes the schemes for a linear continuum and a linear wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tie {
    /// The force of a window is the one under which both sides end in the same place: what the exact and secant dual Schur
    /// schemes and a converged fixed point come to.
    Exact,
    /// One solve on a compliance that is this many times the true one.
    Believed(f64),
    /// The force acts one window late.
    LateForce,
    /// Force and motion act one window late.
    LateBoth,
    /// The velocity goes in a straight line to one at which the force at the end is that of the wall.
    Velocity,
    /// The continuum follows the velocity of the wall one window late, the wall takes the force of that.
    LateVelocity,
    /// Velocity and force reach the other side one window late.
    LateVelocityAndForce,
}

/// Both sides and what the coupler keeps between windows.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// The continuum's displacements and velocities.
    pub continuum: DVector<f64>,
    /// The masses on the wall.
    pub masses: Masses,
    /// Force of the last window (N).
    pub lambda: f64,
    /// Motion of the interface in the last window (m).
    pub motion: f64,
    /// Where the wall takes the interface to be (m).
    pub place: f64,
}

/// A continuum and a wall, joined.
#[derive(Clone, Debug)]
pub struct Operator<'a> {
    /// The continuum's window.
    pub response: &'a Response,
    /// The wall's.
    pub wall: Wall,
    /// Length of the window (s).
    pub window_s: f64,
    /// The scheme.
    pub tie: Tie,
}

impl Operator<'_> {
    /// One window.
    pub fn advance(&self, start: &Joint) -> Joint {
        let Response {
            carry, push, place, ..
        } = self.response;
        let (h, c) = (self.window_s, self.response.compliance());
        let coasted = carry * &start.continuum;
        let q_0 = place.dot(&start.continuum);
        // The increment without any force in the window.
        let free = place.dot(&coasted) - q_0;
        let rigid = |du: f64| Motion {
            free: du / h,
            compliance: 0.0,
        };
        let motion = match self.tie {
            Tie::Exact => Motion {
                free: free / h,
                compliance: c / (h * h),
            },
            Tie::Believed(factor) => Motion {
                free: (free + (1.0 - factor) * c * start.lambda) / h,
                compliance: factor * c / (h * h),
            },
            Tie::LateForce => rigid(free + c * start.lambda),
            Tie::LateBoth => rigid(start.motion),
            Tie::Velocity => return self.led(start),
            Tie::LateVelocity | Tie::LateVelocityAndForce => return self.pushed(start),
        };
        let solved = self.wall.window(&start.masses, q_0, motion);
        let acting = match self.tie {
            Tie::Exact | Tie::Believed(_) => solved.force,
            _ => start.lambda,
        };
        let continuum = coasted + push * acting;
        Joint {
            place: place.dot(&continuum),
            continuum,
            masses: solved.masses,
            lambda: solved.force,
            motion: free + c * acting,
        }
    }

    /// One window along a straight line of velocities: with the acceleration a the continuum answers
    /// lambda_0 + S a = lambda_0 + (S / H) (v - v_0).
    fn led(&self, start: &Joint) -> Joint {
        let (h, lead) = (self.window_s, &self.response.lead);
        let v_0 = self.response.speed(&start.continuum);
        let (_, lambda_0) = lead.window(&start.continuum, 0.0);
        let (_, resists) = lead.window(&DVector::zeros(start.continuum.len()), 1.0);
        let motion = Motion {
            free: v_0 - h * lambda_0 / resists,
            compliance: 1.0 / resists,
        };
        let solved = self.wall.window(&start.masses, start.place, motion);
        let v = solved.masses.glued_velocity;
        let (continuum, _) = lead.window(&start.continuum, (v - v_0) / h);
        Joint {
            continuum,
            masses: solved.masses,
            lambda: solved.force,
            motion: h * v,
            place: start.place + h * v,
        }
    }

    /// One window in which the continuum goes to the velocity that the wall had, and the wall bears its force.
    fn pushed(&self, start: &Joint) -> Joint {
        let (h, lead) = (self.window_s, &self.response.lead);
        let v_0 = self.response.speed(&start.continuum);
        let (continuum, lambda) = lead.window(&start.continuum, (start.motion / h - v_0) / h);
        let borne = match self.tie {
            Tie::LateVelocityAndForce => start.lambda,
            _ => lambda,
        };
        let solved = self.wall.pushed(&start.masses, start.place, h * borne);
        let motion = h * solved.masses.glued_velocity;
        Joint {
            continuum,
            masses: solved.masses,
            lambda,
            motion,
            place: start.place + motion,
        }
    }

    /// The largest factor by which a window multiplies a disturbance in the long run: the spectral radius.
    pub fn growth(&self) -> f64 {
        let inner = self.response.push.len();
        let size = inner + 6;
        let mut matrix = DMatrix::zeros(size, size);
        for column in 0..size {
            let mut unit = DVector::zeros(size);
            unit[column] = 1.0;
            let end = pack(&self.advance(&unpack(&unit)));
            matrix.set_column(column, &end);
        }
        radius(matrix)
    }
}

fn pack(joint: &Joint) -> DVector<f64> {
    let masses = &joint.masses;
    let rest = [
        masses.glued_velocity,
        masses.place,
        masses.velocity,
        joint.lambda,
        joint.motion,
        joint.place,
    ];
    DVector::from_iterator(
        joint.continuum.len() + rest.len(),
        joint.continuum.iter().copied().chain(rest),
    )
}

fn unpack(packed: &DVector<f64>) -> Joint {
    let inner = packed.len() - 6;
    Joint {
        continuum: packed.rows(0, inner).into_owned(),
        masses: Masses {
            glued_velocity: packed[inner],
            place: packed[inner + 1],
            velocity: packed[inner + 2],
        },
        lambda: packed[inner + 3],
        motion: packed[inner + 4],
        place: packed[inner + 5],
    }
}

/// rho = lim |M^k|^(1/k) (Gelfand 1941) with k = 2^40, by squaring. Unlike eigenvalues this is as exact for the pairs on
/// the unit circle that undamped schemes have: their rounding is divided by k as well.
fn radius(mut matrix: DMatrix<f64>) -> f64 {
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
        assert!((radius(turn) - 1.0).abs() < 1e-12);
        let drift = DMatrix::from_row_slice(2, 2, &[1.0, 5.0, 0.0, 1.0]);
        assert!((radius(drift) - 1.0).abs() < 1e-9);
        let grows = DMatrix::from_row_slice(2, 2, &[0.5, 1e6, 0.0, 1.25]);
        assert!((radius(grows) - 1.25).abs() < 1e-9);
    }
}
