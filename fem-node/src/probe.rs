//! What the user wants to see: signals of each window, stresses when asked.

use crate::element::Layout;
use crate::integrate::State;
use crate::mesh::{Edge, Mesh};
use crate::model::Model;

/// 1/sqrt(3), the coordinate of the 2 x 2 Gauss points.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Names of what [`surface_signals`] returns.
pub(crate) const SURFACE_SIGNALS: [&str; 2] = ["surface_mean_uy_m", "surface_min_uy_m"];

/// Mean (weighted with the lengths of the reference surface) and least vertical displacement of the upper edge (m).
pub(crate) fn surface_signals(model: &Model, state: &State) -> [f64; 2] {
    let nodes = model.mesh.edge(Edge::Top);
    let lengths = model.mesh.tributary(&nodes);
    let uy = |node: &[usize; 2]| state.u[model.body.layout().index(*node, 1)];
    let weighted: f64 = nodes
        .iter()
        .zip(&lengths)
        .map(|(node, length)| length * uy(node))
        .sum();
    let least = nodes.iter().map(uy).fold(f64::INFINITY, f64::min);
    [weighted / lengths.iter().sum::<f64>(), least]
}

/// The largest hydrostatic pressures of the body (Pa). The same displacements give different maxima at different
/// points, so both are reported by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureMaxima {
    /// Over the centroids of the elements.
    pub centroid: f64,
    /// Over the 2 x 2 Gauss points.
    pub gauss: f64,
}

/// Largest hydrostatic pressures of a state.
pub fn pressure_maxima(model: &Model, state: &State) -> PressureMaxima {
    let mut maxima = PressureMaxima {
        centroid: f64::NEG_INFINITY,
        gauss: f64::NEG_INFINITY,
    };
    for j in 0..model.mesh.rows() {
        for i in 0..model.mesh.columns() {
            let pressure = |xi, eta| {
                model
                    .elastic
                    .pressure(stress(model, state, [i, j], [xi, eta]))
            };
            maxima.centroid = maxima.centroid.max(pressure(0.0, 0.0));
            for (xi, eta) in [
                (-GAUSS, -GAUSS),
                (GAUSS, -GAUSS),
                (GAUSS, GAUSS),
                (-GAUSS, GAUSS),
            ] {
                maxima.gauss = maxima.gauss.max(pressure(xi, eta));
            }
        }
    }
    maxima
}

/// Stress (sxx, syy, sxy) of the displacements at natural coordinates of the element (column, row) (Pa).
pub fn stress(model: &Model, state: &State, element: [usize; 2], natural: [f64; 2]) -> [f64; 3] {
    let corners = model.mesh.corners(element[0], element[1]);
    let points = corners.map(|n| model.mesh.point(n[0], n[1]));
    let u = corners.map(|node| displacement(model.body.layout(), state, node));
    model.elastic.stress(strain(&points, &u, natural))
}

/// Strain (exx, eyy, 2 exy) of a bilinear quadrilateral at natural coordinates, corners anticlockwise.
pub fn strain(points: &[[f64; 2]; 4], u: &[[f64; 2]; 4], natural: [f64; 2]) -> [f64; 3] {
    let slopes = shape_slopes(points, natural);
    let mut strain = [0.0; 3];
    for ([dx, dy], [ux, uy]) in slopes.iter().zip(u) {
        strain[0] += dx * ux;
        strain[1] += dy * uy;
        strain[2] += dy * ux + dx * uy;
    }
    strain
}

/// Displacement of the node (column, row) (m).
pub(crate) fn displacement(layout: Layout, state: &State, node: [usize; 2]) -> [f64; 2] {
    [0, 1].map(|k| state.u[layout.index(node, k)])
}

/// Derivatives (N,x N,y) of the four shape functions N = (1 + xi xi_a)(1 + eta eta_a)/4.
fn shape_slopes(points: &[[f64; 2]; 4], [xi, eta]: [f64; 2]) -> [[f64; 2]; 4] {
    let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let natural: [[f64; 2]; 4] =
        signs.map(|[s, t]| [0.25 * s * (1.0 + t * eta), 0.25 * t * (1.0 + s * xi)]);
    let mut jacobian = [[0.0; 2]; 2];
    for (slope, point) in natural.iter().zip(points) {
        for k in 0..2 {
            jacobian[k][0] += slope[k] * point[0];
            jacobian[k][1] += slope[k] * point[1];
        }
    }
    let [[a, b], [c, d]] = jacobian;
    let determinant = a * d - b * c;
    natural.map(|[s, t]| [(d * s - b * t) / determinant, (a * t - c * s) / determinant])
}

/// Centroid stresses (sxx, syy, sxy) of all elements, row after row (Pa).
pub(crate) fn centroid_stresses(model: &Model, state: &State) -> Vec<[f64; 3]> {
    let mesh: &Mesh = &model.mesh;
    let elements = (0..mesh.rows()).flat_map(|j| (0..mesh.columns()).map(move |i| [i, j]));
    elements
        .map(|element| stress(model, state, element, [0.0, 0.0]))
        .collect()
}
