//! Flows of third body in a small sheared layer.
//!
//! ```text
//!   ======================   flat wheel, pressed down and moved sideways
//!     o o o o o o o o o      weakly bonded grains
//!    o o o o o o o o o o
//!   # # # # # # # # # # #    glued row
//!             o ->           a loose grain that flies out below it
//! ```
//!
//! Reference: the graph of the bonds, searched here breadth first, and masses counted grain by grain. The loose grain leaves when
//! its straight path passes the end of the zone, and counts as wear T_w later. Tolerance: rounding.

use dem_node::Dem;
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::dem_support::{Report, build, close, march, mass, refusal, scene, setting};
use crate::vtk_file::array;

pub const R: f64 = 0.07e-3;
pub const STEP: f64 = 1e-6;
pub const STEPS: u32 = 800;
const WEAR: f64 = 3.5e-4;
const SPEED: f64 = 4.0;

pub fn sheared(flow: Value) -> Value {
    let law = json!({
        "kind": "cohesion", "friction": 0.6, "contact_stiffness_pa": 1.4e10, "tangential_stiffness_ratio": 0.5,
        "cn_pa_per_m": 4e14, "ct_pa_per_m": 2e14, "w_j_per_m2": 0.06, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one",
        "alert_m": 2e-6,
    });
    let disk = |x: f64, y: f64| json!({"x_m": x, "y_m": y, "radius_m": R});
    let row = |count: u32, height: f64| {
        let left = -f64::from(count - 1) * R;
        (0..count).map(move |i| disk(left + 2.0 * R * f64::from(i), height * 3f64.sqrt() * R))
    };
    let mut disks: Vec<Value> = row(9, 2.0).chain(row(10, 1.0)).collect();
    disks.push(json!({"x_m": 0.0, "y_m": -4.0 * R, "radius_m": R, "vx_m_per_s": SPEED}));
    disks.extend(row(11, 0.0).map(|mut disk| {
        disk["glued"] = json!(true);
        disk
    }));
    let wheel = json!({
        "load_n": 20.0, "mass_kg": 0.01, "ramp_s": 1e-4, "hold_s": 5e-5, "amplitude_m": 4.0 * R,
        "frequency_hz": 3000.0, "cycles": 2.0,
    });
    let sample = json!({"kind": "disks", "disks": disks});
    let mut config = scene(
        law,
        STEP,
        sample,
        json!({"wheel": wheel, "mass_scale": 100.0}),
    );
    config["solver"] =
        json!({"kind": "nsgs", "tolerance": 1e-6, "max_iterations": 20_000, "min_iterations": 1});
    if !flow.is_null() {
        config["flow"] = flow;
    }
    config
}

pub fn followed() -> Value {
    json!({"wear_s": WEAR})
}

/// True for each free grain that a chain of bonds connects with the glued row.
fn held(dem: &Dem) -> Vec<bool> {
    let (free, all) = (dem.bodies().free, dem.bodies().disks());
    let mut reached: Vec<bool> = (0..all).map(|disk| disk >= free).collect();
    let bonds = dem.state().bonds.iter().filter(|bond| bond.adhesion > 0.01);
    let pairs: Vec<[usize; 2]> = bonds.map(|b| [b.a as usize, b.b as usize]).collect();
    for _ in 0..free {
        for [a, b] in &pairs {
            let either = reached[*a] || reached[*b];
            (reached[*a], reached[*b]) = (either, either);
        }
    }
    reached.truncate(free);
    reached
}

/// Real mass of the third body between two places (kg), without the grains in store.
pub fn third_body(dem: &Dem, ends: [f64; 2]) -> f64 {
    let present = dem.state().present(dem.bodies());
    let centres = dem.state().centres.iter().zip(held(dem));
    let third = centres
        .take(present)
        .filter(|(c, held)| !held && (ends[0]..=ends[1]).contains(&c[0]));
    third.count() as f64 * mass(R)
}

pub fn zone(report: &Report) -> [f64; 2] {
    [report.signal("zone_left_m"), report.signal("zone_right_m")]
}

#[test]
fn masses_of_a_sheared_layer_match_its_grains_and_balance() {
    let mut dem = build(&sheared(followed()));
    assert_eq!(held(&dem), [[true; 19].as_slice(), &[false]].concat());
    for window in 0..STEPS / 50 {
        let report = march(&mut dem, u64::from(50 * window), 50);
        let found = report.signal("third_body_zone_kg");
        let expected = third_body(&dem, zone(&report));
        close("third body in the zone", found, expected, 1e-12 * mass(R));
    }
    let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
    // All except the loose grain, which had no bond at the start.
    let detached = third_body(&dem, everywhere) - mass(R);
    let results = dem.finish().expect("it ends").results;
    assert!(detached > 3.5 * mass(R), "{detached:e}");
    close(
        "detached",
        results["q_detached_total_kg"],
        detached,
        1e-12 * detached,
    );
    close("source", results["q_source_kg"], detached, 1e-12 * detached);
    close("balance", results["flow_balance_rel"], 0.0, 1e-15);
    assert_eq!(results["q_reattached_kg"], 0.0);
    assert!(results["q_internal_abs_kg"] >= results["q_internal_net_kg"].abs());
}

