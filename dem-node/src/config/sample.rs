//! The keys of `sample`: a layer, a rail or listed disks, in a strip that repeats or not.

use std::borrow::Cow;

use dem_kernel::bodies::geometry::{Period, drop_at};
use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::ROUNDING;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer};

use super::disks::DisksConfig;
use super::file::FileConfig;
use super::layer::{LayerConfig, PERIOD};
use super::radii::Radii;
use super::rail::RailConfig;
use super::surface::SurfaceConfig;

/// Least length of a strip in diameters of the widest disk: a grain must not meet its neighbours around the strip.
const DIAMETERS: f64 = 4.0;
/// Farthest that a grain may stand beside the base of a rail, in largest diameters.
const APRON: f64 = 5.0;

/// `sample`: the source of the grains.
#[derive(Clone, Debug)]
pub enum SampleConfig {
    /// A pressed layer that follows the crown, glued to its base.
    Layer(LayerConfig),
    /// A portion of a rail that consists of grains, glued to its base.
    Rail(RailConfig),
    /// Disks and walls one by one, or the disks of a file.
    Disks(DisksConfig),
}

/// The words for `sample.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SampleKind {
    Layer,
    Rail,
    Disks,
    File,
}

#[derive(Deserialize)]
struct SampleTag {
    kind: SampleKind,
}

/// Written by hand, like the deserialiser.
impl JsonSchema for SampleConfig {
    fn schema_name() -> Cow<'static, str> {
        "SampleConfig".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        kit::schema::one_of_kinds(
            "kind",
            [
                ("layer", generator.subschema_for::<LayerConfig>()),
                ("rail", generator.subschema_for::<RailConfig>()),
                ("disks", generator.subschema_for::<DisksConfig>()),
                ("file", generator.subschema_for::<FileConfig>()),
            ],
        )
    }
}

/// Written by hand: an error of a derived enum with `tag = "kind"` names the table, not the key in it.
impl<'de> Deserialize<'de> for SampleConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<SampleConfig, D::Error> {
        let mut keys = serde_json::Map::deserialize(deserializer)?;
        // A missing or unknown kind is refused like any other key.
        let kind = keys.shift_remove_entry("kind");
        let SampleTag { kind } = kit::read_part(kind.into_iter().collect())?;
        match kind {
            SampleKind::Layer => kit::read_part(keys.into()).map(SampleConfig::Layer),
            SampleKind::Rail => kit::read_part(keys.into()).map(SampleConfig::Rail),
            SampleKind::Disks => kit::read_part(keys.into()).map(SampleConfig::Disks),
            SampleKind::File => {
                let file: FileConfig = kit::read_part(keys.into())?;
                let inside = |error: ConfigError| kit::keys::error_inside("path", &error);
                file.read().map(SampleConfig::Disks).map_err(inside)
            }
        }
    }
}

/// A line along which a sample is cut, where it is glued to a body: it falls away from the grains by the drop of a crown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutLine {
    /// Height over x = 0 (m).
    pub height: f64,
    /// Radius of the crown (m), 0 = straight.
    pub crown_radius: f64,
}

impl CutLine {
    /// Height at x (m): beside x = 0 a base (`side` -1) falls and a lid (1) rises.
    pub fn height_at(self, x: f64, side: f64) -> f64 {
        self.height + side * drop_at(x, self.crown_radius)
    }
}

impl SampleConfig {
    /// The strip that repeats along x, where one does.
    pub fn period(&self) -> Option<Period> {
        self.period_ends().map(Period::between)
    }

    pub(crate) fn period_ends(&self) -> Option<[f64; 2]> {
        match self {
            SampleConfig::Layer(layer) => layer.periodic_x_m,
            SampleConfig::Rail(_) => None,
            SampleConfig::Disks(disks) => disks.periodic_x_m,
        }
    }

    /// The keys of the surface that the sample lies on, where there are any.
    pub fn surface(&self) -> Option<&SurfaceConfig> {
        match self {
            SampleConfig::Layer(layer) => Some(&layer.surface),
            SampleConfig::Rail(_) => None,
            SampleConfig::Disks(disks) => disks.surface.as_ref(),
        }
    }

