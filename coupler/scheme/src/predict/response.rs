//! A linear continuum in one interface motion: its window as matrices, and the equivalent elastic bar.

use std::f64::consts::{FRAC_PI_4, PI};
use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector};

/// x' = A x + B lambda over one window, with the interface displacement R x; x holds displacements and velocities. The
/// increment is du = R (A - 1) x + C lambda with the compliance C = R B.
#[derive(Clone, Debug)]
pub struct Response {
    /// A.
    pub carry: DMatrix<f64>,
    /// B (1/N).
    pub push: DVector<f64>,
    /// R: extracts the interface displacement from a state.
    pub interface: DVector<f64>,
    /// Mass of the interface itself (kg).
    mass_kg: f64,
    /// Internal force of the interface (N/m).
    pull: DVector<f64>,
    substeps: u32,
    /// One step over (x, a) with a given acceleration a of the interface.
    prescribed_step: DMatrix<f64>,
    /// The window of such steps, made on first use: few schemes need it.
    prescribed_window: OnceLock<DMatrix<f64>>,
}

impl Response {
    /// `substeps` explicit steps of u'' = K u + b lambda with the interface displacement r.u. If r.u'' = a is given
    /// instead, it requires the force lambda = m a + pull.u with m = 1 / (r.b) and pull = -m K^T r.
    pub fn new(
        step_s: f64,
        substeps: u32,
        k: &DMatrix<f64>,
        b: &DVector<f64>,
        r: &DVector<f64>,
    ) -> Response {
        let size = 2 * r.len();
        let mass_kg = 1.0 / r.dot(b);
        let pull = k.tr_mul(r) * -mass_kg;
        let window = matrix_power(&one_step(step_s, k, b), substeps);
        Response {
            carry: window.view((0, 0), (size, size)).into_owned(),
            push: window.column(size).rows(0, size).into_owned(),
            interface: r.clone().resize_vertically(size, 0.0),
            mass_kg,
            substeps,
            prescribed_step: one_step(step_s, &(k + b * pull.transpose()), &(b * mass_kg)),
            prescribed_window: OnceLock::new(),
            pull: pull.resize_vertically(size, 0.0),
        }
    }

    /// C (m/N).
    pub fn compliance(&self) -> f64 {
        self.interface.dot(&self.push)
    }

    /// H D^-1 (m/N), with the force D v at the end of a window in which the velocity rises linearly from zero to v.
    pub fn prescribed_compliance(&self, window_s: f64) -> f64 {
        let (_, resists) = self.prescribed(&DVector::zeros(self.push.len()), 1.0);
        window_s * window_s / resists
    }

    /// Velocity of the interface (m/s).
    pub fn speed(&self, state: &DVector<f64>) -> f64 {
        let half = state.len() / 2;
        self.interface.rows(0, half).dot(&state.rows(half, half))
    }

    /// The state at the end of a window with a constant acceleration of the interface (m/s^2), and the force there (N).
    pub fn prescribed(&self, start: &DVector<f64>, acceleration: f64) -> (DVector<f64>, f64) {
        let whole = || matrix_power(&self.prescribed_step, self.substeps);
        let window = self.prescribed_window.get_or_init(whole);
        let size = start.len();
        let state = window.view((0, 0), (size, size)) * start
            + window.column(size).rows(0, size) * acceleration;
        let force = self.mass_kg * acceleration + self.pull.dot(&state);
        (state, force)
    }
}

/// u' = u + h v + h^2/2 a, v' = v + h/2 (a + a') with a = K u + b f, as a matrix over (u, v, f).
fn one_step(h: f64, k: &DMatrix<f64>, b: &DVector<f64>) -> DMatrix<f64> {
    let n = b.len();
    let mut a = k.clone().resize_horizontally(2 * n + 1, 0.0);
    a.set_column(2 * n, b);
    let mut step = DMatrix::identity(2 * n + 1, 2 * n + 1);
    let moved = step.rows(0, n) + step.rows(n, n) * h + &a * (0.5 * h * h);
    step.rows_mut(0, n).copy_from(&moved);
    let sped = step.rows(n, n) + (&a + &a * &step) * (0.5 * h);
    step.rows_mut(n, n).copy_from(&sped);
    step
}