#[test]
fn a_grain_that_flies_out_is_worn_once_and_on_time() {
    let mut dem = build(&sheared(followed()));
    let (mut left, mut worn) = (None, None);
    for step in 0..u64::from(STEPS) {
        let report = march(&mut dem, step, 1);
        let x = SPEED * STEP * (step + 1) as f64;
        let outside = report.signal("q_ejected_kg") + report.signal("q_left_by_zone_kg");
        if left.is_none() && outside > 0.0 {
            let [_, right] = zone(&report);
            assert!(
                x > right && x - SPEED * STEP <= right + 2.0 * R,
                "{x} {right}"
            );
            left = Some(step);
        }
        if worn.is_none() && report.signal("q_wear_kg") > 0.0 {
            worn = Some(step);
        }
    }
    let [left, worn] = [left, worn].map(|step| step.expect("it happens"));
    assert_eq!(worn - left, 350);
    let results = dem.finish().expect("it ends").results;
    close("wear", results["q_wear_kg"], mass(R), 1e-12 * mass(R));
}

#[test]
fn a_resumed_run_has_the_flows_of_an_unbroken_one() {
    let mut whole = build(&sheared(followed()));
    march(&mut whole, 0, 300);
    let checkpoint = whole.checkpoint().expect("it can be packed");
    march(&mut whole, 300, 500);
    let mut resumed = build(&sheared(followed()));
    resumed.restore(&checkpoint).expect("it is of these grains");
    march(&mut resumed, 300, 500);
    let [whole, resumed] = [whole, resumed].map(|mut dem| dem.finish().expect("it ends"));
    assert_eq!(whole.state_hash, resumed.state_hash);
    assert_eq!(whole.results, resumed.results);
    assert!(whole.results["q_source_kg"] > 0.0);
    let mut plain = build(&sheared(json!(null)));
    let error = plain.restore(&checkpoint).expect_err("it follows no flows");
    assert!(error.message.contains("flows"), "{error}");
}

#[test]
fn flows_do_not_change_the_motion() {
    let [mut plain, mut followed] = [json!(null), followed()].map(|flow| build(&sheared(flow)));
    march(&mut plain, 0, 200);
    march(&mut followed, 0, 200);
    let names = plain.describe().signals;
    assert!(
        !names.iter().any(|name| name.starts_with("q_")),
        "{names:?}"
    );
    let hashes = [&plain, &followed].map(|dem| dem.state().hash());
    assert_eq!(hashes[0], hashes[1]);
    let [plain, followed] = [plain, followed].map(|mut dem| dem.finish().expect("it ends"));
    assert_eq!(plain.state_hash, hashes[0]);
    assert_ne!(followed.state_hash, hashes[0]);
    assert!(!plain.results.contains_key("flow_balance_rel"));
}

