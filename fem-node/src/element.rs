//! The discretised body: masses, supports and the internal forces of its elements.
//!
//! Every nodal field is stored row after row; a row of nodes holds its x components, then its y components,
//! each padded with zeros to [`Layout::stride`], so that packs of neighbours never need a special case. All nodes of a
//! mesh that is no block form one row, and its elements gather from it what they need.

mod gather;
mod q4_1point;
mod q4_2x2;
mod q4_bbar;
mod row;
mod stiffness;

use std::ops::Range;
use std::sync::Arc;

use crate::config::{Base, ElementKind, Sides};
use crate::material::Elastic;
use crate::material::j2::{HISTORY, remembered};
use crate::material::point::PointLaw;
use crate::mesh::{Cells, Edge, Mesh};
use crate::pack::LANES;

pub(crate) use gather::{CORNER_FORCES, Gathered, Nodal};
use q4_1point::Q4OnePoint;
use q4_2x2::Q4Full;
use q4_bbar::Q4MeanDilatation;
pub(crate) use row::{CornerRows, Course, RowForces, Standing};
pub use stiffness::Stiffness;

/// 1/sqrt(3), the coordinate of the 2 x 2 Gauss points.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Natural coordinates of the 2 x 2 Gauss points; each has the weight 1.
pub const GAUSS_POINTS: [[f64; 2]; 4] = [
    [-GAUSS, -GAUSS],
    [GAUSS, -GAUSS],
    [GAUSS, GAUSS],
    [-GAUSS, GAUSS],
];

/// Where the components of the nodes are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Of elements.
    columns: usize,
    rows: usize,
    /// Of nodes.
    nodes_in_row: usize,
    node_rows: usize,
    stride: usize,
    /// Whether the last node of each row is the first one.
    periodic: bool,
}

impl Layout {
    fn new(mesh: &Mesh) -> Layout {
        let nodes_in_row = mesh.nodes_in_row();
        let mut layout = Layout {
            columns: mesh.columns(),
            rows: mesh.rows(),
            nodes_in_row,
            node_rows: mesh.points().len() / nodes_in_row,
            stride: nodes_in_row.next_multiple_of(LANES),
            periodic: mesh.periodic(),
        };
        if mesh.cells().is_none() {
            layout.stride = layout.element_stride();
        }
        layout
    }

    /// Forces on a row of nodes: the last node of a periodic row hands its own to the first, so that each counts once.
    pub(crate) fn gather(self, force: &mut [f64]) {
        if !self.periodic {
            return;
        }
        for component in force.chunks_exact_mut(self.stride()) {
            component[0] += component[self.columns];
            component[self.columns] = 0.0;
        }
    }

    /// Rows of displacements or their rates: the last node of a periodic row moves like the first.
    pub(crate) fn spread(self, motion: &mut [f64]) {
        if !self.periodic {
            return;
        }
        for component in motion.chunks_exact_mut(self.stride()) {
            component[self.columns] = component[0];
        }
    }

    /// The component that this one moves with, itself except in the last node of a periodic row.
    pub(crate) fn tied_to(self, index: usize) -> usize {
        match self.periodic && index % self.stride() == self.columns {
            true => index - self.columns,
            false => index,
        }
    }

    /// Elements in a row.
    pub fn element_columns(self) -> usize {
        self.columns
    }

    /// Rows of elements.
    pub fn element_rows(self) -> usize {
        self.rows
    }

    /// Numbers that a row of elements keeps for one component at its corners: room to load and to store a whole pack
    /// one column to the right of any element.
    fn element_stride(self) -> usize {
        self.padded_columns() + LANES
    }

    /// Elements in a row, rounded up to whole packs.
    fn padded_columns(self) -> usize {
        self.columns.next_multiple_of(LANES)
    }

    /// Numbers that a row of nodes keeps for one component: all nodes, and in a block room to load a whole pack from
    /// any of them.
    pub fn stride(self) -> usize {
        self.stride
    }

    /// Numbers in a row of nodes.
    pub fn row_len(self) -> usize {
        2 * self.stride()
    }

