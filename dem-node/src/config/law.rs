//! The keys of `law` and their limits.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{refuse_given, required};
use protocol::Cause;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use dem_kernel::law;

/// `law`: unilateral contact with optional friction and compliance.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LawConfig {
    /// Kind of law: `signorini` without friction, `coulomb` for loose grains, `cohesion` for bonded grains, or LMGC90's name for one of them with its
    /// options.
    pub kind: LawKind,
    /// Coefficient of friction, at least 0; with `coulomb` and `cohesion`.
    #[schemars(range(min = 0.0))]
    pub friction: Option<f64>,
    /// Resistance to rolling of contacts without bond; none when absent.
    pub rolling: Option<RollingConfig>,
    /// Attraction of pairs that touch or nearly touch; none when absent. Refused with `cohesion`.
    pub adhesion: Option<AdhesionConfig>,
    /// Stiffness of each contact per thickness (Pa): kn = value x thickness. Contacts are rigid when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub contact_stiffness_pa: Option<f64>,
    /// kt / kn of compliant contacts with friction, above 0; required for these, refused with rigid contacts.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tangential_stiffness_ratio: Option<f64>,
    /// Restitution of a compliant contact, 0.14 to 1, by a damper parallel to its spring; elastic when absent. A cluster that lands on several
    /// contacts at once rebounds with another restitution. Bonds have `bond_damping_ratio`.
    #[schemars(range(min = 0.14, max = 1.0))]
    pub damping: Option<f64>,
    /// Newton's coefficient of restitution of rigid contacts, 0 to 1; inelastic when absent.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub restitution: Option<f64>,
    /// Treatment of overlaps of rigid contacts; `iqs` when absent.
    pub penetration: Option<Penetration>,
    /// Cn (Pa/m), normal stiffness of a bond over its area r1 r2/(r1 + r2) x thickness; required with `cohesion`, refused otherwise.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cn_pa_per_m: Option<f64>,
    /// Ct (Pa/m), tangential stiffness of a bond over its area, at least 0; required with `cohesion`, refused otherwise.
    #[schemars(range(min = 0.0))]
    pub ct_pa_per_m: Option<f64>,
    /// w (J/m2), decohesion energy of a bond over its area: the strength is sqrt(w Cn). Required with `cohesion`, refused otherwise.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub w_j_per_m2: Option<f64>,
    /// b (Pa m s^p), viscosity of decohesion, at least 0; required with `cohesion`, refused otherwise.
    #[schemars(range(min = 0.0))]
    pub b_pa_m_s: Option<f64>,
    /// Damping ratio of the dampers parallel to the springs of bonds, 0 to 1; they weaken with the bond. No dampers when absent. With `cohesion`
    /// only.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub bond_damping_ratio: Option<f64>,
    /// p, power of the rate of decohesion; required with `cohesion`, refused otherwise.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub p: Option<f64>,
    /// h', weight of the decohesion energy while adhesion falls; required with `cohesion`, refused otherwise.
    pub h_prime: Option<HPrime>,
    /// Growth of bonds between pairs that press on each other; none when absent. With `cohesion` only.
    pub healing: Option<HealingConfig>,
    /// Gap below which pairs of grains are bonded at the start (m); required with `cohesion`, refused otherwise.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub alert_m: Option<f64>,
    /// Number of bonds, 0 to 6, below which a grain is bonded to its nearest neighbours as well. With 2 no grain can turn about a single bond.
    #[serde(default)]
    #[schemars(range(max = 6))]
    pub bonds_min: u32,
    /// Laws of contacts between two groups of bodies, where they differ from `law`.
    #[serde(default)]
    pub pairs: Vec<PairConfig>,
}