/// An integer power of a matrix, by squaring.
fn matrix_power(base: &DMatrix<f64>, mut exponent: u32) -> DMatrix<f64> {
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

/// A uniform elastic bar, held at its far end and coupled at the near one: lumped masses, explicit steps without
/// damping.
///
/// Its modes are known in closed form: with n elements, omega_j = omega_max sin((2j - 1) pi / (4n)), and every mode
/// takes the same share of a force on the end, u_j'' = -omega_j^2 u_j + share lambda with u = sum u_j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquivalentBar {
    /// Elements.
    pub elements: usize,
    /// The upper bound of its frequencies (1/s).
    pub omega_max: f64,
    /// Share of a force that a mode takes: 2 over the mass of the bar (1/kg).
    pub share: f64,
}

/// Upper bound on the elements of an equivalent bar: its operator is full, and more elements do not change a limit.
const ELEMENTS_MAX: usize = 40;

impl EquivalentBar {
    /// The bar with the continuum's values from the handshake: the highest frequency from the step limit (of an
    /// undamped step, 2/omega_max, which errs to the stiff side), the first period, and the compliance (m/N) over a
    /// window of `substeps`, which `measure` takes from a response.
    pub fn equivalent(
        step_s: f64,
        substeps: u32,
        limit_s: f64,
        period_s: Option<f64>,
        compliance: f64,
        measure: impl Fn(&Response) -> f64,
    ) -> EquivalentBar {
        let omega_max = 2.0 / limit_s;
        // Without a period: a bar so long that no wave returns within two windows.
        let window_s = step_s * f64::from(substeps);
        let period_s = period_s.unwrap_or(8.0 * window_s.max(limit_s));
        let ratio = (2.0 * PI / (period_s * omega_max)).min(0.7);
        let elements = (FRAC_PI_4 / ratio.asin()).round() as usize;
        let unit = EquivalentBar {
            elements: elements.clamp(1, ELEMENTS_MAX),
            omega_max,
            share: 1.0,
        };
        EquivalentBar {
            share: compliance / measure(&unit.response(step_s, substeps)),
            ..unit
        }
    }

    /// Its window of `substeps` steps, by its modes.
    pub fn response(&self, step_s: f64, substeps: u32) -> Response {
        let n = self.elements;
        let omega = |j| self.omega_max * ((2 * j + 1) as f64 * PI / (4 * n) as f64).sin();
        let k = DMatrix::from_diagonal(&DVector::from_fn(n, |j, _| -omega(j) * omega(j)));
        let share = DVector::from_element(n, self.share);
        Response::new(step_s, substeps, &k, &share, &DVector::from_element(n, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// C(1) = h^2 / (2 m): the end node of a bar of ten elements of 1 kg has 0.5 kg.
    #[test]
    fn one_step_moves_the_end_node_alone() {
        let bar = EquivalentBar {
            elements: 10,
            omega_max: 2.0,
            share: 2.0 / 10.0,
        };
        let step_s = 0.7;
        let compliance = bar.response(step_s, 1).compliance();
        assert!((compliance - 0.49).abs() < 1e-14, "{compliance}");
    }

    /// The handshake's numbers for such a bar reproduce the bar.
    #[test]
    fn the_equivalent_of_a_bar_is_itself() {
        let bar = EquivalentBar {
            elements: 10,
            omega_max: 2.0,
            share: 0.2,
        };
        let step_s = 0.9;
        let period = 2.0 * std::f64::consts::PI / (2.0 * (std::f64::consts::PI / 40.0).sin());
        for substeps in [1, 7, 1000] {
            let window_s = step_s * f64::from(substeps);
            let own = bar.response(step_s, substeps);
            let free = |response: &Response| response.compliance();
            let found =
                EquivalentBar::equivalent(step_s, substeps, 1.0, Some(period), free(&own), free);
            assert_eq!(found.elements, 10);
            assert!((found.share / bar.share - 1.0).abs() < 1e-9);
            let led = |response: &Response| response.prescribed_compliance(window_s);
            let found =
                EquivalentBar::equivalent(step_s, substeps, 1.0, Some(period), led(&own), led);
            assert!((found.share / bar.share - 1.0).abs() < 1e-9);
        }
    }
}
