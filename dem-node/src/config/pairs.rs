//! The keys of `law.pairs`: what contacts between two named groups have of their own.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::limits::{not_negative, positive, within};
use protocol::Cause;

use super::law::{LawConfig, LawKind, PairConfig};

/// Refuses pairs of groups that are not there, that are there twice, or whose law cannot go with the others.
pub(super) fn validate_pairs(law: &LawConfig, groups: &[&str]) -> Result<(), ConfigError> {
    for (i, pair) in law.pairs.iter().enumerate() {
        let key = |name: &str| format!("law.pairs[{i}].{name}");
        for name in &pair.between {
            refuse_if(
                !groups.contains(&name.as_str()),
                &key("between"),
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
            law.pairs[..i].iter().any(same),
            &key("between"),
            format!("the pair {:?} is there twice", pair.between),
            "write one entry a pair",
        )
        .map_err(|error| error.because(Cause::DuplicateName))?;
        validate_pair(pair, law, key)?;
    }
    Ok(())
}

fn validate_pair(
    pair: &PairConfig,
    law: &LawConfig,
    key: impl Fn(&str) -> String,
) -> Result<(), ConfigError> {
    not_negative(&key("friction"), pair.friction.unwrap_or(0.0), "")?;
    let rolling = pair.rolling.map_or(0.0, |rolling| rolling.coefficient);
    not_negative(&key("rolling.coefficient"), rolling, "")?;
    if let Some(adhesion) = &pair.adhesion {
        adhesion.validate(&key("adhesion"))?;
    }
    if let Some(healing) = &pair.healing {
        healing.validate(&key("healing"))?;
        refuse_if(
            law.kind.plain() != LawKind::Cohesion,
            &key("healing"),
            "belongs to bonds, and this law has none",
            "choose law.kind = \"cohesion\"",
        )?;
    }
    within(&key("restitution"), pair.restitution, [0.0, 1.0])?;
    positive(
        &key("contact_stiffness_pa"),
        pair.contact_stiffness_pa,
        "Pa",
    )?;
    positive(
        &key("tangential_stiffness_ratio"),
        pair.tangential_stiffness_ratio,
        "",
    )?;
    refuse_if(
        pair.friction.is_some() && law.friction.is_none(),
        &key("friction"),
        "law.kind = \"signorini\" has no tangential force",
        "choose law.kind = \"coulomb\" with friction = 0",
    )?;
    let springs = law.contact_stiffness_pa.is_some();
    refuse_if(
        springs && pair.restitution.is_some(),
        &key("restitution"),
        "is for rigid contacts, and law.contact_stiffness_pa makes elastic ones",
        "remove it",
    )?;
    let elastic = pair.contact_stiffness_pa.is_some() || pair.tangential_stiffness_ratio.is_some();
    refuse_if(
        !springs && elastic,
        &key("contact_stiffness_pa"),
        "is for elastic contacts, and law has no contact_stiffness_pa: rigid and elastic contacts do not mix",
        "give law.contact_stiffness_pa too, or remove it",
    )
}
