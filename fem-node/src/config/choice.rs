//! Choices with a few named values each.

use fem_kernel::element::body;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of analysis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Analysis {
    /// Explicit dynamics.
    #[default]
    Dynamic,
    /// Equilibrium under the full load.
    Static,
}

/// Loading of a body under a wheel at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// The wheel's load grows over `wheel.ramp_s`.
    #[default]
    Ramp,
    /// The run starts in equilibrium under the full load, without a ramp; `wheel.hold_s` keeps its meaning.
    Static,
}

/// Finite element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

impl From<ElementKind> for body::ElementKind {
    fn from(kind: ElementKind) -> body::ElementKind {
        match kind {
            ElementKind::Q4OnePoint => body::ElementKind::Q4OnePoint,
            ElementKind::Q4Full => body::ElementKind::Q4Full,
            ElementKind::Q4MeanDilatation => body::ElementKind::Q4MeanDilatation,
        }
    }
}

/// Out-of-plane condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Plane {
    /// ezz = 0.
    #[default]
    Strain,
    /// szz = 0.
    Stress,
}

/// Support of the lower edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Base {
    /// Both components fixed.
    #[default]
    Clamped,
    /// y fixed, x free, except in the middle node where nothing else holds the body.
    Roller,
    /// No support.
    Free,
}

/// Edge of a structured mesh that touches something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactEdge {
    /// The upper edge.
    #[default]
    Top,
    /// The lower edge: the mesh is upside down.
    Bottom,
}

/// Support of the lateral edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// No support.
    #[default]
    Free,
    /// x fixed, y free: a laterally confined strip. Of a mesh from a file that has only one of the groups `left` and `right`, that one is held.
    FixedX,
}

/// Measure of strain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kinematics {
    /// The symmetric part of the displacement gradient; rotations must stay small.
    #[default]
    Small,
    /// The stretch without the rotation: rotations may be large, the stretch must stay small.
    Corotational,
}
