//! `report --movie` through the command: one self-contained page of the fields that exist.

use std::path::Path;
use std::process::Output;

use harness::runs::{Scratch, thirdbody};

/// A small rail under its wheel: a short hold and a short motion.
const SCENE: &str = r#"
[run]
name = "</script><b>rail & wheel"
thickness_m = 1e-3
[[participant]]
name = "rail"
kind = "fem"
[participant.config]
start = "ramp"
base = "clamped"
sides = "free"
mesh = { width_m = 8e-3, height_m = 2e-3, size_m = 0.5e-3 }
material = { young_pa = 102.5e9, poisson = 0.3, density_kg_per_m3 = 7800.0 }
time = { step_s = 5e-8, damping = 0.75 }
wheel = { load_n = 100.0, mass_kg = 0.01, radius_m = 0.0, amplitude_m = 1e-5, frequency_hz = 1000.0, ramp_s = 2e-5, hold_s = 2e-5, cycles = 0.05 }
contact = { friction = 0.3, friction_while_loading = true }
"#;

fn movie(folder: &Path) -> Output {
    let mut command = thirdbody(folder);
    command.args(["report", "out", "--movie"]);
    command.output().expect("it starts")
}

/// A folder with the run `out`; its fields are `every` apart (s).
fn ran(name: &str, every: &str) -> Scratch {
    let work = Scratch::new(name);
    std::fs::write(work.path().join("scenario.toml"), SCENE).expect("the folder is writable");
    let mut command = thirdbody(work.path());
    let fields = format!("run.output.fields_every_s={every}");
    command.args(["run", ".", "--out", "out", "--set", "run.name=hostile"]);
    let output = command
        .args(["--set", &fields])
        .output()
        .expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(work.path().join("out/signals.csv").is_file(), "{said}");
    work
}

fn page(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("out/movie.html")).expect("it was written")
}

#[test]
fn a_run_becomes_one_page_with_a_frame_for_each_moment() {
    let work = ran("movie", "5e-6");
    let output = movie(work.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let printed = String::from_utf8_lossy(&output.stdout);
    assert_eq!(printed.trim(), "out/movie.html");
    let page = page(work.path());
    assert!(page.len() < 5_000_000 && page.contains("<h1>hostile</h1>"));
    // Four moments in ramp and hold, ten in 5e-5 s of motion.
    assert_eq!(page.matches("\"t_ms\":").count(), 2 * 18);
    assert!(!page.contains("fields_every_s"), "there are enough");
    assert!(!work.path().join("out/report.html").exists());
}

/// A run directory may come from another user: the report reads its scenario as it is.
#[test]
fn a_name_from_elsewhere_ends_no_element_of_the_page() {
    let work = ran("movie-hostile", "5e-6");
    let scripts = |page: &str| page.matches("</script").count();
    movie(work.path());
    let before = scripts(&page(work.path()));
    std::fs::write(work.path().join("out/scenario.toml"), SCENE).expect("it is writable");
    movie(work.path());
    let page = page(work.path());
    assert_eq!(scripts(&page), before);
    assert!(page.contains("&lt;/script&gt;&lt;b&gt;rail &amp; wheel"));
}

#[test]
fn a_page_of_few_moments_says_how_to_get_more() {
    let work = ran("movie-few", "1.0");
    assert!(movie(work.path()).status.success());
    // A hundredth of 0.09 ms.
    assert!(page(work.path()).contains("--set run.output.fields_every_s=9e-7"));
}

#[test]
fn a_run_cut_short_is_shown_and_a_run_without_fields_is_refused_with_the_key() {
    let work = ran("movie-cut", "5e-6");
    let fields = work.path().join("out/fields");
    let file = fields.join("rail-hold-1.vtu");
    let text = std::fs::read(&file).expect("it was written");
    std::fs::write(&file, &text[..text.len() / 2]).expect("it is writable");
    std::fs::remove_file(work.path().join("out/summary.json")).expect("it was written");
    assert!(movie(work.path()).status.success());
    let page = page(work.path());
    assert!(page.contains("rail-hold-1.vtu: ends in the middle"));
    assert!(page.contains("was killed, or still runs"));
    std::fs::remove_dir_all(&fields).expect("it is there");
    let output = movie(work.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("fields_every_s"), "{said}");
}
