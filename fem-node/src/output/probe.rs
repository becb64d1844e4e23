//! Signals of each window, stresses and pressures.

use fem_kernel::element::body::ElementKind;
use fem_kernel::element::layout::Layout;
use fem_kernel::element::shape::{GAUSS_POINTS, gradient, jacobian, strain, symmetric};
use fem_kernel::integrate::state::NodalState;
use fem_kernel::material::nonlinear::{NonlinearLaw, stretch_at};
use fem_kernel::mesh::{Edge, area};
use fem_kernel::pack::largest;
use fem_kernel::wheel::rigid::Wheel;
use fem_kernel::wheel::state::WheelState;
use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::output::profile::ContactProfile;

kit::results! {
    /// # Load and approach
    /// - `p_max_centroid_pa`: Largest hydrostatic pressure -tr(σ)/3, positive in compression, at
    ///   the centroids of the elements, at the end of the hold.
    /// - `p_max_gauss_pa`: Largest hydrostatic pressure over all points of integration, at the end
    ///   of the hold.
    /// - `p_max_nodal_pa`: Largest hydrostatic pressure over the nodes, averaged over the elements around each node, at the end of the hold.
    /// # Forces and places of sets
    /// - `<set>_outward_m`: Mean displacement of the line along its outward normal.
    /// # Signals
    /// - `surface_mean_uy_m`: Mean displacement along y of the upper edge, on whichever edge the body is coupled.
    /// - `surface_min_uy_m`: Smallest displacement along y of the upper edge, where it is pressed down most.
}

/// Momentum of a body along the directions in which nothing holds or moves it (kg m/s), by the names of its signals.
pub(crate) fn momentum(model: &Model, state: &NodalState) -> Vec<(String, f64)> {
    if model.free == [false; 2] {
        return Vec::new();
    }
    let body = &model.body;
    let mut sums = [0.0; 2];
    for (index, (v, mass)) in state.v.iter().zip(&body.mass).enumerate() {
        sums[body.layout.direction(index)] += v * mass;
    }
    let named = ["x", "y"].into_iter().zip(sums);
    let free = named.zip(model.free).filter(|(_, free)| *free);
    free.map(|((direction, sum), _)| (format!("momentum_{direction}_kg_m_per_s"), sum))
        .collect()
}

/// Rows of nodes whose displacements and velocities enter the signals of a window.
pub(crate) fn reported_rows(model: &Model) -> Vec<usize> {
    let mesh = &model.mesh;
    if model.free != [false; 2] {
        return (0..model.body.layout.node_rows).collect();
    }
    let surface = mesh.edge(Edge::Top);
    let probes = model.probes.iter().flat_map(|probe| probe.at());
    let nodes = surface.into_iter().chain(probes);
    let mut rows: Vec<usize> = nodes.map(|[_, row]| row).collect();
    rows.sort_unstable();
    rows.dedup();
    rows
}

/// Force on the coupled surfaces (N), by the names of its signals, of components in the order (x0, y0, x1, y1, ...).
pub(crate) fn interface_force(components: impl Iterator<Item = f64>) -> [(String, f64); 2] {
    let mut sum = [0.0; 2];
    for (k, force) in components.enumerate() {
        sum[k % 2] += force;
    }
    [0, 1].map(|k| (format!("interface_force_{}_n", ["x", "y"][k]), sum[k]))
}

/// Mean (weighted with the lengths of the reference surface) and least vertical displacement of the upper edge (m), by the names of their signals;
/// empty for a body without an upper edge.
pub(crate) fn surface_signals(model: &Model, state: &NodalState) -> Vec<(String, f64)> {
    let nodes = model.mesh.edge(Edge::Top);
    if nodes.is_empty() {
        return Vec::new();
    }
    let lengths = model.mesh.tributary(&nodes);
    let uy = |node: &[usize; 2]| state.u[model.body.layout.index(*node, 1)];
    let pairs = nodes.iter().zip(&lengths);
    let weighted: f64 = pairs.map(|(node, length)| length * uy(node)).sum();
    let deepest = nodes.iter().map(|node| -uy(node));
    let deepest = deepest.fold(f64::NEG_INFINITY, larger);
    let mean = weighted / lengths.iter().sum::<f64>();
    vec![
        ("surface_mean_uy_m".into(), mean),
        ("surface_min_uy_m".into(), -deepest),
    ]
}

