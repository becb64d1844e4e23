//! The discretised body: masses and the internal forces of its elements.

use std::ops::Range;
use std::sync::Arc;

use protocol::larger;
use schemars::JsonSchema;
use serde::Deserialize;

use super::corners::{CornerRows, StrainPath, StrainState};
use super::gather::{CORNER_FORCES, GatherBuffers, NodalFields, corner_rows, gather, sum_corners};
use super::layout::Layout;
use super::linear::{LinearRow, OverElements};
use super::q4_1point::{self, Q4OnePoint};
use super::q4_2x2::{Linear, Q4FourPoint};
use super::q4_bbar;
use super::row_forces::RowForces;
use crate::element::stiffness::{Stiffness, four_point};
use crate::material::Elastic;
use crate::material::j2::{HISTORY, history_at};
use crate::material::nonlinear::NonlinearLaw;
use crate::mesh::connectivity::Connectivity;
use crate::mesh::{Mesh, area};
use crate::pack::in_registers;
use crate::pack::lanes::{InRegisters, Registers};
use crate::pack::line::Lines;

/// Finite element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
pub enum ElementKind {
    /// Bilinear quadrilateral, one integration point, hourglass stiffness of Flanagan and Belytschko.
    #[serde(rename = "q4_1point")]
    Q4OnePoint,
    /// Bilinear quadrilateral, 2 x 2 integration points.
    #[serde(rename = "q4_2x2")]
    Q4Full,
    /// Bilinear quadrilateral, 2 x 2 points for the change of shape, one mean value for the change of volume; it
    /// does not lock when nearly incompressible.
    #[serde(rename = "q4_bbar")]
    Q4MeanDilatation,
}

/// A body ready to be integrated in time.
#[derive(Clone, Debug)]
pub struct Body {
    /// Storage of the components.
    pub layout: Layout,
    /// Mass of each component (kg), lumped, zero at supports, in the padding, and where a node moves with another one.
    pub mass: Lines,
    /// Its inverse (1/kg), zero where the component cannot move.
    pub inverse_mass: Lines,
    /// Mass of each node (kg), supports included; row after row without padding.
    node_mass: Vec<f64>,
    element: Element,
    /// Connectivity of an unstructured mesh.
    pub connectivity: Option<Arc<Connectivity>>,
}

/// History and dissipation of a row of elements, both empty under a law without history.
#[derive(Default)]
pub(crate) struct ElementRow<'a> {
    pub(crate) history: &'a mut [f64],
    pub(crate) dissipated: &'a mut [f64],
}

/// The closed set of elements.
#[derive(Clone, Debug)]
enum Element {
    OnePoint(Q4OnePoint),
    FourPoint(Q4FourPoint),
}

/// Runs `$work` on either kind of elements.
macro_rules! of_kind {
    ($element:expr, $elements:ident: $work:expr) => {
        match $element {
            Element::OnePoint($elements) => $work,
            Element::FourPoint($elements) => $work,
        }
    };
}

/// A computation over a row of the elements.
struct OverRow<'a, C> {
    element: &'a Element,
    row: usize,
    computation: C,
}

impl<C: OverElements> InRegisters for OverRow<'_, C> {
    #[inline(always)]
    fn run<R: Registers>(self, registers: R) {
        let (row, computation) = (self.row, self.computation);
        match self.element {
            Element::OnePoint(elements) => computation.over(registers, elements, row),
            Element::FourPoint(elements) if elements.mean_dilatation => {
                computation.over(registers, &Linear::<true>(elements), row);
            }
            Element::FourPoint(elements) => {
                computation.over(registers, &Linear::<false>(elements), row);
            }
        }
    }
}

impl Body {
    /// Lumps the masses, a quarter of each element to each of its corners, and prepares the elements.
    pub fn new(mesh: &Mesh, kind: ElementKind, elastic: &Elastic, thickness: f64) -> Body {
        let layout = Layout::new(mesh);
        let element = if kind == ElementKind::Q4OnePoint {
            Element::OnePoint(Q4OnePoint::new(mesh, layout, elastic, thickness))
        } else {
            let mean = kind == ElementKind::Q4MeanDilatation;
            Element::FourPoint(Q4FourPoint::new(mesh, layout, elastic, thickness, mean))
        };
        let node_mass = lump(mesh, elastic.density * thickness);
        let mut body = Body {
            layout,
            mass: Lines::zeros(layout.len()),
            inverse_mass: Lines::zeros(layout.len()),
            node_mass,
            element,
            connectivity: mesh.connectivity.clone(),
        };
        body.spread_masses();
        body
    }

