//! A linear continuum in one interface motion: its window as matrices, and the elastic bar that answers as it does.

use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector, Matrix3};

/// x' = A x + B lambda over one window, and the interface displacement R x; x holds displacements and velocities.
/// The increment is du = R (A - 1) x + C lambda with the compliance C = R B.
#[derive(Clone, Debug)]
pub struct Response {
    /// A.
    pub carry: DMatrix<f64>,
    /// B (1/N).
    pub push: DVector<f64>,
    /// R.
    pub place: DVector<f64>,
    /// The same with a velocity that is given instead of a force.
    pub prescribed: PrescribedResponse,
}

impl Response {
    /// C (m/N).
    pub fn compliance(&self) -> f64 {
        self.place.dot(&self.push)
    }

    /// H D^-1 (m/N) with the force D v at the end of a window in which the velocity goes from rest to v.
    pub fn prescribed_compliance(&self, window_s: f64) -> f64 {
        let rest = DVector::zeros(self.push.len());
        let (_, resists) = self.prescribed.window(&rest, 1.0);
        window_s * window_s / resists
    }

    /// Velocity of the interface (m/s).
    pub fn speed(&self, state: &DVector<f64>) -> f64 {
        let half = state.len() / 2;
        self.place.rows(0, half).dot(&state.rows(half, half))
    }
}

/// A window in which the interface has a constant acceleration a: x' = A x + B a, and the force that this takes at the end,
/// mass a + pull.x'. The whole window is made when it is first asked for: few schemes do.
#[derive(Clone, Debug)]
pub struct PrescribedResponse {
    step: DMatrix<f64>,
    substeps: u32,
    /// Mass of the interface itself (kg).
    mass: f64,
    /// Internal force of the interface (N/m).
    pull: DVector<f64>,
    window: OnceLock<DMatrix<f64>>,
}

impl PrescribedResponse {
    /// Of one step as a matrix over (x, a), `substeps` of which are a window.
    pub fn new(
        step: DMatrix<f64>,
        substeps: u32,
        mass: f64,
        pull: DVector<f64>,
    ) -> PrescribedResponse {
        PrescribedResponse {
            step,
            substeps,
            mass,
            pull,
            window: OnceLock::new(),
        }
    }

    /// The state at the end of a window and the force there (N).
    pub fn window(&self, start: &DVector<f64>, acceleration: f64) -> (DVector<f64>, f64) {
        let whole = || matrix_power(&self.step, self.substeps);
        let window = self.window.get_or_init(whole);
        let inner = start.len();
        let state = window.view((0, 0), (inner, inner)) * start
            + window.column(inner).rows(0, inner) * acceleration;
        let force = self.mass * acceleration + self.pull.dot(&state);
        (state, force)
    }
}

/// A matrix to a whole power, by squaring.
pub fn matrix_power(base: &DMatrix<f64>, mut exponent: u32) -> DMatrix<f64> {
    let mut base = base.clone();
    let mut result = DMatrix::identity(base.nrows(), base.ncols());
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = &base * result;
        }
        base = &base * &base;
        exponent >>= 1;
    }
    result
}

/// A uniform elastic bar, held at its far end and coupled at the other: lumped masses, explicit steps.
///
/// Its modes are known in closed form: with n elements, omega_j = omega_max sin((2j - 1) pi / (4n)), and every mode
/// takes the same share of a force on the end, u_j'' = -omega_j^2 u_j + share lambda with u = sum u_j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Elements.
    pub elements: usize,
    /// The upper bound of its frequencies (1/s).
    pub omega_max: f64,
    /// What a mode takes of a force: 2 over the mass of the bar (1/kg).
    pub share: f64,
}

/// An explicit step: its length and Newmark's gamma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Length (s).
    pub step_s: f64,
    /// 0.5 to 1; 0.5 dissipates nothing.
    pub damping: f64,
}

/// Elements of an equivalent bar are kept below this: its operator is full, and more of them do not move a limit.
const ELEMENTS_MAX: usize = 40;

impl Bar {
    /// The bar that answers as a continuum does, as far as a handshake tells: with the highest frequency of its step limit (the
    /// one of an undamped step, 2/omega_max, which errs to the stiff side), its first period, and its compliance
    /// (m/N) over a window of `substeps`, which `measure` reads off a response.
    pub fn equivalent(
        step: Step,
        substeps: u32,
        limit_s: f64,
        period_s: Option<f64>,
        compliance: f64,
        measure: impl Fn(&Response) -> f64,
    ) -> Bar {
        let omega_max = 2.0 / limit_s;
        // Without a period: a bar that no wave returns from within two windows.
        let window_s = step.step_s * f64::from(substeps);
        let period_s = period_s.unwrap_or(8.0 * window_s.max(limit_s));
        let ratio = (2.0 * std::f64::consts::PI / (period_s * omega_max)).min(0.7);
        let elements = (std::f64::consts::FRAC_PI_4 / ratio.asin()).round() as usize;
        let unit = Bar {
            elements: elements.clamp(1, ELEMENTS_MAX),
            omega_max,
            share: 1.0,
        };
        Bar {
            share: compliance / measure(&unit.response(step, substeps)),
            ..unit
        }
    }

