//! Grains from a file: the table gives back every bit of its sample, and each mistake in it is refused
//! by its line. Numbers are written with the shortest digits that read back as the same double.

use std::path::{Path, PathBuf};

use dem_kernel::bodies::disk::Disk;
use dem_node::config::DemConfig;
use dem_node::sample;
use dem_node::sample::types::Sample;
use serde_json::{Value, json};

use crate::dem_support::{build, march, refusal, scene};

/// A new file below the system's temporary folder, removed when dropped.
struct Table(PathBuf);

impl Table {
    fn new(name: &str, text: impl AsRef<[u8]>) -> Table {
        let name = format!("thirdbody-grains-{name}-{}.csv", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, text).expect("the temporary folder is writable");
        Table(path)
    }
}

impl Drop for Table {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn of(path: &Path) -> Value {
    let sample = json!({"kind": "file", "path": path});
    scene(json!({"kind": "signorini"}), 1e-4, sample, json!({}))
}

fn prepared(config: &Value) -> Sample {
    let config: DemConfig = kit::read_config(config).expect("it is valid");
    sample::prepare(&config, 1).expect("it can be prepared")
}

fn lines(disks: &[Disk], glued: bool) -> String {
    let line = |disk: &Disk| {
        let [x, y] = disk.centre;
        format!("{},{x},{},{y}\n", disk.radius, u8::from(glued))
    };
    disks.iter().map(line).collect()
}

#[test]
fn a_sample_comes_back_from_its_table_bit_for_bit() {
    let layer = json!({
        "kind": "layer", "thickness_m": 3e-4, "half_width_m": 1.5e-3, "crown_radius_m": 0.3, "radius_min_m": 5e-5,
        "radius_max_m": 1e-4, "law": "surface_uniform",
    });
    let original = prepared(&scene(
        json!({"kind": "signorini"}),
        1e-4,
        layer,
        json!({"wheel": {"load_n": 1.0, "mass_kg": 1.0, "ramp_s": 0.0, "hold_s": 1.0}}),
    ));
    assert!(original.free.len() > 20 && original.glued.len() > 10);
    let text = format!(
        "radius_m,x_m,glued,y_m\n{}{}",
        lines(&original.free, false),
        lines(&original.glued, true)
    );
    let table = Table::new("round", text);
    let back = prepared(&of(&table.0));
    let bits = |disks: &[Disk]| -> Vec<[u64; 3]> {
        let numbers = |d: &Disk| [d.centre[0], d.centre[1], d.radius].map(f64::to_bits);
        disks.iter().map(numbers).collect()
    };
    assert_eq!(bits(&back.free), bits(&original.free));
    assert_eq!(bits(&back.glued), bits(&original.glued));
}

/// A disk that rests on a glued one, without a wheel: nothing moves.
#[test]
fn a_file_needs_no_wheel_and_may_use_words() {
    let text =
        "\u{feff}x_m, y_m, radius_m, glued\r\n0, 0, 1e-3, true\r\n\r\n0, 2e-3, 1e-3, false\r\n";
    let table = Table::new("words", text);
    let mut dem = build(&of(&table.0));
    march(&mut dem, 0, 3);
    assert_eq!(dem.state().centres, [[0.0, 2e-3], [0.0, 0.0]]);
    assert_eq!((dem.bodies().free, dem.bodies().glued()), (1, 1));
}

#[test]
fn mistakes_in_a_table_are_refused_by_their_line() {
    let header = "x_m,y_m,radius_m,glued\n";
    let with = |line: &str| format!("{header}0,0,1,0\n\n{line}\n");
    let cases = [
        ("", "line 1: \"\" is no column"),
        (
            "x_m,y_m,radius,glued\n",
            "line 1: \"radius\" is no column of such a table; columns: x_m, y_m",
        ),
        (
            "x_m,y_m,x_m,glued\n",
            "line 1: the column x_m is there twice",
        ),
        ("x_m,y_m,glued\n", "line 1: the column radius_m is missing"),
        (header, "there is no disk that is not glued"),
        (
            &with("NaN,0,1,0"),
            "line 4: x_m must be a finite number, got \"NaN\"",
        ),
        (
            &with("0,inf,1,0"),
            "line 4: y_m must be a finite number, got \"inf\"",
        ),
        (
            &with("0,0,one,0"),
            "line 4: radius_m must be a finite number, got \"one\"",
        ),
        (
            &with("0,0,-1,0"),
            "line 4: radius_m must be above 0, got -1e0",
        ),
        (
            &with("0,0,1,yes"),
            "line 4: glued must be 0, 1, true or false, got \"yes\"",
        ),
        (&with("0,0,1"), "line 4: it has 3 values, the header 4"),
        (&with("0,0,1,0,0"), "line 4: it has 5 values, the header 4"),
        (
            &format!("{header}0,0,1,1\n"),
            "there is no disk that is not glued; write 0",
        ),
    ];
    for (number, (text, expected)) in cases.into_iter().enumerate() {
        let table = Table::new(&format!("case-{number}"), text);
        let message = refusal(&of(&table.0));
        assert!(message.starts_with("sample.path: "), "{message}");
        assert!(message.contains(expected), "{message}");
        assert!(message.contains(".csv"), "{message}");
    }
    let binary = Table::new("binary", [0xff, 0xfe, 0x00]);
    let message = refusal(&of(&binary.0));
    assert!(message.contains("cannot be read"), "{message}");
}

#[test]
fn a_missing_or_special_file_is_refused() {
    for (path, why) in [
        ("missing.csv", "No such file"),
        ("/dev/null", "a pipe or a device"),
    ] {
        let message = refusal(&of(Path::new(path)));
        assert!(message.starts_with("sample.path: "), "{message}");
        assert!(message.contains(path) && message.contains(why), "{message}");
    }
    let sample = json!({"kind": "file", "path": "a.csv", "glued": true});
    let config = scene(json!({"kind": "signorini"}), 1e-4, sample, json!({}));
    assert!(refusal(&config).contains("sample.glued: no such key"));
}
