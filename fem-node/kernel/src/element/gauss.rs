//! Integration over the four Gauss points of quadrilaterals, a pack of neighbours at a time.

use super::modes::{Modes, plus_minus};
use super::shape::{GAUSS, jacobian};
use crate::pack::lanes::Lanes;

/// Number of geometric constants of an element: the means of x,xi, y,xi, x,eta, y,eta; the slopes of x and y in xi eta at a Gauss point; t / 16 J at
/// the four points.
pub(super) const GEOMETRY: usize = 10;

/// Number of constants of each element: the [`geometry`], and t k / area for the mean pressure.
pub(super) const CONSTANTS: usize = GEOMETRY + 1;

/// Forces f = sum over the four points of t J B^T s of a pack of elements with these constants. `stress` gives t s / 4 (xx, yy, xy) of a
/// point, given its number in the order of the weights, 4 J e (exx, eyy, 2 exy), and t D e / 4.
#[inline(always)]
pub(crate) fn integrate<V: Lanes>(
    constants: &[V; CONSTANTS],
    [x, y]: [Modes<V>; 2],
    moduli: [f64; 3],
    mut stress: impl FnMut(usize, [V; 3], [V; 3]) -> [V; 3],
) -> [Modes<V>; 2] {
    let (c11, c12) = (x.xi.all(moduli[0]), x.xi.all(moduli[1]));
    let c33 = x.xi.all(moduli[2]);
    let (bx, by) = (constants[4], constants[5]);
    let zero = bx.all(0.0);
    let [mut fx, mut fy] = [Modes::zero(zero); 2];
    for upper in [false, true] {
        let u_xi = plus_minus(upper, x.xi, x.hourglass);
        let v_xi = plus_minus(upper, y.xi, y.hourglass);
        let x_xi = plus_minus(upper, constants[0], bx);
        let y_xi = plus_minus(upper, constants[1], by);
        let mut row = [zero; 2];
        for right in [false, true] {
            let u_eta = plus_minus(right, x.eta, x.hourglass);
            let v_eta = plus_minus(right, y.eta, y.hourglass);
            let x_eta = plus_minus(right, constants[2], bx);
            let y_eta = plus_minus(right, constants[3], by);
            let point = 2 * usize::from(upper) + usize::from(right);
            let weight = constants[6 + point];

            let exx = u_xi * y_eta - u_eta * y_xi;
            let eyy = v_eta * x_xi - v_xi * x_eta;
            let shear = (u_eta * x_xi - u_xi * x_eta) + (v_xi * y_eta - v_eta * y_xi);
            let sxx = weight * (c11 * exx + c12 * eyy);
            let syy = weight * (c12 * exx + c11 * eyy);
            let sxy = weight * (c33 * shear);
            let [sxx, syy, sxy] = stress(point, [exx, eyy, shear], [sxx, syy, sxy]);

            row[0] = row[0] + (sxx * y_eta - sxy * x_eta);
            row[1] = row[1] + (sxy * y_eta - syy * x_eta);
            fx.add_eta(right, sxy * x_xi - sxx * y_xi);
            fy.add_eta(right, syy * x_xi - sxy * y_xi);
        }
        fx.add_xi(upper, row[0]);
        fy.add_xi(upper, row[1]);
    }
    [fx, fy]
}

/// Constants of an element, [`GEOMETRY`].
pub(super) fn geometry(p: &[[f64; 2]; 4], thickness: f64) -> [f64; GEOMETRY] {
    let mean = |k: usize, signs: [f64; 4]| 0.25 * (0..4).map(|a| signs[a] * p[a][k]).sum::<f64>();
    let (s, t, h) = (
        [-1.0, 1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0, -1.0],
    );
    let weight = |xi: f64, eta: f64| thickness / (16.0 * jacobian(p, [xi, eta]));
    [
        mean(0, s),
        mean(1, s),
        mean(0, t),
        mean(1, t),
        GAUSS * mean(0, h),
        GAUSS * mean(1, h),
        weight(-GAUSS, -GAUSS),
        weight(GAUSS, -GAUSS),
        weight(-GAUSS, GAUSS),
        weight(GAUSS, GAUSS),
    ]
}
