//! The keys of `sample` with kind = "layer" and their limits.

use dem_kernel::bodies::geometry::drop_at;
use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::at_least;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::radii::{Radii, RadiusLaw};
use super::surface::{SPACING, SurfaceConfig};

/// The key of a strip that repeats, in both kinds of sample.
pub(super) const PERIOD: &str = "sample.periodic_x_m";

/// More grains than this are taken for a mistyped unit: their bed would be pressed for hours.
const GRAINS_MAX: f64 = 5e5;

/// Last pressure over the contact stiffness: in `quick` (2e-4) the approach is 1 % lower at 4e-3, 2 % at 9e-3 and 28 % at 0.044.
const PRESTRESS: f64 = 4e-3;

/// A pressed layer on a crowned line: of constant thickness under a wheel, or up to the face of a body above it.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LayerConfig {
    /// Distance from the base line to the wheel's face (m), or to the line of the lid over x = 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness_m: f64,
    /// Position of the layer's middle along x (m), for one of several layers between straight bodies; 0 when absent.
    #[serde(default)]
    pub x_m: f64,
    /// Half of the layer's width (m), to either side of its middle.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub half_width_m: f64,
    /// Load that `half_width_m` is meant for (N): under a wheel of another load P the layer covers `half_width_m` sqrt(P / this),
    /// as a Hertzian line contact widens (Hertz 1882). The half-width is `half_width_m` for every load when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub half_width_load_n: Option<f64>,
    /// Radius of the crown of the base line (m); 0 = straight.
    #[schemars(range(min = 0.0))]
    pub crown_radius_m: f64,
    /// Smallest radius of the grains (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_min_m: f64,
    /// Largest radius of the grains (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius_max_m: f64,
    /// Distribution of the radii.
    pub law: RadiusLaw,
    /// Exponent k of law = "power", p ~ r^k; required there, refused with other laws.
    #[schemars(range(min = -20.0, max = 20.0))]
    pub power: Option<f64>,
    /// Seed of the packing; the run's seed when absent.
    pub seed: Option<u64>,
    /// True for a layer that is also cut along its top and glued to a body there, set `lid`; it then has no wheel.
    #[serde(default)]
    pub lid: bool,
    /// False for loose grains on the bare surface: they are pressed on a flat plate in its place, and nothing is cut or glued.
    #[serde(default = "glued")]
    pub glued: bool,
    /// The bare surface on either side of the glued row, or in its place; it has the defaults of its keys when absent.
    #[serde(default)]
    pub surface: SurfaceConfig,
    /// Radius of the face of the body on top (m), convex towards the layer, along which the lid is cut; 0 = straight.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub lid_crown_radius_m: f64,
    /// Height of the bed below the cut (m), and with a lid also above the upper cut. Five mean diameters keep the floor's ordering out of the layer.
    #[serde(default = "bed_extra")]
    #[schemars(range(min = 0.0))]
    pub bed_extra_m: f64,
    /// Pressures under the flat plate, one after the other (Pa). The second, lower one leaves little
    /// elastic overlap to relax when the side walls go.
    #[serde(default = "press")]
    #[schemars(length(min = 1), extend("items" = { "type": "number", "exclusiveMinimum": 0 }))]
    pub press_pa: Vec<f64>,
    /// Ends of the strip that repeats along x (m), [-half_width_m, half_width_m], instead of side walls; the base is then straight. Nothing repeats
    /// when absent.
    pub periodic_x_m: Option<[f64; 2]>,
}

fn glued() -> bool {
    true
}

fn bed_extra() -> f64 {
    0.7e-3
}

fn press() -> Vec<f64> {
    vec![300e6, 50e6]
}

impl LayerConfig {
    /// The radii.
    pub fn radii(&self) -> Radii {
        Radii::new(self.law, self.power, self.radius_min_m, self.radius_max_m)
    }

