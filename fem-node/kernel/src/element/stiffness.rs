//! Element stiffness matrices.

use super::shape::{GAUSS_POINTS, jacobian, slopes};

/// Tangent stiffness (N/m) of one element: rows and columns (x1, y1, x2, y2, x3, y3, x4, y4), corners anticlockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stiffness(pub [[f64; 8]; 8]);

impl Stiffness {
    /// Adds weight B^T D B of the strain (exx, eyy, 2 exy) = B u, D = ((c11, c12, 0), (c12, c11, 0), (0, 0, c33)).
    pub(super) fn add_material(&mut self, slopes: &[[f64; 2]; 4], moduli: [f64; 3], weight: f64) {
        let [c11, c12, c33] = moduli;
        let [xx, yy, shear] = strain_rows(slopes);
        self.add_outer(&xx, &xx, weight * c11);
        self.add_outer(&yy, &yy, weight * c11);
        self.add_outer(&xx, &yy, weight * c12);
        self.add_outer(&yy, &xx, weight * c12);
        self.add_outer(&shear, &shear, weight * c33);
    }

    /// Adds weight a b^T.
    pub(super) fn add_outer(&mut self, a: &[f64; 8], b: &[f64; 8], weight: f64) {
        for (row, a) in self.0.iter_mut().zip(a) {
            for (entry, b) in row.iter_mut().zip(b) {
                *entry += weight * a * b;
            }
        }
    }
}

/// K = sum over the 2 x 2 Gauss points of t J B^T D B, `moduli` being (c11, c12, c33) of D.
pub(super) fn four_point(p: &[[f64; 2]; 4], moduli: [f64; 3], thickness: f64) -> Stiffness {
    let mut k = Stiffness::default();
    for natural in GAUSS_POINTS {
        let weight = thickness * jacobian(p, natural);
        k.add_material(&slopes(p, natural), moduli, weight);
    }
    k
}

/// The rows of B: exx, eyy and 2 exy of the displacements of the corners.
fn strain_rows(slopes: &[[f64; 2]; 4]) -> [[f64; 8]; 3] {
    let mut rows = [[0.0; 8]; 3];
    for (a, [dx, dy]) in slopes.iter().enumerate() {
        rows[0][2 * a] = *dx;
        rows[1][2 * a + 1] = *dy;
        rows[2][2 * a] = *dy;
        rows[2][2 * a + 1] = *dx;
    }
    rows
}

/// exx + eyy of the displacements of the corners.
pub(super) fn dilatation_row(slopes: &[[f64; 2]; 4]) -> [f64; 8] {
    let [xx, yy, _] = strain_rows(slopes);
    std::array::from_fn(|k| xx[k] + yy[k])
}
