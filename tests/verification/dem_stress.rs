//! Stress in cells and in the whole sample.
//!
//! References: a disk between two plates, sigma_yy = f d / V (Love 1927; Weber 1966); grains at rest between walls, whose internal
//! moments sum to the moments of the wall forces, so the stress in the box is the pressure on its walls for any packing. Tolerance:
//! rounding and the residual motion. Further: the closed-form Young's modulus of a bonded hexagonal lattice, to the 0.5 % required
//! in any region, and the pressure in a part of a box of grains, to its scatter from place to place.

use dem_node::Dem;
use dem_node::config::stress::StressConfig;
use dem_node::measure::stress::StressMap;
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
    let config = kit::read_config(squeezed(squeeze, region())).expect("it is valid");
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
fn nothing_is_measured_without_a_stress_table() {
    let mut dem = build(&squeezed(0.02 * R, json!({})));
    march(&mut dem, 0, 1);
    let results = dem.finish().expect("it ends").results;
    let measured = |name: &String| name.starts_with("stress_") || name.starts_with("dem_p_");
    assert!(!results.keys().any(measured), "{results:?}");
}

/// A box of four walls with disks in n rows and columns, of radius (`mean` +- `spread`) R, and the length of its side (m).
fn box_of_grains(n: usize, [mean, spread]: [f64; 2]) -> (Value, f64) {
    let pitch = 1.9 * R;
    let side = n as f64 * pitch;
    let disk = |i: usize| {
        let size = mean + spread * ((7 * i) as f64).sin();
        let place = [i % n, i / n].map(|k| pitch * (k as f64 + 0.5));
        json!({"x_m": place[0], "y_m": place[1], "radius_m": R * size})
    };
    let sample = json!({
        "kind": "disks",
        "disks": (0..n * n).map(disk).collect::<Vec<_>>(),
        "walls": [
            half_plane(0.0, 0.0, 1.0, 0.0), half_plane(side, 0.0, -1.0, 0.0),
            half_plane(0.0, 0.0, 0.0, 1.0), half_plane(0.0, side, 0.0, -1.0),
        ],
    });
    (sample, side)
}

/// Pressures on the left wall, the right one, the floor and the lid (Pa).
fn on_walls(dem: &Dem, side: f64) -> [f64; 4] {
    let slots = &dem.state().list.slots;
    let first = dem.bodies().first_wall() as u32;
    [0, 1, 2, 3].map(|wall| {
        let own = slots.iter().filter(|slot| slot.b == first + wall);
        own.map(|slot| slot.force[0]).sum::<f64>() / (side * THICKNESS)
    })
}

#[test]
fn a_box_of_grains_at_rest_has_the_pressure_on_its_walls() {
    let (sample, side) = box_of_grains(6, [1.0, 0.05]);
    let stress =
        json!({"stress": {"cell_m": 7.0 * R * 1.01, "x_m": [0.0, side], "y_m": [0.0, side]}});
    let mut dem = build(&scene(sprung(), 1e-4, sample, stress));
    march(&mut dem, 0, 600);
    let [left, right, floor, lid] = on_walls(&dem, side);
    let results = dem.finish().expect("it ends").results;
    // At rest opposite walls carry the same force.
    close("left and right", left, right, 1e-9 * right);
    close("floor and lid", floor, lid, 1e-9 * lid);
    assert!(right > 1e6 && lid > 1e6, "{right} {lid}");
    close("sxx", results["stress_xx_pa"], right, 1e-9 * right);
    close("syy", results["stress_yy_pa"], lid, 1e-9 * lid);
}

/// In a box at rest the mean normal stress at each level is the pressure on the lid, and so is the stress of a strip from wall to wall.
/// Tiles shift moments along a branch, by less than a radius at the strip's two edges. In a strip of 3.75 diameters the error is
/// 0.24 % (rms); with the grains' centres instead of tiles it is 2.7 % (rms).
#[test]
fn every_strip_of_a_pressed_box_has_the_pressure_of_the_lid() {
    let (sample, side) = box_of_grains(16, [1.03, 0.15]);
    let mut config = scene(sprung(), 1e-4, sample, json!({}));
    config["solver"]["tolerance"] = json!(1e-6);
    let mut dem = build(&config);
    march(&mut dem, 0, 250);
    let [.., floor, lid] = on_walls(&dem, side);
    close("floor and lid", floor, lid, 1e-4 * lid);
    for part in 0..16 {
        let low = 1.37 * R * f64::from(part);
        let config = StressConfig {
            cell_m: 7.2 * R,
            x_m: Some([0.0, side]),
            y_m: Some([low, low + 7.5 * R]),
            at_s: None,
        };
        let map = StressMap::measure(&config, dem.bodies(), dem.state(), THICKNESS);
        let syy = map.expect("it is loaded").results()[1].1;
        close("syy", syy, lid, 6e-3 * lid);
    }
}