/// Mean displacement along the outward normal (m) of every named line on the outline of an unstructured mesh: the area swept by the line over its
/// length, exact for sides that stay straight. Named `<set>_outward_m`.
pub(crate) fn outward_displacements(model: &Model, state: &NodalState) -> Vec<(String, f64)> {
    let mesh = &model.mesh;
    if mesh.connectivity.is_none() {
        return Vec::new();
    }
    let mut means = Vec::new();
    for name in mesh.sets() {
        let lines = mesh.lines(name).unwrap_or_default();
        let segments = lines.iter().flat_map(|line| line.windows(2));
        let (mut swept, mut length) = (0.0, 0.0);
        for [a, b] in segments.filter_map(|pair| mesh.outline(pair[0], pair[1])) {
            let [p, q] = [a, b].map(|node| mesh.point(node[0], node[1]));
            let [u, v] = [a, b].map(|node| displacement(model.body.layout, state, node));
            let along = [q[0] - p[0], q[1] - p[1]];
            // With the body on the left of a -> b the outward normal times the length is (dy, -dx).
            swept += 0.5 * (along[1] * (u[0] + v[0]) - along[0] * (u[1] + v[1]));
            length += along[0].hypot(along[1]);
        }
        if length > 0.0 {
            means.push((format!("{name}_outward_m"), swept / length));
        }
    }
    means
}

/// The largest hydrostatic pressures of the body (Pa). The same displacements give different maxima at different kinds of points, so each is reported
/// by name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressureMaxima {
    /// Over the centroids of the elements.
    pub centroid: f64,
    /// Over the 2 x 2 Gauss points.
    pub gauss: f64,
    /// Over the nodes, averaged over the elements around each node.
    pub nodal: f64,
}

impl PressureMaxima {
    /// Results by name.
    pub(crate) fn results(&self) -> [(String, f64); 3] {
        [
            ("p_max_centroid_pa".into(), self.centroid),
            ("p_max_gauss_pa".into(), self.gauss),
            ("p_max_nodal_pa".into(), self.nodal),
        ]
    }
}

/// Record of the moment before the wheel starts to move sideways.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct HoldRecord {
    pub(crate) maxima: PressureMaxima,
    /// Tractions of the wheel on the upper edge.
    pub(crate) profile: ContactProfile,
    /// Approach of the wheel since it touched the body (m).
    pub(crate) approach: f64,
}

/// Pressures and approach of a state.
pub(crate) fn hold_record(
    model: &Model,
    state: &NodalState,
    wheel: &Wheel,
    at: &WheelState,
) -> HoldRecord {
    HoldRecord {
        maxima: pressure_maxima(model, state),
        profile: ContactProfile::in_motion(model, &at.contacts),
        approach: at.approach(wheel),
    }
}

/// Largest hydrostatic pressures of a state.
pub fn pressure_maxima(model: &Model, state: &NodalState) -> PressureMaxima {
    let mut maxima = PressureMaxima {
        centroid: f64::NEG_INFINITY,
        gauss: f64::NEG_INFINITY,
        nodal: f64::NEG_INFINITY,
    };
    let mut nodal = vec![(0.0, 0.0); model.mesh.points.len()];
    for [i, j] in model.mesh.element_indices() {
        let pressure = |xi, eta| pressure(model, state, [i, j], [xi, eta]);
        maxima.centroid = larger(maxima.centroid, pressure(0.0, 0.0));
        for [xi, eta] in GAUSS_POINTS {
            maxima.gauss = larger(maxima.gauss, pressure(xi, eta));
        }
        for (node, [xi, eta]) in model.mesh.corners(i, j).into_iter().zip(GAUSS_POINTS) {
            let (sum, count) = &mut nodal[model.mesh.number(model.mesh.tied_to(node))];
            *sum += pressure(xi.signum(), eta.signum());
            *count += 1.0;
        }
    }
    let seen = nodal.into_iter().filter(|(_, count)| *count > 0.0);
    let means = seen.map(|(sum, count)| sum / count);
    maxima.nodal = means.fold(f64::NEG_INFINITY, larger);
    maxima
}

/// Largest entry of the displacement gradient over the centroids, rotations included; under corotational kinematics the largest component of the
/// stretch's strain. NaN if any entry is NaN.
pub fn largest_strain(model: &Model, state: &NodalState) -> f64 {
    let entries = |element: [usize; 2]| {
        let (points, u) = corners(model, state, element);
        let gradient = gradient(&points, &u, [0.0, 0.0]);
        if model.law == Some(NonlinearLaw::Corotational) {
            let ([xx, yy, xy], _) = stretch_at(gradient);
            [xx, yy, 0.5 * xy, 0.0]
        } else {
            let [[xx, xy], [yx, yy]] = gradient;
            [xx, xy, yx, yy]
        }
    };
    let elements = model.mesh.element_indices();
    largest(elements.flat_map(entries).map(f64::abs))
}

