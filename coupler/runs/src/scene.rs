//! The parts of a scenario that pages use, read leniently from the run's own copy: a run may be older than this
//! program, and its files may be missing.

use scenario::keys::TransportKind;
use scenario::plausible::Plausible;
use serde::Deserialize;
use toml::{Table, Value};

/// A rigid wheel that is not made of disks.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothWheel {
    /// The participant that carries it.
    pub participant: String,
    /// Radius of its face (m); 0 = flat.
    pub radius_m: f64,
}

/// Keys of a scenario.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// `run.name`, empty if it cannot be read.
    pub name: String,
    /// `run.transport`.
    pub transport: TransportKind,
    /// `run.plausible`.
    pub plausible: Plausible,
    /// The participants in the order of the file.
    pub participants: Vec<String>,
    /// The wheel, if it is not made of disks.
    pub wheel: Option<SmoothWheel>,
    /// The participant that carries a wheel of any kind.
    pub wheel_of: Option<String>,
    /// Frequency of the wheel's sideways motion, if there is one (1/s).
    pub wheel_hz: Option<f64>,
    /// True for a wheel that rolls.
    pub rolls: bool,
    /// The sets that each interface joins, `participant.set`.
    pub joined: Vec<[String; 2]>,
}

impl Setup {
    /// The setup in a `scenario.toml`.
    pub fn from(table: &Table) -> Setup {
        let list = |key| {
            table
                .get(key)
                .and_then(Value::as_array)
                .into_iter()
                .flatten()
        };
        let name = |participant: &Value| key::<String>(Some(participant), "name");
        let wheel = |p: &Value| Some((name(p), p.get("config")?.get("wheel").cloned()?));
        let (wheel_of, wheel) = list("participant").find_map(wheel).unzip();
        let wheel = wheel.as_ref();
        let is_smooth = key::<String>(wheel, "face") != "disks";
        let smooth = wheel_of.clone().filter(|_| is_smooth);
        let joined = list("interface").filter_map(|interface| key(Some(interface), "between"));
        let run = table.get("run");
        Setup {
            name: key(run, "name"),
            transport: key(run, "transport"),
            plausible: key(run, "plausible"),
            wheel: smooth.map(|participant| SmoothWheel {
                participant,
                radius_m: key(wheel, "radius_m"),
            }),
            wheel_of,
            rolls: wheel.is_some_and(|wheel| wheel.get("rolling").is_some()),
            wheel_hz: Some(key(wheel, "frequency_hz")).filter(|hz| *hz > 0.0),
            joined: joined.collect(),
            participants: list("participant").map(name).collect(),
        }
    }

    /// The set of a participant and the set that it is joined with, at the first of its interfaces.
    pub fn partner(&self, participant: &str) -> Option<JoinedSet<'_>> {
        self.joined.iter().find_map(|[a, b]| {
            let (a, b) = (a.split_once('.')?, b.split_once('.')?);
            let mut ordered = [(a, b), (b, a)].into_iter();
            let (own, other) = ordered.find(|(own, _)| own.0 == participant)?;
            Some(JoinedSet {
                set: own.1,
                partner: other.0,
                partner_set: other.1,
            })
        })
    }
}

/// A set of a participant, and the set that it is joined with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JoinedSet<'a> {
    /// The participant's own set.
    pub set: &'a str,
    /// The participant on the other side.
    pub partner: &'a str,
    /// Its set.
    pub partner_set: &'a str,
}

/// A key of a table; its default if it cannot be read.
fn key<'a, T: Deserialize<'a> + Default>(table: Option<&Value>, key: &str) -> T {
    let value = table.and_then(|table| table.get(key)).cloned();
    let read = value.and_then(|value| value.try_into().ok());
    read.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup(text: &str) -> Setup {
        Setup::from(&text.parse().expect("it is TOML"))
    }

    #[test]
    fn a_setup_has_the_wheel_and_the_joined_sets() {
        let setup = setup(
            "run.name = \"a\"\nrun.transport = \"channel\"\nrun.plausible.gap_rel = [0.5, 1]\n[[participant]]\nname = \"up\"\n[[participant]]\nname = \"layer\"\n\
             config.wheel = { radius_m = 1, frequency_hz = 300 }\n[[interface]]\nbetween = [\"up.bottom\", \"layer.lid\"]",
        );
        assert_eq!(setup.participants, ["up", "layer"]);
        assert_eq!(setup.transport, TransportKind::Channel);
        assert_eq!(setup.plausible.of(&crate::plausible::GAP).warn, 0.5);
        let wheel = setup.wheel.as_ref().expect("it has a face");
        assert_eq!((wheel.participant.as_str(), wheel.radius_m), ("layer", 1.0));
        assert_eq!(setup.wheel_hz, Some(300.0));
        let joint = setup.partner("up").expect("it is joined");
        assert_eq!(
            [joint.set, joint.partner, joint.partner_set],
            ["bottom", "layer", "lid"]
        );
        assert_eq!(setup.partner("layer").map(|joint| joint.set), Some("lid"));
        assert_eq!(setup.partner("none"), None);
    }

    #[test]
    fn a_wheel_of_disks_has_no_shape_of_its_own() {
        let setup = setup("[[participant]]\nname = \"a\"\nconfig.wheel = { face = \"disks\" }");
        assert_eq!((setup.wheel, setup.wheel_of), (None, Some("a".into())));
    }
}