    /// Rows of nodes.
    pub fn node_rows(self) -> usize {
        self.node_rows
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
            (0..layout.node_rows).flat_map(|j| (0..layout.nodes_in_row).map(move |i| [i, j]));
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

/// Area of a quadrilateral (m2), positive when its corners run anticlockwise.
pub(crate) fn area(p: &[[f64; 2]; 4]) -> f64 {
    0.5 * ((p[2][0] - p[0][0]) * (p[3][1] - p[1][1]) - (p[3][0] - p[1][0]) * (p[2][1] - p[0][1]))
}

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

/// Area of the element over that of the natural square, at natural coordinates (m2).
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

/// Derivatives (N,xi N,eta) of N = (1 + xi xi_a)(1 + eta eta_a)/4.
fn natural_slopes([xi, eta]: [f64; 2]) -> [[f64; 2]; 4] {
    let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    signs.map(|[s, t]| [0.25 * s * (1.0 + t * eta), 0.25 * t * (1.0 + s * xi)])
}

fn fixed_components(mesh: &Mesh, supports: Supports, layout: Layout) -> Vec<usize> {
    let bottom = mesh.edge(Edge::Bottom);
    let mut fixed: Vec<usize> = bottom.iter().map(|node| layout.index(*node, 1)).collect();
    match (supports.base, supports.sides) {
        (Base::Free, _) => fixed.clear(),
        (Base::Clamped, _) => fixed.extend(bottom.iter().map(|node| layout.index(*node, 0))),
        (Base::Roller, Sides::Free) => {
            let middle = bottom.get(bottom.len() / 2);
            fixed.extend(middle.map(|node| layout.index(*node, 0)));
        }
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
    fn distorted() -> Mesh {
        Mesh::structured(6, 4, |i, j| {
            let wobble = |k: usize| 0.2 * ((k * 7919 + 13) % 101) as f64 / 101.0;
            let k = j * 7 + i;
            [i as f64 + wobble(k), -1.3 * j as f64 + wobble(k + 50)]
        })
    }

    fn law(plane: crate::config::Plane) -> Elastic {
        let material = crate::config::MaterialConfig::elastic(3.0, 0.3, 1.0);
        Elastic::new(&material, plane)
    }

    /// The row kernels regroup the formulas of the matrices, which are those of the books.
    #[test]
    fn the_forces_of_a_body_are_its_stiffness_times_the_displacements() {
        use crate::config::Plane;
        let mesh = distorted();
        for kind in [
            ElementKind::Q4OnePoint,
            ElementKind::Q4Full,
            ElementKind::Q4MeanDilatation,
        ] {
            for plane in [Plane::Strain, Plane::Stress] {
                let (law, t) = (law(plane), 0.7);
                let body = Body::new(&mesh, kind, &law, Supports::default(), t);
                let layout = body.layout();
                let motion =
                    |n: [usize; 2], k: usize| ((31 * n[0] + 17 * n[1] + 5 * k) as f64).sin();
                let (mut u, mut exact) = (vec![0.0; layout.len()], vec![0.0; layout.len()]);
                for (i, j) in (0..4).flat_map(|j| (0..6).map(move |i| (i, j))) {
                    let corners = mesh.corners(i, j);
                    let points = corners.map(|n| mesh.point(n[0], n[1]));
                    let stiffness = stiffness(kind, &points, &law, t);
                    let places: [usize; 8] =
                        std::array::from_fn(|r| layout.index(corners[r / 2], r % 2));
                    let moved: [f64; 8] = std::array::from_fn(|r| motion(corners[r / 2], r % 2));
                    for (row, place) in stiffness.0.iter().zip(places) {
                        exact[place] += row.iter().zip(moved).map(|(k, u)| k * u).sum::<f64>();
                    }
                    places.iter().zip(moved).for_each(|(p, m)| u[*p] = m);
                }
                let mut force = vec![0.0; layout.len()];
                body.internal_force(&u, &mut force);
                let scale = exact.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
                for (computed, exact) in force.iter().zip(&exact) {
                    let error = (computed - exact).abs();
                    assert!(error <= 1e-12 * scale, "{kind:?} {computed} {exact}");
                }
            }
        }
    }

    const COROTATIONAL: PointLaw = PointLaw {
        kinematics: crate::config::Kinematics::Corotational,
        plastic: None,
    };
    const ROTATING: [ElementKind; 2] = [ElementKind::Q4OnePoint, ElementKind::Q4Full];

    /// The field x -> place(x) - x of a body and the forces of the corotational law under it.
    fn moved(body: &Body, mesh: &Mesh, place: impl Fn([f64; 2]) -> [f64; 2]) -> [Vec<f64>; 2] {
        let mut u = vec![0.0; body.layout().len()];
        for (i, j) in (0..=mesh.rows()).flat_map(|j| (0..=mesh.columns()).map(move |i| (i, j))) {
            let (x, y) = (mesh.point(i, j), place(mesh.point(i, j)));
            (0..2).for_each(|k| u[body.layout().index([i, j], k)] = y[k] - x[k]);
        }
        let force = forces(body, &u);
        [u, force]
    }

    fn forces(body: &Body, u: &[f64]) -> Vec<f64> {
        let layout = body.layout();
        let mut rows = RowForces::new(layout);
        let mut force = vec![0.0; layout.len()];
        for row in 0..layout.node_rows() {
            match row + 1 < layout.node_rows() {
                true => {
                    let course = Course {
                        u: CornerRows::between([&u[layout.row(row)], &u[layout.row(row + 1)]]),
                        du: CornerRows::between([&[], &[]]),
                        history: &mut [],
                    };
                    body.element_row_by(&COROTATIONAL, row, course, &mut rows);
                }
                false => rows.clear_upper(),
            }
            rows.assemble(&mut force[layout.row(row)]);
            rows.advance();
        }
        force
    }

    fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
        let (sin, cos) = angle.sin_cos();
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// Not affine, so that the hourglass modes take part; strains of some 1e-2.
    fn bent([x, y]: [f64; 2]) -> [f64; 2] {
        [x + 0.01 * x * y, y - 0.02 * y + 0.005 * x * x]
    }

    #[test]
    fn a_rotation_gives_no_force_and_turns_the_forces_of_a_stretch() {
        let (mesh, law) = (distorted(), law(crate::config::Plane::Strain));
        for kind in ROTATING {
            let body = Body::new(&mesh, kind, &law, Supports::default(), 0.7);
            let [_, still] = moved(&body, &mesh, bent);
            let scale = still.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
            for angle in [0.3, 1.6, -2.9] {
                let [_, none] = moved(&body, &mesh, |x| rotated(x, angle));
                assert!(
                    none.iter().all(|f| f.abs() < 1e-12 * scale / 0.01),
                    "{kind:?} {angle}"
                );
                let [_, turned] = moved(&body, &mesh, |x| rotated(bent(x), angle));
                for (i, j) in (0..=4).flat_map(|j| (0..=6).map(move |i| (i, j))) {
                    let of = |f: &[f64]| [0, 1].map(|k| f[body.layout().index([i, j], k)]);
                    let (exact, computed) = (rotated(of(&still), angle), of(&turned));
                    let error = (exact[0] - computed[0]).hypot(exact[1] - computed[1]);
                    assert!(error < 1e-11 * scale / 0.01, "{kind:?} {angle}: {error:e}");
                }
            }
        }
    }

    /// Central differences of U = u F / 2 + [`Body::energy_beyond`], in rough directions.
    #[test]
    fn the_forces_of_a_rotated_body_are_the_slope_of_its_energy() {
        let (mesh, law) = (distorted(), law(crate::config::Plane::Strain));
        for kind in ROTATING {
            let body = Body::new(&mesh, kind, &law, Supports::default(), 0.7);
            let [u, force] = moved(&body, &mesh, |x| rotated(bent(x), 0.8));
            let energy = |u: &[f64]| {
                let work: f64 = u.iter().zip(forces(&body, u)).map(|(u, f)| u * f).sum();
                0.5 * work + body.energy_beyond(&COROTATIONAL, u, &[])
            };
            for seed in 0..5 {
                let mut along = vec![0.0; u.len()];
                for (i, j) in (0..=4).flat_map(|j| (0..=6).map(move |i| (i, j))) {
                    let rough = |k: usize| ((seed * 91 + 31 * i + 17 * j + 5 * k) as f64).sin();
                    (0..2).for_each(|k| along[body.layout().index([i, j], k)] = rough(k));
                }
                let at = |share: f64| -> Vec<f64> {
                    u.iter().zip(&along).map(|(u, d)| u + share * d).collect()
                };
                let slope = (energy(&at(1e-5)) - energy(&at(-1e-5))) / 2e-5;
                let exact: f64 = force.iter().zip(&along).map(|(f, d)| f * d).sum();
                let scale: f64 = force.iter().zip(&along).map(|(f, d)| (f * d).abs()).sum();
                assert!(
                    (slope - exact).abs() < 1e-6 * scale,
                    "{kind:?}: {slope} {exact}"
                );
            }
        }
    }
}
