//! Profiles over slices of a sample.
//!
//! Reference: areas of circular segments, statics of a column, rigid motion. Tolerance: rounding.

use std::f64::consts::PI;

use dem_node::Dem;
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, refusal, scene, setting};

const R: f64 = 1e-3;

/// Rows of `<participant>-profile.csv` after this many steps, with the expected names of the columns.
fn profile_of(config: &Value, steps: u32, name: &str) -> Vec<Vec<f64>> {
    let folder =
        std::env::temp_dir().join(format!("thirdbody-profile-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    let setting = Setting {
        fields: Some(folder.clone()),
        ..setting(1)
    };
    let config = kit::read_config(config).expect("the scene is valid");
    let mut dem = Dem::new(&config, &setting).expect("the scene can be prepared");
    march(&mut dem, 0, steps);
    dem.finish().expect("the run can end");
    let text = std::fs::read_to_string(folder.join("third-body-profile.csv"));
    let text = text.expect("the profile is written");
    std::fs::remove_dir_all(&folder).expect("the folder can go");
    let mut lines = text.lines();
    let header = "t0_s,t1_s,y_m,vx_m_per_s,vy_m_per_s,solid_fraction,stress_xx_pa,stress_xy_pa,stress_yx_pa,stress_yy_pa,shear_rate_per_s,granular_temperature_m2_per_s2";
    assert_eq!(lines.next(), Some(header));
    let number = |word: &str| word.parse::<f64>().expect("a number");
    lines
        .map(|line| line.split(',').map(number).collect())
        .collect()
}

#[test]
fn a_disk_counts_in_each_slice_with_its_segment_and_moves_there_with_its_velocity() {
    let disk = |x: f64, vx: f64| json!({"x_m": x, "y_m": 0.0, "radius_m": R, "vx_m_per_s": vx});
    let sample = json!({"kind": "disks", "disks": [disk(0.0, 1.0), disk(4.0 * R, 3.0)]});
    let law = json!({"kind": "signorini"});
    let profile = json!({"profile": {"axis": "y", "bins": 4, "every_s": 1.0}});
    let rows = profile_of(&scene(law, 1e-12, sample, profile), 1, "segments");
    assert_eq!(rows.len(), 4);
    // Two disks in a box of 6 R x 2 R; a quarter of the height from the edge cuts off pi/3 - sqrt(3)/4.
    let outer = PI / 3.0 - 3.0f64.sqrt() / 4.0;
    let shares = [outer, PI / 2.0 - outer, PI / 2.0 - outer, outer];
    for (row, share) in rows.iter().zip(shares) {
        close("velocity", row[3], 2.0, 1e-12);
        close("solid fraction", row[5], 2.0 * share / 3.0, 1e-9);
        close("granular temperature", row[11], 1.0, 1e-12);
    }
    close("y", rows[0][2], -0.75 * R, 1e-12);
}

#[test]
fn every_slice_of_a_column_carries_the_weight_above() {
    let g = 9.81;
    let disk = |i: u32| json!({"x_m": 0.0, "y_m": R * (1.0 + 2.0 * f64::from(i)), "radius_m": R});
    let sample = json!({
        "kind": "disks",
        "disks": (0..6).map(disk).collect::<Vec<_>>(),
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let overrides = json!({
        "gravity_m_per_s2": [0.0, -g],
        "profile": {"axis": "y", "bins": 6, "start_s": 4.5e-5, "every_s": 1.0},
    });
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let rows = profile_of(&scene(law, 1e-5, sample, overrides), 6, "column");
    let weight = 7800.0 * PI * R * R * THICKNESS * g;
    for (i, row) in rows.iter().enumerate() {
        // A slice is a grain: one half has the force from below, the other half the force from above, less by one weight.
        let above = 6.0 - i as f64 - 0.5;
        let expected = above * weight / (2.0 * R * THICKNESS);
        close("stress", row[9], expected, 1e-6 * expected);
        close("sideways", row[6], 0.0, 1e-9 * expected);
        close("solid fraction", row[5], PI / 4.0, 1e-6);
    }
}

#[test]
fn the_shear_rate_is_the_slope_of_the_speeds_and_intervals_follow_each_other() {
    let disk = |i: u32| {
        let y = 2.5 * R * f64::from(i);
        json!({"x_m": 0.0, "y_m": y, "radius_m": R, "vx_m_per_s": 40.0 * y})
    };
    let sample = json!({"kind": "disks", "disks": (0..8).map(disk).collect::<Vec<_>>()});
    let law = json!({"kind": "signorini"});
    // The height of 19.5 R is cut into thirds of 6.5 R between disks.
    let profile = json!({"profile": {"axis": "y", "bins": 1, "start_s": 1e-9, "every_s": 2e-9}});
    let config = scene(law, 1e-9, sample, profile);
    let rows = profile_of(&config, 6, "intervals");
    let times: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], row[1]]).collect();
    assert_eq!(times.len(), 3);
    for (i, [start, end]) in times.into_iter().enumerate() {
        close("start", start, 1e-9 * (1.0 + 2.0 * i as f64), 1e-18);
        close("end", end, (1e-9 * (3.0 + 2.0 * i as f64)).min(6e-9), 1e-18);
    }
    close("velocity", rows[0][3], 40.0 * 2.5 * R * 3.5, 1e-12);
    let mut sliced = config;
    sliced["profile"]["bins"] = json!(3);
    let rows = profile_of(&sliced, 3, "slope");
    // Three slices of 6.5 R, symmetric about the middle: 8 disks, the middle slice with those at 7.5 R and 10 R.
    let slope = (rows[2][3] - rows[0][3]) / (rows[2][2] - rows[0][2]);
    close("shear rate", rows[1][10], slope, 1e-9 * slope);
    assert!((38.0..42.0).contains(&slope), "{slope}");
}

