//! Prescribed motions of a set: a velocity or a displacement, or a displacement over time.

use kit::ConfigError;
use kit::keys::refuse_if;
use kit::number::PrescribedComponent;
use kit::table::{LoadTable, check_table, last_change, load_at};
use schemars::JsonSchema;
use serde::Deserialize;

/// Displacement over time: entries of a time (s) and the displacement along x and y (m), or `"free"` in all of them.
pub type MotionTable = Vec<[PrescribedComponent; 3]>;

/// A motion to and fro, D(t) = A sin(2 pi f (t - t_s)) from t_s on; it starts at full speed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReciprocatingConfig {
    /// Amplitude A (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub amplitude_m: f64,
    /// Frequency f (1/s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub frequency_hz: f64,
    /// Start t_s (s); the set is held until then.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub start_s: f64,
    /// Direction of D, of any length but 0, `"free"` where the set may move; when absent, along x and free along y.
    #[serde(default = "along_x")]
    pub direction: [PrescribedComponent; 2],
}

fn along_x() -> [PrescribedComponent; 2] {
    [Some(1.0), None].map(PrescribedComponent)
}

/// Motion of a set, once read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SetMotion<'a> {
    Velocity([PrescribedComponent; 2]),
    Displacement([PrescribedComponent; 2]),
    Table(&'a MotionTable),
    Reciprocating(&'a ReciprocatingConfig),
}

impl SetMotion<'_> {
    /// Its components: (m/s), (m), or factors of the displacement over time.
    pub(crate) fn components(self) -> [PrescribedComponent; 2] {
        match self {
            SetMotion::Velocity(components) | SetMotion::Displacement(components) => components,
            SetMotion::Table(table) => [1, 2].map(|k| {
                let given = table.first().and_then(|entry| entry[k].0);
                PrescribedComponent(given.map(|_| 1.0))
            }),
            SetMotion::Reciprocating(motion) => {
                let along = unit(motion.direction.map(|d| d.0.unwrap_or(0.0)));
                [0, 1].map(|k| PrescribedComponent(motion.direction[k].0.map(|_| along[k])))
            }
        }
    }

    /// The key that gives it.
    pub(crate) fn key(self) -> &'static str {
        match self {
            SetMotion::Velocity(_) => "velocity_m_per_s",
            SetMotion::Displacement(_) => "displacement_m",
            SetMotion::Table(_) => "motion_table",
            SetMotion::Reciprocating(_) => "motion",
        }
    }

    /// True if it moves the set along x (0) or y (1); a set may also be held at 0.
    pub(crate) fn moves(self, k: usize) -> bool {
        match self {
            SetMotion::Table(table) => by_direction(table)[k].iter().any(|entry| entry[1] != 0.0),
            _ => self.components()[k]
                .0
                .is_some_and(|component| component != 0.0),
        }
    }

    /// Refuses numbers that describe no motion.
    pub(super) fn check(self, set: &str) -> Result<(), ConfigError> {
        let key = |name: &str| format!("boundary.{set}.{name}");
        match self {
            SetMotion::Velocity(components) | SetMotion::Displacement(components) => refuse_if(
                components.iter().all(|component| component.0.is_none()),
                &key(self.key()),
                "leaves the set free in both directions",
                "remove the key, or write a number along one of them",
            ),
            SetMotion::Table(table) => check_motion_table(&key("motion_table"), table),
            SetMotion::Reciprocating(motion) => {
                let given = motion.direction.map(|d| d.0.unwrap_or(0.0));
                check_direction(&key("motion.direction"), given)
            }
        }
    }
}

/// Displacements along x and y over time (s, m), empty where the set may move.
pub(crate) fn by_direction(table: &MotionTable) -> [LoadTable; 2] {
    let entry = |entry: &[PrescribedComponent; 3], k: usize| Some([entry[0].0?, entry[k].0?]);
    [1, 2].map(|k| table.iter().filter_map(|all| entry(all, k)).collect())
}

/// Time from which the set stays in place (s).
pub(crate) fn settled_at(table: &MotionTable) -> f64 {
    let changes = by_direction(table);
    let changes = changes.iter().filter_map(|along| last_change(Some(along)));
    changes.fold(0.0, f64::max)
}

/// Refuses a table that [`check_table`] refuses in a direction, that moves nothing, or that begins with a jump.
fn check_motion_table(key: &str, table: &MotionTable) -> Result<(), ConfigError> {
    let refused = |problem: String| {
        ConfigError::new(key, problem).help(
            "write [[0.0, 0.0, 0.0], [t_s, x_m, y_m], ...], by ascending time and with \"free\" in all entries where the set may move",
        )
    };
    let given = |entry: &[PrescribedComponent; 3]| entry.map(|number| number.0.is_some());
    if table.len() < 2 {
        return Err(
            ConfigError::new(key, "moves nothing with fewer than two entries")
                .help("write displacement_m = [0.0, 0.0] to hold the set"),
        );
    }
    let [_, along_x, along_y] = given(&table[0]);
    if !along_x && !along_y {
        return Err(refused("leaves the set free in both directions".into()));
    }
    let other = |entry| given(entry) != [true, along_x, along_y];
    if let Some(i) = table.iter().position(other) {
        let problem = format!("entry {i} has no time, or its free directions differ from entry 0");
        return Err(refused(problem));
    }
    for along in by_direction(table).iter().filter(|one| !one.is_empty()) {
        check_table(key, along).map_err(|error| refused(error.problem))?;
        let start = load_at(along, 0.0);
        if start != 0.0 {
            let problem = format!("is {start:e} m at t = 0, where the body is not displaced");
            return Err(refused(problem));
        }
    }
    Ok(())
}

/// The unit vector along a vector that is not 0.
pub(super) fn unit(along: [f64; 2]) -> [f64; 2] {
    // The length of two large numbers overflows; the length of their ratios does not.
    let larger = along[0].abs().max(along[1].abs());
    let [x, y] = along.map(|d| d / larger);
    [x, y].map(|d| d / x.hypot(y))
}

/// Refuses a direction of no length.
pub(super) fn check_direction(key: &str, direction: [f64; 2]) -> Result<(), ConfigError> {
    if direction != [0.0; 2] {
        return Ok(());
    }
    let problem = format!("is {direction:?}, but must hold two numbers that are not both 0");
    Err(ConfigError::new(key, problem)
        .help("write [0.0, -1.0] for downwards, [1.0, 0.0] for to the right"))
}
