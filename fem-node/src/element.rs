//! The discretised body: masses, supports and the internal forces of its elements.
//!
//! Every nodal field is stored row after row; a row of nodes holds its x components, then its y components,
//! each padded with zeros to [`Layout::stride`], so that packs of neighbours never need a special case. All nodes of a
//! mesh that is no block form one row, and its elements gather from it what they need.

mod gather;
mod layout;
mod q4_1point;
mod q4_2x2;
mod q4_bbar;
mod row;
mod shape;
mod stiffness;
mod supports;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::config::ElementKind;
use crate::material::Elastic;
use crate::material::j2::{HISTORY, remembered};
use crate::material::point::PointLaw;
use crate::mesh::{Cells, Mesh};

pub(crate) use gather::{CORNER_FORCES, Gathered, Nodal};
pub use layout::Layout;
use q4_1point::Q4OnePoint;
use q4_2x2::Q4Full;
use q4_bbar::Q4MeanDilatation;
pub(crate) use row::{CornerRows, Course, RowForces, Standing};
use shape::GAUSS;
pub(crate) use shape::area;
pub use shape::{GAUSS_POINTS, jacobian, slopes};
pub use stiffness::Stiffness;
pub use supports::Supports;
use supports::fixed_components;

/// A body ready to be integrated in time.
#[derive(Clone, Debug)]
pub struct Body {
    layout: Layout,
    /// Mass of each component (kg), lumped, zero at supports, in the padding, and where a node moves with another one.
    pub mass: Vec<f64>,
    /// Its inverse (1/kg), zero where the component cannot move.
    pub inverse_mass: Vec<f64>,
    /// Mass of each node (kg), supports included; row after row without padding.
    node_mass: Vec<f64>,
    element: Element,
    /// Of a mesh that is no block.
    cells: Option<Arc<Cells>>,
}

/// The closed set of elements.
#[derive(Clone, Debug)]
enum Element {
    OnePoint(Q4OnePoint),
    Full(Q4Full),
    MeanDilatation(Q4MeanDilatation),
}

