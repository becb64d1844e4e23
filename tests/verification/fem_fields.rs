//! Problem: the fields of a committed state on disk, and the pressures at the end of the hold.
//! Exact: a VTK file with one value for each node and element; the pressures of the state committed at the snapshot
//! `hold`, not of the last state.
//! Source: VTK File Formats, "UnstructuredGrid".
//! Tolerance: none, except the rounding of sums for nu (sxx + syy) = szz in plane strain.

use fem_node::{FemConfig, FemNode};
use kit::read_config;
use protocol::{Node, Setting};
use serde_json::json;

use crate::fem_bodies::{block, setting, window, with};
use crate::vtk_file::array;

fn loaded(fields: Option<std::path::PathBuf>) -> FemNode {
    let load = json!({"boundary": {"top": {"traction_pa": [0.0, -1e6]}}});
    let config: FemConfig = read_config(with(block(), load)).expect("valid");
    let setting = Setting {
        fields,
        ..setting(1)
    };
    FemNode::new(&config, &setting).expect("valid")
}

#[test]
fn a_snapshot_holds_every_node_and_element() {
    let folder = std::env::temp_dir().join(format!("fem-fields-{}", std::process::id()));
    let mut node = loaded(Some(folder.join("fields")));
    node.advance_alone(&window(0, 20)).expect("stable");
    node.snapshot("hold").expect("written");
    let file = std::fs::read(folder.join("fields/rail-hold.vtu")).expect("it exists");
    std::fs::remove_dir_all(&folder).expect("it exists");
    let values = |name| array(&file, name).len();
    assert_eq!(values("points"), 3 * 13 * 7);
    assert_eq!(values("displacement_m"), 3 * 13 * 7);
    assert_eq!(values("velocity_m_per_s"), 3 * 13 * 7);
    assert_eq!(values("connectivity"), 4 * 12 * 6);
    for name in [
        "hydrostatic_pressure_pa",
        "sigma_xx_pa",
        "sigma_yy_pa",
        "sigma_xy_pa",
        "sigma_zz_pa",
        "types",
    ] {
        assert_eq!(values(name), 12 * 6, "{name}");
    }
    let [xx, yy, zz] = ["xx", "yy", "zz"].map(|k| array(&file, &format!("sigma_{k}_pa")));
    for k in 0..12 * 6 {
        let plane_strain = 0.3 * (xx[k] + yy[k]);
        assert!((zz[k] - plane_strain).abs() <= 1e-9 * 1e6, "{k}");
    }
}

#[test]
fn a_snapshot_shows_contacts_of_the_upper_edge() {
    let folder = std::env::temp_dir().join(format!("fem-status-{}", std::process::id()));
    let wheel = json!({
        "wheel": {"load_n": 500.0, "mass_kg": 1e-3, "ramp_s": 0.0, "hold_s": 1e-4},
        "contact": {"friction": 0.3},
    });
    let config: FemConfig = read_config(with(block(), wheel)).expect("valid");
    let setting = Setting {
        fields: Some(folder.clone()),
        ..setting(1)
    };
    let mut node = FemNode::new(&config, &setting).expect("valid");
    node.advance_alone(&window(0, 100)).expect("stable");
    node.snapshot("pressed").expect("written");
    let file = std::fs::read(folder.join("rail-pressed.vtu")).expect("it exists");
    std::fs::remove_dir_all(&folder).expect("it exists");
    let status = array(&file, "node_status");
    let (top, below) = status.split_at(13);
    assert!(top[6] > 0.0, "the crown touches");
    assert_eq!((top[0], top[12]), (0.0, 0.0), "the edges do not");
    assert_eq!(below, [-1.0; 13 * 6]);
    let pressure = array(&file, "contact_pressure_pa");
    let pressed = pressure.iter().zip(&status);
    assert!(pressed.clone().any(|(p, _)| *p > 0.0));
    assert!(
        pressed
            .clone()
            .all(|(p, status)| *status > 0.0 || *p == 0.0)
    );
}

#[test]
fn a_name_that_leaves_the_folder_is_refused() {
    assert!(loaded(None).snapshot("../hold").is_err());
}

#[test]
fn reported_pressures_belong_to_the_hold() {
    let (mut held, mut unheld) = (loaded(None), loaded(None));
    for node in [&mut held, &mut unheld] {
        node.advance_alone(&window(0, 20)).expect("stable");
    }
    let at_hold = unheld.finish().expect("it ends").results;
    held.snapshot("hold").expect("nothing to write");
    for node in [&mut held, &mut unheld] {
        node.advance_alone(&window(1, 20)).expect("stable");
    }
    assert_eq!(held.finish().expect("it ends").results, at_hold);
    assert_ne!(unheld.finish().expect("it ends").results, at_hold);
}
