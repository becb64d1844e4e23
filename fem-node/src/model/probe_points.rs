//! Points of the body whose motion is reported, between its nodes by the shape functions of their element.

use kit::ConfigError;

use crate::config::probe::ProbeConfig;
use crate::element::layout::Layout;
use crate::element::shape::{natural_coordinates, shape_functions};
use crate::integrate::state::NodalState;
use crate::mesh::Mesh;

/// A point and the nodes around it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProbePoint {
    name: String,
    /// Node (column, row) and its shape function there.
    nodes: [([usize; 2], f64); 4],
}

/// Signals of a probe beside its name: displacement, and velocity in dynamics.
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
    /// Names of its signals: displacement, and velocity where the body moves in time.
    pub(crate) fn signals(&self, moving: bool) -> impl Iterator<Item = String> {
        let count = if moving { 4 } else { 2 };
        SUFFIXES[..count]
            .iter()
            .map(|suffix| format!("{}{suffix}", self.name))
    }

    /// Nodes around it (column, row).
    pub(crate) fn at(&self) -> impl Iterator<Item = [usize; 2]> {
        self.nodes.iter().map(|(node, _)| *node)
    }

    /// Values of these signals (m, m/s), sum N_a u_a.
    pub(crate) fn values(&self, layout: Layout, state: &NodalState, moving: bool) -> Vec<f64> {
        let fields = if moving {
            &[&state.u, &state.v][..]
        } else {
            &[&state.u][..]
        };
        let at = |field: &[f64], k: usize| {
            let parts = self.nodes.iter();
            parts
                .map(|(node, shape)| shape * field[layout.index(*node, k)])
                .sum::<f64>()
        };
        fields
            .iter()
            .flat_map(|field| [0, 1].map(|k| at(field, k)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two skewed elements beside each other, 2 m wide and 1 m high.
    fn mesh() -> Mesh {
        Mesh::structured(2, 1, |i, j| {
            let lean = if (i, j) == (1, 1) { 0.3 } else { 0.0 };
            [i as f64 + lean, -(j as f64)]
        })
    }

    fn probe(x_m: f64, y_m: f64) -> ProbeConfig {
        ProbeConfig {
            name: "p".into(),
            x_m,
            y_m,
        }
    }

    #[test]
    fn shape_functions_give_the_position_back() {
        let mesh = mesh();
        for [x, y] in [
            [0.2, -0.1],
            [1.1, -0.5],
            [1.9, -0.99],
            [0.0, 0.0],
            [1.3, -1.0],
        ] {
            let found = &locate(&[probe(x, y)], &mesh).expect("inside")[0];
            let sum = |value: &dyn Fn([f64; 2]) -> f64| -> f64 {
                let parts = found.nodes.iter();
                parts
                    .map(|([i, j], shape)| shape * value(mesh.point(*i, *j)))
                    .sum()
            };
            assert!((sum(&|p| p[0]) - x).abs() < 1e-12);
            assert!((sum(&|p| p[1]) - y).abs() < 1e-12);
            assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_point_outside_is_refused_with_the_nearest_node() {
        let error = locate(&[probe(0.5, -0.5), probe(1.0, 0.1)], &mesh()).expect_err("above");
        assert_eq!(error.key, "probes[1].x_m");
        assert!(error.help.is_some_and(|help| help.contains("(1e0, ")));
    }
}
