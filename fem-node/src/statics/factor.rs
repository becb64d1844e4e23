//! Stiffness of the body and its Cholesky factor.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

use crate::element::body;
use crate::element::layout::Layout;
use crate::error::FemError;
use crate::model::Model;

/// Right-hand sides that are solved together: the factor is read once for all of them.
const SOLVED_TOGETHER: usize = 16;

/// K = L L^T of the components that can move.
pub(crate) struct Factor {
    layout: Layout,
    /// Component of each equation.
    components: Vec<usize>,
    /// Equation of each component, [`FIXED`] where there is none.
    equations: Vec<u32>,
    llt: Llt<u32, f64>,
}

/// The equation of a component that cannot move.
const FIXED: u32 = u32::MAX;

impl Factor {
    pub(super) fn new(model: &Model) -> Result<Factor, FemError> {
        let (components, equations) = number(model);
        let size = components.len();
        let failed = |reason: String| FemError::Factor {
            equations: size,
            reason,
        };
        let triplets = assemble(model, &equations);
        let matrix = SparseColMat::try_new_from_triplets(size, size, &triplets)
            .map_err(|error| failed(format!("{error:?}")))?;
        drop(triplets);
        let symbolic = SymbolicLlt::try_new(matrix.symbolic(), Side::Lower)
            .map_err(|error| failed(format!("{error:?}")))?;
        let llt = Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower)
            .map_err(|error| failed(format!("{error:?}")))?;
        Ok(Factor {
            layout: model.body.layout,
            components,
            equations,
            llt,
        })
    }

    /// True where the component can move.
    pub(super) fn moves(&self, component: usize) -> bool {
        self.equations[component] != FIXED
    }

    /// Solves K u = f: displacements of the whole body under these forces, a field in the layout of the body.
    pub(crate) fn solve(&self, force: &[f64]) -> Vec<f64> {
        let mut x = Mat::from_fn(self.components.len(), 1, |i, _| force[self.components[i]]);
        self.llt.solve_in_place(x.as_mut());
        let mut u = vec![0.0; force.len()];
        for (row, component) in self.components.iter().enumerate() {
            u[*component] = x[(row, 0)];
        }
        self.layout.repeat_period(&mut u);
        u
    }

    /// Displacements of the components `at` under a unit force on each of the components `sources`, column by column.
    pub(super) fn columns(&self, sources: &[usize], at: &[usize]) -> Vec<Vec<f64>> {
        let mut columns = Vec::with_capacity(sources.len());
        for group in sources.chunks(SOLVED_TOGETHER) {
            let mut x = Mat::<f64>::zeros(self.components.len(), group.len());
            for (j, source) in group.iter().enumerate().filter(|(_, s)| self.moves(**s)) {
                x[(self.equations[*source] as usize, j)] = 1.0;
            }
            self.llt.solve_in_place(x.as_mut());
            columns.extend((0..group.len()).map(|j| {
                let value = |component: &usize| match self.equations[*component] {
                    FIXED => 0.0,
                    row => x[(row as usize, j)],
                };
                at.iter().map(value).collect::<Vec<f64>>()
            }));
        }
        columns
    }
}

/// The components that can move, node after node, and the equation of each.
fn number(model: &Model) -> (Vec<usize>, Vec<u32>) {
    let (layout, mesh) = (model.body.layout, &model.mesh);
    let all = mesh
        .nodes()
        .flat_map(|node| [0, 1].map(|k| layout.index(node, k)));
    let components: Vec<usize> = all.filter(|i| model.body.inverse_mass[*i] > 0.0).collect();
    let mut equations = vec![FIXED; layout.len()];
    for (row, component) in components.iter().enumerate() {
        equations[*component] = row as u32;
    }
    for index in 0..layout.len() {
        equations[index] = equations[layout.tied_to(index)];
    }
    (components, equations)
}

/// Entries of the lower triangle, element after element.
fn assemble(model: &Model, equations: &[u32]) -> Vec<Triplet<u32, u32, f64>> {
    let (layout, mesh) = (model.body.layout, &model.mesh);
    let mut triplets = Vec::with_capacity(36 * mesh.elements());
    for [i, j] in mesh.element_indices() {
        let corners = mesh.corners(i, j);
        let points = corners.map(|n| mesh.point(n[0], n[1]));
        let stiffness = body::stiffness(model.element, &points, &model.elastic, model.thickness);
        let rows: [u32; 8] =
            std::array::from_fn(|r| equations[layout.index(corners[r / 2], r % 2)]);
        for (r, c) in (0..8).flat_map(|r| (0..8).map(move |c| (r, c))) {
            if rows[r] != FIXED && rows[c] != FIXED && rows[r] >= rows[c] {
                triplets.push(Triplet::new(rows[r], rows[c], stiffness.0[r][c]));
            }
        }
    }
    triplets
}
