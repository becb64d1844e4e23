//! Helpers that the cases share: small scenes as JSON, and reports whose values are read by the node's names.

use dem_node::Dem;
use protocol::{Description, Node, Role, Setting, Window};
use serde_json::{Value, json};

/// Thickness of all scenes (m).
pub const THICKNESS: f64 = 1e-3;
/// Density of all scenes (kg/m3).
pub const DENSITY: f64 = 7800.0;

/// A setting that writes nothing.
pub fn setting(seed: u64) -> Setting {
    Setting {
        participant: "third-body".into(),
        seed,
        thickness_m: THICKNESS,
        threads: 1,
        fields: None,
        cache: None,
    }
}

/// Mass of a disk of this radius (kg).
pub fn mass(radius: f64) -> f64 {
    DENSITY * std::f64::consts::PI * radius * radius * THICKNESS
}

/// Window number `index`, of this length (s).
pub fn window(index: u64, length: f64) -> Window {
    Window {
        index,
        substeps: 1,
        t0_s: index as f64 * length,
        t1_s: (index + 1) as f64 * length,
        ..Window::default()
    }
}

/// A scene of single disks; `overrides` are merged over its top-level keys.
pub fn scene(law: Value, step_s: f64, sample: Value, overrides: Value) -> Value {
    let config = json!({
        "law": law,
        "solver": {"kind": "nsgs", "tolerance": 1e-12, "max_iterations": 20_000, "min_iterations": 1},
        "time": {"step_s": step_s, "pressure_pa": 1.0},
        "density_kg_per_m3": DENSITY,
        "sample": sample,
    });
    with(config, &overrides)
}

/// A table of keys, with the keys of another table set over it.
pub fn with(mut keys: Value, more: &Value) -> Value {
    for (key, value) in more.as_object().into_iter().flatten() {
        keys[key] = value.clone();
    }
    keys
}

/// The node of disks on a floor at y = 0, under gravity downwards (m/s2).
pub fn on_floor(law: Value, step_s: f64, gravity: f64, disks: Value, overrides: &Value) -> Dem {
    let floor = json!([{"name": "floor", "x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]);
    let sample = json!({"kind": "disks", "disks": disks, "walls": floor});
    let overrides = with(json!({"gravity_m_per_s2": [0.0, -gravity]}), overrides);
    build(&scene(law, step_s, sample, overrides))
}

/// The node of a scene.
pub fn build(config: &Value) -> Dem {
    let config = kit::read_config(config).expect("the scene is valid");
    Dem::new(&config, &setting(1)).expect("the scene can be prepared")
}

/// The message that refuses a scene.
pub fn refusal(config: &Value) -> String {
    let config = match kit::read_config(config) {
        Ok(config) => config,
        Err(error) => return error.to_string(),
    };
    let refused = Dem::new(&config, &setting(1)).err();
    refused.expect("the scene must be refused").to_string()
}

/// Advances the node alone by `steps` of its own steps, from step `from`.
pub fn march(dem: &mut Dem, from: u64, steps: u32) -> Report {
    let window = Window {
        step: from,
        substeps: steps,
        ..Window::default()
    };
    let values = dem.advance_alone(&window).expect("the steps converge");
    Report::new(dem.describe(), values)
}

/// A report with the names of its values.
pub struct Report {
    description: Description,
    values: Vec<f64>,
}

impl Report {
    pub fn new(description: Description, values: Vec<f64>) -> Report {
        assert_eq!(
            values.len(),
            description.signals.len() + description.ledger.len()
        );
        Report {
            description,
            values,
        }
    }

    pub fn signal(&self, name: &str) -> f64 {
        let mut names = self.description.signals.iter();
        let index = names.position(|signal| signal == name);
        self.values[index.unwrap_or_else(|| panic!("there is no signal {name}"))]
    }

    pub fn energy(&self, name: &str) -> f64 {
        let mut terms = self.description.ledger.iter();
        let index = terms.position(|term| term.name == name);
        let first = self.description.signals.len();
        self.values[first + index.unwrap_or_else(|| panic!("there is no term {name}"))]
    }

    /// |W - dE - D| over `scale` (J), or over the sum of |W| when it is larger.
    pub fn imbalance(&self, scale: f64) -> f64 {
        let first = self.description.signals.len();
        let (mut balance, mut work) = (0.0, 0.0);
        for (term, value) in self.description.ledger.iter().zip(&self.values[first..]) {
            match term.role {
                Role::InterfaceWork | Role::Work => {
                    balance += value;
                    work += value.abs();
                }
                Role::Stored | Role::Dissipated => balance -= value,
                Role::Rounding => {}
            }
        }
        balance.abs() / scale.max(work)
    }
}

/// Fails unless |value - expected| <= tolerance.
#[track_caller]
pub fn close(what: &str, value: f64, expected: f64, tolerance: f64) {
    let distance = (value - expected).abs();
    assert!(
        distance <= tolerance,
        "{what}: {value:e} instead of {expected:e}, off by {distance:e} where {tolerance:e} is allowed"
    );
}
