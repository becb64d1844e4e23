//! Source of the mesh: a few numbers, or a Gmsh file.

use std::borrow::Cow;
use std::path::PathBuf;

use kit::keys::read_part;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::Error;
use serde_json::{Map, Value};

use super::choice::ContactEdge;

/// The mesh: `{ width_m = .., .. }`, a graded structured mesh, or `{ gmsh = "rail.msh" }`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Map<String, Value>")]
pub enum MeshSource {
    /// Structured mesh from a few numbers.
    Graded(MeshConfig),
    /// Quadrilaterals from a file.
    Gmsh(GmshConfig),
}

/// Geometry of a graded structured mesh, fine in the middle of one edge. The middle of that edge is the origin.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshConfig {
    /// Width of the body (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub width_m: f64,
    /// Height of the body in the middle (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub height_m: f64,
    /// Element size in the fine zone (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub size_m: f64,
    /// Width of the fine zone, centred (m); the whole width when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fine_width_m: Option<f64>,
    /// Depth of the fine zone (m); the whole height when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fine_depth_m: Option<f64>,
    /// Number of graded columns of elements on each side of the fine zone.
    #[serde(default)]
    pub side_columns: usize,
    /// Number of graded rows of elements beyond the fine zone.
    #[serde(default)]
    pub depth_rows: usize,
    /// Edge with the crown, from which `fine_depth_m` counts; the upper edge when absent.
    #[serde(default)]
    pub contact_edge: ContactEdge,
    /// Radius of the contact edge (m), convex outwards; flat when absent or 0.
    #[schemars(range(min = 0.0))]
    pub crown_radius_m: Option<f64>,
    /// True joins the left and the right edge: the body then repeats without end along x.
    #[serde(default)]
    pub periodic_x: bool,
}

/// A mesh that Gmsh wrote.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GmshConfig {
    /// Path of the file, MSH 2.2 or 4.1, ASCII or binary. It is relative to the scenario's folder; a node without a scenario takes it relative to its
    /// working directory.
    pub gmsh: PathBuf,
    /// Length of the file's unit (m), > 0; 1 when absent.
    #[serde(default = "kit::number::one::<f64>")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_unit_m: f64,
}

/// Written by hand: the keys are assigned to a source after reading, see `KEYS`.
impl JsonSchema for MeshSource {
    fn schema_name() -> Cow<'static, str> {
        "MeshSource".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let sources = [
            generator.subschema_for::<MeshConfig>(),
            generator.subschema_for::<GmshConfig>(),
        ];
        json_schema!({ "oneOf": sources })
    }
}

/// Keys of both sources, the file's first. They are assigned to a source after reading, so that each message names its key and lists all keys.
const KEYS: [&str; 12] = [
    "gmsh",
    "length_unit_m",
    "width_m",
    "height_m",
    "size_m",
    "fine_width_m",
    "fine_depth_m",
    "side_columns",
    "depth_rows",
    "contact_edge",
    "crown_radius_m",
    "periodic_x",
];

impl MeshSource {
    /// The contact edge of a structured mesh.
    pub(crate) fn contact_edge(&self) -> Option<ContactEdge> {
        match self {
            MeshSource::Graded(config) => Some(config.contact_edge),
            MeshSource::Gmsh(_) => None,
        }
    }

    /// True where the left and the right edge are one.
    pub(super) fn periodic_x(&self) -> bool {
        matches!(self, MeshSource::Graded(config) if config.periodic_x)
    }
}

impl TryFrom<Map<String, Value>> for MeshSource {
    type Error = serde_json::Error;

    fn try_from(keys: Map<String, Value>) -> Result<MeshSource, Self::Error> {
        if let Some(unknown) = keys.keys().find(|key| !KEYS.contains(&key.as_str())) {
            return Err(Error::unknown_field(unknown, &KEYS));
        }
        if keys.contains_key("gmsh") {
            let of_a_block = KEYS[2..].iter().find(|key| keys.contains_key(**key));
            return match of_a_block {
                Some(key) => Err(Error::custom(format!(
                    "`{key}` describes a block and does not go with a file in `gmsh`; remove one of them"
                ))),
                None => read_part(keys.into()).map(MeshSource::Gmsh),
            };
        }
        if keys.contains_key("length_unit_m") {
            let problem = "`length_unit_m` is the unit of a file in `gmsh`, which is absent";
            return Err(Error::custom(problem));
        }
        read_part(keys.into()).map(MeshSource::Graded)
    }
}