/// Law of contacts between two groups: an absent key has its value from `law`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairConfig {
    /// Names of the two groups: `grains`, `base`, `lid`, `wheel`, a wall or a cluster. The same name twice stands for contacts within the group.
    pub between: [String; 2],
    /// Coefficient of friction; `law.friction` when absent.
    #[schemars(range(min = 0.0))]
    pub friction: Option<f64>,
    /// Resistance to rolling; `law.rolling` when absent.
    pub rolling: Option<RollingConfig>,
    /// Attraction, switched off by a pull-off force of 0; `law.adhesion` when absent.
    pub adhesion: Option<AdhesionConfig>,
    /// Growth of bonds; `law.healing` when absent.
    pub healing: Option<HealingConfig>,
    /// Newton's coefficient of restitution of rigid contacts; `law.restitution` when absent.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub restitution: Option<f64>,
    /// Stiffness of the contacts per thickness (Pa); `law.contact_stiffness_pa` when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub contact_stiffness_pa: Option<f64>,
    /// Restitution of compliant contacts by dampers parallel to their springs; `law.damping` when absent.
    #[schemars(range(min = 0.14, max = 1.0))]
    pub damping: Option<f64>,
    /// kt / kn of compliant contacts; `law.tangential_stiffness_ratio` when absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tangential_stiffness_ratio: Option<f64>,
}

/// Treatment of the gap of a rigid contact and of an overlap: the words for `law.penetration`.
///
/// A repair within the velocities (Baumgarte) throws grains apart: they keep the distance repaired in a step as speed, and no heap comes to rest. The
/// two repairs of positions do not change the velocities (see [`dem_kernel::step::repair`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Penetration {
    /// U = u_n + g/h: an overlap is gone after the step, at the price of a speed |g|/h.
    Gap,
    /// U = u_n + max(0, g)/h: overlaps stay (LMGC90's IQS). The default: 600 grains that fell into a box then move at 2e-5 m/s and overlap by 3e-5 of
    /// a radius on average; under `gap` they move at 1e-3 m/s, with bursts of 0.08 m/s and six times the iterations.
    Iqs,
    /// As IQS, then the bodies are moved apart along the normals of the step.
    Split,
    /// As IQS, then the bodies are moved apart until no pair overlaps at its new position.
    Projection,
}

/// Weight of the surface energy at a falling adhesion: the words for `law.h_prime`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HPrime {
    /// h' = 1: adhesion falls gradually, separation takes w.
    One,
    /// h' = a: brittle, separation takes w/2.
    Adhesion,
}

/// `law.rolling`: a couple of at most `coefficient` x r x the normal force against relative spin, with r = r1 r2/(r1 + r2), or the radius of the
/// grain on walls, surfaces and wheels.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RollingConfig {
    /// Coefficient of rolling resistance, at least 0.
    #[schemars(range(min = 0.0))]
    pub coefficient: f64,
}

/// `law.adhesion`: a constant attraction N_c between bodies whose gap is below a range; contact and friction hold for the normal force
/// plus N_c.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdhesionConfig {
    /// N_c of every pair (N); give either this key or `pull_off_pa`.
    #[schemars(range(min = 0.0))]
    pub pull_off_n: Option<f64>,
    /// N_c over r x thickness (Pa), with r = r1 r2/(r1 + r2), or the radius of the grain on walls, surfaces and wheels; in place of `pull_off_n`.
    #[schemars(range(min = 0.0))]
    pub pull_off_pa: Option<f64>,
    /// Gap below which pairs attract each other (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub range_m: f64,
}

/// `law.healing`: pairs that press on each other are bonded, and their bonds grow. A bond of adhesion a also has the part 1 - a of the friction.
/// A bond to a wall or a surface passes from one segment to the next.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HealingConfig {
    /// Time under pressure in which adhesion grows from 0 to 1 (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub time_s: f64,
    /// Least pressure at which a bond grows (Pa): the normal force over the bond's area r1 r2/(r1 + r2) x thickness.
    #[schemars(range(min = 0.0))]
    pub pressure_pa: f64,
}

