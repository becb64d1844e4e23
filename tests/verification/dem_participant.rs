//! The node as a participant: its description, and the fields that it writes.
//!
//! Pressure of a disk in a vice: sigma_yy = -2F / (pi r thickness), sigma_xx = 0, so the mean in-plane pressure is
//! F / (pi r thickness). Reference: single_disk_diametral_F of the project's own stress_cases.csv, F = 10 N, r = 0.07 mm:
//! sigma_yy = -90.9457 MPa. Tolerance: the digits of the table.

use std::path::Path;

use dem_node::{build, check};
use protocol::{PROTOCOL_VERSION, Session, Transport, Window};
use serde_json::{Value, json};

use crate::dem_support::{close, scene, setting};
use crate::vtk_file::array;

const R: f64 = 0.07e-3;
const FORCE: f64 = 10.0;
const SYY: f64 = 90.9457e6;

/// A disk between a glued disk and the wheel.
fn vice() -> Value {
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": 0.0, "y_m": R, "radius_m": R},
        {"x_m": 0.0, "y_m": -R, "radius_m": R, "glued": true},
    ]});
    let wheel = json!({"load_n": FORCE, "mass_kg": 0.01, "ramp_s": 1e-5, "hold_s": 1e-5});
    let law = json!({"kind": "coulomb", "friction": 0.3});
    // Rigid contacts between a grain and a wheel of 80 000 times its mass would need 80 000 sweeps.
    scene(
        law,
        1e-6,
        sample,
        json!({"wheel": wheel, "mass_scale": 1e5}),
    )
}

fn session(config: Value, fields: Option<&Path>) -> Session {
    Session {
        protocol: PROTOCOL_VERSION,
        run_id: 1,
        scenario_hash: "none".into(),
        coordinator_pid: std::process::id(),
        setting: protocol::Setting {
            fields: fields.map(Path::to_path_buf),
            ..setting(1)
        },
        transport: Transport::Channel,
        idle_deadline_s: 1.0,
        config,
    }
}

#[test]
fn a_session_becomes_a_participant_that_describes_itself() {
    let node = build(&session(vice(), None)).expect("it can be built");
    let description = node.describe();
    assert_eq!(description.kind, "dem");
    assert!(description.capabilities.rollback && description.capabilities.compliant_boundary);
    assert!(description.capabilities.alone && !description.capabilities.advance);
    assert_eq!(description.sets, ["base"]);
    close(
        "end",
        description.end_s.expect("the wheel has an end"),
        2e-5,
        1e-18,
    );
    let mut names: Vec<&String> = description.signals.iter().collect();
    names.extend(description.ledger.iter().map(|term| &term.name));
    let count = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), count, "names must differ");
}

#[test]
fn check_warns_without_preparing_anything() {
    let mut config = vice();
    assert_eq!(check(&config, &setting(1)), Ok(Vec::new()));
    config["time"]["pressure_pa"] = json!(1.5e11);
    let warnings = check(&config, &setting(1)).expect("it is only slow");
    assert!(
        warnings.len() == 1 && warnings[0].contains("inertial time"),
        "{warnings:?}"
    );
    let flat = protocol::Setting {
        thickness_m: 0.0,
        ..setting(1)
    };
    let error = check(&config, &flat).expect_err("nothing has no thickness");
    assert_eq!(error.key, "run.thickness_m");
}

#[test]
fn every_glued_disk_takes_part_in_the_exchange() {
    let mut config = vice();
    config["time"] = json!({"pressure_pa": 1.0});
    let mut node = build(&session(config, None)).expect("it can be built");
    assert_eq!(node.couple("base").expect("it is there").len(), 1);
    node.select(&[0]).expect("these are all");
    let error = node.select(&[]).expect_err("one would be left out");
    assert!(error.message.contains("select all"), "{error}");
    let again = node.couple("base").expect_err("one wall carries it");
    assert!(again.message.contains("already coupled"), "{again}");
}

#[test]
fn a_snapshot_holds_the_pressure_of_a_disk_in_a_vice() {
    let folder = std::env::temp_dir().join(format!("dem-snapshot-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    let mut node = build(&session(vice(), Some(&folder))).expect("it can be built");
    node.advance_alone(&Window {
        substeps: 20,
        ..Window::default()
    })
    .expect("it converges");
    node.snapshot("held").expect("the folder is there");
    let read = |file| std::fs::read(folder.join(file)).expect("it was written");
    let [document, contacts] = ["third-body-held.vtp", "third-body-held-contacts.vtp"].map(read);
    std::fs::remove_dir_all(&folder).expect("it is ours");
    assert_eq!(array(&document, "points").len(), 6);
    assert_eq!(array(&document, "glued"), [0.0, 1.0]);
    assert_eq!(array(&document, "radius_m"), [R, R]);
    assert_eq!(array(&document, "coordination"), [2.0, 1.0]);
    close(
        "pressure",
        array(&document, "pressure_pa")[0],
        0.5 * SYY,
        50.0,
    );
    let moved = array(&document, "displacement_since_start_m");
    let y = array(&document, "points")[1];
    assert_eq!(moved, [0.0, y - R, 0.0, 0.0, 0.0, 0.0]);
    let forces = array(&contacts, "force_n");
    assert_eq!(forces.len(), 4, "two contacts, normal and tangential");
    close("force on the glued disk", forces[0], FORCE, 1e-9);
    close("force of the wheel", forces[2], FORCE, 1e-9);
    assert_eq!(array(&contacts, "status"), [1.0, 1.0], "both stick");
    // From the disk to the glued one, and to the wheel above it, whose contact point lies within the overlap.
    assert_eq!(array(&contacts, "connectivity"), [0.0, 1.0, 0.0, 2.0]);
    let top = array(&contacts, "points")[7] - y;
    let gap = array(&contacts, "gap_m")[1];
    close("place of the wheel", top, R + gap, 1e-12 * R);
}

#[test]
fn a_snapshot_that_cannot_be_written_is_an_error() {
    let nowhere = Path::new("/nonexistent/fields");
    let mut node = build(&session(vice(), Some(nowhere))).expect("it can be built");
    let error = node.snapshot("held").expect_err("there is no such folder");
    assert!(error.message.contains("third-body-held.vtp"), "{error}");
}