    /// The lines along which base and lid of a layer, or the base of a rail, are cut.
    pub fn cut_lines(&self) -> Option<[CutLine; 2]> {
        let lines = match self {
            SampleConfig::Layer(layer) => [
                (0.0, layer.crown_radius_m),
                (layer.thickness_m, layer.lid_crown_radius_m),
            ],
            SampleConfig::Rail(rail) => [(rail.base(), 0.0); 2],
            SampleConfig::Disks(_) => return None,
        };
        Some(lines.map(|(height, crown_radius)| CutLine {
            height,
            crown_radius,
        }))
    }

    /// Distance beside the base in which grains still belong to the sample (m): the sides of a rail bulge.
    pub fn apron(&self) -> f64 {
        match self {
            SampleConfig::Rail(rail) => APRON * 2.0 * rail.radius_max_m,
            SampleConfig::Layer(_) | SampleConfig::Disks(_) => 0.0,
        }
    }

    /// True if any disks move together.
    pub(super) fn has_clusters(&self) -> bool {
        matches!(self, SampleConfig::Disks(disks) if disks.has_clusters())
    }

    /// True if a row of disks is glued to a body above the others.
    pub(super) fn has_lid(&self) -> bool {
        match self {
            SampleConfig::Layer(layer) => layer.lid,
            SampleConfig::Rail(_) => false,
            SampleConfig::Disks(disks) => disks.disks.iter().any(|disk| disk.lid),
        }
    }

    /// Speed of the fastest cluster whose motion is prescribed (m/s).
    pub fn driven_speed(&self) -> f64 {
        let SampleConfig::Disks(disks) = self else {
            return 0.0;
        };
        let clusters = disks.clusters.iter();
        let drives = clusters.filter_map(|cluster| cluster.drive.as_ref());
        let speeds = drives.map(|drive| {
            let [x, y] = drive.velocity().map(Option::unwrap_or_default);
            x.hypot(y)
        });
        speeds.fold(0.0, f64::max)
    }

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        match self {
            SampleConfig::Layer(layer) => layer.validate(),
            SampleConfig::Rail(rail) => rail.validate(),
            SampleConfig::Disks(disks) => disks.validate(),
        }
    }

    /// Refuses a strip from `ends[0]` to `ends[1]` (m) that does not fit the sample.
    pub(super) fn validate_strip(&self, ends: [f64; 2]) -> Result<(), ConfigError> {
        let widest = match self {
            SampleConfig::Layer(layer) => layer.validate_strip(ends)?,
            SampleConfig::Rail(_) => return Ok(()),
            SampleConfig::Disks(disks) => disks.validate_strip(ends)?,
        };
        let (length, narrowest) = (ends[1] - ends[0], 2.0 * DIAMETERS * widest);
        refuse_if(
            length < narrowest * (1.0 - ROUNDING),
            PERIOD,
            format!(
                "a strip of {length:e} m is narrower than {DIAMETERS} of the widest diameter, {narrowest:e} m"
            ),
            "write [left, right] with right further away",
        )
    }

    /// The row of disks of a wheel as wide as the sample: radii, width (m) and seed; `None` for listed disks.
    pub fn wheel_row(&self) -> Option<(Radii, f64, Option<u64>)> {
        match self {
            SampleConfig::Layer(layer) => {
                Some((layer.radii(), 2.0 * layer.half_width_m, layer.seed))
            }
            SampleConfig::Rail(rail) => Some((rail.radii(), rail.width_m, rail.seed)),
            SampleConfig::Disks(_) => None,
        }
    }

    /// Half-width and thickness of a layer that does not repeat (m).
    pub fn ends(&self) -> Option<[f64; 2]> {
        match self {
            SampleConfig::Layer(layer) if layer.periodic_x_m.is_none() => {
                Some([layer.half_width_m, layer.thickness_m])
            }
            _ => None,
        }
    }

    /// Middle of the sample along x (m), which a layer may set.
    pub fn middle(&self) -> f64 {
        match self {
            SampleConfig::Layer(layer) => layer.x_m,
            SampleConfig::Rail(_) | SampleConfig::Disks(_) => 0.0,
        }
    }

    /// Mean and smallest radius (m). For a layer or a rail these are the law's, so that bounds do not depend on the seed.
    pub fn radii(&self) -> (f64, f64) {
        match self {
            SampleConfig::Disks(disks) => disks.radii(),
            SampleConfig::Layer(layer) => (layer.radii().mean(), layer.radius_min_m),
            SampleConfig::Rail(rail) => (rail.radii().mean(), rail.radius_min_m),
        }
    }
}
