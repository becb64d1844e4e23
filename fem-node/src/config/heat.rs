//! The keys of `heat`: temperatures of a body.

use std::collections::BTreeMap;

use fem_kernel::heat::EdgeCondition;
use fem_kernel::mesh::Edge;
use kit::ConfigError;
use kit::heat::check_factors;
use kit::table::LoadTable;
use schemars::JsonSchema;
use serde::Deserialize;

/// `heat`: friction under the body's own wheel, plastic flow and grains on its upper edge warm the body, and heat passes through it.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeatConfig {
    /// Thermal conductivity k (W/(m K)).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub conductivity_w_per_m_k: f64,
    /// Heat capacity c (J/(kg K)).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub capacity_j_per_kg_k: f64,
    /// Temperature at the start (K).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub start_k: f64,
    /// Thickness of the layer at the upper edge (m); a 64th of the first row of elements when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub finest_m: Option<f64>,
    /// Own steps from one step of heat to the next; 100 when absent, or a hundredth of the body's own history if that is less. A static analysis has one in each increment.
    #[schemars(range(min = 1))]
    pub every_steps: Option<u32>,
    /// Shares of the losses that become heat.
    #[serde(default)]
    pub sources: HeatSources,
    /// Share of the heat by friction that the wheel takes: b_w/(b + b_w) for two half-spaces that meet for the same time, b = sqrt(k rho c); 0 when
    /// absent, an insulated wheel.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wheel_share: f64,
    /// The wheel as half-spaces, in place of `wheel_share`: each node that it touches meets a point of its surface that stays with the node until
    /// they part. This holds for wheels that roll, and for strokes far shorter than the contact.
    pub wheel_half_space: Option<HalfSpaceConfig>,
    /// Factors on the conductivity over temperature, `[[kelvins, factor], ...]`: linear between entries and constant beyond; 1 when absent.
    pub conductivity_factor: Option<LoadTable>,
    /// Factors on the heat capacity, as of `conductivity_factor`.
    pub capacity_factor: Option<LoadTable>,
    /// Coefficient of thermal expansion (1/K); the body does not expand when absent.
    pub alpha_per_k: Option<f64>,
    /// Dependence of the material on temperature; none when absent.
    pub softening: Option<SofteningConfig>,
    /// Conditions on `top`, `bottom`, `left` and `right`; an edge without one is insulated.
    #[serde(default)]
    pub edges: BTreeMap<String, HeatEdge>,
}

/// A half-space beside a body.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceConfig {
    /// Effusivity b = sqrt(k rho c) (W s^0.5/(m2 K)).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub effusivity_w_s05_per_m2_k: f64,
    /// Temperature at the start (K).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub start_k: f64,
}

/// `heat.softening`: dependence of the material on temperature.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SofteningConfig {
    /// Factors on `yield_pa` over temperature, `[[kelvins, factor], ...]`: linear between entries and constant beyond, at the mean temperature of an
    /// element.
    pub yield_stress: LoadTable,
}

/// `heat.sources`: shares of the losses that become heat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeatSources {
    /// Share of the slip under the body's own wheel; 1 when absent.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub friction: Option<f64>,
    /// Share of the plastic work (Taylor and Quinney 1934); 0.9 when absent.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub plastic: Option<f64>,
}

/// Condition on an edge: a temperature, a flux, or a film to surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeatEdge {
    /// Temperature at which it is held (K).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub held_k: Option<f64>,
    /// Flux into the body (W/m2).
    pub flux_w_per_m2: Option<f64>,
    /// Conductance of a film (W/(m2 K)) to surroundings at `ambient_k`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub film_w_per_m2_k: Option<f64>,
    /// Temperature of the surroundings beyond the film (K).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub ambient_k: Option<f64>,
}

impl HeatConfig {
    /// Refuses wrong tables over temperature.
    pub(super) fn check_tables(&self) -> Result<(), ConfigError> {
        let yields = self.softening.as_ref().map(|of| &of.yield_stress);
        let [conductivity, capacity] = [&self.conductivity_factor, &self.capacity_factor];
        for (key, table, above) in [
            ("heat.conductivity_factor", conductivity.as_ref(), false),
            ("heat.capacity_factor", capacity.as_ref(), true),
            ("heat.softening.yield_stress", yields, true),
        ] {
            table.map_or(Ok(()), |table| check_factors(key, table, above))?;
        }
        Ok(())
    }

    /// The edges with their conditions, temperatures as rises above the start.
    ///
    /// # Errors
    /// An unknown edge, or an edge without exactly one condition.
    pub(crate) fn conditions(&self) -> Result<Vec<(Edge, EdgeCondition)>, ConfigError> {
        let start = self.start_k;
        let each = self.edges.iter().map(|(name, given)| {
            let key = format!("heat.edges.{name}");
            let edge = Edge::named(name).ok_or_else(|| {
                ConfigError::new(&key, "is no edge of a structured mesh")
                    .help("name top, bottom, left or right")
            })?;
            let film = (given.film_w_per_m2_k, given.ambient_k);
            let condition = match (given.held_k, given.flux_w_per_m2, film) {
                (Some(held), None, (None, None)) => EdgeCondition::Held(held - start),
                (None, Some(flux), (None, None)) => EdgeCondition::Flux(flux),
                (None, None, (Some(film), Some(ambient))) => {
                    EdgeCondition::Film([film, ambient - start])
                }
                _ => {
                    let error = ConfigError::new(&key, "has no condition, or more than one");
                    let help = "give held_k, flux_w_per_m2, or film_w_per_m2_k with ambient_k";
                    return Err(error.help(help));
                }
            };
            Ok((edge, condition))
        });
        each.collect()
    }
}
