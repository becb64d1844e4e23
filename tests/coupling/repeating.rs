//! Coupled bodies that are periodic along x: the seam has no effect.
//!
//! ```text
//!   : | | | | | :          p
//!   :~~~~~~~~~~~:   rail, its left and right edge identified
//!   : o o o o o o          grains between glued rows, or under a flat wheel; some lie across the seam (:)
//!   :~~~~~~~~~~~:   rail, clamped base
//! ```
//!
//! Exact: a regular row between two rails carries p everywhere, and all bodies deform as in uniaxial strain, wherever the row
//! stands. Moving grains by whole elements, listing images of them, or cutting the strip elsewhere changes no result. All forces
//! add up to the load, and their sum changes only the momentum of the grains.

use harness::runs::{Left, run_in_process};
use harness::scene::{POISSON, SPACING_M, YOUNG_PA, head, interface, participant};

const WIDTH_M: f64 = 4e-3;
const HEIGHT_M: f64 = 2e-3;
const STIFFNESS_PA: f64 = 1e11;
const PRESSURE_PA: f64 = 100e6;

/// A damped rail of 10 x 5 elements.
fn rail(name: &str, base: &str, repeats: bool, keys: &str) -> String {
    let mesh = format!("width_m = {WIDTH_M:e}, height_m = {HEIGHT_M:e}, size_m = {SPACING_M:e}");
    let elastic = format!("young_pa = {YOUNG_PA:e}, poisson = {POISSON:?}");
    let keys = format!(
        r#"
base = "{base}"
mesh = {{ {mesh}, periodic_x = {repeats} }}
material = {{ {elastic}, density_kg_per_m3 = 7800.0 }}
time = {{ step_s = 5e-8, damping = 0.5, mass_damping_per_s = 6e5 }}
{keys}
"#
    );
    participant(name, "fem", &keys)
}

