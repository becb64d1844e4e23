//! One window of each scheme as a matrix, written by hand for a linear continuum and a linear wall: the reference for the schemes
//! themselves.
//!
//! The two sides are closed forms of [`scheme::predict`]; this module does not use the schemes.

use nalgebra::DMatrix;
use nalgebra::DVector;

use scheme::predict::growth::spectral_radius;
use scheme::predict::response::Response;
use scheme::predict::sprung_mass::{Masses, Motion, Solved, SprungMass};

/// The transmission condition of a scheme, its only distinction for a linear continuum and a linear wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransmissionCondition {
    /// Under the force of a window both sides end in the same place: the exact and secant dual Schur schemes and a converged
    /// fixed point.
    Exact,
    /// One solve on a compliance that is this many times the true one.
    Believed(f64),
    /// The force acts one window late.
    LateForce,
    /// Force and motion act one window late.
    LateBoth,
    /// The velocity changes linearly to a value at which the force at the end equals the wall's.
    Velocity,
    /// The continuum follows the velocity of the wall one window late, and the wall takes the resulting force.
    LateVelocity,
    /// Velocity and force reach the other side one window late.
    LateVelocityAndForce,
}

/// Both sides and the coupler's state between windows.
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
    /// Position of the interface on the wall's side (m).
    pub position: f64,
}

/// A continuum and a wall, joined.
#[derive(Clone, Debug)]
pub struct Operator<'a> {
    /// The continuum's window.
    pub response: &'a Response,
    /// The wall's window.
    pub wall: SprungMass,
    /// Length of the window (s).
    pub window_s: f64,
    /// The scheme.
    pub condition: TransmissionCondition,
}

impl Operator<'_> {
    /// One window.
    pub fn advance(&self, start: &Joint) -> Joint {
        let Response {
            carry,
            push,
            interface,
            ..
        } = self.response;
        let (h, c) = (self.window_s, self.response.compliance());
        let coasted = carry * &start.continuum;
        let q_0 = interface.dot(&start.continuum);
        // The increment without a force in the window.
        let free = interface.dot(&coasted) - q_0;
        let rigid = |du: f64| Motion {
            free: du / h,
            compliance: 0.0,
        };
        let motion = match self.condition {
            TransmissionCondition::Exact => Motion {
                free: free / h,
                compliance: c / (h * h),
            },
            TransmissionCondition::Believed(factor) => Motion {
                free: (free + (1.0 - factor) * c * start.lambda) / h,
                compliance: factor * c / (h * h),
            },
            TransmissionCondition::LateForce => rigid(free + c * start.lambda),
            TransmissionCondition::LateBoth => rigid(start.motion),
            TransmissionCondition::Velocity => return self.led(start),
            TransmissionCondition::LateVelocity | TransmissionCondition::LateVelocityAndForce => {
                return self.pushed(start);
            }
        };
        let solved = self.wall.window(&start.masses, q_0, motion);
        let acting = match self.condition {
            TransmissionCondition::Exact | TransmissionCondition::Believed(_) => solved.force,
            _ => start.lambda,
        };
        let continuum = coasted + push * acting;
        Joint {
            position: interface.dot(&continuum),
            continuum,
            masses: solved.masses,
            lambda: solved.force,
            motion: free + c * acting,
        }
    }

    /// One window with a linear velocity: under the acceleration a the continuum answers
    /// lambda_0 + S a = lambda_0 + (S / H) (v - v_0).
    fn led(&self, start: &Joint) -> Joint {
        let (h, response) = (self.window_s, self.response);
        let v_0 = response.speed(&start.continuum);
        let (_, lambda_0) = response.prescribed(&start.continuum, 0.0);
        let (_, resists) = response.prescribed(&DVector::zeros(start.continuum.len()), 1.0);
        let motion = Motion {
            free: v_0 - h * lambda_0 / resists,
            compliance: 1.0 / resists,
        };
        let solved = self.wall.window(&start.masses, start.position, motion);
        let v = solved.masses.glued_velocity;
        let (continuum, _) = response.prescribed(&start.continuum, (v - v_0) / h);
        Joint {
            continuum,
            masses: solved.masses,
            lambda: solved.force,
            motion: h * v,
            position: start.position + h * v,
        }
    }

    /// One window in which the continuum reaches the velocity that the wall had, and the wall carries its force.
    fn pushed(&self, start: &Joint) -> Joint {
        let (h, response) = (self.window_s, self.response);
        let v_0 = response.speed(&start.continuum);
        let (continuum, lambda) =
            response.prescribed(&start.continuum, (start.motion / h - v_0) / h);
        let borne = match self.condition {
            TransmissionCondition::LateVelocityAndForce => start.lambda,
            _ => lambda,
        };
        let solved = pushed(&self.wall, start, h, h * borne);
        let motion = h * solved.masses.glued_velocity;
        Joint {
            continuum,
            masses: solved.masses,
            lambda,
            motion,
            position: start.position + motion,
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
        spectral_radius(matrix)
    }
}

fn pack(joint: &Joint) -> DVector<f64> {
    let masses = &joint.masses;
    let rest = [
        masses.glued_velocity,
        masses.position,
        masses.velocity,
        joint.lambda,
        joint.motion,
        joint.position,
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
            position: packed[inner + 1],
            velocity: packed[inner + 2],
        },
        lambda: packed[inner + 3],
        motion: packed[inner + 4],
        position: packed[inner + 5],
    }
}

/// The masses under an impulse p (N s) on the freely moving wall. They obey A v_g + p = R; two imposed motions give A and R.
fn pushed(wall: &SprungMass, start: &Joint, window_s: f64, p: f64) -> Solved {
    let imposed = |free: f64| {
        let rigid = Motion {
            free,
            compliance: 0.0,
        };
        wall.window(&start.masses, start.position, rigid)
    };
    let drive = window_s * imposed(0.0).force;
    let inertia = drive - window_s * imposed(1.0).force;
    imposed((drive - p) / inertia)
}
