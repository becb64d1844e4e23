//! The bilinear quadrilateral: its Jacobian, the slopes of its shape functions and its Gauss points.

/// 1/sqrt(3), the coordinate of the 2 x 2 Gauss points.
pub(super) const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Natural coordinates of the 2 x 2 Gauss points; each has the weight 1.
pub const GAUSS_POINTS: [[f64; 2]; 4] = [
    [-GAUSS, -GAUSS],
    [GAUSS, -GAUSS],
    [GAUSS, GAUSS],
    [-GAUSS, GAUSS],
];

/// Natural coordinates of the corners, anticlockwise.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Distance in natural coordinates by which a point may miss its element: the rounding of positions of 1 m with elements of
/// 1 um.
const OUTSIDE: f64 = 1e-9;

/// Iterations after which a point lies in no element; the map of a convex element takes fewer than ten.
const ITERATIONS: usize = 25;

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

/// Area of the element relative to the natural square, at natural coordinates (m2).
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

/// Strain (exx, eyy, 2 exy) of a bilinear quadrilateral at natural coordinates, corners anticlockwise.
pub fn strain(points: &[[f64; 2]; 4], u: &[[f64; 2]; 4], natural: [f64; 2]) -> [f64; 3] {
    symmetric(gradient(points, u, natural))
}

/// Strain (exx, eyy, 2 exy) of a displacement gradient.
pub fn symmetric([[xx, xy], [yx, yy]]: [[f64; 2]; 2]) -> [f64; 3] {
    [xx, yy, xy + yx]
}

/// u,x u,y / v,x v,y of a bilinear quadrilateral at natural coordinates, corners anticlockwise.
pub fn gradient(points: &[[f64; 2]; 4], u: &[[f64; 2]; 4], natural: [f64; 2]) -> [[f64; 2]; 2] {
    let mut gradient = [[0.0; 2]; 2];
    for (slope, u) in slopes(points, natural).iter().zip(u) {
        for k in 0..2 {
            gradient[k][0] += slope[0] * u[k];
            gradient[k][1] += slope[1] * u[k];
        }
    }
    gradient
}

/// Derivatives (N,xi N,eta) of N = (1 + xi xi_a)(1 + eta eta_a)/4.
fn natural_slopes([xi, eta]: [f64; 2]) -> [[f64; 2]; 4] {
    CORNERS.map(|[s, t]| [0.25 * s * (1.0 + t * eta), 0.25 * t * (1.0 + s * xi)])
}

/// N_a = (1 + xi xi_a)(1 + eta eta_a)/4, corners anticlockwise.
pub fn shape_functions([xi, eta]: [f64; 2]) -> [f64; 4] {
    CORNERS.map(|[s, t]| 0.25 * (1.0 + s * xi) * (1.0 + t * eta))
}

/// Natural coordinates of a position in the element, the zero of sum N_a x_a - x by Newton's method; `None` outside.
pub fn natural_coordinates(p: &[[f64; 2]; 4], position: [f64; 2]) -> Option<[f64; 2]> {
    let mut natural = [0.0, 0.0];
    for _ in 0..ITERATIONS {
        let shapes = shape_functions(natural);
        let mean = |k: usize| (0..4).map(|a| shapes[a] * p[a][k]).sum::<f64>();
        let [x, y] = [0, 1].map(|k| position[k] - mean(k));
        let [[a, b], [c, d]] = tangents(p, natural);
        let determinant = a * d - b * c;
        let step = [(d * x - c * y) / determinant, (a * y - b * x) / determinant];
        natural = [natural[0] + step[0], natural[1] + step[1]];
        if step.iter().all(|d| d.abs() < OUTSIDE) {
            let inside = natural.iter().all(|n| n.abs() <= 1.0 + OUTSIDE);
            return inside.then_some(natural.map(|n| n.clamp(-1.0, 1.0)));
        }
    }
    None
}
