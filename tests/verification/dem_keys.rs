//! Mistakes in `sample`, whose keys depend on its kind: each is refused by the path of the key, not by the path of the table.

use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, refusal, scene};

fn of(sample: Value) -> String {
    refusal(&scene(
        json!({"kind": "signorini"}),
        1e-4,
        sample,
        json!({}),
    ))
}

/// A sample with this value of a key in a table, given as a JSON pointer, or without the key if there is no value.
fn changed(mut sample: Value, table: &str, key: &str, value: Option<Value>) -> Value {
    let keys = sample.pointer_mut(table).and_then(Value::as_object_mut);
    let keys = keys.expect("the table is there");
    match value {
        Some(value) => keys.insert(key.into(), value),
        None => keys.shift_remove(key),
    };
    sample
}

fn disks() -> Value {
    let disk = |x: f64| json!({"x_m": x, "y_m": 1e-3, "radius_m": 1e-3});
    json!({
        "kind": "disks", "disks": [disk(0.0), disk(2e-3), disk(4e-3), disk(6e-3)],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    })
}

fn layer() -> Value {
    json!({
        "kind": "layer", "thickness_m": 3e-4, "half_width_m": 1.5e-3, "crown_radius_m": 0.3, "radius_min_m": 5e-5,
        "radius_max_m": 1e-4, "law": "surface_uniform",
    })
}

/// The message must contain all parts.
fn contains_all(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

#[test]
fn a_wrong_type_is_named() {
    let word = || Some(json!("wide"));
    let message = of(changed(disks(), "/disks/3", "radius_m", word()));
    contains_all(
        &message,
        &["sample.disks[3].radius_m: invalid type", "\"wide\""],
    );
    let message = of(changed(disks(), "/walls/0", "nx", word()));
    contains_all(&message, &["sample.walls[0].nx: invalid type"]);
    let message = of(changed(layer(), "", "thickness_m", word()));
    contains_all(&message, &["sample.thickness_m: invalid type", "\"wide\""]);
    contains_all(&of(json!(3)), &["sample: invalid type"]);
}

#[test]
fn a_missing_key_is_named() {
    let message = of(changed(disks(), "/disks/1", "radius_m", None));
    contains_all(&message, &["sample.disks[1].radius_m: ", "missing"]);
    let message = of(changed(disks(), "", "disks", None));
    contains_all(&message, &["sample.disks: ", "missing"]);
    let message = of(changed(layer(), "", "half_width_m", None));
    contains_all(&message, &["sample.half_width_m: ", "missing"]);
    let message = of(changed(layer(), "", "kind", None));
    contains_all(&message, &["sample.kind: ", "missing"]);
}

#[test]
fn an_unknown_key_is_named_with_the_nearest_one() {
    let one = || Some(json!(1.0));
    let message = of(changed(disks(), "/disks/2", "raduis_m", one()));
    contains_all(
        &message,
        &["sample.disks[2].raduis_m: no such key", "`radius_m`"],
    );
    let message = of(changed(disks(), "", "wals", Some(json!([]))));
    contains_all(&message, &["sample.wals: no such key", "`walls`"]);
    let message = of(changed(layer(), "", "thikness_m", one()));
    contains_all(
        &message,
        &["sample.thikness_m: no such key", "`thickness_m`"],
    );
}

#[test]
fn a_word_outside_the_choices_is_named() {
    let word = || Some(json!("even"));
    let message = of(changed(layer(), "", "law", word()));
    contains_all(&message, &["sample.law: `even`", "surface_uniform"]);
    let message = of(changed(layer(), "", "kind", word()));
    contains_all(
        &message,
        &["sample.kind: `even`", "layer, rail, disks, file"],
    );
}

/// A glued disk moves with its body.
#[test]
fn a_velocity_that_cannot_act_is_refused() {
    for key in ["vx_m_per_s", "vy_m_per_s", "spin_rad_per_s"] {
        let glued = changed(disks(), "/disks/1", "glued", Some(json!(true)));
        let message = of(changed(glued, "/disks/1", key, Some(json!(1.0))));
        contains_all(
            &message,
            &[&format!("sample.disks[1].{key}: has no effect"), "glued"],
        );
    }
}

/// At 1e12 m a position is rounded to a tenth of this radius.
#[test]
fn grains_too_far_from_the_origin_raise_a_warning() {
    let warnings = |y: f64| {
        let sample = json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": y, "radius_m": 1e-3}]});
        let config = scene(json!({"kind": "signorini"}), 1e-4, sample, json!({}));
        build(&config).describe().warnings
    };
    assert_eq!(warnings(999.0), [""; 0]);
    let far = warnings(1e12);
    contains_all(
        &far[0],
        &["a grain lies 1e12 m from the origin", "1.0e15 times"],
    );
}

#[test]
fn a_layer_without_free_grains_or_with_too_many_is_refused() {
    let with = |key: &str, value: f64| of(changed(layer(), "", key, Some(json!(value))));
    contains_all(
        &with("thickness_m", 1e-6),
        &["sample.thickness_m: ", "1e-4"],
    );
    contains_all(
        &with("thickness_m", 10.0),
        &["sample.thickness_m: ", "grains"],
    );
    contains_all(
        &with("radius_min_m", 1e-9),
        &["sample.radius_min_m: ", "grains"],
    );
}

#[test]
fn a_wheel_too_fast_for_a_step_or_too_small_for_a_grain_is_refused() {
    let with = |wheel: Value| {
        let mut all = json!({"load_n": 1.0, "mass_kg": 1e-3, "radius_m": 0.0, "ramp_s": 0.0, "hold_s": 0.0,
                             "amplitude_m": 0.0, "frequency_hz": 0.0, "cycles": 0.0});
        for (key, value) in wheel.as_object().into_iter().flatten() {
            all[key] = value.clone();
        }
        let wheel = json!({"wheel": all});
        refusal(&scene(json!({"kind": "signorini"}), 1e-4, layer(), wheel))
    };
    contains_all(
        &with(json!({"radius_m": 1e-5})),
        &["wheel.radius_m: ", "4e-4"],
    );
    contains_all(
        &with(json!({"cycles": 1.0, "frequency_hz": 1e9})),
        &["wheel.frequency_hz: ", "fewer than 20 steps"],
    );
    contains_all(
        &with(json!({"load_table": []})),
        &["wheel.load_table: ", "no entries"],
    );
}
