//! The keys of `heat`: temperatures of the grains.

use std::collections::BTreeMap;

use dem_kernel::bodies::pairs::GRAINS;
use dem_kernel::law::heat::{Conduction, HalfSpace, HeatLaw, Softening};
use kit::ConfigError;
use kit::heat::{CapacityTable, check_factors};
use kit::keys::refuse_if;
use kit::table::LoadTable;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::config::law::{LawConfig, LawKind};

/// `heat`: each grain has one temperature; what its contacts dissipate warms it, and heat passes through contacts that press.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeatConfig {
    /// Heat capacity c of the grains (J/(kg K)), of their true mass.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub capacity_j_per_kg_k: f64,
    /// Factors above 0 on the heat capacity over temperature, `[[kelvins, factor], ...]`: linear between entries and constant beyond.
    pub capacity_factor: Option<LoadTable>,
    /// Thermal conductivity k of the grains (W/(m K)). The width of a contact, which sets its conductance, is Hertz's, by `young_pa` and `poisson`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub conductivity_w_per_m_k: Option<f64>,
    /// Young's modulus of the grains (Pa), beside `conductivity_w_per_m_k`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub young_pa: Option<f64>,
    /// Poisson's ratio of the grains, beside `young_pa`.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub poisson: Option<f64>,
    /// Conductance of every contact that presses (W/K), in place of `conductivity_w_per_m_k`.
    #[schemars(range(min = 0.0))]
    pub conductance_w_per_k: Option<f64>,
    /// Factors on `conductivity_w_per_m_k` or `conductance_w_per_k` over temperature, as of `capacity_factor`: at the mean temperature of the two bodies of
    /// a contact, before heat passes.
    pub conductivity_factor: Option<LoadTable>,
    /// Width over which the heat of a contact spreads in a body that is no grain (m): the length of its elements. Such a body resists nothing when
    /// absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spread_m: Option<f64>,
    /// Temperature of the grains at the start (K).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub start_k: f64,
    /// Shares of the losses that become heat; all of each when absent.
    #[serde(default)]
    pub sources: HeatSources,
    /// Temperatures (K) of bodies that are no grains, by the names that `law.pairs` uses: `base`, `lid`, `wheel`, walls and clusters. Bodies without one
    /// let no heat through.
    #[serde(default)]
    pub held_k: BTreeMap<String, f64>,
    /// Bodies that are no grains and take heat as half-spaces, by the names of `held_k`, each with its effusivity sqrt(k rho c)
    /// `effusivity_w_s05_per_m2_k` (W s^0.5/(m2 K)), its temperature at the start `start_k`, and the length of the surface through which heat enters
    /// `length_m`. The temperature of the surface is uniform, and follows from all heat so far.
    #[serde(default)]
    pub half_spaces: BTreeMap<String, HalfSpaceConfig>,
    /// Steps from one conduction to the next; sources act in each step.
    #[serde(default = "kit::number::one::<u32>")]
    #[schemars(range(min = 1))]
    pub every_steps: u32,
    /// Dependence of the laws of contacts on temperature; none when absent.
    pub softening: Option<SofteningConfig>,
}

/// `heat.half_spaces.<body>`: a half-space for heat.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceConfig {
    /// Effusivity b = sqrt(k rho c) (W s^0.5/(m2 K)).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub effusivity_w_s05_per_m2_k: f64,
    /// Temperature at the start (K).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub start_k: f64,
    /// Length of the surface through which heat enters (m), such as the period of a layer; times the thickness it is the area.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length_m: f64,
}

/// `heat.softening`: dependence on temperature of `law`, `law.pairs` and the friction of the surface.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SofteningConfig {
    /// Factors on the coefficients of friction over temperature, `[[kelvins, factor], ...]`: linear between entries and constant beyond, at the mean
    /// temperature of the two bodies.
    pub friction: LoadTable,
    /// Factors on `w_j_per_m2`, the energy of bonds, as of `friction`; the strength of bonds follows its root.
    pub bonds: LoadTable,
    /// Activation energy E of healing (J/mol): `time_s` is the constant times exp(E/R (1/T - 1/T_0)), T_0 being `start_k`.
    #[schemars(range(min = 0.0))]
    pub healing_j_per_mol: f64,
}

/// `heat.sources`: shares of the losses that become heat.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HeatSources {
    /// Share of the slip.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub friction: f64,
    /// Share of the dampers.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub damping: f64,
    /// Share of the impacts of rigid contacts.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub impact: f64,
    /// Share of broken and softened bonds.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub bonds: f64,
}

impl Default for HeatSources {
    fn default() -> HeatSources {
        HeatSources {
            friction: 1.0,
            damping: 1.0,
            impact: 1.0,
            bonds: 1.0,
        }
    }
}

impl SofteningConfig {
    /// Refuses wrong tables, and keys that change nothing of this law.
    pub(super) fn validate(
        &self,
        law: &LawConfig,
        surface: Option<f64>,
    ) -> Result<(), ConfigError> {
        let pairs = &law.pairs;
        let others = pairs.iter().map(|pair| pair.friction);
        let mut all = others.chain([law.friction, surface]).flatten();
        let rubs = all.any(|friction| friction > 0.0);
        let heals = law.healing.is_some() || pairs.iter().any(|pair| pair.healing.is_some());
        let tables = [
            (
                "heat.softening.friction",
                &self.friction,
                rubs,
                "law.friction",
            ),
            (
                "heat.softening.bonds",
                &self.bonds,
                law.kind.plain() == LawKind::Cohesion,
                "law.w_j_per_m2",
            ),
        ];
        for (key, table, has, constant) in tables.into_iter().filter(|table| !table.1.is_empty()) {
            check_factors(key, table, false)?;
            refuse_if(
                !has,
                key,
                format!("has no effect without {constant}"),
                "remove it",
            )?;
        }
        let idle = self.healing_j_per_mol != 0.0 && !heals;
        refuse_if(
            idle,
            "heat.softening.healing_j_per_mol",
            "has no effect without law.healing",
            "remove it",
        )
    }
}

