//! The material and its numbers.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::refuse_given;
use protocol::Cause;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Constitutive law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MaterialKind {
    /// Linear elastic, isotropic.
    #[default]
    Elastic,
    /// Elastic up to the von Mises yield surface, which grows and moves linearly with the plastic strain; plane strain only.
    J2,
}

/// Constitutive law with its numbers.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialConfig {
    /// Kind of law; when absent `j2` with a `yield_pa`, `elastic` without.
    pub kind: Option<MaterialKind>,
    /// Young's modulus (Pa), > 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub young_pa: f64,
    /// Poisson's ratio, in (-1, 0.5).
    #[schemars(extend("exclusiveMinimum" = -1, "exclusiveMaximum" = 0.5))]
    pub poisson: f64,
    /// Density (kg/m3), > 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density_kg_per_m3: f64,
    /// Yield stress in uniaxial tension (Pa), > 0; required with `j2`, refused with `elastic`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub yield_pa: Option<f64>,
    /// Growth H of the yield stress with the equivalent plastic strain (Pa), >= 0; 0 when absent.
    #[schemars(range(min = 0.0))]
    pub hardening_pa: Option<f64>,
    /// Growth of the back stress with the plastic strain in uniaxial tension (Pa), >= 0; 0 when absent.
    #[schemars(range(min = 0.0))]
    pub kinematic_hardening_pa: Option<f64>,
}

impl MaterialConfig {
    /// The law that the keys select: scripts give `yield_pa` alone.
    pub fn law(&self) -> MaterialKind {
        match (self.kind, self.yield_pa) {
            (Some(kind), _) => kind,
            (None, Some(_)) => MaterialKind::J2,
            (None, None) => MaterialKind::Elastic,
        }
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        if self.law() == MaterialKind::Elastic {
            let keys =
                kit::named!("material.", self; yield_pa, hardening_pa, kinematic_hardening_pa);
            return refuse_given(
                keys.map(|(key, value)| (key, value.is_some())),
                "has no effect on an elastic material",
                "give material.yield_pa and leave material.kind out, or remove the key",
            );
        }
        refuse_if(
            self.yield_pa.is_none(),
            "material.yield_pa",
            "is required with material.kind = \"j2\"",
            "give the yield stress in uniaxial tension (Pa)",
        )
        .map_err(|error| error.because(Cause::MissingKey))
    }
}