    /// The piece of a structured body with these columns of nodes and the elements between them.
    pub fn piece(&self, columns: &Range<usize>) -> Body {
        let (all, layout) = (self.layout, self.layout.piece(columns));
        let nodal = |field: &[f64]| {
            let mut piece = Lines::zeros(layout.len());
            for (row, field) in piece
                .chunks_mut(layout.stride)
                .zip(field.chunks(all.stride))
            {
                row[..columns.len()].copy_from_slice(&field[columns.clone()]);
            }
            piece
        };
        let node_mass = self.node_mass.chunks(all.nodes_in_row);
        Body {
            layout,
            mass: nodal(&self.mass),
            inverse_mass: nodal(&self.inverse_mass),
            node_mass: node_mass
                .flat_map(|row| row[columns.clone()].to_vec())
                .collect(),
            element: match &self.element {
                Element::OnePoint(elements) => {
                    Element::OnePoint(elements.piece(layout, columns.start))
                }
                Element::FourPoint(elements) => {
                    Element::FourPoint(elements.piece(layout, columns.start))
                }
            },
            connectivity: None,
        }
    }

    /// Removes components from the equations of motion.
    pub fn fix(&mut self, components: impl Iterator<Item = usize>) {
        for index in components {
            self.mass[index] = 0.0;
            self.inverse_mass[index] = 0.0;
        }
    }

    /// Lumped mass of the node (column, row) (kg), supported or not.
    pub fn node_mass(&self, node: [usize; 2]) -> f64 {
        self.node_mass[node[1] * self.layout.nodes_in_row + node[0]]
    }

    /// Internal forces F(u) = sum over the elements of the integral of B^T s (N), on the whole body, supports included.
    pub fn internal_force(&self, u: &[f64], force: &mut [f64]) {
        let layout = self.layout;
        if let Some(connectivity) = self.connectivity.as_ref() {
            let mut corners = vec![0.0; CORNER_FORCES * self.elements()];
            let mut buffers = GatherBuffers::new(layout, false);
            let fields = NodalFields { u, du: &[] };
            let rows = corners.chunks_mut(CORNER_FORCES * layout.columns);
            for (row, out) in rows.enumerate() {
                self.gathered_row(None, row, fields, &mut buffers, Default::default(), out);
            }
            let (x, y) = force.split_at_mut(layout.stride);
            return sum_corners(connectivity, &corners, 0, [x, y]);
        }
        let mut rows = RowForces::new(layout);
        for row in 0..layout.node_rows {
            if row + 1 < layout.node_rows {
                let all = 0..layout.padded_columns();
                self.element_row(row, structured_row(layout, u, row), all, &mut rows);
            } else {
                rows.clear_upper();
            }
            let all = layout.spans([0, layout.stride]);
            rows.assemble(&mut force[layout.row(row)], &all);
            layout.fold_period(&mut force[layout.row(row)]);
            rows.advance();
        }
    }

    /// Forces of some elements of a row, in whole packs, under the displacements of their corners.
    pub(crate) fn element_row(
        &self,
        row: usize,
        u: CornerRows,
        columns: Range<usize>,
        out: &mut RowForces,
    ) {
        let linear = LinearRow {
            u,
            stride: self.layout.element_stride(),
            columns,
            out,
        };
        self.over_linear(row, linear);
    }

    /// Runs a computation over a row of elements under a linear law.
    fn over_linear(&self, row: usize, computation: impl OverElements) {
        in_registers(OverRow {
            element: &self.element,
            row,
            computation,
        });
    }

    /// Forces of a row of elements of an unstructured mesh on their corners, element after element, [`CORNER_FORCES`] each.
    pub(crate) fn gathered_row(
        &self,
        law: Option<&NonlinearLaw>,
        row: usize,
        fields: NodalFields,
        buffers: &mut GatherBuffers,
        own: ElementRow,
        out: &mut [f64],
    ) {
        let layout = self.layout;
        let elements = self.gather_displacements(row, fields.u, &mut buffers.u);
        if !buffers.du[0].is_empty() {
            gather(elements, layout, fields.du, &mut buffers.du);
        }
        let (u, forces) = (corner_rows(&buffers.u), &mut buffers.forces);
        let all = 0..layout.padded_columns();
        match law {
            None => self.element_row(row, u, all, forces),
            Some(law) => {
                let path = StrainPath {
                    u,
                    du: corner_rows(&buffers.du),
                    history: own.history,
                    dissipated: own.dissipated,
                };
                self.nonlinear_row(law, row, path, all, forces);
            }
        }
        for (i, out) in out.chunks_exact_mut(CORNER_FORCES).enumerate() {
            out.copy_from_slice(&forces.of_element(layout.element_stride(), i));
        }
    }

    fn gather_displacements(&self, row: usize, u: &[f64], into: &mut [Vec<f64>; 4]) -> &[[u32; 4]] {
        let connectivity = self.connectivity.as_ref();
        let elements = connectivity
            .expect("only unstructured meshes gather")
            .row(row);
        gather(elements, self.layout, u, into);
        elements
    }

    /// Number of elements.
    pub(crate) fn elements(&self) -> usize {
        let structured = self.layout.rows * self.layout.columns;
        let connectivity = self.connectivity.as_ref();
        connectivity.map_or(structured, |all| all.corners.len())
    }

