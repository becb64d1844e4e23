//! Partial slip of a flat wheel on a crowned rail, through a row of bonded grains on bare steel.
//!
//! ```text
//!     __wheel__  P, then D = D0 sin wt
//!     oooooooooo     a row of equal disks, bonded so that none of them rolls
//!    /~~~rail~~~\    its bare surface
//! ```
//!
//! Exact: the row is a hundred times as stiff as the rail, so wheel and rail meet as without it: the sinking under the load (Hertz), and
//! the force over D with slip from the edges inwards (Cattaneo 1938, Mindlin 1949). The reference is the rail alone under its own wheel,
//! on the same elements. Tolerances: 0.5 % for the sinking and 1 % of the limit of friction for the force; the row keeps 0.1 % and 0.6 %.
//! With elements and disks half as large the slip zones are the same as well, and the force on every 0.8 mm of the contact within 1.3 %.

use harness::runs::{Left, run_in_process};
use harness::scene::{head, interface, participant};

const CROWN: f64 = 0.3;
const R: f64 = 0.2e-3;
/// Disks on either side of the middle: 8 mm, of which the contact covers 5.2.
const SIDE: i32 = 20;
const LIMIT: f64 = 0.3 * 8000.0;

fn rail(keys: &str) -> String {
    let keys = format!(
        r#"element = "q4_1point"
plane = "strain"
base = "clamped"
sides = "free"
mesh = {{ width_m = 65e-3, height_m = 20e-3, size_m = 0.4e-3, fine_width_m = 21.6e-3, fine_depth_m = 2e-3, side_columns = 20, depth_rows = 10, crown_radius_m = {CROWN:?} }}
material = {{ kind = "elastic", young_pa = 102.5e9, poisson = 0.3, density_kg_per_m3 = 7800.0 }}
{keys}"#
    );
    [
        head("partial-slip", 1e-3, "seed = 1"),
        participant("rail", "fem", &keys),
    ]
    .concat()
}

const WHEEL: &str = "wheel = { load_n = 8000.0, mass_kg = 0.01, radius_m = 0.0, amplitude_m = 2e-5, frequency_hz = 300.0, ramp_s = 1e-3, hold_s = 0.5e-3, cycles = 0.75 }\n";

fn alone() -> Left {
    let keys = "analysis = \"dynamic\"\nstart = \"ramp\"\ncontact = { friction = 0.3, friction_while_loading = true }\ntime = { step_s = 6.8e-8, damping = 0.75, start_mass_damping_per_s = 3e4 }\n";
    ran(&rail(&[keys, WHEEL].concat()))
}

fn through_grains() -> Left {
    let angle = 2.0 * (R / (CROWN + R)).asin();
    let disk = |k: i32| {
        let (sin, cos) = (f64::from(k) * angle).sin_cos();
        let [x, y] = [(CROWN + R) * sin, (CROWN + R) * cos - CROWN];
        format!("{{ x_m = {x:e}, y_m = {y:e}, radius_m = {R:e} }}")
    };
    let disks: Vec<String> = (-SIDE..=SIDE).map(disk).collect();
    let keys = format!(
        r#"density_kg_per_m3 = 7800.0
mass_scale = 1000.0
law = {{ kind = "cohesion", friction = 0.3, contact_stiffness_pa = 1e13, tangential_stiffness_ratio = 0.5, cn_pa_per_m = 6.4e16, ct_pa_per_m = 6.4e16, w_j_per_m2 = 1e6, b_pa_m_s = 0.0, p = 1.0, h_prime = "one", alert_m = 8e-6, bonds_min = 2 }}
solver = {{ kind = "nsgs", tolerance = 1e-4, max_iterations = 5000, min_iterations = 2 }}
time = {{ pressure_pa = 1e9 }}
{WHEEL}
[participant.config.sample]
kind = "disks"
disks = [{}]
surface = {{ half_width_m = 9e-3, spacing_m = 0.4e-3, crown_radius_m = {CROWN:?} }}"#,
        disks.join(", ")
    );
    let sets = ["rail.top", "row.base"];
    let text = [
        rail("time = { step_s = 6.8e-8, damping = 0.75 }"),
        participant("row", "dem", &keys),
        interface("surface", sets, "dual-schur", 9, "tolerance_rel = 1e-5"),
    ];
    ran(&text.concat())
}

fn ran(text: &str) -> Left {
    run_in_process(text, &[]).expect("it is valid").completed()
}

#[test]
fn a_row_of_bonded_grains_slips_as_in_cattaneo_and_mindlin() {
    let (alone, row) = (alone(), through_grains());
    let [exact, sunk] = [&alone, &row].map(|left| left.number("results.approach_m"));
    println!("sinks by {sunk:e} for {exact:e}");
    assert!((sunk / exact - 1.0).abs() < 5e-3);
    let mut slipping = 0.0f64;
    // The middle of the way out, its end, the way back, the other end.
    for phase in [0.125, 0.25, 0.375, 0.5, 0.625, 0.75] {
        let time = 1.5e-3 + phase / 300.0 - 1e-6;
        let [exact, found] =
            [(&alone, "wheel_ft_n"), (&row, "row.wheel_ft_n")].map(|(left, name)| {
                let at = left.signals["t_s"].partition_point(|t| *t < time);
                left.signals[name][at] / LIMIT
            });
        println!("{phase} of a cycle: {found:.4} for {exact:.4}");
        assert!((found - exact).abs() < 0.01, "{phase}: {found} for {exact}");
        slipping = slipping.max(found.abs());
    }
    assert!(slipping > 0.4 && slipping < 0.9, "partial slip: {slipping}");
}