impl AdhesionConfig {
    pub(super) fn validate(&self, key: &str) -> Result<(), ConfigError> {
        refuse_if(
            self.pull_off_n.is_some() == self.pull_off_pa.is_some(),
            key,
            "needs one of pull_off_n and pull_off_pa",
            "give the force of every pair, or the force over r x thickness",
        )
    }
}

/// The words for `law.kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LawKind {
    /// Unilateral contact without friction.
    Signorini,
    /// Unilateral contact with Coulomb friction: loose grains.
    Coulomb,
    /// Bonds of Raous, Cangémi and Cocou between grains, which carry tension and break; Coulomb friction elsewhere.
    Cohesion,
    /// `coulomb` with `penetration = "iqs"`.
    #[serde(rename = "IQS_CLB")]
    IqsClb,
    /// `coulomb` with `restitution`, which it needs.
    #[serde(rename = "RST_CLB")]
    RstClb,
    /// `cohesion` with `penetration = "iqs"`.
    #[serde(rename = "IQS_MAC_CZM")]
    IqsMacCzm,
}

impl LawKind {
    /// The kind without LMGC90's name.
    pub fn plain(self) -> LawKind {
        match self {
            LawKind::IqsClb | LawKind::RstClb => LawKind::Coulomb,
            LawKind::IqsMacCzm => LawKind::Cohesion,
            plain => plain,
        }
    }
}

impl PairConfig {
    /// True for an entry that gives no key of a law.
    pub(super) fn has_no_law(&self) -> bool {
        let given = kit::named!(self, is_some; friction, rolling, adhesion, healing, restitution,
            contact_stiffness_pa, damping, tangential_stiffness_ratio);
        given.iter().all(|(_, given)| !given)
    }

    /// The law with the keys of this pair.
    pub fn merged(&self, law: &LawConfig) -> LawConfig {
        let mut merged = law.clone();
        merged.pairs.clear();
        macro_rules! own {
            ($($key:ident),+) => { $(merged.$key = self.$key.or(law.$key);)+ };
        }
        own!(friction, rolling, adhesion, healing, restitution);
        own!(contact_stiffness_pa, damping, tangential_stiffness_ratio);
        merged
    }
}

impl LawConfig {
    /// Treatment of overlaps of rigid contacts.
    pub fn penetration(&self) -> law::Penetration {
        match self.penetration {
            Some(Penetration::Gap) => law::Penetration::Gap,
            None | Some(Penetration::Iqs) => law::Penetration::Iqs,
            Some(Penetration::Split) => law::Penetration::Split,
            Some(Penetration::Projection) => law::Penetration::Projection,
        }
    }

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        self.validate_contacts("law")?;
        self.validate_adhesion()?;
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

    /// Checks the keys that pairs have too; `key` is their table.
    fn validate_contacts(&self, key: &str) -> Result<(), ConfigError> {
        if let Some(adhesion) = &self.adhesion {
            adhesion.validate(&format!("{key}.adhesion"))?;
        }
        refuse_if(
            self.damping.is_some() && self.contact_stiffness_pa.is_none(),
            &format!("{key}.damping"),
            "is for springs, and rigid contacts have none: the key would have no effect",
            format!("write {key}.restitution instead, or give {key}.contact_stiffness_pa"),
        )
    }