/// Centre and radius of a disk (m), and the row that it is glued to.
type Disk = (f64, f64, f64, &'static str);

fn grains(strip: Option<[f64; 2]>, disks: &[Disk], keys: &str) -> String {
    let disk = |(x, y, radius, row): &Disk| {
        let glued = match *row {
            "" => "",
            "lid" => ", glued = true, lid = true",
            _ => ", glued = true",
        };
        format!("{{ x_m = {x:e}, y_m = {y:e}, radius_m = {radius:e}{glued} }}")
    };
    let disks: Vec<String> = disks.iter().map(disk).collect();
    let period = strip.map_or(String::new(), |ends| format!("periodic_x_m = {ends:?}, "));
    let keys = format!(
        r#"
density_kg_per_m3 = 7800.0
law = {{ kind = "coulomb", friction = 0.3, contact_stiffness_pa = {STIFFNESS_PA:e}, tangential_stiffness_ratio = 1.0 }}
solver = {{ kind = "nsgs", tolerance = 1e-11, max_iterations = 100000, min_iterations = 1 }}
time = {{ pressure_pa = 1e6 }}
sample = {{ kind = "disks", {period}disks = [{}] }}
{keys}
"#,
        disks.join(", ")
    );
    participant("grains", "dem", &keys)
}

const HALF: [f64; 2] = [-0.5 * WIDTH_M, 0.5 * WIDTH_M];

fn glue(name: &str, between: [&str; 2]) -> String {
    interface(name, between, "dual-schur", 4, "tolerance_rel = 1e-9")
}

fn run(text: &str) -> Left {
    run_in_process(text, &[]).expect("it is valid").completed()
}

fn last(left: &Left, name: &str) -> f64 {
    *left.signals[name].last().expect("there are windows")
}

fn ledger_closes(left: &Left, names: &[&str], gap: f64) {
    for name in names {
        let of = |key: &str| left.number(&format!("interfaces.{name}.{key}"));
        assert!(of("gap_max_rel") <= gap, "{}", of("gap_max_rel"));
        assert!(
            of("energy_defect_rel") <= 1e-12,
            "{}",
            of("energy_defect_rel")
        );
        assert!(
            of("force_residual_rel") <= 1e-14,
            "{}",
            of("force_residual_rel")
        );
    }
}

#[test]
fn a_regular_row_presses_both_rails_evenly_wherever_it_stands() {
    let modulus = YOUNG_PA * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let load = PRESSURE_PA * WIDTH_M * 1e-3;
    let depth = PRESSURE_PA * HEIGHT_M / modulus;
    let squeeze = 2.0 * PRESSURE_PA * SPACING_M / STIFFNESS_PA + depth;
    for shift in [0.0, 0.3, 4.5, -27.9] {
        let disk = |k: usize| {
            let (x, row) = ((k / 3) as f64 - 4.5 + shift, k % 3);
            let y = 0.3e-3 * row as f64;
            (x * SPACING_M, y, 0.15e-3, ["base", "", "lid"][row])
        };
        let disks: Vec<Disk> = (0..30).map(disk).collect();
        let pressed = format!("boundary = {{ top = {{ pressure_pa = {PRESSURE_PA:e} }} }}");
        let left = run(&[
            head("even", 1e-3, "end_s = 1e-4"),
            rail("lower", "clamped", true, ""),
            grains(Some(HALF), &disks, ""),
            rail("upper", "free", true, &pressed),
            glue("below", ["lower.top", "grains.base"]),
            glue("above", ["upper.bottom", "grains.lid"]),
        ]
        .concat());
        let lower = last(&left, "lower.surface_mean_uy_m");
        let approach = lower - last(&left, "upper.surface_mean_uy_m");
        let found = [
            -last(&left, "below.interface_fy_n") / load,
            last(&left, "above.interface_fy_n") / load,
            -lower / depth,
            last(&left, "lower.surface_min_uy_m") / lower,
            approach / squeeze,
        ];
        println!("{shift}: {found:?} of exact");
        assert!(found.iter().all(|f| (f - 1.0).abs() < 1e-10), "{found:?}");
        ledger_closes(&left, &["below", "above"], 1e-15);
    }
}

/// Grains of three sizes in rows of six on a glued row of the same grains, which fill the strip of 12.5 radii, moved by `shift` (m).
fn heap(shift: f64, fold: bool) -> Vec<Disk> {
    let radius = WIDTH_M / 12.5;
    let disk = |i: u32| {
        let (column, row) = (i % 6, i / 6);
        let x = radius * (2.05 * f64::from(column) + 0.9 * f64::from(row % 2)) + shift;
        let x = if fold { x.rem_euclid(WIDTH_M) } else { x };
        let glued = if row == 0 { "base" } else { "" };
        let own = radius * [0.95, 0.9, 0.8][i as usize % 3];
        (x, 1.85 * radius * f64::from(row), own, glued)
    };
    (0..24).map(disk).collect()
}

/// Signals that do not depend on positions along x, window by window, and the pressure at the nodes.
fn pressed_heap(strip: [f64; 2], disks: &[Disk]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let wheel = "wheel = { load_n = 400.0, mass_kg = 1e-4, radius_m = 0.0, amplitude_m = 2e-6, frequency_hz = 2e4, ramp_s = 2e-5, hold_s = 2e-5, cycles = 0.5 }";
    let left = run(&[
        head("heap", 1e-3, ""),
        rail("rail", "clamped", true, ""),
        grains(Some(strip), disks, wheel),
        glue("base", ["rail.top", "grains.base"]),
    ]
    .concat());
    ledger_closes(&left, &["base"], 1e-15);
    let names = [
        "interface_fx_n",
        "interface_fy_n",
        "rail.surface_mean_uy_m",
        "grains.wheel_y_m",
        "grains.wheel_ft_n",
    ];
    let profile = harness::runs::read_csv(&left.scratch.path().join("profile.csv"));
    let signals = names.map(|name| left.signals[name].clone());
    (signals.to_vec(), profile["pressure_pa"].clone())
}

fn apart(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0f64, |m, v| m.max(v.abs()));
    let difference = largest(&mut one.iter().zip(other).map(|(a, b)| a - b));
    difference / largest(&mut one.iter().copied())
}

