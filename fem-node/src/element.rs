//! The discretised body: masses, supports and the internal forces of its elements.
//!
//! Every nodal field is stored row after row; a row of nodes holds its x components, then its y components,
//! each padded with zeros to [`Layout::stride`], so that packs of neighbours never need a special case.

mod q4_1point;

use std::ops::Range;

use crate::config::{Base, ElementKind, Sides};
use crate::material::Elastic;
use crate::mesh::{Edge, Mesh};
use crate::pack::LANES;

use q4_1point::Q4OnePoint;
pub(crate) use q4_1point::RowForces;

/// Where the components of the nodes are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    columns: usize,
    rows: usize,
}

impl Layout {
    fn new(mesh: &Mesh) -> Layout {
        Layout {
            columns: mesh.columns(),
            rows: mesh.rows(),
        }
    }

    /// Elements in a row, rounded up to whole packs.
    fn padded_columns(self) -> usize {
        self.columns.next_multiple_of(LANES)
    }

    /// Numbers that a row keeps for one component: all nodes, and room to load a whole pack from any of them.
    pub fn stride(self) -> usize {
        self.padded_columns() + LANES
    }

    /// Numbers in a row of nodes.
    pub fn row_len(self) -> usize {
        2 * self.stride()
    }

    /// Rows of nodes.
    pub fn node_rows(self) -> usize {
        self.rows + 1
    }

    /// Numbers in a field.
    pub fn len(self) -> usize {
        self.node_rows() * self.row_len()
    }

    /// Whether the field is empty; it never is.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Place of component 0 (x) or 1 (y) of the node (column, row).
    pub fn index(self, node: [usize; 2], component: usize) -> usize {
        node[1] * self.row_len() + component * self.stride() + node[0]
    }

    /// The row of nodes that holds this place.
    pub fn row_of(self, index: usize) -> usize {
        index / self.row_len()
    }

    /// The places of a row of nodes.
    pub fn row(self, row: usize) -> Range<usize> {
        row * self.row_len()..(row + 1) * self.row_len()
    }
}

/// A body ready to be integrated in time.
#[derive(Clone, Debug)]
pub struct Body {
    layout: Layout,
    /// Mass of each component (kg), lumped, zero at supports and in the padding.
    pub mass: Vec<f64>,
    /// Its inverse (1/kg), zero where the component cannot move.
    pub inverse_mass: Vec<f64>,
    /// Mass of each node (kg), supports included; row after row without padding.
    node_mass: Vec<f64>,
    element: Element,
}

/// The closed set of elements.
#[derive(Clone, Debug)]
enum Element {
    Q4OnePoint(Q4OnePoint),
}

/// Which components are held at zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Supports {
    /// Lower edge.
    pub base: Base,
    /// Lateral edges.
    pub sides: Sides,
}

impl Body {
    /// Lumps the masses, a quarter of each element to each of its corners, and prepares the elements.
    pub fn new(
        mesh: &Mesh,
        kind: ElementKind,
        elastic: &Elastic,
        supports: Supports,
        thickness: f64,
    ) -> Body {
        let layout = Layout::new(mesh);
        let element = match kind {
            ElementKind::Q4OnePoint => {
                Element::Q4OnePoint(Q4OnePoint::new(mesh, layout, elastic, thickness))
            }
        };
        let node_mass = lump(mesh, elastic.density * thickness);
        let mut body = Body {
            layout,
            mass: vec![0.0; layout.len()],
            inverse_mass: vec![0.0; layout.len()],
            node_mass,
            element,
        };
        body.spread_masses(&fixed_components(mesh, supports, layout));
        body
    }

    /// Where the components are stored.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Lumped mass of the node (column, row) (kg), supported or not.
    pub fn node_mass(&self, node: [usize; 2]) -> f64 {
        self.node_mass[node[1] * (self.layout.columns + 1) + node[0]]
    }

    /// Internal forces F(u) of the whole body (N), supports included.
    pub fn internal_force(&self, u: &[f64], force: &mut [f64]) {
        let layout = self.layout;
        let mut rows = RowForces::new(layout);
        for row in 0..layout.node_rows() {
            match row + 1 < layout.node_rows() {
                true => {
                    self.element_row(row, &u[layout.row(row)], &u[layout.row(row + 1)], &mut rows)
                }
                false => rows.clear_upper(),
            }
            rows.assemble(&mut force[layout.row(row)]);
            rows.advance();
        }
    }

    /// Forces of the elements between two rows of nodes, of which `row` is the upper one.
    pub(crate) fn element_row(
        &self,
        row: usize,
        upper: &[f64],
        lower: &[f64],
        out: &mut RowForces,
    ) {
        match &self.element {
            Element::Q4OnePoint(elements) => elements.row(row, upper, lower, out),
        }
    }

    fn spread_masses(&mut self, fixed: &[usize]) {
        let layout = self.layout;
        let nodes = (0..layout.node_rows()).flat_map(|j| (0..=layout.columns).map(move |i| [i, j]));
        for (node, mass) in nodes.zip(&self.node_mass) {
            for component in 0..2 {
                self.mass[layout.index(node, component)] = *mass;
                self.inverse_mass[layout.index(node, component)] = 1.0 / mass;
            }
        }
        for index in fixed {
            self.mass[*index] = 0.0;
            self.inverse_mass[*index] = 0.0;
        }
    }
}

/// Lumped mass of each node, `surface_density` being density times thickness (kg/m2).
fn lump(mesh: &Mesh, surface_density: f64) -> Vec<f64> {
    let mut mass = vec![0.0; mesh.points().len()];
    for j in 0..mesh.rows() {
        for i in 0..mesh.columns() {
            let corners = mesh.corners(i, j);
            let quarter = 0.25 * surface_density * area(&corners.map(|n| mesh.point(n[0], n[1])));
            for [column, row] in corners {
                mass[row * (mesh.columns() + 1) + column] += quarter;
            }
        }
    }
    mass
}

/// Area of a quadrilateral (m2), positive when its corners run anticlockwise.
pub(crate) fn area(p: &[[f64; 2]; 4]) -> f64 {
    0.5 * ((p[2][0] - p[0][0]) * (p[3][1] - p[1][1]) - (p[3][0] - p[1][0]) * (p[2][1] - p[0][1]))
}

fn fixed_components(mesh: &Mesh, supports: Supports, layout: Layout) -> Vec<usize> {
    let bottom = mesh.edge(Edge::Bottom);
    let mut fixed: Vec<usize> = bottom.iter().map(|node| layout.index(*node, 1)).collect();
    match (supports.base, supports.sides) {
        (Base::Clamped, _) => fixed.extend(bottom.iter().map(|node| layout.index(*node, 0))),
        (Base::Roller, Sides::Free) => fixed.push(layout.index(bottom[bottom.len() / 2], 0)),
        (Base::Roller, Sides::FixedX) => {}
    }
    if supports.sides == Sides::FixedX {
        for edge in [Edge::Left, Edge::Right] {
            fixed.extend(mesh.edge(edge).iter().map(|node| layout.index(*node, 0)));
        }
    }
    fixed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_of_a_trapezium_is_right() {
        assert_eq!(area(&[[0.0, 0.0], [4.0, 0.0], [3.0, 2.0], [1.0, 2.0]]), 6.0);
    }

    #[test]
    fn lumped_masses_add_up_to_the_body() {
        let mesh = Mesh::structured(3, 2, |i, j| [i as f64 + 0.1 * j as f64, -2.0 * j as f64]);
        let total: f64 = lump(&mesh, 5.0).iter().sum();
        assert!((total - 5.0 * 12.0).abs() < 1e-12);
    }
}
