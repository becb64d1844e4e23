//! Stress in cells and in the whole sample.
//!
//! Reference: a disk between two plates, sigma_yy = f d / V (Love 1927; Weber 1966); grains at rest between walls, whose internal
//! moments add up to those of the forces on the walls, so that the stress of the box is the pressure on its walls whatever the
//! packing. Tolerance: rounding, and what is left of the motion.

use dem_node::Dem;
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, refusal, scene, setting};

const R: f64 = 1e-3;
const STIFFNESS: f64 = 1e9;

fn sprung() -> Value {
    json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS})
}

fn half_plane(x: f64, y: f64, nx: f64, ny: f64) -> Value {
    json!({"x_m": x, "y_m": y, "nx": nx, "ny": ny})
}

/// A disk between two plates that squeeze it by `squeeze` (m), in a region of 8 R x 8 R.
fn squeezed(squeeze: f64, stress: Value) -> Value {
    let sample = json!({
        "kind": "disks",
        "disks": [{"x_m": 0.0, "y_m": R - 0.5 * squeeze, "radius_m": R}],
        "walls": [half_plane(0.0, 0.0, 0.0, 1.0), half_plane(0.0, 2.0 * R - squeeze, 0.0, -1.0)],
    });
    scene(sprung(), 1e-6, sample, stress)
}

fn region() -> Value {
    let side = [-4.0 * R, 4.0 * R];
    json!({"stress": {"cell_m": 8.0 * R, "x_m": side, "y_m": side}})
}

#[test]
fn a_disk_between_plates_has_the_force_times_its_height_over_the_volume() {
    let squeeze = 0.02 * R;
    let folder = std::env::temp_dir().join(format!("thirdbody-stress-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    let setting = Setting {
        fields: Some(folder.clone()),
        ..setting(1)
    };
    let config = kit::read_config(&squeezed(squeeze, region())).expect("it is valid");
    let mut dem = Dem::new(&config, &setting).expect("it can be prepared");
    march(&mut dem, 0, 3);
    let results = dem.finish().expect("it ends").results;
    let text = std::fs::read_to_string(folder.join("third-body-stress.csv"));
    let names = std::fs::read_dir(&folder).expect("it is there").count();
    std::fs::remove_dir_all(&folder).expect("the folder can go");
    let force = 0.5 * squeeze * STIFFNESS * THICKNESS;
    let expected = force * (2.0 * R - squeeze) / (64.0 * R * R * THICKNESS);
    for (name, part) in [
        ("stress_xx_pa", 0.0),
        ("stress_yy_pa", 1.0),
        ("stress_xy_pa", 0.0),
        ("dem_p_max_tr3_pa", 1.0 / 3.0),
        ("dem_p_max_mean_pa", 0.5),
    ] {
        close(name, results[name], part * expected, 1e-9 * expected);
    }
    let text = text.expect("the cells are written");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "x_m,y_m,sxx_pa,syy_pa,sxy_pa,p_tr3_pa,p_mean_pa,solid_fraction,grains"
    );
    assert_eq!((lines.len(), names), (2, 1));
    let syy: f64 = lines[1]
        .split(',')
        .nth(3)
        .expect("it is there")
        .parse()
        .expect("a number");
    close("syy of the cell", syy, expected, 1e-9 * expected);
}

#[test]
fn nothing_is_measured_unless_it_is_asked_for() {
    let mut dem = build(&squeezed(0.02 * R, json!({})));
    march(&mut dem, 0, 1);
    let results = dem.finish().expect("it ends").results;
    let told = |name: &String| name.starts_with("stress_") || name.starts_with("dem_p_");
    assert!(!results.keys().any(told), "{results:?}");
}

