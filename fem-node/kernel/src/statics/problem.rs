//! The body of an equilibrium problem, and its loads without a wheel.

use crate::element::body::{Body, ElementKind};
use crate::material::Elastic;
use crate::mesh::Mesh;

/// A linear elastic body and its nodal forces.
#[derive(Clone, Debug)]
pub struct StaticProblem<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The discretised body, whose components without mass cannot move.
    pub body: &'a Body,
    /// The law of the material.
    pub elastic: &'a Elastic,
    /// Kind of element.
    pub element: ElementKind,
    /// Thickness (m).
    pub thickness: f64,
    /// Nodal forces of the full tractions (N), a field in the layout of the body.
    pub tractions: Vec<f64>,
}
