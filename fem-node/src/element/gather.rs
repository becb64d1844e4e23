//! Elements of a mesh that is no block: they gather the displacements of their corners from one row of nodes, and
//! every node sums the forces of the elements around it in an order of its own, whichever thread asks.

use super::row::{CornerRows, Course, RowForces, Standing};
use super::{Body, Layout};
use crate::material::point::PointLaw;
use crate::mesh::Cells;

/// Numbers that an element leaves: x and y of the force on each corner.
pub(crate) const CORNER_FORCES: usize = 8;

/// Room for one row of elements.
#[derive(Clone, Debug)]
pub(crate) struct Gathered {
    u: [Vec<f64>; 4],
    /// Empty where the points do not remember.
    du: [Vec<f64>; 4],
    forces: RowForces,
}

impl Gathered {
    pub(crate) fn new(layout: Layout) -> Gathered {
        let zero = || vec![0.0; 2 * layout.element_stride()];
        Gathered {
            u: [zero(), zero(), zero(), zero()],
            du: Default::default(),
            forces: RowForces::new(layout),
        }
    }

    /// With room for what the points remember.
    pub(crate) fn remembering(self, layout: Layout, law: &PointLaw) -> Gathered {
        match law.plastic {
            Some(_) => Gathered {
                du: Gathered::new(layout).u,
                ..self
            },
            None => self,
        }
    }
}

/// A nodal field and its increments in the last step, the latter empty where the points do not remember.
#[derive(Clone, Copy)]
pub(crate) struct Nodal<'a> {
    pub(crate) u: &'a [f64],
    pub(crate) du: &'a [f64],
}

impl Body {
    /// Elements of the mesh where it is no block.
    pub(crate) fn cells(&self) -> Option<&Cells> {
        self.cells.as_deref()
    }

    /// Forces of a row of elements on their corners, element after element, [`CORNER_FORCES`] each. Returns what they
    /// dissipated (J).
    pub(crate) fn gathered_row(
        &self,
        law: Option<&PointLaw>,
        row: usize,
        nodal: Nodal,
        (room, history): (&mut Gathered, &mut [f64]),
        out: &mut [f64],
    ) -> f64 {
        let layout = self.layout;
        let elements = self.elements_of(row);
        gather(elements, layout, nodal.u, &mut room.u);
        let forces = &mut room.forces;
        let dissipated = match law {
            None => {
                self.corner_row(row, apart(&room.u), forces);
                0.0
            }
            Some(law) => {
                if !room.du[0].is_empty() {
                    gather(elements, layout, nodal.du, &mut room.du);
                }
                let course = Course {
                    u: apart(&room.u),
                    du: apart(&room.du),
                    history,
                };
                self.element_row_by(law, row, course, forces)
            }
        };
        for (i, out) in out.chunks_exact_mut(CORNER_FORCES).enumerate() {
            out.copy_from_slice(&forces.of_element(layout.element_stride(), i));
        }
        dissipated
    }

    /// The forces on the nodes from `first` on, components (x, y) apart, summed over the elements around each.
    pub(crate) fn sum_corners(&self, corners: &[f64], first: usize, [x, y]: [&mut [f64]; 2]) {
        let cells = self.cells().expect("only meshes of cells gather");
        for (k, (x, y)) in x
            .iter_mut()
            .zip(y)
            .enumerate()
            .take(cells.nodes().saturating_sub(first))
        {
            (*x, *y) = (0.0, 0.0);
            for place in cells.around(first + k) {
                *x += corners[2 * *place as usize];
                *y += corners[2 * *place as usize + 1];
            }
        }
    }

    /// [`Body::internal_force`] of a mesh that is no block.
    pub(super) fn gathered_force(&self, u: &[f64], force: &mut [f64]) {
        let layout = self.layout;
        let mut room = Gathered::new(layout);
        let mut corners = vec![0.0; self.corner_forces_len()];
        let nodal = Nodal { u, du: &[] };
        for (row, out) in corners
            .chunks_mut(CORNER_FORCES * layout.columns)
            .enumerate()
        {
            self.gathered_row(None, row, nodal, (&mut room, &mut []), out);
        }
        let (x, y) = force.split_at_mut(layout.stride());
        self.sum_corners(&corners, 0, [x, y]);
    }

    /// Numbers that all elements leave.
    pub(crate) fn corner_forces_len(&self) -> usize {
        CORNER_FORCES * self.cells().map_or(0, |cells| cells.corners().len())
    }

    /// [`Body::energy_beyond`] of a mesh that is no block.
    pub(super) fn gathered_energy(&self, law: &PointLaw, u: &[f64], history: &[f64]) -> f64 {
        let size = self.history_row_len(law);
        let mut room = Gathered::new(self.layout);
        let mut sum = 0.0;
        for row in 0..self.layout.element_rows() {
            gather(self.elements_of(row), self.layout, u, &mut room.u);
            let now = Standing {
                u: apart(&room.u),
                history: &history[row * size..(row + 1) * size],
            };
            sum += self.row_energy(law, row, now);
        }
        sum
    }

    fn elements_of(&self, row: usize) -> &[[u32; 4]] {
        let cells = self.cells().expect("only meshes of cells gather");
        let first = row * self.layout.columns;
        let end = (first + self.layout.columns).min(cells.corners().len());
        &cells.corners()[first..end]
    }
}

/// What is beyond the last element of a row keeps older numbers: its forces go to nobody, and its share of the
/// energies has the volume zero.
fn gather(elements: &[[u32; 4]], layout: Layout, field: &[f64], into: &mut [Vec<f64>; 4]) {
    let (x, y) = field.split_at(layout.stride());
    let stride = layout.element_stride();
    for (corner, into) in into.iter_mut().enumerate() {
        let (into_x, into_y) = into.split_at_mut(stride);
        for ((element, into_x), into_y) in elements.iter().zip(into_x).zip(into_y) {
            let node = element[corner] as usize;
            (*into_x, *into_y) = (x[node], y[node]);
        }
    }
}

fn apart(corners: &[Vec<f64>; 4]) -> CornerRows<'_> {
    CornerRows::apart([0, 1, 2, 3].map(|corner| corners[corner].as_slice()))
}
