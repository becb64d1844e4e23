//! The bilinear quadrilateral: its area, its Jacobian, the slopes of its shape functions and its Gauss points.

/// 1/sqrt(3), the coordinate of the 2 x 2 Gauss points.
pub(super) const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Natural coordinates of the 2 x 2 Gauss points; each has the weight 1.
pub const GAUSS_POINTS: [[f64; 2]; 4] = [
    [-GAUSS, -GAUSS],
    [GAUSS, -GAUSS],
    [GAUSS, GAUSS],
    [-GAUSS, GAUSS],
];

/// Area of a quadrilateral (m2), positive when its corners run anticlockwise.
pub(crate) fn area(p: &[[f64; 2]; 4]) -> f64 {
    0.5 * ((p[2][0] - p[0][0]) * (p[3][1] - p[1][1]) - (p[3][0] - p[1][0]) * (p[2][1] - p[0][1]))
}

/// dx/dxi, dy/dxi and dx/deta, dy/deta at natural coordinates.
fn tangents(p: &[[f64; 2]; 4], natural: [f64; 2]) -> [[f64; 2]; 2] {
    let mut tangents = [[0.0; 2]; 2];
    for (slope, point) in natural_slopes(natural).iter().zip(p) {
        for k in 0..2 {
            tangents[k][0] += slope[k] * point[0];
            tangents[k][1] += slope[k] * point[1];
        }
    }
    tangents
}

/// Area of the element over that of the natural square, at natural coordinates (m2).
pub fn jacobian(p: &[[f64; 2]; 4], natural: [f64; 2]) -> f64 {
    let [[a, b], [c, d]] = tangents(p, natural);
    a * d - b * c
}

/// Derivatives (N,x N,y) of the four shape functions (1/m), corners anticlockwise.
pub fn slopes(p: &[[f64; 2]; 4], natural: [f64; 2]) -> [[f64; 2]; 4] {
    let [[a, b], [c, d]] = tangents(p, natural);
    let determinant = a * d - b * c;
    natural_slopes(natural)
        .map(|[s, t]| [(d * s - b * t) / determinant, (a * t - c * s) / determinant])
}

/// Derivatives (N,xi N,eta) of N = (1 + xi xi_a)(1 + eta eta_a)/4.
fn natural_slopes([xi, eta]: [f64; 2]) -> [[f64; 2]; 4] {
    let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    signs.map(|[s, t]| [0.25 * s * (1.0 + t * eta), 0.25 * t * (1.0 + s * xi)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_of_a_trapezium_is_right() {
        assert_eq!(area(&[[0.0, 0.0], [4.0, 0.0], [3.0, 2.0], [1.0, 2.0]]), 6.0);
    }
}
