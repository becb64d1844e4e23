//! The continuum of the bench, element by element. Spacing, element mass and element stiffness are one.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use scheme::predict::response::Response;

/// An elastic bar of unit elements, held at its far end, coupled at the other end; explicit steps without damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitBar {
    /// Elements.
    pub elements: usize,
    /// Step (s); the stability limit is 1.
    pub step_s: f64,
}

/// The end node has the half mass of its one element.
const END_MASS_KG: f64 = 0.5;

impl UnitBar {
    /// Stability limit of the step (s): omega_max is 2 for unit masses and springs.
    pub const LIMIT_S: f64 = 1.0;

    /// First period (s): omega_1 = 2 sin(pi / (4 n)).
    pub fn first_period_s(&self) -> f64 {
        PI / (PI / (4 * self.elements) as f64).sin()
    }

    /// The window of `substeps` steps as matrices: m_i u_i'' = u_i-1 - 2 u_i + u_i+1, at the end u_i-1 - u_i + lambda.
    pub fn response(&self, substeps: u32) -> Response {
        let end = self.elements - 1;
        let mass = |i| if i == end { END_MASS_KG } else { 1.0 };
        let k = DMatrix::from_fn(end + 1, end + 1, |i, j| match i.abs_diff(j) {
            0 => -2.0,
            1 => 1.0 / mass(i),
            _ => 0.0,
        });
        let end_node = DVector::from_fn(end + 1, |i, _| f64::from(u8::from(i == end)));
        let push = &end_node / END_MASS_KG;
        Response::new(self.step_s, substeps, &k, &push, &end_node)
    }
}
