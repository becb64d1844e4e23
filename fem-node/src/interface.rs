//! The points that the body exchanges with a coupler.

use std::collections::BTreeMap;

use protocol::Surface;

use crate::error::FemError;
use crate::mesh::{Edge, Mesh};
use crate::model::Model;

/// The coupled nodes, those of them that are exchanged, and what was condensed onto them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interface {
    sets: Vec<String>,
    nodes: Vec<[usize; 2]>,
    /// Exchanged components in the order (x0, y0, x1, y1, ...), as places in the fields.
    components: Vec<usize>,
    /// Square matrices by their kind and number of steps, column after column, for the present selection.
    condensed: BTreeMap<(Condensed, u32), Vec<f64>>,
}

/// What is condensed onto the exchanged components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Condensed {
    /// C (m/N) of a constant force.
    Compliance,
    /// D (kg/s) of a velocity that grows in a straight line.
    Impedance,
}

impl Condensed {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Condensed::Compliance => "compliance",
            Condensed::Impedance => "impedance",
        }
    }
}

impl Interface {
    /// Couples a set; all of its nodes are exchanged until a selection says otherwise.
    pub(crate) fn couple(&mut self, model: &Model, set: &str) -> Result<Surface, FemError> {
        let unknown = || FemError::UnknownSet {
            set: set.into(),
            known: sets(model).join(", "),
        };
        if set == Edge::Bottom.name() && model.supported {
            return Err(FemError::SupportedSet);
        }
        let nodes = model.mesh.open_line(set).ok_or_else(unknown)?;
        if model.is_driven(set) {
            return Err(FemError::DrivenSet { set: set.into() });
        }
        if self.sets.iter().any(|known| known == set) {
            return Err(FemError::CoupledTwice { set: set.into() });
        }
        let (nodes, lengths) = match Edge::named(set) {
            Some(edge) => model.mesh.surface(edge),
            None => (nodes.clone(), model.mesh.tributary(&nodes)),
        };
        let surface = surface(model, &nodes, lengths);
        self.sets.push(set.into());
        self.nodes.extend(nodes);
        self.exchange(model, self.nodes.clone());
        Ok(surface)
    }

    /// Restricts the exchange to these points of the coupled sets.
    pub(crate) fn select(&mut self, model: &Model, points: &[usize]) -> Result<(), FemError> {
        let count = self.nodes.len();
        let mut seen = vec![false; count];
        for point in points {
            match seen.get_mut(*point) {
                Some(seen) if !*seen => *seen = true,
                _ => {
                    return Err(FemError::Point {
                        point: *point,
                        count,
                    });
                }
            }
        }
        let nodes = points.iter().map(|point| self.nodes[*point]).collect();
        self.exchange(model, nodes);
        Ok(())
    }

    /// Exchanged components, as places in the fields.
    pub(crate) fn components(&self) -> &[usize] {
        &self.components
    }

    /// The matrix for this number of steps, computed at the first request.
    pub(crate) fn condensed(
        &mut self,
        what: Condensed,
        substeps: u32,
        compute: impl FnOnce(&[usize]) -> Vec<f64>,
    ) -> &[f64] {
        self.condensed
            .entry((what, substeps))
            .or_insert_with(|| compute(&self.components))
    }

    /// Whether the matrix for this number of steps is known.
    pub(crate) fn knows(&self, what: Condensed, substeps: u32) -> bool {
        self.condensed.contains_key(&(what, substeps))
    }

    fn exchange(&mut self, model: &Model, nodes: Vec<[usize; 2]>) {
        let layout = model.body.layout();
        let places = nodes
            .iter()
            .flat_map(|node| [0, 1].map(|k| layout.index(*node, k)));
        self.components = places.collect();
        self.condensed.clear();
    }
}

/// The sets that can be coupled: open lines on the outline, but for a support.
pub(crate) fn sets(model: &Model) -> Vec<String> {
    let sets = model.mesh.sets().into_iter();
    let movable = sets.filter(|name| !(model.supported && *name == Edge::Bottom.name()));
    let lines = movable.filter(|name| model.mesh.open_line(name).is_some());
    lines.map(String::from).collect()
}

fn surface(model: &Model, nodes: &[[usize; 2]], length_m: Vec<f64>) -> Surface {
    let place = |mesh: &Mesh, k: usize| nodes.iter().map(|n| mesh.point(n[0], n[1])[k]).collect();
    Surface {
        x_m: place(&model.mesh, 0),
        y_m: place(&model.mesh, 1),
        mass_kg: nodes
            .iter()
            .map(|node| model.body.node_mass(*node))
            .collect(),
        radius_m: vec![0.0; nodes.len()],
        length_m,
    }
}
