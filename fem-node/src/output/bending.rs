//! Energy of the hourglass modes compared with pure bending: the part of the stiffness in which the elements differ and lock.
//!
//! On a rectangle of the half-sides a and b the displacement q xi eta has, along its sides, the strains e_xx = q_x eta/a,
//! e_yy = q_y xi/b, 2 e_xy = q_x xi/b + q_y eta/a. With V its volume,
//!
//! ```text
//! energy of the element   V/6 (k_b A + k_s B),   A = q_x^2/a^2 + q_y^2/b^2,   B = q_x^2/b^2 + q_y^2/a^2
//! energy of pure bending  V/6 (c11 - c12^2/c11) A        a beam has neither shear nor transverse stress then
//! ```
//!
//! q4_2x2 has k_b = c11 (the volume locks), k_s = c33 (the shear of a slender element locks), q4_bbar k_b = c11 - k, and q4_1point
//! three times its hourglass modulus for both. Other quadrilaterals are treated as the rectangle of their mid-lines. Macneal (1994), Finite Elements:
//! Their Design and Performance, chapters 3 and 6, derives both locks from these modes.

use fem_kernel::element::body::ElementKind;
use fem_kernel::element::q4_1point::hourglass_modulus;
use fem_kernel::element::shape::gradient;
use fem_kernel::integrate::state::NodalState;
use fem_kernel::mesh::area;

use super::probe::{corners, stress};
use crate::model::Model;

/// Energy of the hourglass modes less the energy of pure bending, and all strain energy (J).
pub(super) fn bending_excess(model: &Model, state: &NodalState) -> [f64; 2] {
    let [c11, c12, c33] = model.elastic.moduli();
    let bending = c11 - c12 * c12 / c11;
    let [in_bending, in_shear] = match model.element {
        ElementKind::Q4Full => [c11, c33],
        ElementKind::Q4MeanDilatation => [c11 - model.elastic.bulk(), c33],
        ElementKind::Q4OnePoint => [3.0 * hourglass_modulus(&model.elastic); 2],
    };
    let [mut excess, mut energy] = [0.0; 2];
    for element in model.mesh.element_indices() {
        let (points, u) = corners(model, state, element);
        let sixth = model.thickness * area(&points) / 6.0;
        let [a, b] = modes(&points, &u);
        let hourglass = in_bending * a + in_shear * b;
        let [xx, yy, xy] = stress(model, state, element, [0.0, 0.0]);
        let direct = xx * xx + yy * yy - 2.0 * c12 / c11 * xx * yy;
        excess += sixth * (hourglass - bending * a);
        energy += sixth * (3.0 * (direct / bending + xy * xy / c33) + hourglass);
    }
    [excess, energy]
}

/// A and B of an element, with its displaced sides: the modes turn with them.
fn modes(points: &[[f64; 2]; 4], u: &[[f64; 2]; 4]) -> [f64; 2] {
    let sum = |of: &[[f64; 2]; 4], signs: [f64; 4]| {
        [0, 1].map(|k| (0..4).map(|n| 0.25 * signs[n] * of[n][k]).sum::<f64>())
    };
    let [h, xi, eta] = [
        [1.0, -1.0, 1.0, -1.0],
        [-1.0, 1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0, 1.0],
    ];
    let [hourglass, moved] = [h, xi].map(|signs| sum(u, signs));
    let [h, side, across] = [h, xi, eta].map(|signs| sum(points, signs));
    let slope = gradient(points, u, [0.0, 0.0]);
    let q = [0, 1].map(|k| hourglass[k] - slope[k][0] * h[0] - slope[k][1] * h[1]);
    let dot = |p: [f64; 2], q: [f64; 2]| p[0] * q[0] + p[1] * q[1];
    let (a2, b2) = (dot(side, side), dot(across, across));
    let side = [0, 1].map(|k| side[k] + moved[k]);
    let x2 = dot(q, side).powi(2) / dot(side, side);
    let y2 = dot(q, q) - x2;
    [x2 / a2 + y2 / b2, x2 / b2 + y2 / a2]
}