impl Element {
    fn new(
        kind: ElementKind,
        mesh: &Mesh,
        layout: Layout,
        elastic: &Elastic,
        thickness: f64,
    ) -> Element {
        match kind {
            ElementKind::Q4OnePoint => {
                Element::OnePoint(Q4OnePoint::new(mesh, layout, elastic, thickness))
            }
            ElementKind::Q4Full => Element::Full(Q4Full::new(mesh, layout, elastic, thickness)),
            ElementKind::Q4MeanDilatation => {
                Element::MeanDilatation(Q4MeanDilatation::new(mesh, layout, elastic, thickness))
            }
        }
    }
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
        let element = Element::new(kind, mesh, layout, elastic, thickness);
        let node_mass = lump(mesh, elastic.density * thickness);
        let mut body = Body {
            layout,
            mass: vec![0.0; layout.len()],
            inverse_mass: vec![0.0; layout.len()],
            node_mass,
            element,
            cells: mesh.cells().cloned(),
        };
        body.spread_masses(&fixed_components(mesh, supports, layout));
        body
    }

    /// Takes components out of the equations of motion.
    pub(crate) fn hold(&mut self, components: impl Iterator<Item = usize>) {
        for index in components {
            self.mass[index] = 0.0;
            self.inverse_mass[index] = 0.0;
        }
    }

    /// Where the components are stored.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Lumped mass of the node (column, row) (kg), supported or not.
    pub fn node_mass(&self, node: [usize; 2]) -> f64 {
        self.node_mass[node[1] * self.layout.nodes_in_row + node[0]]
    }

    /// Internal forces F(u) of the whole body (N), supports included.
    pub fn internal_force(&self, u: &[f64], force: &mut [f64]) {
        if self.cells.is_some() {
            return self.gathered_force(u, force);
        }
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
            layout.gather(&mut force[layout.row(row)]);
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
        self.corner_row(row, CornerRows::between([upper, lower]), out);
    }

    /// The same under the displacements of the corners, wherever they are from.
    #[inline(always)]
    fn corner_row(&self, row: usize, u: CornerRows, out: &mut RowForces) {
        match &self.element {
            Element::OnePoint(elements) => elements.row(row, u, out),
            Element::Full(elements) => elements.row(row, u, out),
            Element::MeanDilatation(elements) => elements.row(row, u, out),
        }
    }

    /// Like [`Body::element_row`] under any law; returns what the elements dissipated (J).
    pub(crate) fn element_row_by(
        &self,
        law: &PointLaw,
        row: usize,
        course: Course,
        out: &mut RowForces,
    ) -> f64 {
        match &self.element {
            Element::OnePoint(elements) => elements.row_by(law, row, course, out),
            Element::Full(elements) => elements.row_by(law, row, course, out),
            Element::MeanDilatation(elements) => elements.row_by(law, row, course, out),
        }
    }

    /// Stored energy less u F(u) / 2 (J) under a law that is not linear.
    pub(crate) fn energy_beyond(&self, law: &PointLaw, u: &[f64], history: &[f64]) -> f64 {
        if self.cells.is_some() {
            return self.gathered_energy(law, u, history);
        }
        let layout = self.layout;
        let size = self.history_row_len(law);
        let mut sum = 0.0;
        for row in 0..layout.node_rows() - 1 {
            let now = Standing {
                u: CornerRows::between([&u[layout.row(row)], &u[layout.row(row + 1)]]),
                history: &history[row * size..(row + 1) * size],
            };
            sum += self.row_energy(law, row, now);
        }
        sum
    }

    fn row_energy(&self, law: &PointLaw, row: usize, now: Standing) -> f64 {
        match &self.element {
            Element::OnePoint(elements) => elements.energy_beyond(law, row, now),
            Element::Full(elements) => elements.energy_beyond(law, row, now),
            Element::MeanDilatation(elements) => elements.energy_beyond(law, row, now),
        }
    }

    /// Numbers that a row of elements remembers.
    pub(crate) fn history_row_len(&self, law: &PointLaw) -> usize {
        match law.plastic {
            Some(_) => self.points() * HISTORY * self.layout.padded_columns(),
            None => 0,
        }
    }

    /// Points in which an element has a stress of its own.
    fn points(&self) -> usize {
        match &self.element {
            Element::OnePoint(_) => 1,
            Element::Full(_) | Element::MeanDilatation(_) => 4,
        }
    }

    /// Plastic strain (pxx, pyy, 2 pxy) and its equivalent value at natural coordinates of an element: those of the
    /// nearest point, at the centroid the mean over the points.
    pub fn plastic_strain(
        &self,
        history: &[f64],
        [column, row]: [usize; 2],
        [xi, eta]: [f64; 2],
    ) -> [f64; HISTORY] {
        let padded = self.layout.padded_columns();
        let of_point = |point: usize| {
            let first = (row * self.points() + point) * HISTORY * padded;
            remembered(&history[first..first + HISTORY * padded], padded, column)
        };
        if history.is_empty() {
            return [0.0; HISTORY];
        }
        if self.points() == 1 {
            return of_point(0);
        }
        if xi == 0.0 && eta == 0.0 {
            let all = [0, 1, 2, 3].map(of_point);
            return std::array::from_fn(|k| 0.25 * all.iter().map(|p| p[k]).sum::<f64>());
        }
        of_point(2 * usize::from(eta > 0.0) + usize::from(xi > 0.0))
    }

    fn spread_masses(&mut self, fixed: &[usize]) {
        let layout = self.layout;
        let nodes =
            (0..layout.node_rows()).flat_map(|j| (0..layout.nodes_in_row).map(move |i| [i, j]));
        for (node, mass) in nodes.zip(&self.node_mass) {
            for component in 0..2 {
                self.mass[layout.index(node, component)] = *mass;
                self.inverse_mass[layout.index(node, component)] = 1.0 / mass;
            }
        }
        self.hold(fixed.iter().copied());
        self.hold((0..layout.len()).filter(|index| layout.tied_to(*index) != *index));
    }
}

/// Tangent stiffness of one element: the derivative of the forces that the body gives it.
pub fn stiffness(
    kind: ElementKind,
    corners: &[[f64; 2]; 4],
    elastic: &Elastic,
    thickness: f64,
) -> Stiffness {
    let moduli = [elastic.c11, elastic.c12, elastic.c33];
    match kind {
        ElementKind::Q4OnePoint => q4_1point::stiffness(corners, elastic, thickness),
        ElementKind::Q4Full => q4_2x2::stiffness(corners, moduli, thickness),
        ElementKind::Q4MeanDilatation => q4_bbar::stiffness(corners, elastic, thickness),
    }
}

/// Lumped mass of each node, `surface_density` being density times thickness (kg/m2).
fn lump(mesh: &Mesh, surface_density: f64) -> Vec<f64> {
    let mut mass = vec![0.0; mesh.points().len()];
    for [i, j] in mesh.places() {
        let corners = mesh.corners(i, j);
        let quarter = 0.25 * surface_density * area(&corners.map(|n| mesh.point(n[0], n[1])));
        for node in corners {
            mass[mesh.number(mesh.tied_to(node))] += quarter;
        }
    }
    mass
}