/// A hexagonal lattice of 15 columns by 17 rows, bonded by springs of equal stiffness along and across: k = l C N/m, l = R t / 2. It
/// expands along y with velocities linear in y, for a time in which no wave from its edges reaches the next row. So the strain is the
/// rate times the time.
///
/// ```text
///    o o o o o  2V     sigma_yy = -(1/A t) sum f_y L_y over two slanted branches L_y = sqrt(3) R in A = 2 sqrt(3) R^2,
///     o o o o o  V     f_y = k strain L_y: E = sqrt(3) k / t = sqrt(3) R C / 2, without lateral strain
///    o o o o o   0
/// ```
#[test]
fn a_bonded_lattice_has_its_modulus_in_any_region_and_cell() {
    let (stiffness, strain, steps, step) = (4e14, 1e-5, 4, 1e-9);
    let pitch = 3f64.sqrt() * R;
    let rate = strain / (f64::from(steps) * step);
    let disk = |i: usize| {
        let (row, column) = ((i / 15) as f64, (i % 15) as f64);
        let [x, y] = [R * (2.0 * column + row % 2.0), pitch * row];
        json!({"x_m": x, "y_m": y, "radius_m": R, "vy_m_per_s": rate * y})
    };
    let sample = json!({"kind": "disks", "disks": (0..255).map(disk).collect::<Vec<_>>()});
    let law = json!({
        "kind": "cohesion", "friction": 0.3, "cn_pa_per_m": stiffness, "ct_pa_per_m": stiffness, "w_j_per_m2": 1e9,
        "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 2e-6,
    });
    let mut dem = build(&scene(law, step, sample, json!({})));
    march(&mut dem, 0, steps);
    let modulus = 0.5 * 3f64.sqrt() * R * stiffness;
    for part in 0..14 {
        let part = f64::from(part);
        let (x, y) = (2.1 * R + 0.25 * R * part, 2.1 * R + 0.53 * R * part);
        let config = StressConfig {
            cell_m: 7.1 * R,
            x_m: Some([x, x + 7.2 * R + 1.11 * R * part]),
            y_m: Some([y, y + 7.2 * R + 0.67 * R * part]),
            at_s: None,
        };
        let map = StressMap::measure(&config, dem.bodies(), dem.state(), THICKNESS);
        let map = map.expect("it is loaded");
        let found = -map.results()[1].1 / strain;
        close("modulus", found, modulus, 1e-5 * modulus);
        for line in map.csv().lines().skip(1) {
            let syy: f64 = line
                .split(',')
                .nth(3)
                .expect("it is there")
                .parse()
                .expect("a number");
            close("modulus of a cell", -syy / strain, modulus, 1e-5 * modulus);
        }
    }
}

/// A wheel presses a disk on a glued one, and the load falls after the hold.
#[test]
fn the_stress_is_measured_at_the_end_of_the_hold() {
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
    let mut twice = overrides.clone();
    twice["stress"]["at_s"] = json!(4e-3);
    let message = refusal(&scene(sprung(), 1e-5, sample.clone(), twice));
    assert!(
        message.contains("stress.at_s") && message.contains("wheel.hold_s"),
        "{message}"
    );
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
fn cells_that_cannot_show_a_stress_are_refused() {
    let of = |stress: Value| refusal(&squeezed(0.0, json!({"stress": stress})));
    let contains_all = |message: &str, parts: &[&str]| {
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?}");
        }
    };
    contains_all(
        &of(json!({"cell_m": 6.9 * R})),
        &[
            "stress.cell_m",
            "at least 7e-3",
            "got 6.9",
            "3.5 mean diameters",
        ],
    );
    let wide = [-0.01, 0.01];
    contains_all(
        &of(json!({"cell_m": 8.0 * R, "x_m": wide, "y_m": [0.0, R]})),
        &["stress.y_m", "no cell of 8e-3 m", "1e-3 m"],
    );
    contains_all(
        &of(json!({"cell_m": 8.0 * R, "x_m": [0.01, -0.01]})),
        &["stress.x_m", "does not lie before"],
    );
    // By default the region bounds the grains, 2 R x 2 R.
    contains_all(
        &of(json!({"cell_m": 8.0 * R})),
        &["stress.cell_m", "no cell of 8e-3 m fits", "2e-3 m x 2e-3 m"],
    );
    let far = [-50.0, 50.0];
    contains_all(
        &of(json!({"cell_m": 8.0 * R, "x_m": far, "y_m": far})),
        &["stress.cell_m", "1.6e8 cells"],
    );
}

/// In floating point 3.5 x 0.1 is 0.35000000000000003, 1.9 - 1.1 is less than 0.8, and 2.3 - 2.1 is less than 0.2. Such lengths still fit.
#[test]
fn lengths_too_short_by_rounding_are_accepted() {
    let disk = json!({"x_m": 0.2, "y_m": 0.2, "radius_m": 0.05});
    let listed = json!({"kind": "disks", "disks": [disk]});
    let cell =
        |cell: f64| json!({"stress": {"cell_m": cell, "x_m": [0.0, 0.4], "y_m": [0.0, 0.4]}});
    build(&scene(sprung(), 1e-6, listed.clone(), cell(0.35)));
    let message = refusal(&scene(sprung(), 1e-6, listed, cell(0.3499)));
    assert!(message.contains("stress.cell_m"), "{message}");
    let fill = |right: f64| {
        let radii = json!({"radius_min_m": 0.1, "radius_max_m": 0.1, "law": "number_uniform"});
        let mut fill = json!({"x_m": [2.1, right], "y_m": [0.0, 0.2], "speed_m_per_s": 0.0});
        for (key, value) in radii.as_object().expect("a table") {
            fill[key] = value.clone();
        }
        scene(
            sprung(),
            1e-6,
            json!({"kind": "disks", "fill": [fill]}),
            json!({}),
        )
    };
    build(&fill(2.3));
    assert!(refusal(&fill(2.299)).contains("no room"));
    let strip = |right: f64| {
        let disk = json!({"x_m": 1.5, "y_m": 0.0, "radius_m": 0.1});
        let sample = json!({"kind": "disks", "disks": [disk], "periodic_x_m": [1.1, right]});
        scene(sprung(), 1e-6, sample, json!({}))
    };
    build(&strip(1.9));
    assert!(refusal(&strip(1.899)).contains("narrower"));
}
