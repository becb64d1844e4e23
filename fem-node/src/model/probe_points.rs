//! Points of the body whose motion is reported, interpolated between nodes by the shape functions of their element.

use fem_kernel::element::layout::Layout;
use fem_kernel::element::shape::{natural_coordinates, shape_functions};
use fem_kernel::integrate::state::NodalState;
use fem_kernel::mesh::Mesh;
use kit::ConfigError;

use crate::config::probe::ProbeConfig;

/// A point and the nodes around it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProbePoint {
    name: String,
    /// Node (column, row) and its shape function there.
    nodes: [([usize; 2], f64); 4],
}

/// Suffixes of a probe's signals after its name: displacement, and velocity in dynamics.
const SUFFIXES: [&str; 4] = ["_ux_m", "_uy_m", "_vx_m_per_s", "_vy_m_per_s"];

/// Finds the elements of the probes.
pub(crate) fn locate(probes: &[ProbeConfig], mesh: &Mesh) -> Result<Vec<ProbePoint>, ConfigError> {
    let mut points = Vec::new();
    for (index, probe) in probes.iter().enumerate() {
        let position = [probe.x_m, probe.y_m];
        let nodes = containing(mesh, position).ok_or_else(|| outside(mesh, index, position))?;
        points.push(ProbePoint {
            name: probe.name.clone(),
            nodes,
        });
    }
    Ok(points)
}

/// Nodes and shape functions of the first element that holds this position.
fn containing(mesh: &Mesh, position: [f64; 2]) -> Option<[([usize; 2], f64); 4]> {
    mesh.element_indices().find_map(|[i, j]| {
        let corners = mesh.corners(i, j);
        let points = corners.map(|n| mesh.point(n[0], n[1]));
        let natural = natural_coordinates(&points, position)?;
        let shapes = shape_functions(natural);
        Some(std::array::from_fn(|a| {
            (mesh.tied_to(corners[a]), shapes[a])
        }))
    })
}

/// The refusal of a position outside, with the nearest node.
fn outside(mesh: &Mesh, index: usize, [x, y]: [f64; 2]) -> ConfigError {
    let far = |p: &[f64; 2]| (p[0] - x).hypot(p[1] - y);
    let nearest = mesh.points.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
    let [nx, ny] = nearest.copied().unwrap_or_default();
    let problem = format!("({x:e}, {y:e}) m lies outside of the body");
    ConfigError::new(&format!("probes[{index}].x_m"), problem).help(format!(
        "its nearest node is at ({nx:e}, {ny:e}) m; check the unit (m)"
    ))
}

impl ProbePoint {
    /// Displacement, and velocity of a body in motion, sum N_a u_a (m, m/s), by the names of their signals.
    pub(crate) fn signals(
        &self,
        layout: Layout,
        state: &NodalState,
        moving: bool,
    ) -> impl Iterator<Item = (String, f64)> {
        let count = if moving { 4 } else { 2 };
        let fields = [&state.u, &state.u, &state.v, &state.v];
        let signals = SUFFIXES.into_iter().zip(fields).enumerate().take(count);
        signals.map(move |(k, (suffix, field))| {
            let parts = self.nodes.iter();
            let parts = parts.map(|(node, shape)| shape * field[layout.index(*node, k % 2)]);
            (format!("{}{suffix}", self.name), parts.sum::<f64>())
        })
    }

    /// Nodes around the point (column, row).
    pub(crate) fn at(&self) -> impl Iterator<Item = [usize; 2]> {
        self.nodes.iter().map(|(node, _)| *node)
    }
}