impl HeatConfig {
    /// Refuses scenes whose grains come and go, conduction without its numbers, wrong tables, and temperatures of bodies that the scene does not have;
    /// `groups` are the names of its bodies.
    pub(super) fn validate(&self, comes_or_goes: bool, groups: &[&str]) -> Result<(), ConfigError> {
        let both = [self.conductivity_w_per_m_k, self.conductance_w_per_k];
        let elastic = self.young_pa.is_some() && self.poisson.is_some();
        let refusals = [
            (
                comes_or_goes,
                "heat",
                "knows the temperature of every grain from the start on, and injection, detachment or flow.lateral change their number",
                "remove one of the tables",
            ),
            (
                both.iter().flatten().count() != 1,
                "heat",
                "needs either heat.conductivity_w_per_m_k or heat.conductance_w_per_k",
                "give one of the two",
            ),
            (
                self.conductivity_w_per_m_k.is_some() != elastic
                    || (self.young_pa.is_some() != self.poisson.is_some()),
                "heat.conductivity_w_per_m_k",
                "conducts through the width of a contact, which heat.young_pa and heat.poisson set",
                "give all three keys, or heat.conductance_w_per_k",
            ),
            (
                self.spread_m.is_some() && self.conductivity_w_per_m_k.is_none(),
                "heat.spread_m",
                "has no effect beside heat.conductance_w_per_k, which is the same for every contact",
                "remove it",
            ),
        ];
        refusals
            .into_iter()
            .try_for_each(|(holds, key, why, help)| refuse_if(holds, key, why, help))?;
        for (key, table, above) in [
            ("heat.capacity_factor", &self.capacity_factor, true),
            ("heat.conductivity_factor", &self.conductivity_factor, false),
        ] {
            let table = table.as_ref();
            table.map_or(Ok(()), |table| check_factors(key, table, above))?;
        }
        let mut known = groups.to_vec();
        known.retain(|name| *name != GRAINS);
        for (name, held) in &self.held_k {
            let key = format!("heat.held_k.{name}");
            refuse_if(
                !(*held > 0.0 && held.is_finite()),
                &key,
                format!("is {held}, and a temperature is above 0"),
                "give kelvins",
            )?;
        }
        let held = self.held_k.keys().map(|name| ("held_k", name));
        let spaces = self.half_spaces.keys();
        for (table, name) in held.chain(spaces.map(|name| ("half_spaces", name))) {
            let key = format!("heat.{table}.{name}");
            refuse_if(
                table == "half_spaces" && self.held_k.contains_key(name),
                &key,
                "is a half-space, and heat.held_k holds the same body at a temperature",
                "give one of the two",
            )?;
            refuse_if(
                !known.contains(&name.as_str()),
                &key,
                format!("is no body of this scene, which has {}", known.join(", ")),
                "give one of these names, or a name to the wall",
            )?;
        }
        Ok(())
    }

    /// The law, for this thickness (m) and bodies of these names.
    pub fn law(&self, thickness: f64, names: &[String]) -> HeatLaw {
        let mut groups: Vec<&str> = names.iter().map(String::as_str).collect();
        groups.sort_unstable();
        groups.dedup();
        groups.retain(|name| *name != GRAINS);
        let group = |name: &String| groups.iter().position(|group| group == name);
        let group_of = names.iter().map(|name| group(name).map(|at| at as u32));
        let own = self.sources;
        let (young, poisson) = (self.young_pa.unwrap_or(0.0), self.poisson.unwrap_or(0.0));
        let conduction = match (self.conductivity_w_per_m_k, self.conductance_w_per_k) {
            (Some(conductivity), _) => Conduction::Hertz {
                conductivity: conductivity * thickness,
                modulus: 0.5 * young / (1.0 - poisson * poisson) * thickness,
                spread: self.spread_m,
            },
            (None, conductance) => Conduction::Constant(conductance.unwrap_or(0.0)),
        };
        let given = |name: &str| {
            let start = self.half_spaces.get(name).map(|of| of.start_k);
            self.held_k.get(name).copied().or(start)
        };
        let half_spaces = groups.iter().enumerate().filter_map(|(group, name)| {
            let keys = self.half_spaces.get(*name)?;
            Some(HalfSpace {
                group,
                effusivity: keys.effusivity_w_s05_per_m2_k,
                area: keys.length_m * thickness,
                start: keys.start_k,
            })
        });
        let shown = groups.iter().map(|name| {
            let shown = if name.is_empty() { "walls" } else { name };
            (shown.to_string(), given(name))
        });
        let factors = self.capacity_factor.as_deref().unwrap_or_default();
        HeatLaw {
            capacity: self.capacity_j_per_kg_k,
            capacity_factor: CapacityTable::new(factors, self.start_k),
            conductivity_factor: self.conductivity_factor.clone().unwrap_or_default(),
            conduction,
            start: self.start_k,
            sources: [own.friction, own.damping, own.impact, own.bonds],
            group_of: group_of.collect(),
            groups: shown.collect(),
            half_spaces: half_spaces.collect(),
            every: self.every_steps,
            softening: self.softening.as_ref().map(|softening| Softening {
                friction: softening.friction.clone(),
                bonds: softening.bonds.clone(),
                activation: softening.healing_j_per_mol,
            }),
        }
    }
}
