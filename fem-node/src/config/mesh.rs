//! Source of the mesh: a few numbers, or a file of Gmsh.

use std::borrow::Cow;
use std::path::PathBuf;

use kit::ConfigError;
use kit::limits::{not_negative, positive};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use super::choice::ContactEdge;

/// The mesh: `{ width_m = .., .. }`, a graded structured mesh, or `{ gmsh = "rail.msh" }`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "MeshKeys")]
pub enum MeshSource {
    /// Structured mesh from a few numbers.
    Graded(MeshConfig),
    /// Quadrilaterals from a file.
    Gmsh(GmshConfig),
}

/// Geometry of a graded structured mesh, fine in the middle of one edge. The middle of that edge is the origin.
#[derive(Clone, Debug, PartialEq, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MeshConfig {
    /// Width (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub width_m: f64,
    /// Height in the middle (m).
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
    /// Graded columns on each side of the fine zone.
    #[schemars(default)]
    pub side_columns: usize,
    /// Graded rows beyond the fine zone.
    #[schemars(default)]
    pub depth_rows: usize,
    /// Edge from which `fine_depth_m` counts and which has the crown; the upper one when absent.
    #[schemars(default)]
    pub contact_edge: ContactEdge,
    /// Radius of that edge, convex outwards (m); flat when absent or 0.
    #[schemars(range(min = 0.0))]
    pub crown_radius_m: Option<f64>,
    /// The left and the right edge are one: a body that goes on for ever in x.
    #[schemars(default)]
    pub periodic_x: bool,
}

/// A mesh that Gmsh wrote.
#[derive(Clone, Debug, PartialEq, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct GmshConfig {
    /// The file, MSH 2.2 or 4.1, ASCII or binary. In a scenario relative to its folder, which the loader makes absolute; a node that
    /// is built without a scenario takes it relative to its working directory.
    pub gmsh: PathBuf,
    /// Length of the file's unit (m), > 0; 1 when absent.
    #[schemars(default = "one", extend("exclusiveMinimum" = 0))]
    pub length_unit_m: f64,
}

fn one() -> f64 {
    1.0
}

/// By hand: the keys are sorted after they were read, see `MeshKeys`.
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

/// Keys of both sources; they are sorted afterwards, so that every message names its key.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshKeys {
    gmsh: Option<PathBuf>,
    length_unit_m: Option<f64>,
    width_m: Option<f64>,
    height_m: Option<f64>,
    size_m: Option<f64>,
    fine_width_m: Option<f64>,
    fine_depth_m: Option<f64>,
    side_columns: Option<usize>,
    depth_rows: Option<usize>,
    contact_edge: Option<ContactEdge>,
    crown_radius_m: Option<f64>,
    periodic_x: Option<bool>,
}

impl MeshSource {
    /// True where the left and the right edge are one.
    pub(super) fn periodic_x(&self) -> bool {
        matches!(self, MeshSource::Graded(config) if config.periodic_x)
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        match self {
            MeshSource::Graded(config) => config.check(),
            MeshSource::Gmsh(config) => positive("mesh.length_unit_m", config.length_unit_m, "m"),
        }
    }
}

impl MeshConfig {
    fn check(&self) -> Result<(), ConfigError> {
        positive("mesh.width_m", self.width_m, "m")?;
        positive("mesh.height_m", self.height_m, "m")?;
        positive("mesh.size_m", self.size_m, "m")?;
        positive("mesh.fine_width_m", self.fine_width_m, "m")?;
        positive("mesh.fine_depth_m", self.fine_depth_m, "m")?;
        not_negative("mesh.crown_radius_m", self.crown_radius_m, "m")
    }
}

/// serde's own words for a missing key are understood by [`kit::keys::config_error`].
impl TryFrom<MeshKeys> for MeshSource {
    type Error = String;

    fn try_from(keys: MeshKeys) -> Result<MeshSource, String> {
        if let Some(gmsh) = &keys.gmsh {
            return match keys.of_a_structured_mesh() {
                Some(key) => Err(format!(
                    "`{key}` describes a block and does not go with a file in `gmsh`; remove one of them"
                )),
                None => Ok(MeshSource::Gmsh(GmshConfig {
                    gmsh: gmsh.clone(),
                    length_unit_m: keys.length_unit_m.unwrap_or(1.0),
                })),
            };
        }
        if keys.length_unit_m.is_some() {
            return Err(
                "`length_unit_m` is the unit of a file in `gmsh`, and there is none".into(),
            );
        }
        let required =
            |name: &str, value: Option<f64>| value.ok_or_else(|| format!("missing field `{name}`"));
        Ok(MeshSource::Graded(MeshConfig {
            width_m: required("width_m", keys.width_m)?,
            height_m: required("height_m", keys.height_m)?,
            size_m: required("size_m", keys.size_m)?,
            fine_width_m: keys.fine_width_m,
            fine_depth_m: keys.fine_depth_m,
            side_columns: keys.side_columns.unwrap_or(0),
            depth_rows: keys.depth_rows.unwrap_or(0),
            contact_edge: keys.contact_edge.unwrap_or_default(),
            crown_radius_m: keys.crown_radius_m,
            periodic_x: keys.periodic_x.unwrap_or(false),
        }))
    }
}

impl MeshKeys {
    /// The first key that only a structured mesh has.
    fn of_a_structured_mesh(&self) -> Option<&'static str> {
        let given = kit::named!(self, is_some; width_m, height_m, size_m, fine_width_m, fine_depth_m,
            side_columns, depth_rows, contact_edge, crown_radius_m, periodic_x);
        given.iter().find(|(_, given)| *given).map(|(key, _)| *key)
    }
}
