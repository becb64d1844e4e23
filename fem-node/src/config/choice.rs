//! Choices with a few named values each.

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
