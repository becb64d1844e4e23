//! The points that the body exchanges with a coupler, and its windows between two exchanges.
//!
//! - `window`: one window from the committed state.

pub(crate) mod window;

use std::collections::BTreeMap;

use fem_kernel::mesh::{Edge, Mesh};
use protocol::Surface;

use crate::error::FemError;
use crate::model::Model;

/// Coupled nodes, the exchanged ones among them, and the matrices condensed onto these.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interface {
    nodes: Vec<[usize; 2]>,
    /// The exchanged nodes among them.
    pub(crate) exchanged: Vec<[usize; 2]>,
    /// Exchanged components in the order (x0, y0, x1, y1, ...), as indices in the fields.
    pub(crate) components: Vec<usize>,
    /// Matrices by kind and number of steps, n x n, column-major, for the current selection.
    pub(crate) condensed: BTreeMap<(&'static str, u32), Vec<f64>>,
}

impl Interface {
    /// Couples a set; without a selection all of its nodes are exchanged. A set that carries several layers is coupled once for each layer, and the
    /// selection gives each layer its own nodes.
    pub(crate) fn couple(&mut self, model: &Model, set: &str) -> Result<Surface, FemError> {
        let unknown = || FemError::UnknownSet {
            set: set.into(),
            known: coupling_sets(model).join(", "),
        };
        let layers = model.heat.as_ref().map(|heat| heat.surface.name());
        if let Some(layers) = layers.filter(|layers| *layers != set) {
            let set = set.into();
            return Err(FemError::CoupledWithHeat { set, layers });
        }
        if set == Edge::Bottom.name() && model.supported {
            return Err(FemError::SupportedSet);
        }
        let nodes = model.mesh.open_line(set).ok_or_else(unknown)?;
        if model.moved_sets.iter().any(|moved| moved == set) {
            return Err(FemError::MovedSet { set: set.into() });
        }
        let (nodes, lengths) = match Edge::named(set) {
            Some(edge) => model.mesh.surface(edge),
            None => (nodes.clone(), model.mesh.tributary(&nodes)),
        };
        let surface = surface(model, &nodes, lengths);
        self.nodes.extend(nodes);
        self.exchange(model, self.nodes.clone());
        Ok(surface)
    }

    /// Restricts the exchange to these points of the coupled sets.
    pub(crate) fn select(&mut self, model: &Model, points: &[usize]) -> Result<(), FemError> {
        let count = self.nodes.len();
        let mut seen = vec![false; count];
        for point in points {
            if seen.get(*point) != Some(&false) {
                let point = *point;
                return Err(FemError::Point { point, count });
            }
            seen[*point] = true;
        }
        let nodes = points.iter().map(|point| self.nodes[*point]).collect();
        self.exchange(model, nodes);
        Ok(())
    }

    fn exchange(&mut self, model: &Model, nodes: Vec<[usize; 2]>) {
        let layout = model.body.layout;
        let components = nodes.iter().flat_map(|node| layout.components(*node));
        self.components = components.collect();
        self.exchanged = nodes;
        self.condensed.clear();
    }
}

/// The sets that can be coupled: open lines on the outline, except a support.
pub(crate) fn coupling_sets(model: &Model) -> Vec<String> {
    let sets = model.mesh.sets().into_iter();
    let movable = sets.filter(|name| !(model.supported && *name == Edge::Bottom.name()));
    let lines = movable.filter(|name| model.mesh.open_line(name).is_some());
    lines.map(String::from).collect()
}

/// Mean outward normals of the sets that can be coupled, by name.
pub(crate) fn outward_normals(model: &Model) -> BTreeMap<String, [f64; 2]> {
    let normal = |name: String| {
        let line = model.mesh.open_line(&name)?;
        let [x, y] = outward_sum(&model.mesh, &line);
        let length = x.hypot(y);
        (length > 0.0).then(|| (name, [x / length, y / length]))
    };
    let sets = coupling_sets(model).into_iter();
    sets.filter_map(normal).collect()
}

/// Lengths along x (m) after which the sets that can be coupled repeat, by name: the upper and the lower edge of a periodic mesh.
pub(crate) fn periods(model: &Model) -> BTreeMap<String, f64> {
    let mesh = &model.mesh;
    if !mesh.periodic {
        return BTreeMap::new();
    }
    let length = mesh.point(mesh.columns, 0)[0] - mesh.point(0, 0)[0];
    let sets = coupling_sets(model).into_iter();
    sets.map(|name| (name, length)).collect()
}

/// Sum over a line of outward normal times length (m), (dy, -dx) with the body on the left of a -> b.
fn outward_sum(mesh: &Mesh, line: &[[usize; 2]]) -> [f64; 2] {
    let segments = line.windows(2);
    let segments = segments.filter_map(|pair| mesh.outline(pair[0], pair[1]));
    segments.fold([0.0; 2], |sum, ends| {
        let [p, q] = ends.map(|node| mesh.point(node[0], node[1]));
        [sum[0] + q[1] - p[1], sum[1] - q[0] + p[0]]
    })
}

fn surface(model: &Model, nodes: &[[usize; 2]], length_m: Vec<f64>) -> Surface {
    let point = |n: &[usize; 2]| model.mesh.point(n[0], n[1]);
    let mass = |node: &[usize; 2]| model.body.node_mass(*node);
    Surface {
        x_m: nodes.iter().map(|node| point(node)[0]).collect(),
        y_m: nodes.iter().map(|node| point(node)[1]).collect(),
        mass_kg: nodes.iter().map(mass).collect(),
        radius_m: vec![0.0; nodes.len()],
        length_m,
    }
}