/// Disks that fly apart: the slices of a later interval are thicker, and less full.
#[test]
fn an_interval_cut_by_the_end_has_no_results() {
    let disk = |i: u32| {
        let y = 2.5 * R * f64::from(i);
        json!({"x_m": 0.0, "y_m": y, "radius_m": R, "vy_m_per_s": 40.0 * y})
    };
    let sample = json!({"kind": "disks", "disks": (0..8).map(disk).collect::<Vec<_>>()});
    let results = |steps: u32| {
        let profile =
            json!({"profile": {"axis": "y", "bins": 2, "start_s": 1e-3, "every_s": 3e-3}});
        let law = json!({"kind": "signorini"});
        let mut dem = build(&scene(law, 1e-3, sample.clone(), profile));
        march(&mut dem, 0, steps);
        let outcome = dem.finish().expect("the run can end");
        let solid = outcome.results.get("profile_solid_fraction").copied();
        (solid, outcome.warnings)
    };
    let (none, texts) = results(3);
    assert_eq!(none, None);
    assert!(
        texts.len() == 1 && texts[0].contains("profile.every_s"),
        "{texts:?}"
    );
    assert_eq!(results(1).0, None, "it has not begun");
    let (first, texts) = results(4);
    assert!(first.is_some() && texts.is_empty(), "{first:?} {texts:?}");
    for steps in [5, 6] {
        assert_eq!(results(steps).0, first, "after {steps} steps");
    }
    assert!(results(7).0 < first, "the second interval is over");
}

#[test]
fn more_slices_than_a_file_should_hold_are_refused() {
    let sample = json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": 0.0, "radius_m": R}]});
    let overrides = json!({
        "profile": {"axis": "x", "bins": 100, "every_s": 1e-6},
        "time": {"step_s": 1e-6, "pressure_pa": 1.0, "end_s": 0.1},
    });
    let message = refusal(&scene(
        json!({"kind": "signorini"}),
        1e-6,
        sample,
        overrides,
    ));
    assert!(
        message.contains("profile.every_s") && message.contains("1.0e7 slices"),
        "{message}"
    );
}

#[test]
fn a_profile_without_grains_gives_advice() {
    let disks = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "cluster": "top"}]);
    let drive = json!({"velocity_m_per_s": [0.1, 0.0]});
    let sample =
        json!({"kind": "disks", "disks": disks, "clusters": [{"name": "top", "drive": drive}]});
    let profile = json!({"profile": {"axis": "y", "bins": 4, "every_s": 1e-5}});
    let mut dem = build(&scene(json!({"kind": "signorini"}), 1e-5, sample, profile));
    march(&mut dem, 0, 3);
    let warnings = dem.finish().expect("it ends").warnings;
    assert!(
        warnings.iter().any(|w| w.contains("no slice held a grain")),
        "{warnings:?}"
    );
}
