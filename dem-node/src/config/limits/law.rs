//! Limits of `law`.

use protocol::ConfigError;

use super::{at_least, positive, required, within};
use crate::config::{LawConfig, LawKind, PenetrationKind};

impl LawConfig {
    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        if let Some(stiffness) = self.contact_stiffness_pa {
            positive("law.contact_stiffness_pa", stiffness, "Pa")?;
        }
        self.validate_rigid()?;
        match self.kind.plain() {
            LawKind::Signorini => self.validate_frictionless()?,
            LawKind::Cohesion => {
                self.validate_friction("law.kind = \"cohesion\"")?;
                return self.validate_cohesion();
            }
            _ => self.validate_friction("law.kind = \"coulomb\"")?,
        }
        self.refuse_cohesion()
    }

    /// What belongs to rigid contacts: restitution and penetration, written out or meant by a name of LMGC90.
    fn validate_rigid(&self) -> Result<(), ConfigError> {
        if let Some(restitution) = self.restitution {
            within("law.restitution", restitution, 0.0, 1.0)?;
        }
        self.refuse_rigid_options_of_springs()?;
        self.validate_names()?;
        if self.restitution.is_some() && self.penetration == Some(PenetrationKind::Gap) {
            return Err(ConfigError::new(
                "law.penetration",
                "\"gap\" repairs overlaps by velocity, which would add to the rebound of law.restitution",
            )
            .help("write \"iqs\", \"split\" or \"projection\""));
        }
        let repairs = [PenetrationKind::Split, PenetrationKind::Projection];
        if self.kind.plain() == LawKind::Cohesion
            && self.penetration.is_some_and(|p| repairs.contains(&p))
        {
            return Err(ConfigError::new(
                "law.penetration",
                "moves grains apart after the step, which would stretch their bonds without any work",
            )
            .help("write \"iqs\" or \"gap\" with law.kind = \"cohesion\""));
        }
        Ok(())
    }

    fn refuse_rigid_options_of_springs(&self) -> Result<(), ConfigError> {
        let options = [
            ("law.restitution", self.restitution.is_some()),
            ("law.penetration", self.penetration.is_some()),
            ("law.kind", self.kind.plain() != self.kind),
        ];
        match options.into_iter().find(|(_, given)| *given) {
            Some((key, _)) if self.contact_stiffness_pa.is_some() => Err(ConfigError::new(
                key,
                "is for rigid contacts, and law.contact_stiffness_pa makes elastic ones, which rebound and overlap by themselves",
            )
            .help("remove one of the two")),
            _ => Ok(()),
        }
    }

    /// LMGC90's names against the options that they mean.
    fn validate_names(&self) -> Result<(), ConfigError> {
        let contradicts = |key: &str, means: &str| {
            let problem = format!(
                "contradicts law.kind = \"{}\", which means {means}",
                self.kind.word()
            );
            Err(ConfigError::new(key, problem)
                .help("remove the key, or choose the plain kind with the options that you want"))
        };
        let iqs = matches!(self.kind, LawKind::IqsClb | LawKind::IqsMacCzm);
        if iqs && self.restitution.is_some() {
            return contradicts("law.restitution", "inelastic impacts");
        }
        if iqs && !matches!(self.penetration, None | Some(PenetrationKind::Iqs)) {
            return contradicts("law.penetration", "penetration = \"iqs\"");
        }
        if self.kind == LawKind::RstClb {
            let by = "contacts of law.kind = \"RST_CLB\"";
            required("law.restitution", self.restitution, by)?;
        }
        Ok(())
    }

    fn validate_cohesion(&self) -> Result<(), ConfigError> {
        let given = |key, value| required(key, value, "law.kind = \"cohesion\"");
        let [cn, ct, w, b, p, alert] = self.cohesion_numbers();
        for ((key, value), unit) in [(cn, "Pa/m"), (w, "J/m2"), (p, ""), (alert, "m")] {
            positive(key, given(key, value)?, unit)?;
        }
        for ((key, value), unit) in [(ct, "Pa/m"), (b, "Pa m s")] {
            at_least(key, given(key, value)?, 0.0, unit)?;
        }
        within("law.bonds_min", f64::from(self.bonds_min), 0.0, 6.0)?;
        match self.h_prime {
            Some(_) => Ok(()),
            None => Err(ConfigError::new(
                "law.h_prime",
                "law.kind = \"cohesion\" needs it and it is missing",
            )
            .help("write h_prime = \"one\" or \"adhesion\"")),
        }
    }

    fn refuse_cohesion(&self) -> Result<(), ConfigError> {
        let numbers = self.cohesion_numbers().into_iter();
        let given = numbers
            .filter(|(_, value)| value.is_some())
            .map(|(key, _)| key);
        let fewest = (self.bonds_min > 0).then_some("law.bonds_min");
        let others = self
            .h_prime
            .map(|_| "law.h_prime")
            .into_iter()
            .chain(fewest);
        match given.chain(others).next() {
            None => Ok(()),
            Some(key) => Err(ConfigError::new(
                key,
                "belongs to bonds, and this law has none: the key would have no effect",
            )
            .help("remove it, or choose law.kind = \"cohesion\"")),
        }
    }

    fn cohesion_numbers(&self) -> [(&'static str, Option<f64>); 6] {
        [
            ("law.cn_pa_per_m", self.cn_pa_per_m),
            ("law.ct_pa_per_m", self.ct_pa_per_m),
            ("law.w_j_per_m2", self.w_j_per_m2),
            ("law.b_pa_m_s", self.b_pa_m_s),
            ("law.p", self.p),
            ("law.alert_m", self.alert_m),
        ]
    }

    fn validate_frictionless(&self) -> Result<(), ConfigError> {
        let superfluous = [
            ("law.friction", self.friction),
            (
                "law.tangential_stiffness_ratio",
                self.tangential_stiffness_ratio,
            ),
        ];
        match superfluous.into_iter().find(|(_, value)| value.is_some()) {
            None => Ok(()),
            Some((key, _)) => Err(ConfigError::new(
                key,
                "law.kind = \"signorini\" has no tangential force, the key would have no effect",
            )
            .help("remove it, or choose law.kind = \"coulomb\"")),
        }
    }

    fn validate_friction(&self, by: &str) -> Result<(), ConfigError> {
        let friction = required("law.friction", self.friction, by)?;
        at_least("law.friction", friction, 0.0, "")?;
        let key = "law.tangential_stiffness_ratio";
        match (self.contact_stiffness_pa, self.tangential_stiffness_ratio) {
            (None, None) => Ok(()),
            (None, Some(_)) => Err(ConfigError::new(
                key,
                "rigid contacts have no stiffness, the key would have no effect",
            )
            .help("remove it, or give law.contact_stiffness_pa")),
            (Some(_), ratio) => {
                let why = "compliant contacts with friction";
                positive(key, required(key, ratio, why)?, "")
            }
        }
    }
}
