//! Bilinear quadrilateral with 2 x 2 Gauss points for the change of shape and one mean value for the change of volume.
//!
//! T. J. R. Hughes, "Generalization of selective integration procedures to anisotropic and nonlinear media", Int. J.
//! Numer. Meth. Engng 15 (1980) 1413-1418. Four points require a nearly incompressible element to keep its volume four times with eight
//! displacements, and it locks; the mean requires it once. With the dilatation e = u,x + v,y, its mean E over the element and the bulk modulus k, the
//! stress is
//!
//! ```text
//! s = D strain + k (E - e) 1,      k = c12 + 2/3 c33
//! ```
//!
//! Because the mean of e - E is zero, s works on the plain gradients of the virtual displacements. In plane strain k is
//! the bulk modulus lambda + 2 mu / 3 and s is k E 1 plus twice mu the deviator. In plane stress, where nothing locks,
//! the same formula holds with the lambda of plane stress.
//!
//! D - k is the matrix of the moduli (4/3, -2/3, 1) c33, so the kernel of [`super::q4_2x2`] serves here too, with the forces of the uniform pressure
//! -k E, which need only the mean gradients.

use super::gauss::CONSTANTS;
use super::modes::Modes;
use super::shape::{GAUSS_POINTS, jacobian, slopes};
use crate::element::stiffness::{Stiffness, dilatation_row, four_point};
use crate::material::Elastic;
use crate::mesh::area;
use crate::pack::lanes::Lanes;

/// Adds the forces t A k E b of the mean pressure -k E, E = b u being the mean dilatation. The constants begin with the means
/// of x,xi, y,xi, x,eta, y,eta and end with t k / area. The mean gradients times the area give t k E; the hourglass modes do not change the volume.
#[inline(always)]
pub(crate) fn add_mean_pressure<V: Lanes>(
    constants: &[V; CONSTANTS],
    [x, y]: [Modes<V>; 2],
    [fx, fy]: &mut [Modes<V>; 2],
) {
    let [x_xi, y_xi, x_eta, y_eta, .., stiffness] = *constants;
    let volume = (x.xi * y_eta - x.eta * y_xi) + (y.eta * x_xi - y.xi * x_eta);
    let stress = stiffness * volume;
    fx.xi = fx.xi + stress * y_eta;
    fx.eta = fx.eta - stress * y_xi;
    fy.xi = fy.xi - stress * x_eta;
    fy.eta = fy.eta + stress * x_xi;
}

/// Moduli of D - k, which resist a change of shape (Pa).
pub(super) fn deviatoric_moduli(elastic: &Elastic) -> [f64; 3] {
    let bulk = elastic.bulk();
    [elastic.c11 - bulk, elastic.c12 - bulk, elastic.c33]
}

/// K = sum over the points of t J B^T (D - k) B, and t A k b b^T with E = b u.
pub(super) fn stiffness(p: &[[f64; 2]; 4], elastic: &Elastic, thickness: f64) -> Stiffness {
    let mut k = four_point(p, deviatoric_moduli(elastic), thickness);
    let mean = mean_dilatation(p);
    k.add_outer(&mean, &mean, thickness * area(p) * elastic.bulk());
    k
}

/// The row b of the mean dilatation E = b u.
fn mean_dilatation(p: &[[f64; 2]; 4]) -> [f64; 8] {
    let mut mean = [0.0; 8];
    for natural in GAUSS_POINTS {
        let share = jacobian(p, natural) / area(p);
        let row = dilatation_row(&slopes(p, natural));
        mean.iter_mut()
            .zip(row)
            .for_each(|(mean, b)| *mean += share * b);
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.3], [1.7, 1.9], [-0.2, 1.1]];

    fn elastic(poisson: f64) -> Elastic {
        Elastic::plane_strain(3.0, poisson, 1.0)
    }

    /// Hughes' form: the strains themselves, ezz included, get a third of (mean - own) dilatation, and the full
    /// three-dimensional law is applied to them.
    #[test]
    fn the_stiffness_matches_the_three_dimensional_law_on_the_modified_strains() {
        let (law, t) = (elastic(0.3), 0.5);
        let ours = stiffness(&CORNERS, &law, t);
        let mean = mean_dilatation(&CORNERS);
        for (r, row) in ours.0.iter().enumerate() {
            for (c, entry) in row.iter().enumerate() {
                let mut exact = 0.0;
                for natural in GAUSS_POINTS {
                    let b = slopes(&CORNERS, natural);
                    let own = dilatation_row(&b);
                    let strain = |k: usize| {
                        let third = (mean[k] - own[k]) / 3.0;
                        let [dx, dy] = b[k / 2];
                        match k % 2 {
                            0 => [dx + third, third, third, dy],
                            _ => [third, dy + third, third, dx],
                        }
                    };
                    let (e, d) = (strain(r), strain(c));
                    let (lambda, mu) = (law.c12, law.c33);
                    let trace = |e: [f64; 4]| e[0] + e[1] + e[2];
                    let work = lambda * trace(e) * trace(d)
                        + 2.0 * mu * (e[0] * d[0] + e[1] * d[1] + e[2] * d[2])
                        + mu * e[3] * d[3];
                    exact += t * jacobian(&CORNERS, natural) * work;
                }
                assert!((entry - exact).abs() < 1e-13, "{r} {c}: {entry} {exact}");
            }
        }
    }

    #[test]
    fn bending_keeps_the_volume_of_a_nearly_incompressible_element() {
        // u = x y, v = 0 on a square: e = y has the mean 0, so only the change of shape costs energy.
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let energy = |poisson: f64| {
            let k = stiffness(&square, &elastic(poisson), 1.0);
            let u = [1.0, 0.0, -1.0, 0.0, 1.0, 0.0, -1.0, 0.0];
            let force = |row: &[f64; 8]| row.iter().zip(u).map(|(k, u)| k * u).sum::<f64>();
            k.0.iter()
                .zip(u)
                .map(|(row, u)| u * force(row))
                .sum::<f64>()
                / elastic(poisson).c33
        };
        assert!((energy(0.499_999) / energy(0.3) - 1.0).abs() < 1e-9);
    }
}
