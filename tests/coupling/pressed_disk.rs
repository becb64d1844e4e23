//! A rigid disk pressed on the bare surface of an elastic block.
//!
//! ```text
//!        ( o )  F
//!    .__.\_|_/.__.__     points of the surface, on the nodes of the block or between them
//!   |~~~~~~~~~~~~~~~|
//!   |_____block_____|
//! ```
//!
//! A disk of fifty elements sinks as deep as a wheel in a static solution of the same block on elements a quarter as large, at any
//! place between the nodes: within 1 % (0.2 to 0.9 % at twenty places, points one element and half an element apart). A grain as large as
//! an element sinks 31 to 39 % less than on a continuum, because an element does not bend within itself. By Saint-Venant's principle the
//! surface three elements away lies as under any other contact of the same force: within 1 % (0.7 %).
//! A disk sinks by 3 to 25 % too much if only its nearest segment holds it, or if collinear segments hold it by a whole spring each.

use harness::runs::{Left, run_in_process};
use harness::scene::{head, interface, participant};

const ELEMENT: f64 = 0.2e-3;

/// The block, with elements of this size under the middle (m), and further keys of the mesh, the body and the run.
fn block(size: f64, fine: &str, keys: &str, of_run: &str) -> String {
    let keys = format!(
        r#"base = "clamped"
sides = "free"
mesh = {{ width_m = 24e-3, height_m = 10e-3, size_m = {size:e}, {fine} }}
material = {{ young_pa = 102.5e9, poisson = 0.3, density_kg_per_m3 = 7800.0 }}
probes = [{{ name = "left", x_m = -0.6e-3, y_m = 0.0 }}, {{ name = "far", x_m = -0.8e-3, y_m = 0.0 }}]
{keys}"#
    );
    [
        head("pressed-disk", 1e-3, &format!("seed = 1\n{of_run}")),
        participant("block", "fem", &keys),
    ]
    .concat()
}

/// The static answer of a wheel of this radius (m) under this load (N), on elements of this size (m) in its neighbourhood.
fn reference(radius: f64, load: f64, size: f64) -> Left {
    let keys = format!(
        r#"analysis = "static"
wheel = {{ load_n = {load:?}, mass_kg = 0.01, radius_m = {radius:e}, amplitude_m = 0.0, frequency_hz = 300.0, ramp_s = 1e-3, hold_s = 1e-3, cycles = 0.0 }}
contact = {{ friction = 0.0 }}
time = {{ step_s = 1e-8, damping = 0.75 }}
statics = {{ increment_n = {:?} }}
"#,
        load / 10.0
    );
    let fine = format!(
        "fine_width_m = {:e}, fine_depth_m = {:e}, side_columns = 90, depth_rows = 90",
        96.0 * size,
        60.0 * size
    );
    ran(&block(size, &fine, &keys, ""))
}

/// A disk of this radius at x (m) on points with this spacing (m), under this load (N).
fn pressed(radius: f64, x: f64, spacing: f64, load: f64) -> Left {
    let time = "time = { step_s = 3e-8, damping = 0.75, mass_damping_per_s = 3e5 }";
    let keys = format!(
        r#"density_kg_per_m3 = 1000.0
law = {{ kind = "signorini", contact_stiffness_pa = 1e13 }}
solver = {{ kind = "nsgs", tolerance = 1e-5, max_iterations = 20000, min_iterations = 2 }}
time = {{ pressure_pa = 1e9 }}
[participant.config.sample]
kind = "disks"
disks = [{{ x_m = {x:e}, y_m = {radius:e}, radius_m = {radius:e}, cluster = "punch" }}]
surface = {{ half_width_m = 3e-3, spacing_m = {spacing:e} }}
clusters = [{{ name = "punch", drive = {{ velocity_m_per_s = [0.0, "free"], load_table = [[0.0, 0.0], [1e-4, -{load:?}]] }} }}]"#
    );
    let sets = ["block.top", "disk.base"];
    let text = [
        block(ELEMENT, "", time, "end_s = 3e-4"),
        participant("disk", "dem", &keys),
        interface("contact", sets, "dual-schur", 10, "tolerance_rel = 1e-5"),
    ];
    ran(&text.concat())
}

fn ran(text: &str) -> Left {
    run_in_process(text, &[]).expect("it is valid").completed()
}

fn last(left: &Left, signal: &str) -> f64 {
    *left.signals[signal].last().expect("there are windows")
}

#[test]
fn a_large_disk_sinks_as_deep_as_in_a_static_solution() {
    let (radius, load) = (10e-3, 5000.0);
    let exact = reference(radius, load, ELEMENT / 4.0).number("results.approach_m");
    for (place, spacing) in [(0.3, 1.0), (0.9, 1.0), (0.2, 0.5)] {
        let left = pressed(radius, place * ELEMENT, spacing * ELEMENT, load);
        let sunk = radius - last(&left, "disk.punch_y_m");
        println!(
            "{place} of an element, points {spacing} apart: {:.4}",
            sunk / exact
        );
        assert!((sunk / exact - 1.0).abs() < 1e-2, "{sunk:e} for {exact:e}");
        assert!((last(&left, "disk.glued_fy_n") / load + 1.0).abs() < 2e-3);
        assert!(last(&left, "disk.glued_fx_n").abs() < 2e-3 * load);
        assert!(left.number("results.energy_balance_rel") < 1e-3);
    }
}

#[test]
fn the_surface_is_exact_three_elements_from_a_small_grain() {
    let (radius, load) = (ELEMENT, 176.0);
    let exact = reference(10e-3, load, ELEMENT / 4.0);
    let own = reference(radius, load, ELEMENT / 40.0);
    let below = last(&exact, "left_uy_m");
    let mut sunk = Vec::new();
    for (place, probe) in [(0.0, "block.left_uy_m"), (1.0, "block.far_uy_m"), (0.5, "")] {
        let left = pressed(radius, -place * ELEMENT, ELEMENT, load);
        sunk.push((radius - last(&left, "disk.punch_y_m")) / own.number("results.approach_m"));
        if !probe.is_empty() {
            let found = last(&left, probe) / below;
            println!("{place} of an element: {found:.4}");
            assert!((found - 1.0).abs() < 1e-2, "{probe}: {found}");
        }
    }
    println!("sunk by {sunk:?}");
    assert!((sunk[0] - sunk[1]).abs() < 2e-3, "as deep on the next node");
    for (part, expected) in sunk.iter().zip([0.69, 0.69, 0.61]) {
        assert!((part - expected).abs() < 0.01, "{part} for {expected}");
    }
}