    /// Its window of `substeps` steps, mode by mode.
    pub fn response(&self, step: Step, substeps: u32) -> Response {
        let n = self.elements;
        let mut carry = DMatrix::zeros(2 * n, 2 * n);
        let mut push = DVector::zeros(2 * n);
        let mut place = DVector::zeros(2 * n);
        for j in 0..n {
            let angle = (2 * j + 1) as f64 * std::f64::consts::PI / (4 * n) as f64;
            let window = power(self.mode(self.omega_max * angle.sin(), step), substeps);
            for row in 0..2 {
                for column in 0..2 {
                    carry[(j + row * n, j + column * n)] = window[(row, column)];
                }
                push[j + row * n] = window[(row, 2)];
            }
            place[j] = 1.0;
        }
        Response {
            carry,
            push,
            place,
            prescribed: self.prescribed(step, substeps),
        }
    }

    /// The interface is the sum q of the modes; the force for q'' = a is f = (a + sum omega_j^2 u_j) / (n share), of which
    /// every mode takes the n-th part.
    fn prescribed(&self, step: Step, substeps: u32) -> PrescribedResponse {
        let n = self.elements;
        let modes = n as f64;
        let squares: Vec<f64> = (0..n)
            .map(|j| {
                let angle = (2 * j + 1) as f64 * std::f64::consts::PI / (4 * n) as f64;
                (self.omega_max * angle.sin()).powi(2)
            })
            .collect();
        // Accelerations over (u, v, a).
        let mut a = DMatrix::zeros(n, 2 * n + 1);
        for j in 0..n {
            for (k, square) in squares.iter().enumerate() {
                a[(j, k)] = square / modes;
            }
            a[(j, j)] -= squares[j];
            a[(j, 2 * n)] = 1.0 / modes;
        }
        let mass = 1.0 / (modes * self.share);
        let pull = (0..2 * n).map(|j| squares.get(j).map_or(0.0, |square| mass * square));
        PrescribedResponse::new(
            prescribed_step(&a, step),
            substeps,
            mass,
            DVector::from_iterator(2 * n, pull),
        )
    }

    /// One step of one mode on (u, v, lambda): u += h v + h^2/2 a, v += h ((1 - b) a + b a').
    fn mode(&self, omega: f64, step: Step) -> Matrix3<f64> {
        let (h, b) = (step.step_s, step.damping);
        let before = [-omega * omega, 0.0, self.share];
        let moved = [0, 1, 2].map(|k| [1.0, h, 0.0][k] + 0.5 * h * h * before[k]);
        let after = [0, 1, 2].map(|k| [0.0, 0.0, self.share][k] - omega * omega * moved[k]);
        let sped =
            [0, 1, 2].map(|k| [0.0, 1.0, 0.0][k] + h * ((1.0 - b) * before[k] + b * after[k]));
        Matrix3::from_row_slice(&[
            moved[0], moved[1], moved[2], sped[0], sped[1], sped[2], 0.0, 0.0, 1.0,
        ])
    }
}

/// u' = u + h v + h^2/2 a, v' = v + h ((1 - b) a + b a') as a matrix over (u, v, acceleration of the interface), from the
/// accelerations a over the same.
fn prescribed_step(a: &DMatrix<f64>, step: Step) -> DMatrix<f64> {
    let (h, b) = (step.step_s, step.damping);
    let (n, size) = a.shape();
    let mut step = DMatrix::identity(size, size);
    let moved = step.rows(0, n) + step.rows(n, n) * h + a * (0.5 * h * h);
    step.rows_mut(0, n).copy_from(&moved);
    let before = a.clone();
    let after = a * &step;
    let sped = step.rows(n, n) + before * (h * (1.0 - b)) + (after * (h * b));
    step.rows_mut(n, n).copy_from(&sped);
    step
}

fn power(mut base: Matrix3<f64>, mut exponent: u32) -> Matrix3<f64> {
    let mut result = Matrix3::identity();
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = base * result;
        }
        base *= base;
        exponent >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// C(1) = h^2 / (2 m): the end node of a bar of ten elements of 1 kg has 0.5 kg.
    #[test]
    fn one_step_moves_the_end_node_alone() {
        let bar = Bar {
            elements: 10,
            omega_max: 2.0,
            share: 2.0 / 10.0,
        };
        let step = Step {
            step_s: 0.7,
            damping: 0.5,
        };
        let compliance = bar.response(step, 1).compliance();
        assert!((compliance - 0.49).abs() < 1e-14, "{compliance}");
    }

    /// What a handshake tells of such a bar gives the bar back.
    #[test]
    fn the_equivalent_of_a_bar_is_itself() {
        let bar = Bar {
            elements: 10,
            omega_max: 2.0,
            share: 0.2,
        };
        let step = Step {
            step_s: 0.9,
            damping: 0.5,
        };
        let period = 2.0 * std::f64::consts::PI / (2.0 * (std::f64::consts::PI / 40.0).sin());
        for substeps in [1, 7, 1000] {
            let window_s = step.step_s * f64::from(substeps);
            let own = bar.response(step, substeps);
            let free = |response: &Response| response.compliance();
            let found = Bar::equivalent(step, substeps, 1.0, Some(period), free(&own), free);
            assert_eq!(found.elements, 10);
            assert!((found.share / bar.share - 1.0).abs() < 1e-9);
            let led = |response: &Response| response.prescribed_compliance(window_s);
            let found = Bar::equivalent(step, substeps, 1.0, Some(period), led(&own), led);
            assert!((found.share / bar.share - 1.0).abs() < 1e-9);
        }
    }
}