    /// The layer with its half-width for this load (N), without the rule.
    pub(super) fn under(&self, load: f64) -> LayerConfig {
        let meant = self.half_width_load_n;
        let wider = meant.map_or(1.0, |meant| (load / meant).sqrt());
        LayerConfig {
            half_width_m: self.half_width_m * wider,
            half_width_load_n: None,
            ..self.clone()
        }
    }

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        self.radii().validate("sample")?;
        let widest = self.radius_max_m;
        let below = if self.glued { 4.0 * widest } else { 0.0 };
        for (key, value, least) in [
            ("bed_extra_m", self.bed_extra_m, below),
            ("half_width_m", self.half_width_m, 10.0 * widest),
            // A layer thinner than a grain consists of glued ones only.
            ("thickness_m", self.thickness_m, 2.0 * self.radius_min_m),
        ] {
            at_least(&format!("sample.{key}"), value, least, "m")?;
        }
        let beyond = |least: f64| {
            let mut crowns = self.crowns().into_iter().filter(|(_, r)| *r > 0.0);
            crowns.try_for_each(|(key, radius)| at_least(key, radius, least, "m"))
        };
        beyond(2.0 * self.half_width_m)?;
        refuse_if(
            self.lid_crown_radius_m > 0.0 && !self.lid,
            "sample.lid_crown_radius_m",
            "is the radius of a body above the layer, and there is no lid to glue to one",
            "write lid = true, or remove the key",
        )?;
        refuse_if(
            self.lid && !self.glued,
            "sample.glued",
            "a lid is glued to its layer, and so is the base then",
            "remove the key, or sample.lid",
        )?;
        refuse_if(
            self.glued && self.surface.points_m.is_some(),
            "sample.surface.points_m",
            "says where the whole surface is, and a glued row lies on a part of it",
            "add sample.glued = false, or write half_width_m instead",
        )?;
        self.validate_middle()?;
        self.refuse_too_many_grains()?;
        self.refuse_a_tower()?;
        let spacing = SPACING * self.radii().mean();
        let within = self.half_width_m;
        self.surface.validate(within, spacing, true)?;
        beyond(self.surface.half_width_m.unwrap_or(0.0))
    }

    /// Crowns and wheels stand over x = 0.
    fn validate_middle(&self) -> Result<(), ConfigError> {
        let curved = self.crowns().iter().any(|(_, radius)| *radius > 0.0);
        refuse_if(
            self.x_m != 0.0 && (!self.lid || curved || self.periodic_x_m.is_some()),
            "sample.x_m",
            "places a layer between two straight bodies, and this one has a wheel, a crown, or no ends",
            "remove the key, or write lid = true without crowns and periodic_x_m",
        )
    }

    /// Crown radii of the base line and of the lid's line (m).
    fn crowns(&self) -> [(&'static str, f64); 2] {
        [
            ("sample.crown_radius_m", self.crown_radius_m),
            ("sample.lid_crown_radius_m", self.lid_crown_radius_m),
        ]
    }

    /// Height of the lid's line over the base line (m).
    pub fn height_at(&self, x: f64) -> f64 {
        let beyond = self.crowns().map(|(_, radius)| drop_at(x, radius));
        self.thickness_m + beyond[0] + beyond[1]
    }

    /// Height of the bed over the base line (m). A layer with a lid is cut out of a bed that extends above the layer as below.
    pub fn bed_height(&self) -> f64 {
        if self.lid {
            self.height_at(self.half_width_m) + self.bed_extra_m
        } else {
            self.thickness_m
        }
    }

    /// Refuses a layer that is thicker than it is wide: its thickness was probably given in another unit.
    fn refuse_a_tower(&self) -> Result<(), ConfigError> {
        let [thickness, width] = [self.thickness_m, 2.0 * self.half_width_m];
        refuse_if(
            thickness > width,
            "sample.thickness_m",
            format!("a layer {thickness:e} m thick on {width:e} m of its base is a tower"),
            "check the unit (m): 0.4 mm are 4e-4",
        )
    }

    /// Refuses a bed of too many grains. Their number is about the bed's area over the area of a grain with the mean square radius.
    fn refuse_too_many_grains(&self) -> Result<(), ConfigError> {
        let depth = self.bed_height() + self.bed_extra_m;
        let area = std::f64::consts::PI * self.radii().mean_square();
        let grains = 2.0 * self.half_width_m * depth / area;
        let key = if self.thickness_m > self.half_width_m {
            "sample.thickness_m"
        } else {
            "sample.radius_min_m"
        };
        let problem = format!(
            "a bed {:e} m wide and {depth:e} m deep needs about {grains:.1e} grains of {:e} to {:e} m, more than {GRAINS_MAX:.0e}",
            2.0 * self.half_width_m,
            self.radius_min_m,
            self.radius_max_m
        );
        refuse_if(
            grains.is_nan() || grains > GRAINS_MAX,
            key,
            problem,
            "check the units (m): a thinner or narrower layer, or larger grains",
        )
    }

    /// Advice on a layer that springs apart when its plate goes: contacts of this stiffness (Pa) then overlap by about P / k.
    pub fn advice(&self, contact_stiffness_pa: Option<f64>) -> Option<String> {
        let last = *self.press_pa.last()?;
        let overlap = last / contact_stiffness_pa?;
        (overlap > PRESTRESS).then(|| {
            format!(
                "sample.press_pa: the layer is left under {last:e} Pa, {overlap:.1e} of its contact stiffness, and springs apart when the plate goes; above {PRESTRESS} the approach of a wheel is off by 1 % and more: let the last pressure be lower"
            )
        })
    }

    /// Refuses ends other than the layer's, and crowns. Returns the largest radius (m).
    pub(super) fn validate_strip(&self, ends: [f64; 2]) -> Result<f64, ConfigError> {
        let width = self.half_width_m;
        refuse_if(
            ends != [-width, width],
            PERIOD,
            format!("a layer covers its strip, |x| up to sample.half_width_m = {width:e}"),
            format!("write periodic_x_m = [{:e}, {width:e}]", -width),
        )?;
        for (key, radius) in self.crowns() {
            let problem = "a crown does not repeat along x, and sample.periodic_x_m does";
            refuse_if(radius > 0.0, key, problem, "write 0")?;
        }
        Ok(self.radius_max_m)
    }
}