#[test]
fn a_box_of_grains_at_rest_has_the_pressure_on_its_walls() {
    let pitch = 1.9 * R;
    let side = 6.0 * pitch;
    let disk = |i: usize| {
        let size = 1.0 + 0.05 * ((7 * i) as f64).sin();
        let place = [i % 6, i / 6].map(|k| pitch * (k as f64 + 0.5));
        json!({"x_m": place[0], "y_m": place[1], "radius_m": R * size})
    };
    let sample = json!({
        "kind": "disks",
        "disks": (0..36).map(disk).collect::<Vec<_>>(),
        "walls": [
            half_plane(0.0, 0.0, 1.0, 0.0), half_plane(side, 0.0, -1.0, 0.0),
            half_plane(0.0, 0.0, 0.0, 1.0), half_plane(0.0, side, 0.0, -1.0),
        ],
    });
    let stress =
        json!({"stress": {"cell_m": 7.0 * R * 1.01, "x_m": [0.0, side], "y_m": [0.0, side]}});
    let mut dem = build(&scene(sprung(), 1e-4, sample, stress));
    march(&mut dem, 0, 600);
    let slots = &dem.state().list.slots;
    let on_wall = |wall: u32| -> f64 {
        let own = slots.iter().filter(|slot| slot.b == 36 + wall);
        own.map(|slot| slot.force[0]).sum()
    };
    let area = side * THICKNESS;
    let [left, right, floor, lid] = [0, 1, 2, 3].map(|wall| on_wall(wall) / area);
    let results = dem.finish().expect("it ends").results;
    // At rest: opposite walls bear the same.
    close("left and right", left, right, 1e-9 * right);
    close("floor and lid", floor, lid, 1e-9 * lid);
    assert!(right > 1e6 && lid > 1e6, "{right} {lid}");
    close("sxx", results["stress_xx_pa"], right, 1e-9 * right);
    close("syy", results["stress_yy_pa"], lid, 1e-9 * lid);
}

/// A disk under a wheel on a glued one: the load falls after the hold.
#[test]
fn the_stress_is_that_of_the_end_of_the_hold() {
    let load = 10.0;
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": R, "radius_m": R},
        {"x_m": 0.0, "y_m": -R, "radius_m": R, "glued": true},
    ]});
    let wheel = json!({
        "load_n": load, "mass_kg": 1e-3, "ramp_s": 1e-3, "hold_s": 4e-3, "cycles": 0.5, "frequency_hz": 500.0,
        "load_table": [[0.0, 0.0], [1e-3, load], [5e-3, load], [5.2e-3, 0.25 * load]],
    });
    let side = [-4.0 * R, 4.0 * R];
    let mut overrides = json!({"wheel": wheel});
    overrides["stress"] = json!({"cell_m": 8.0 * R, "x_m": side, "y_m": side});
    let mut dem = build(&scene(sprung(), 1e-5, sample, overrides));
    // From the face of the wheel to the middle of the overlap with the glued disk.
    let height = 2.0 * R - 1.5 * load / (STIFFNESS * THICKNESS);
    let expected = load * height / (64.0 * R * R * THICKNESS);
    march(&mut dem, 0, 500);
    let held = dem.finish().expect("it ends").results["stress_yy_pa"];
    close("end of the hold", held, expected, 3e-4 * expected);
    let checkpoint = dem.checkpoint().expect("it can be packed");
    march(&mut dem, 500, 100);
    let last = &dem.state().list.slots;
    let force = last.iter().map(|slot| slot.force[0]).fold(0.0, f64::max);
    assert!(force < 0.5 * load, "the load has fallen: {force}");
    let results = dem.finish().expect("it ends").results;
    assert_eq!(results["stress_yy_pa"], held);
    dem.restore(&checkpoint).expect("it is its own");
    assert_eq!(dem.finish().expect("it ends").results["stress_yy_pa"], held);
}

#[test]
fn cells_that_show_no_stress_are_refused() {
    let of = |stress: Value| refusal(&squeezed(0.0, json!({"stress": stress})));
    let told = |message: &str, parts: &[&str]| {
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?}");
        }
    };
    told(
        &of(json!({"cell_m": 6.9 * R})),
        &[
            "stress.cell_m",
            "at least 7e-3",
            "got 6.9",
            "3.5 mean diameters",
        ],
    );
    let wide = [-0.01, 0.01];
    told(
        &of(json!({"cell_m": 8.0 * R, "x_m": wide, "y_m": [0.0, R]})),
        &["stress.y_m", "no cell of 8e-3 m", "1e-3 m"],
    );
    told(
        &of(json!({"cell_m": 8.0 * R, "x_m": [0.01, -0.01]})),
        &["stress.x_m", "does not lie before"],
    );
    // The region is that of the grains, 2 R x 2 R.
    told(
        &of(json!({"cell_m": 8.0 * R})),
        &["stress.cell_m", "no cell of 8e-3 m fits", "2e-3 m x 2e-3 m"],
    );
    let far = [-50.0, 50.0];
    told(
        &of(json!({"cell_m": 8.0 * R, "x_m": far, "y_m": far})),
        &["stress.cell_m", "1.6e8 cells"],
    );
}
