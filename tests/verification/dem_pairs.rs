//! Laws by pair: contacts of two groups with their own friction, restitution and stiffness.
//!
//! Reference: a block on a slope, Newton's law of impact, Hooke's law. Tolerance: rounding, or the true residual 1e-12.

use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const STEP: f64 = 1e-5;

/// Two disks on a wall each: the left one on `rough`, the right one on a wall without name.
fn two_walls(law: Value, disk: Value, overrides: Value) -> Value {
    let place = |x: f64| {
        let mut placed = disk.clone();
        (placed["x_m"], placed["y_m"], placed["radius_m"]) = (json!(x), json!(R), json!(R));
        placed
    };
    let sample = json!({
        "kind": "disks",
        "disks": [place(-5.0 * R), place(5.0 * R)],
        "walls": [
            {"name": "rough", "points_m": [[-10.0 * R, 0.0], [0.0, 0.0]]},
            {"points_m": [[0.0, 0.0], [10.0 * R, 0.0]]},
        ],
    });
    scene(law, STEP, sample, overrides)
}

#[test]
fn a_pair_has_its_own_friction_and_others_have_the_friction_of_the_law() {
    let law = json!({"kind": "coulomb", "friction": 0.1,
        "pairs": [{"between": ["grains", "rough"], "friction": 0.25}]});
    let (g, speed) = (9.81, 0.1);
    let overrides = json!({"gravity_m_per_s2": [0.0, -g]});
    let disk = json!({"vx_m_per_s": speed});
    let mut dem = build(&two_walls(law, disk, overrides));
    let steps = 20;
    march(&mut dem, 0, steps);
    // A disk that slides loses mu g of its speed in a second, and spins up against it.
    let time = f64::from(steps) * STEP;
    for (disk, friction) in [(0, 0.25), (1, 0.1)] {
        let [vx, _, spin] = dem.state().velocities[disk];
        close("v_x", vx, speed - friction * g * time, 1e-9);
        close("spin", spin.abs(), 2.0 * friction * g * time, 1e-9);
    }
}

#[test]
fn a_pair_rebounds_with_its_own_restitution() {
    let law = json!({"kind": "coulomb", "friction": 0.0, "restitution": 0.2,
        "pairs": [{"between": ["rough", "grains"], "restitution": 0.9}]});
    let disk = json!({"vy_m_per_s": -0.5});
    let mut dem = build(&two_walls(law, disk, json!({})));
    march(&mut dem, 0, 2);
    close("left", dem.state().velocities[0][1], 0.45, 1e-12);
    close("right", dem.state().velocities[1][1], 0.1, 1e-12);
}

#[test]
fn a_pair_deflects_with_its_own_stiffness() {
    let law = json!({"kind": "coulomb", "friction": 0.0, "contact_stiffness_pa": 1e6,
        "tangential_stiffness_ratio": 0.5,
        "pairs": [{"between": ["grains", "rough"], "contact_stiffness_pa": 4e6}]});
    let g = 9.81;
    let time = json!({"step_s": 1.0, "pressure_pa": 1.0, "unsafe_step": true});
    let overrides = json!({"gravity_m_per_s2": [0.0, -g], "time": time});
    let mut dem = build(&two_walls(law, json!({}), overrides));
    // Implicit steps of a second are statics.
    let report = march(&mut dem, 0, 60);
    let weight = mass(R) * g;
    for (disk, stiffness) in [(0, 4e6), (1, 1e6)] {
        let sunk = weight / (stiffness * THICKNESS);
        close("sunk", R - dem.state().centres[disk][1], sunk, 1e-6 * sunk);
    }
    close("balance", report.imbalance(weight * R), 0.0, 1e-10);
}

#[test]
fn unknown_and_impossible_pairs_are_refused() {
    let refusing = |pairs: Value, kind: Value| {
        let mut law = kind;
        law["pairs"] = pairs;
        refusal(&two_walls(law, json!({}), json!({})))
    };
    let coulomb = || json!({"kind": "coulomb", "friction": 0.1});
    let unknown = refusing(json!([{"between": ["grains", "roof"]}]), coulomb());
    assert!(
        unknown.contains("law.pairs[0].between") && unknown.contains("rough"),
        "{unknown}"
    );
    let pair = json!({"between": ["grains", "rough"], "friction": 0.2});
    let mut turned = pair.clone();
    turned["between"] = json!(["rough", "grains"]);
    let twice = refusing(json!([pair, turned]), coulomb());
    assert!(twice.contains("law.pairs[1].between"), "{twice}");
    let rigid = refusing(
        json!([{"between": ["grains", "rough"], "contact_stiffness_pa": 1e6}]),
        coulomb(),
    );
    assert!(rigid.contains("contact_stiffness_pa"), "{rigid}");
    let smooth = refusing(json!([pair]), json!({"kind": "signorini"}));
    assert!(smooth.contains("law.pairs[0].friction"), "{smooth}");
    let idle = refusing(json!([{"between": ["grains", "rough"]}]), coulomb());
    assert!(
        idle.contains("law.pairs[0]: has nothing of its own"),
        "{idle}"
    );
    let fixed = refusing(
        json!([{"between": ["rough", "rough"], "friction": 0.2}]),
        coulomb(),
    );
    assert!(
        fixed.contains("law.pairs[0].between: never touch"),
        "{fixed}"
    );
    // A smooth wheel lies on glued disks; rows and a wheel of disks do not touch.
    let row = |between: Value, face: &str| {
        let mut law = coulomb();
        law["pairs"] = json!([{"between": between, "friction": 0.2}]);
        let disk = |x: f64, y: f64, glued: bool| json!({"x_m": x, "y_m": y, "radius_m": R, "glued": glued});
        let disks = json!([
            disk(0.0, 0.0, true),
            disk(4.0 * R, 0.0, true),
            disk(2.0 * R, 0.0, false)
        ]);
        let sample = json!({"kind": "disks", "disks": disks});
        let wheel =
            json!({"load_n": 1.0, "mass_kg": 1e-3, "ramp_s": 0.0, "hold_s": 1.0, "face": face});
        let config = scene(law, STEP, sample, json!({"wheel": wheel}));
        kit::read_config::<dem_node::DemConfig>(&config)
            .and_then(|config| config.validate())
            .map_err(|error| error.to_string())
    };
    assert_eq!(row(json!(["wheel", "base"]), "flat"), Ok(()));
    assert_eq!(row(json!(["base", "wheel"]), "flat"), Ok(()));
    let apart = row(json!(["base", "base"]), "flat").expect_err("no row touches itself");
    assert!(
        apart.contains("law.pairs[0].between: never touch"),
        "{apart}"
    );
    let springs = json!({"kind": "coulomb", "friction": 0.1, "contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5});
    for (law, damping) in [(springs, 0.05), (coulomb(), 0.5)] {
        let damped = json!([{"between": ["grains", "rough"], "damping": damping}]);
        let refused = refusing(damped, law);
        assert!(refused.contains("law.pairs[0].damping"), "{refused}");
    }
}