    /// Refuses pairs of unknown groups, pairs that are listed twice, and laws that contradict the others.
    pub(super) fn validate_pairs(&self, groups: &[&str]) -> Result<(), ConfigError> {
        for (i, pair) in self.pairs.iter().enumerate() {
            let key = format!("law.pairs[{i}]");
            let between = format!("{key}.between");
            for name in &pair.between {
                refuse_if(
                    !groups.contains(&name.as_str()),
                    &between,
                    format!("there is no group {name:?}; the scene has {groups:?}"),
                    "write one of these names; a wall gets one by sample.walls.name",
                )
                .map_err(|error| error.because(Cause::UnknownName))?;
            }
            let same = |other: &PairConfig| {
                let [a, b] = &other.between;
                pair.between == other.between || pair.between == [b.clone(), a.clone()]
            };
            refuse_if(
                self.pairs[..i].iter().any(same),
                &between,
                format!("the pair {:?} is there twice", pair.between),
                "write one entry a pair",
            )
            .map_err(|error| error.because(Cause::DuplicateName))?;
            pair.merged(self).validate_contacts(&key)?;
            self.validate_pair(pair, &key)?;
        }
        Ok(())
    }

    fn validate_pair(&self, pair: &PairConfig, key: &str) -> Result<(), ConfigError> {
        let springs = self.contact_stiffness_pa.is_some();
        let elastic =
            pair.contact_stiffness_pa.is_some() || pair.tangential_stiffness_ratio.is_some();
        let refusals = [
            (
                pair.healing.is_some() && self.kind.plain() != LawKind::Cohesion,
                "healing",
                "belongs to bonds, and this law has none",
                "choose law.kind = \"cohesion\"",
            ),
            (
                pair.friction.is_some() && self.friction.is_none(),
                "friction",
                "law.kind = \"signorini\" has no tangential force",
                "choose law.kind = \"coulomb\" with friction = 0",
            ),
            (
                springs && pair.restitution.is_some(),
                "restitution",
                "is for rigid contacts, and law.contact_stiffness_pa makes elastic ones",
                "remove it",
            ),
            (
                !springs && elastic,
                "contact_stiffness_pa",
                "is for elastic contacts, and law has no contact_stiffness_pa: rigid and elastic contacts do not mix",
                "give law.contact_stiffness_pa too, or remove it",
            ),
        ];
        refusals
            .into_iter()
            .try_for_each(|(holds, name, why, help)| {
                refuse_if(holds, &format!("{key}.{name}"), why, help)
            })
    }

    /// Refuses adhesion together with keys that contradict it.
    fn validate_adhesion(&self) -> Result<(), ConfigError> {
        let some = self.adhesion.is_some() || self.pairs.iter().any(|pair| pair.adhesion.is_some());
        let rebounds = |pair: &PairConfig| pair.restitution.is_some();
        let others = [
            (
                self.kind.plain() == LawKind::Cohesion,
                "attracts pairs, and law.kind = \"cohesion\" bonds them instead",
                "choose law.kind = \"coulomb\", or remove law.adhesion",
            ),
            (
                self.restitution.is_some() || self.pairs.iter().any(rebounds),
                "acts across a gap, and contacts with law.restitution begin when the gap is closed",
                "remove law.restitution, or give law.contact_stiffness_pa with law.damping",
            ),
            (
                self.penetration().repairs(),
                "has a potential, and law.penetration moves grains apart after the step without any work",
                "write law.penetration = \"iqs\" or \"gap\"",
            ),
        ];
        others
            .into_iter()
            .try_for_each(|(holds, why, help)| refuse_if(some && holds, "law.adhesion", why, help))
    }

    /// Checks the options of rigid contacts, restitution and penetration, whether given by keys or by an LMGC90 name.
    fn validate_rigid(&self) -> Result<(), ConfigError> {
        self.refuse_rigid_options_of_springs()?;
        self.validate_names()?;
        refuse_if(
            self.restitution.is_some() && self.penetration == Some(Penetration::Gap),
            "law.penetration",
            "\"gap\" repairs overlaps by velocity, which would add to the rebound of law.restitution",
            "write \"iqs\", \"split\" or \"projection\"",
        )?;
        refuse_if(
            self.kind.plain() == LawKind::Cohesion && self.penetration().repairs(),
            "law.penetration",
            "moves grains apart after the step, which would stretch their bonds without any work",
            "write \"iqs\" or \"gap\" with law.kind = \"cohesion\"",
        )
    }

