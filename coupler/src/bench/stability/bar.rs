//! The continuum of the bench, element by element. Spacing, element mass and element stiffness are one.

use nalgebra::{DMatrix, DVector};

use crate::scheme::predict::response::{PrescribedResponse, Response, matrix_power};

/// An elastic bar of unit elements, held at its far end, coupled at the other; explicit steps without damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Elements.
    pub elements: usize,
    /// Step (s), 1 being the stability limit.
    pub step_s: f64,
}

/// The end node has the half mass of its one element.
const END_MASS_KG: f64 = 0.5;

impl Bar {
    /// Stability limit of the step (s): omega_max is 2 for unit masses and springs.
    pub const LIMIT_S: f64 = 1.0;

    /// First period (s): omega_1 = 2 sin(pi / (4 n)).
    pub fn first_period_s(&self) -> f64 {
        let angle = std::f64::consts::PI / (4 * self.elements) as f64;
        std::f64::consts::PI / angle.sin()
    }

    /// The window of `substeps` steps as matrices: one step for each unit state, then squared up.
    pub fn response(&self, substeps: u32) -> Response {
        let n = self.elements;
        let free = self.step_matrix(|u, force| self.accelerations(u, force));
        let window = matrix_power(&free, substeps);
        let mut place = DVector::zeros(2 * n);
        place[n - 1] = 1.0;
        let mut pull = place.clone();
        if n > 1 {
            pull[n - 2] = -1.0;
        }
        let prescribed = self.step_matrix(|u, acceleration| {
            let mut a = self.accelerations(u, 0.0);
            a[n - 1] = acceleration;
            a
        });
        Response {
            carry: window.view((0, 0), (2 * n, 2 * n)).into_owned(),
            push: window.column(2 * n).rows(0, 2 * n).into_owned(),
            place,
            prescribed: PrescribedResponse::new(prescribed, substeps, END_MASS_KG, pull),
        }
    }

    /// One velocity Verlet step as a matrix over displacements, velocities and the load on the end: done for each unit of them.
    fn step_matrix(
        &self,
        accelerations: impl Fn(&DVector<f64>, f64) -> DVector<f64>,
    ) -> DMatrix<f64> {
        let (n, h) = (self.elements, self.step_s);
        let mut step = DMatrix::identity(2 * n + 1, 2 * n + 1);
        for column in 0..=2 * n {
            let unit = DVector::from_fn(2 * n + 1, |row, _| f64::from(u8::from(row == column)));
            let (u, v, load) = (unit.rows(0, n).into_owned(), unit.rows(n, n), unit[2 * n]);
            let a = accelerations(&u, load);
            let moved = u + v * h + &a * (0.5 * h * h);
            let sped = v + (a + accelerations(&moved, load)) * (0.5 * h);
            step.view_mut((0, column), (n, 1)).copy_from(&moved);
            step.view_mut((n, column), (n, 1)).copy_from(&sped);
        }
        step
    }

    fn accelerations(&self, u: &DVector<f64>, force: f64) -> DVector<f64> {
        let n = self.elements;
        DVector::from_fn(n, |i, _| {
            let left = if i > 0 { u[i - 1] } else { 0.0 };
            if i + 1 < n {
                left + u[i + 1] - 2.0 * u[i]
            } else {
                (left - u[i] + force) / END_MASS_KG
            }
        })
    }
}