/// Tolerance: rounding of places, 1e-16 of the strip over overlaps of 1e-3 of the strip, times the condition of the contacts.
#[test]
fn moving_grains_by_elements_or_cutting_them_elsewhere_changes_no_result() {
    let (signals, pressure) = pressed_heap(HALF, &heap(0.0, false));
    let uneven = apart(&pressure, &[pressure[0]; 10]);
    println!("pressures {pressure:.4?}, uneven by {uneven:.3}");
    assert!(uneven > 0.1, "{uneven}");
    for (elements, fold, left_end) in [
        (0i32, true, 0.0),
        (3, false, -0.5),
        (-7, true, 0.37),
        (40, false, -0.5),
    ] {
        let strip = [left_end * WIDTH_M, left_end * WIDTH_M + WIDTH_M];
        let shift = f64::from(elements) * SPACING_M;
        let (moved, mut other) = pressed_heap(strip, &heap(shift, fold));
        let worst = signals
            .iter()
            .zip(&moved)
            .map(|(a, b)| apart(a, b))
            .fold(0.0, f64::max);
        other.rotate_left(elements.rem_euclid(10) as usize);
        let pressures = apart(&pressure, &other);
        println!("{elements} elements: signals {worst:.1e}, pressures {pressures:.1e}");
        assert!(
            worst < 2e-9 && pressures < 2e-9,
            "{elements}: {worst:e}, {pressures:e}"
        );
    }
}

/// The upper rail slides further than the period; forces and momentum still add up in every window.
#[test]
fn a_layer_is_sheared_by_more_than_its_period() {
    let disk = |k: usize| {
        let (x, row) = ((k / 3) as f64 - 4.5, k % 3);
        let x = x + 0.5 * f64::from(row == 1);
        let y = [0.0, 0.23e-3, 0.46e-3][row];
        (x * SPACING_M, y, 0.15e-3, ["base", "", "lid"][row])
    };
    let disks: Vec<Disk> = (0..30).map(disk).collect();
    let sheared = "boundary = { top = { velocity_m_per_s = [50.0, \"free\"], traction_pa = [\"free\", -1e6], ramp_s = 1e-5 } }\nprobes = [{ name = \"roof\", x_m = 0.0, y_m = 0.0 }]";
    let left = run(&[
        head("round", 1e-3, "end_s = 1.2e-4"),
        rail("lower", "clamped", true, ""),
        grains(Some(HALF), &disks, ""),
        rail("upper", "free", true, sheared),
        glue("below", ["lower.top", "grains.base"]),
        glue("above", ["upper.bottom", "grains.lid"]),
    ]
    .concat());
    // The motion of a window is a small difference of displacements as large as the period.
    ledger_closes(&left, &["below", "above"], 1e-13);
    let slid = last(&left, "upper.roof_ux_m");
    assert!(slid > 1.2 * WIDTH_M, "{slid}");
    let of = |name: &str| &left.signals[name];
    let t = of("t_s");
    for axis in ["x", "y"] {
        let momentum = of(&format!("grains.momentum_{axis}_kg_m_per_s"));
        let [below, above] =
            ["below", "above"].map(|name| of(&format!("{name}.interface_f{axis}_n")));
        let largest = below
            .iter()
            .chain(above)
            .fold(0.0f64, |m, f| m.max(f.abs()));
        for i in 1..t.len() {
            let rate = (momentum[i] - momentum[i - 1]) / (t[i] - t[i - 1]);
            let defect = (below[i] + above[i] + rate).abs();
            assert!(defect < 1e-9 * largest, "window {i}, {axis}: {defect} N");
        }
    }
}

#[test]
fn sides_of_different_period_are_refused() {
    let disks = heap(0.0, false);
    let refused = |repeats: bool, strip: Option<[f64; 2]>| {
        let text = [
            head("odd", 1e-3, "end_s = 1e-6"),
            rail("rail", "clamped", repeats, ""),
            grains(strip, &disks, ""),
            glue("joint", ["rail.top", "grains.base"]),
        ]
        .concat();
        let left = run_in_process(&text, &[]).expect("it can be read");
        assert_eq!(left.ended.summary.value()["exit_code"], 2);
        left.ended.error.expect("it is refused").to_string()
    };
    let wider = [HALF[0], 1.001 * HALF[1]];
    let cases = [
        (
            refused(false, Some(HALF)),
            [
                "`rail.top` has ends",
                "`grains.base` repeats along x after 4.0",
            ],
        ),
        (
            refused(true, None),
            [
                "`rail.top` repeats along x after 4.0",
                "`grains.base` has ends",
            ],
        ),
        (
            refused(true, Some(wider)),
            ["after 4.000000000e-3 m", "after 4.002000000e-3 m"],
        ),
    ];
    for (message, said) in cases {
        for said in said.into_iter().chain([
            "`joint`",
            "rail.top",
            "grains.base",
            "sample.periodic_x_m",
            "mesh.periodic_x",
        ]) {
            assert!(message.contains(said), "no {said} in {message}");
        }
    }
}