    fn refuse_rigid_options_of_springs(&self) -> Result<(), ConfigError> {
        if self.contact_stiffness_pa.is_none() {
            return Ok(());
        }
        refuse_given(
            [
                ("law.restitution", self.restitution.is_some()),
                ("law.penetration", self.penetration.is_some()),
                ("law.kind", self.kind.plain() != self.kind),
            ],
            "is for rigid contacts, and law.contact_stiffness_pa makes elastic ones, which rebound and overlap by themselves",
            "remove one of the two",
        )
    }

    /// Refuses options that contradict an LMGC90 name.
    fn validate_names(&self) -> Result<(), ConfigError> {
        let contradicts = |holds: bool, key: &str, means: &str| {
            refuse_if(
                holds,
                key,
                format!(
                    "contradicts law.kind = {}, which means {means}",
                    json!(self.kind)
                ),
                "remove the key, or choose the plain kind with the options that you want",
            )
        };
        let iqs = matches!(self.kind, LawKind::IqsClb | LawKind::IqsMacCzm);
        let impacts = iqs && self.restitution.is_some();
        contradicts(impacts, "law.restitution", "inelastic impacts")?;
        let other = iqs && !matches!(self.penetration, None | Some(Penetration::Iqs));
        contradicts(other, "law.penetration", "penetration = \"iqs\"")?;
        if self.kind == LawKind::RstClb {
            let by = "contacts of law.kind = \"RST_CLB\"";
            required("law.restitution", self.restitution, by)?;
        }
        Ok(())
    }

    fn validate_cohesion(&self) -> Result<(), ConfigError> {
        for (key, value) in self.cohesion_numbers() {
            required(key, value, "law.kind = \"cohesion\"")?;
        }
        refuse_if(
            self.h_prime.is_none(),
            "law.h_prime",
            "law.kind = \"cohesion\" needs it and it is missing",
            "write h_prime = \"one\" or \"adhesion\"",
        )
    }

    fn refuse_cohesion(&self) -> Result<(), ConfigError> {
        let numbers = self
            .cohesion_numbers()
            .map(|(key, value)| (key, value.is_some()));
        let others = [
            ("law.h_prime", self.h_prime.is_some()),
            ("law.bonds_min", self.bonds_min > 0),
            ("law.bond_damping_ratio", self.bond_damping_ratio.is_some()),
            ("law.healing", self.healing.is_some()),
        ];
        refuse_given(
            numbers.into_iter().chain(others),
            "belongs to bonds, and this law has none: the key would have no effect",
            "remove it, or choose law.kind = \"cohesion\"",
        )
    }

    fn cohesion_numbers(&self) -> [(&'static str, Option<f64>); 6] {
        kit::named!("law.", self; cn_pa_per_m, ct_pa_per_m, w_j_per_m2, b_pa_m_s, p, alert_m)
    }

    fn validate_frictionless(&self) -> Result<(), ConfigError> {
        let ratio = self.tangential_stiffness_ratio.is_some();
        refuse_given(
            [
                ("law.friction", self.friction.is_some()),
                ("law.tangential_stiffness_ratio", ratio),
            ],
            "law.kind = \"signorini\" has no tangential force, the key would have no effect",
            "remove it, or choose law.kind = \"coulomb\"",
        )
    }

    fn validate_friction(&self, by: &str) -> Result<(), ConfigError> {
        required("law.friction", self.friction, by)?;
        let key = "law.tangential_stiffness_ratio";
        let ratio = self.tangential_stiffness_ratio;
        if self.contact_stiffness_pa.is_some() {
            let why = "compliant contacts with friction";
            return required(key, ratio, why).map(|_| ());
        }
        refuse_if(
            ratio.is_some(),
            key,
            "rigid contacts have no stiffness, the key would have no effect",
            "remove it, or give law.contact_stiffness_pa",
        )
    }
}