/// A participant after this many steps, and the fields of its grains and contacts.
fn fields_of(config: &Value, name: &str, steps: u32) -> (Dem, [Vec<u8>; 2]) {
    let folder = std::env::temp_dir().join(format!("thirdbody-flow-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    let setting = Setting {
        fields: Some(folder.clone()),
        ..setting(1)
    };
    let config = kit::read_config(config).expect("it is valid");
    let mut dem = Dem::new(&config, &setting).expect("it can be prepared");
    march(&mut dem, 0, steps);
    dem.snapshot("here").expect("it can be written");
    let files = ["third-body-here.vtp", "third-body-here-contacts.vtp"];
    let files = files.map(|file| std::fs::read(folder.join(file)).expect("it is there"));
    std::fs::remove_dir_all(&folder).expect("the folder can go");
    (dem, files)
}

/// A viewer refuses a file in which a point lacks a number.
#[test]
fn fields_have_a_number_for_each_disk_also_of_the_wheel() {
    let mut config = sheared(followed());
    config["wheel"]["face"] = json!("disks");
    config["sample"] = json!({
        "kind": "rail", "width_m": 2e-3, "height_m": 0.8e-3, "height_at": "edge", "crown_radius_m": 0.05,
        "radius_min_m": 0.05e-3, "radius_max_m": 0.1e-3, "law": "surface_uniform",
    });
    let (dem, [fields, _]) = fields_of(&config, "wheel", 400);
    let bodies = dem.bodies();
    let counts = |kind: &str| array(&fields, kind).iter().filter(|x| **x == 1.0).count();
    for name in [
        "radius_m",
        "glued",
        "wheel",
        "pressure_pa",
        "coordination",
        "body",
        "detached_s",
    ] {
        assert_eq!(array(&fields, name).len(), bodies.disks(), "{name}");
    }
    assert_eq!(counts("wheel"), bodies.face.len());
    assert_eq!(counts("glued"), bodies.glued());
    assert!(bodies.glued() > 0 && bodies.face.len() > 8);
}

/// Every remaining bond is a line with its adhesion, in compression or tension; a broken bond is drawn only while it is pressed.
#[test]
fn fields_have_the_adhesion_of_each_bond() {
    let (dem, [_, fields]) = fields_of(&sheared(followed()), "bonds", 100);
    let (bodies, state) = (dem.bodies(), dem.state());
    let disks = bodies.disks();
    let adhesion = array(&fields, "adhesion");
    assert_eq!(array(&fields, "force_n").len(), 2 * adhesion.len());
    let ends = array(&fields, "connectivity");
    assert_eq!(ends.len(), 2 * adhesion.len());
    let drawn = ends.chunks(2).zip(&adhesion).filter(|(_, a)| **a > 0.0);
    let drawn: Vec<_> = drawn
        .map(|(ends, a)| (ends[0] as u32, ends[1] as u32, *a))
        .collect();
    let bonds = state.bonds.iter().filter(|bond| (bond.b as usize) < disks);
    let bonds: Vec<_> = bonds.map(|bond| (bond.a, bond.b, bond.adhesion)).collect();
    assert!(
        bonds.len() > 10 && bonds.iter().any(|bond| bond.2 < 1.0),
        "{bonds:?}"
    );
    assert_eq!(drawn, bonds);
    let pulled = state.list.slots.iter().filter(|slot| slot.force[0] < 0.0);
    assert!(pulled.count() > 0, "a bond in tension is drawn too");
}

#[test]
fn fields_show_the_body_of_a_grain_and_the_time_of_its_detachment() {
    let (dem, [fields, _]) = fields_of(&sheared(followed()), "grains", 400);
    let array = |name: &str| array(&fields, name);
    let (bodies, times) = (array("body"), array("detached_s"));
    let mut expected: Vec<f64> = held(&dem)
        .iter()
        .map(|held| f64::from(u8::from(!held)))
        .collect();
    expected[19] = 2.0;
    expected.extend([0.0; 11]);
    assert_eq!(bodies, expected);
    for (body, time) in bodies.iter().zip(times) {
        assert!(
            (time == -1.0) == (*body != 1.0) && time <= 4e-4,
            "{body} {time}"
        );
    }
}

#[test]
fn scenes_without_first_bodies_or_contact_zone_are_refused() {
    let refused = |config: &Value, parts: &[&str]| {
        let message = refusal(config);
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?}");
        }
    };
    refused(
        &sheared(json!({"wear_s": 3e-4})),
        &["flow.wear_s", "at least 3.33", "3e-4 (s)", "within a cycle"],
    );
    refused(
        &sheared(json!({"wear_s": 0.0})),
        &["flow.wear_s", "above 0"],
    );
    let share = json!({"wear_s": WEAR, "zone_share": 1.5});
    refused(
        &sheared(share),
        &["flow.zone_share", "at least 0.5 and at most 1"],
    );
    let margin = json!({"wear_s": WEAR, "margin_diameters": -1.0});
    refused(&sheared(margin), &["flow.margin_diameters"]);
    let slack = json!({"wear_s": WEAR, "hysteresis_diameters": -1.0});
    refused(&sheared(slack), &["flow.hysteresis_diameters"]);
    let mut config = sheared(followed());
    config["wheel"] = json!(null);
    refused(&config, &["flow", "wheel"]);
    let mut config = sheared(followed());
    config["law"] = json!({"kind": "coulomb", "friction": 0.3});
    refused(&config, &["flow", "cohesion"]);
}

/// Before the ramp of the wheel ends, the zone carries almost no load compared with the stress of its moving grains.
#[test]
fn the_kinetic_stress_is_judged_once_the_wheel_carries_its_load() {
    for (steps, judged) in [(60, false), (STEPS, true)] {
        let mut dem = build(&sheared(followed()));
        march(&mut dem, 0, steps);
        let end = dem.finish().expect("it ends");
        assert!(end.results["flow_kinetic_rel"] > 1e-3, "{steps}");
        let found = end
            .findings
            .iter()
            .any(|found| found.code == "flow_kinetic");
        assert_eq!(found, judged, "{steps}");
    }
}