/// Cauchy stress (sxx, syy, sxy) at natural coordinates of the element (column, row) (Pa).
pub fn stress(
    model: &Model,
    state: &NodalState,
    element: [usize; 2],
    natural: [f64; 2],
) -> [f64; 3] {
    let strained = strained(model, state, element, natural);
    let [sxx, syy, sxy] = model.elastic.stress(strained.strain);
    let more = strained.pressure_stress;
    let less = plastic_stress(model, state, element, natural);
    let stress = [sxx + more - less[0], syy + more - less[1], sxy - less[2]];
    let rotation = strained.rotation;
    rotation.map_or(stress, |rotation| turned(stress, rotation))
}

/// Hydrostatic pressure -tr(sigma)/3 at natural coordinates of the element (column, row), compression positive (Pa).
pub fn pressure(model: &Model, state: &NodalState, element: [usize; 2], natural: [f64; 2]) -> f64 {
    let strained = strained(model, state, element, natural);
    let elastic = &model.elastic;
    elastic.pressure(elastic.stress(strained.strain))
        + elastic.pressure_of_uniform(strained.pressure_stress)
}

/// Strain of a point, and the stresses that do not follow from it.
struct Strained {
    /// (exx, eyy, 2 exy), the stretch's strain under large rotations.
    strain: [f64; 3],
    /// Cosine and sine of a large rotation.
    rotation: Option<[f64; 2]>,
    /// The stress in all directions that comes to Hooke's (Pa): k (E - e) of the element with one mean dilatation, less the thermal stress.
    pressure_stress: f64,
}

/// Positions and displacements of the corners of the element (column, row) (m).
pub(super) fn corners(
    model: &Model,
    state: &NodalState,
    element: [usize; 2],
) -> ([[f64; 2]; 4], [[f64; 2]; 4]) {
    let (mesh, layout) = (&model.mesh, model.body.layout);
    let nodes = mesh.corners(element[0], element[1]);
    let u = nodes.map(|node| displacement(layout, state, node));
    (mesh.corner_points(element), u)
}

fn strained(model: &Model, state: &NodalState, element: [usize; 2], natural: [f64; 2]) -> Strained {
    let (points, u) = corners(model, state, element);
    let gradient = gradient(&points, &u, natural);
    let (strain, rotation) = if model.law == Some(NonlinearLaw::Corotational) {
        let (strain, rotation) = stretch_at(gradient);
        (strain, Some(rotation))
    } else {
        (symmetric(gradient), None)
    };
    Strained {
        strain,
        rotation,
        pressure_stress: mean_dilatation_stress(model, &points, &u, natural)
            - thermal_stress(model, state, element),
    }
}

/// The stress in all directions that warmth takes from Hooke's (Pa).
fn thermal_stress(model: &Model, state: &NodalState, [column, row]: [usize; 2]) -> f64 {
    let thermal = state.thermal[1].get(row * model.mesh.columns + column);
    thermal.copied().unwrap_or(0.0)
}

/// 2 mu p, which plastic strain subtracts from Hooke's stress (Pa). It has no trace, so the pressure is unchanged.
fn plastic_stress(
    model: &Model,
    state: &NodalState,
    element: [usize; 2],
    natural: [f64; 2],
) -> [f64; 3] {
    let Some(law) = model.plastic() else {
        return [0.0; 3];
    };
    let [pxx, pyy, pxy, _] = model.body.plastic_strain(&state.history, element, natural);
    [2.0 * law.mu * pxx, 2.0 * law.mu * pyy, law.mu * pxy]
}

/// R S R^T of the rotation (cos, sin).
fn turned([xx, yy, xy]: [f64; 3], [cos, sin]: [f64; 2]) -> [f64; 3] {
    let (cc, ss, cs) = (cos * cos, sin * sin, cos * sin);
    [
        cc * xx - 2.0 * cs * xy + ss * yy,
        ss * xx + 2.0 * cs * xy + cc * yy,
        cs * (xx - yy) + (cc - ss) * xy,
    ]
}

/// k (E - e), the stress in all directions that the element with one mean dilatation E adds to Hooke's (Pa).
fn mean_dilatation_stress(
    model: &Model,
    points: &[[f64; 2]; 4],
    u: &[[f64; 2]; 4],
    natural: [f64; 2],
) -> f64 {
    if model.element != ElementKind::Q4MeanDilatation {
        return 0.0;
    }
    let dilatation = |natural| {
        let [exx, eyy, _] = strain(points, u, natural);
        exx + eyy
    };
    let weighted = GAUSS_POINTS.map(|point| jacobian(points, point) * dilatation(point));
    let mean = weighted.iter().sum::<f64>() / area(points);
    model.elastic.bulk() * (mean - dilatation(natural))
}

/// Displacement of the node (column, row) (m).
pub(crate) fn displacement(layout: Layout, state: &NodalState, node: [usize; 2]) -> [f64; 2] {
    [0, 1].map(|k| state.u[layout.index(node, k)])
}
