//! Driven clusters: rough walls and single bodies with prescribed motions or forces along x and y.
//!
//! ```text
//!    v_x = V  ->  o-o-o-o-o-o   F_y = -P     free:       m (v' - v) = h F - h c v'  (theta = 1)
//!                 o   o  o  o                prescribed: v = V, for any force of the grains
//!    =========================
//! ```
//!
//! Reference: the recursion of a damped mass, Coulomb's law, statics. Tolerance: rounding, or the true residual 1e-12.

use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const STEP: f64 = 1e-5;

fn floor() -> Value {
    json!([{"name": "floor", "x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}])
}

/// One disk that is the cluster `top`, on the floor or above it.
fn single(height: f64, law: Value, drive: Value, overrides: Value) -> Value {
    let sample = json!({
        "kind": "disks",
        "disks": [{"x_m": 0.0, "y_m": R + height, "radius_m": R, "cluster": "top"}],
        "clusters": [{"name": "top", "drive": drive}],
        "walls": floor(),
    });
    scene(law, STEP, sample, overrides)
}

fn coulomb(friction: f64) -> Value {
    json!({"kind": "coulomb", "friction": friction})
}

#[test]
fn a_damped_mass_under_a_constant_force_follows_its_recursion() {
    for theta in [1.0, 0.5] {
        let drive = json!({"force_n": [2e-3, "free"], "mass_kg": 1e-3, "damping_n_s_per_m": 20.0});
        let time = json!({"step_s": STEP, "pressure_pa": 1.0, "theta": theta});
        let config = single(1.0, coulomb(0.3), drive, json!({"time": time}));
        let mut dem = build(&config);
        let report = march(&mut dem, 0, 40);
        let (m, hc, push) = (1e-3, STEP * 20.0, STEP * 2e-3);
        let mut v = 0.0;
        let (mut x, mut work, mut damped) = (0.0, 0.0, 0.0);
        for _ in 0..40 {
            let next = ((m - hc * (1.0 - theta)) * v + push) / (m + hc * theta);
            let mean = theta * next + (1.0 - theta) * v;
            x += STEP * mean;
            work += push * mean;
            damped += hc * mean * mean;
            v = next;
        }
        close("v_x", dem.state().velocities[0][0], v, 1e-13 * v);
        close("x", report.signal("top_x_m"), x, 1e-12 * x);
        close("work", report.energy("walls"), work, 1e-12 * work);
        close("damping", report.energy("damping"), damped, 1e-12 * damped);
        close("balance", report.imbalance(0.0), 0.0, 1e-12);
    }
}

#[test]
fn a_dragged_disk_rubs_under_its_weight_and_load_and_the_drive_does_the_work() {
    let (speed, load, friction, g) = (0.2, 3e-3, 0.3, 9.81);
    let drive = json!({"velocity_m_per_s": [speed, "free"], "force_n": ["free", -load]});
    let overrides = json!({"gravity_m_per_s2": [0.0, -g]});
    let mut dem = build(&single(0.0, coulomb(friction), drive, overrides));
    let report = march(&mut dem, 0, 50);
    let carried = load + mass(R) * g;
    let near = 1e-9 * carried;
    close("force_y", report.signal("top_force_y_n"), carried, near);
    close(
        "force_x",
        report.signal("top_force_x_n"),
        -friction * carried,
        near,
    );
    close("x", report.signal("top_x_m"), 50.0 * STEP * speed, 1e-15);
    let work = friction * carried * 50.0 * STEP * speed;
    close("work", report.energy("walls"), work, 1e-9 * work);
    close("friction", report.energy("friction"), work, 1e-9 * work);
    close("balance", report.imbalance(0.0), 0.0, 1e-11);
    close("defect", report.signal("momentum_defect_n"), 0.0, near);
}

#[test]
fn a_prescribed_descent_carries_the_weight_of_the_cluster() {
    let g = 9.81;
    let drive = json!({"velocity_m_per_s": [0.0, -0.1]});
    let overrides = json!({"gravity_m_per_s2": [0.0, -g]});
    let mut dem = build(&single(1.0, coulomb(0.3), drive, overrides));
    let report = march(&mut dem, 0, 30);
    let way = 30.0 * STEP * 0.1;
    close("y", report.signal("top_y_m"), 1.0 + R - way, 1e-14);
    // The weight does the work m g h, and the drive absorbs it.
    let fallen = mass(R) * g * way;
    close("weight", report.energy("weight"), fallen, 1e-9 * fallen);
    close("walls", report.energy("walls"), -fallen, 1e-9 * fallen);
}

#[test]
fn a_load_over_time_follows_its_table() {
    let table = json!([[0.0, 0.0], [100.0 * STEP, -2.0e-3], [200.0 * STEP, -1.0e-3]]);
    let drive = json!({"velocity_m_per_s": [0.0, "free"], "load_table": table});
    let mut dem = build(&single(0.0, coulomb(0.3), drive, json!({})));
    for (steps, load) in [(50, 1.0e-3), (100, 2.0e-3), (150, 1.5e-3), (250, 1.0e-3)] {
        let report = march(&mut dem, steps - 50, 50);
        close("force_y", report.signal("top_force_y_n"), load, 1e-12);
    }
}

/// A row as wide as the strip presses a fill of disks on the floor.
fn pressed_strip() -> Value {
    let strip = [0.0, 20.0 * R];
    let radii = json!({"radius_min_m": 0.8 * R, "radius_max_m": R, "law": "number_uniform"});
    let with = |mut part: Value| {
        for (key, value) in radii.as_object().into_iter().flatten() {
            part[key] = value.clone();
        }
        part
    };
    let sample = json!({
        "kind": "disks",
        "periodic_x_m": strip,
        "fill": [with(json!({"x_m": strip, "y_m": [0.0, 8.0 * R]}))],
        "rows": [with(json!({"cluster": "top", "x_m": strip, "y_m": 9.1 * R}))],
        "clusters": [{"name": "top", "drive": {
            "velocity_m_per_s": [0.0, "free"], "force_n": ["free", -2.0], "damping_n_s_per_m": 2.0,
        }}],
        "walls": floor(),
    });
    let law = json!({"kind": "coulomb", "friction": 0.4, "contact_stiffness_pa": 1e8,
        "tangential_stiffness_ratio": 0.5});
    let profile = json!({"profile": {"axis": "y", "bins": 4, "start_s": 4e-2, "every_s": 1e-2}});
    let mut config = scene(law, 1e-5, sample, profile);
    config["solver"]["tolerance"] = json!(1e-6);
    config["time"]["end_s"] = json!(5e-2);
    config
}

#[test]
fn a_row_as_wide_as_the_strip_packs_the_grains_below_and_every_slice_carries_its_load() {
    let config = pressed_strip();
    let mut dem = build(&config);
    let mut report = march(&mut dem, 0, 1000);
    for part in 1..5 {
        report = march(&mut dem, 1000 * part, 1000);
    }
    close("force_y", report.signal("top_force_y_n"), 2.0, 1e-2);
    close("balance", report.imbalance(0.0), 0.0, 1e-8);
    let outcome = protocol::Node::finish(&mut dem).expect("the run can end");
    let result = |name: &str| outcome.results[name];
    // Statics: the mean normal stress of any level cut is the load over its area.
    let stress = 2.0 / (20.0 * R * THICKNESS);
    let found = result("profile_normal_stress_pa");
    close("stress", found, stress, 2e-3 * stress);
    let phi = result("profile_solid_fraction");
    assert!((0.74..0.87).contains(&phi), "{phi}");
}

#[test]
fn a_cluster_driven_further_than_half_a_grain_per_step_raises_a_warning() {
    let warned = |speed: f64| {
        let drive = json!({"velocity_m_per_s": [speed, "free"]});
        let config = single(0.0, coulomb(0.3), drive, json!({}));
        protocol::Node::describe(&build(&config)).warnings
    };
    assert_eq!(warned(0.49 * R / STEP), Vec::<String>::new());
    let fast = warned(0.6 * R / STEP);
    assert!(
        fast.len() == 1 && fast[0].contains("0.600 of the smallest radius"),
        "{fast:?}"
    );
}

#[test]
fn meaningless_drives_are_refused_by_their_key() {
    let refused = |drive: Value| refusal(&single(0.0, coulomb(0.3), drive, json!({})));
    let both = refused(json!({"velocity_m_per_s": [1.0, "free"], "force_n": [2.0, 1.0]}));
    assert!(
        both.contains("drive.force_n") && both.contains("along x"),
        "{both}"
    );
    let table = refused(json!({"load_table": [[0.0, 1.0]]}));
    assert!(
        table.contains("drive.load_table") && table.contains("2 directions"),
        "{table}"
    );
    let idle = refused(json!({"velocity_m_per_s": [1.0, 0.0], "mass_kg": 1.0}));
    assert!(idle.contains("clusters[0].drive"), "{idle}");
    let word = refused(json!({"velocity_m_per_s": [1.0, "loose"]}));
    assert!(
        word.contains("velocity_m_per_s") && word.contains("\"free\""),
        "{word}"
    );
    let mut locked = single(0.0, coulomb(0.3), json!({}), json!({}));
    locked["sample"]["clusters"][0]["locked"] = json!(["x"]);
    let locked = refusal(&locked);
    assert!(locked.contains("clusters[0].locked"), "{locked}");
    let mut torn = pressed_strip();
    torn["sample"]["clusters"] = json!([]);
    let torn = refusal(&torn);
    assert!(
        torn.contains("rows[0].cluster") && torn.contains("rotation"),
        "{torn}"
    );
}

#[test]
fn a_force_over_time_is_reached_with_its_last_change() {
    let table = json!([[0.0, 1.0], [0.5, 2.0], [3.0, 2.0]]);
    let drive = json!({"velocity_m_per_s": [0.1, "free"], "load_table": table});
    let dem = build(&single(0.0, coulomb(0.3), drive, json!({})));
    let key = "sample.clusters[0].drive.load_table";
    assert_eq!(dem.describe().moments, [(key.to_string(), 0.5)].into());
}

/// Between a driven and a held disk a rigid contact has no correct force, with or without friction; on springs the bond opens.
#[test]
fn a_rigid_bond_under_a_prescribed_motion_is_refused_with_its_cause() {
    for friction in [0.0, 0.3] {
        for springs in [false, true] {
            let mut law = json!({"kind": "cohesion", "friction": friction, "cn_pa_per_m": 1e9, "ct_pa_per_m": 1e9, "w_j_per_m2": 1e-3,
                "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 1e-6});
            if springs {
                law["contact_stiffness_pa"] = json!(1e7);
                law["tangential_stiffness_ratio"] = json!(1.0);
            }
            let sample = json!({
                "kind": "disks",
                "disks": [{"x_m": 0.0, "y_m": 2.0 * R, "radius_m": R, "cluster": "top"}, {"x_m": 0.0, "y_m": 0.0, "radius_m": R, "glued": true}],
                "clusters": [{"name": "top", "drive": {"velocity_m_per_s": ["free", 0.1]}}],
            });
            let mut dem = build(&scene(law, 1e-7, sample, json!({})));
            let window = protocol::Window {
                substeps: 10,
                ..protocol::Window::default()
            };
            match dem.advance_alone(&window) {
                Ok(_) => assert!(springs, "{friction}"),
                Err(error) => {
                    let text = error.to_string();
                    assert!(
                        !springs && text.contains("prescribed along its normal"),
                        "{text}"
                    );
                    assert!(!text.contains("law.friction"), "{text}");
                }
            }
        }
    }
}

/// A disk glued below and a disk above it that moves only sideways: nothing of the motion is along the normal at first, and little of it later. A
/// damper for the mass along the normal alone would weld the bond, or press with 1e5 N.
#[test]
fn a_body_held_along_the_normal_slides_past_its_dampers() {
    let below = json!({"x_m": 0.0, "y_m": 0.0, "radius_m": R, "glued": true});
    let above = |x: f64, y: f64| json!({"x_m": x, "y_m": y, "radius_m": R, "cluster": "top"});
    let held = |law: Value, disks: Value, drive: Value, step: f64| {
        let clusters = json!([{"name": "top", "drive": drive}]);
        let sample = json!({"kind": "disks", "disks": disks, "clusters": clusters});
        build(&scene(law, step, sample, json!({})))
    };
    // Three times the strength in shear, sqrt(w Ct) times l = 1e-6 m2.
    let law = json!({"kind": "cohesion", "friction": 0.3, "cn_pa_per_m": 1e9, "ct_pa_per_m": 4e8, "w_j_per_m2": 1.0, "b_pa_m_s": 0.0, "p": 1.0,
        "h_prime": "one", "alert_m": 1e-6, "contact_stiffness_pa": 2e6, "tangential_stiffness_ratio": 0.5, "bond_damping_ratio": 0.5});
    let load = json!([[0.0, 0.0], [0.02, 0.03], [1.0, 0.03]]);
    let pulled = json!({"damping_n_s_per_m": 0.0, "velocity_m_per_s": ["free", 0.0], "load_table": load, "mass_kg": 1e-3});
    let disks = json!([below, above(0.0, 2.0 * R)]);
    let mut dem = held(law, disks, pulled, 2e-5);
    assert_eq!(march(&mut dem, 0, 2500).signal("bonds"), 0.0);
    let law = json!({"kind": "coulomb", "friction": 0.0, "contact_stiffness_pa": 1e7, "tangential_stiffness_ratio": 0.5, "damping": 0.3});
    let far = json!({"x_m": 0.0, "y_m": 8.0 * R, "radius_m": 0.2 * R});
    let pressed = json!({"velocity_m_per_s": ["free", -0.1]});
    let mut dem = held(
        law,
        json!([below, above(1e-9, 2.2 * R), far]),
        pressed,
        1e-5,
    );
    let force = march(&mut dem, 0, 300).signal("top_force_y_n");
    // 0.1 m/s over 3 ms, less the gap of 0.2 R.
    close("force", force, 1e7 * THICKNESS * 1e-4, 1e-2);
}
