//! Probes: points of the body whose motion is reported.

use kit::ConfigError;
use protocol::Cause;
use schemars::JsonSchema;
use serde::Deserialize;

/// A point of the undeformed body whose displacement and velocity are signals.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeConfig {
    /// Name, with which those of its signals begin; letters, digits, `-` and `_`.
    pub name: String,
    /// Position (m), in the body or on its outline.
    pub x_m: f64,
    /// Position (m).
    pub y_m: f64,
}

/// Beginnings of the names of other signals.
const TAKEN: [&str; 3] = ["surface_mean", "surface_min", "wheel"];

/// Refuses names that cannot begin a signal or are given twice, and positions that are no numbers.
pub(super) fn check(probes: &[ProbeConfig]) -> Result<(), ConfigError> {
    for (index, probe) in probes.iter().enumerate() {
        let key = format!("probes[{index}]");
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
        if probe.name.is_empty() || !probe.name.chars().all(plain) {
            let problem = format!("`{}` cannot begin the name of a signal", probe.name);
            return Err(ConfigError::new(&format!("{key}.name"), problem)
                .help("use letters, digits, `-` and `_`"));
        }
        if TAKEN.contains(&probe.name.as_str()) {
            let problem = format!(
                "`{}` begins the name of a signal that is no probe's",
                probe.name
            );
            return Err(ConfigError::new(&format!("{key}.name"), problem)
                .because(Cause::DuplicateName)
                .help("choose another name"));
        }
        if probes[..index].iter().any(|other| other.name == probe.name) {
            let problem = format!("`{}` is the name of another probe too", probe.name);
            return Err(ConfigError::new(&format!("{key}.name"), problem)
                .because(Cause::DuplicateName)
                .help("give each probe a name of its own"));
        }
        for (name, value) in [("x_m", probe.x_m), ("y_m", probe.y_m)] {
            if !value.is_finite() {
                return Err(ConfigError::new(&format!("{key}.{name}"), "must be finite")
                    .because(Cause::OutOfRange));
            }
        }
    }
    Ok(())
}
