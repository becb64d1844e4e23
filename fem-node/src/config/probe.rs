//! Probes: points of the body whose motion is reported.

use kit::ConfigError;
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

/// A point of the undeformed body whose displacement and velocity are signals.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeConfig {
    /// Name of letters, digits, `-` and `_`. Its signals are `<name>_ux_m`, `_uy_m` and, except in a static analysis, `_vx_m_per_s`, `_vy_m_per_s`.
    pub name: String,
    /// Position along x (m), in the body or on its outline.
    pub x_m: f64,
    /// Position along y (m).
    pub y_m: f64,
}

/// Beginnings of the names of other signals.
const TAKEN: [&str; 3] = ["surface_mean", "surface_min", "wheel"];

/// Refuses names that cannot begin a signal or are given twice.
pub(super) fn check(probes: &[ProbeConfig]) -> Result<(), ConfigError> {
    for (index, probe) in probes.iter().enumerate() {
        let key = format!("probes[{index}]");
        let name = &probe.name;
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
        let refused = |problem: &str, cause: Cause, help: &str| {
            let error = ConfigError::new(&format!("{key}.name"), format!("`{name}` {problem}"));
            Err(error.because(cause).help(help))
        };
        if name.is_empty() || !name.chars().all(plain) {
            let help = "use letters, digits, `-` and `_`";
            return refused(
                "cannot begin the name of a signal",
                Cause::InvalidValue,
                help,
            );
        }
        if TAKEN.contains(&name.as_str()) {
            let problem = "begins the name of another signal";
            return refused(problem, Cause::DuplicateName, "choose another name");
        }
        if probes[..index].iter().any(|other| other.name == *name) {
            let help = "give each probe a name of its own";
            return refused(
                "is the name of another probe too",
                Cause::DuplicateName,
                help,
            );
        }
    }
    Ok(())
}