    /// Stored energy less u F(u) / 2 (J) under a nonlinear law.
    pub fn energy_correction(&self, law: &NonlinearLaw, u: &[f64], history: &[f64]) -> f64 {
        let (layout, size) = (self.layout, self.history_row_len(Some(law)));
        let mut gathered = [const { Vec::new() }; 4];
        if self.connectivity.is_some() {
            gathered = GatherBuffers::new(layout, false).u;
        }
        let mut sum = 0.0;
        for row in 0..layout.rows {
            if self.connectivity.is_some() {
                self.gather_displacements(row, u, &mut gathered);
            }
            let now = StrainState {
                u: match self.connectivity {
                    None => structured_row(layout, u, row),
                    Some(_) => corner_rows(&gathered),
                },
                history: &history[row * size..(row + 1) * size],
            };
            sum += of_kind!(&self.element, elements: elements.energy_correction(law, row, now));
        }
        sum
    }

    /// History variables of a row of elements.
    pub fn history_row_len(&self, law: Option<&NonlinearLaw>) -> usize {
        match law.and_then(NonlinearLaw::plastic) {
            Some(plastic) => {
                let factors = usize::from(plastic.softens) * self.layout.padded_columns();
                self.history_len() + factors
            }
            None => 0,
        }
    }

    /// The same without factors on the yield stress.
    fn history_len(&self) -> usize {
        self.history_blocks() * HISTORY * self.layout.padded_columns()
    }

    /// Sets the factors on the yield stress, behind the history of each row of elements. Returns the largest change of a factor, over what it was.
    pub fn soften(&self, history: &mut [f64], factor: impl Fn([usize; 2]) -> f64) -> f64 {
        let (own, padded) = (self.history_len(), self.layout.padded_columns());
        let mut changed = 0.0;
        for (j, row) in history.chunks_exact_mut(own + padded).enumerate() {
            for (i, value) in row[own..].iter_mut().enumerate() {
                let before = *value;
                *value = if i < self.layout.columns {
                    factor([i, j])
                } else {
                    1.0
                };
                changed = larger(changed, (*value / before - 1.0).abs());
            }
        }
        changed
    }

    /// Number of points at which an element has its own stress.
    fn points(&self) -> usize {
        match &self.element {
            Element::OnePoint(_) => 1,
            Element::FourPoint(_) => 4,
        }
    }

    /// Blocks of [`HISTORY`] variables of an element: one for each point, and the blocks of the hourglass modes.
    fn history_blocks(&self) -> usize {
        match &self.element {
            Element::OnePoint(_) => q4_1point::HISTORY_BLOCKS,
            Element::FourPoint(_) => 4,
        }
    }

    /// Plastic strain (pxx, pyy, 2 pxy) and its equivalent value at natural coordinates of an element: values of the nearest point, at the centroid
    /// the mean over the points.
    pub fn plastic_strain(
        &self,
        history: &[f64],
        [column, row]: [usize; 2],
        [xi, eta]: [f64; 2],
    ) -> [f64; HISTORY] {
        let padded = self.layout.padded_columns();
        let of_point = |point: usize| {
            let first = row * (history.len() / self.layout.rows) + point * HISTORY * padded;
            history_at(&history[first..first + HISTORY * padded], padded, column)
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

    fn spread_masses(&mut self) {
        let layout = self.layout;
        let nodes =
            (0..layout.node_rows).flat_map(|j| (0..layout.nodes_in_row).map(move |i| [i, j]));
        for (node, mass) in nodes.zip(&self.node_mass) {
            for component in 0..2 {
                self.mass[layout.index(node, component)] = *mass;
                self.inverse_mass[layout.index(node, component)] = 1.0 / mass;
            }
        }
        self.fix((0..layout.len()).filter(|index| layout.tied_to(*index) != *index));
    }
}

/// Tangent stiffness of one element: the derivative of its forces in the body.
pub fn stiffness(
    kind: ElementKind,
    corners: &[[f64; 2]; 4],
    elastic: &Elastic,
    thickness: f64,
) -> Stiffness {
    match kind {
        ElementKind::Q4OnePoint => q4_1point::stiffness(corners, elastic, thickness),
        ElementKind::Q4Full => four_point(corners, elastic.moduli(), thickness),
        ElementKind::Q4MeanDilatation => q4_bbar::stiffness(corners, elastic, thickness),
    }
}

/// Lumped mass of each node (kg), m_a = sum over its elements of rho t A / 4, `surface_density` being density times thickness (kg/m2).
pub(crate) fn lump(mesh: &Mesh, surface_density: f64) -> Vec<f64> {
    let mut mass = vec![0.0; mesh.points.len()];
    for [i, j] in mesh.element_indices() {
        let corners = mesh.corners(i, j);
        let quarter = 0.25 * surface_density * area(&corners.map(|n| mesh.point(n[0], n[1])));
        for node in corners {
            mass[mesh.number(mesh.tied_to(node))] += quarter;
        }
    }
    mass
}

/// Displacements of a row of elements of a structured mesh.
#[inline(always)]
fn structured_row(layout: Layout, u: &[f64], row: usize) -> CornerRows<'_> {
    CornerRows::between([&u[layout.row(row)], &u[layout.row(row + 1)]])
}

mod nonlinear;
#[cfg(test)]
pub(super) mod tests;
