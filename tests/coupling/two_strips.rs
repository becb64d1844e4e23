//! Two elastic strips with a row of grains between them ("Two FE bodies and a sheared layer" of the coupling page).
//!
//! Problem: the lower strip is held at its base, and in x at its sides. Ten disks are glued on its top in the middle of its
//! elements. On each disk rests a grain, and on each grain a disk that is glued to the bottom of the upper strip. Only the
//! grains hold the upper strip in y. A pressure acts on its top; mass damping brings all to rest.
//!
//! ```text
//!      | | | | | p
//!     |~~~~~~~~~|  upper strip, free base
//!      o o o o o   lid, glued to its bottom
//!      O O O O O   grains, contact stiffness kn
//!      o o o o o   base, glued to the top of the
//!     |~~~~~~~~~|  lower strip, clamped base
//! ```
//!
//! Exact answer: uniaxial strain. Both interfaces carry p; the lower strip is compressed by u = p L / M with M = E (1 - nu) /
//! ((1 + nu)(1 - 2 nu)). The top of the upper one sinks further, by twice the overlap p dx t / kn and by its own compression u. Tolerance
//! 1e-3 as in the static patch: the disks disturb a uniform traction by the mapping's ripple.

use harness::runs::{Left, run_both_ways, run_in_process, run_over_shared_memory};
use harness::scene::{POISSON, SPACING_M, YOUNG_PA, head, interface, participant, strip};

const PRESSURE_PA: f64 = 100e6;
const HEIGHT_M: f64 = 2e-3;
const STIFFNESS_PA: f64 = 1e11;

/// A damped strip between walls, with its own step.
fn damped(name: &str, base: &str, step_s: f64, keys: &str) -> String {
    let time = format!(
        "time = {{ step_s = {step_s:?}, damping = 0.5, mass_damping_per_s = 6e5 }}\n{keys}"
    );
    strip(name, [base, "fixed_x"], HEIGHT_M, &time)
}

fn grains() -> String {
    let disk = |i: usize, row: usize| {
        let radius = 0.15e-3;
        let (x, y) = ((i as f64 - 4.5) * SPACING_M, 2.0 * radius * row as f64);
        let glued = match row {
            0 => ", glued = true",
            2 => ", glued = true, lid = true",
            _ => "",
        };
        format!("{{ x_m = {x:e}, y_m = {y:e}, radius_m = {radius:e}{glued} }}")
    };
    let disks: Vec<String> = (0..30).map(|k| disk(k / 3, k % 3)).collect();
    let keys = format!(
        r#"
density_kg_per_m3 = 7800.0
law = {{ kind = "coulomb", friction = 0.3, contact_stiffness_pa = {STIFFNESS_PA:e}, tangential_stiffness_ratio = 1.0 }}
solver = {{ kind = "nsgs", tolerance = 1e-10, max_iterations = 100000, min_iterations = 1 }}
time = {{ pressure_pa = 1e6 }}
sample = {{ kind = "disks", disks = [{}] }}
"#,
        disks.join(", ")
    );
    participant("grains", "dem", &keys)
}

fn scenario(lower: &str) -> String {
    let pressed = format!("boundary = {{ top = {{ pressure_pa = {PRESSURE_PA:e} }} }}");
    let (below, above) = (["lower.top", "grains.base"], ["upper.bottom", "grains.lid"]);
    let tolerance = "tolerance_rel = 1e-9";
    [
        head("two-strips", 1e-3, "end_s = 6e-5"),
        damped("lower", "clamped", 5e-8, lower),
        grains(),
        damped("upper", "free", 2.5e-8, &pressed),
        interface("below", below, "dual-schur", 4, tolerance),
        interface("above", above, "dual-schur", 8, tolerance),
    ]
    .concat()
}

fn holds(left: &Left) {
    let last = |name: &str| *left.signals[name].last().expect("there are windows");
    let modulus = YOUNG_PA * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let area = 4e-3 * 1e-3;
    let (below, above) = (last("below.interface_fy_n"), last("above.interface_fy_n"));
    let lower = last("lower.surface_mean_uy_m");
    let overlap = PRESSURE_PA * SPACING_M * 1e-3 / (STIFFNESS_PA * 1e-3);
    let squeeze = 2.0 * overlap + PRESSURE_PA * HEIGHT_M / modulus;
    let approach = (lower - last("upper.surface_mean_uy_m")) / squeeze;
    let displacement = -lower / (PRESSURE_PA * HEIGHT_M / modulus);
    println!(
        "below {:.6}, above {:.6}, displacement {displacement:.6}, approach {approach:.6} of exact, gap {:.1e}",
        -below / (PRESSURE_PA * area),
        above / (PRESSURE_PA * area),
        left.number("coupling.gap_max_rel")
    );
    for found in [
        -below / (PRESSURE_PA * area),
        above / (PRESSURE_PA * area),
        displacement,
        approach,
    ] {
        assert!((found - 1.0).abs() <= 1e-3, "{found}");
    }
    for name in ["below", "above"] {
        assert!(left.number(&format!("interfaces.{name}.gap_max_rel")) <= 1e-12);
        assert!(left.number(&format!("interfaces.{name}.force_residual_rel")) <= 1e-12);
    }
    assert!(left.number("results.energy_balance_rel") <= 1e-6);
}

#[test]
fn a_row_of_grains_carries_the_pressure_from_strip_to_strip() {
    holds(
        &run_in_process(&scenario(""), &[])
            .expect("it is valid")
            .completed(),
    );
}

#[test]
fn the_same_over_shared_memory() {
    holds(
        &run_over_shared_memory(&scenario(""), &[])
            .expect("it is valid")
            .completed(),
    );
}

/// The lower strip as few modes: in the end it is in equilibrium.
#[test]
fn the_lower_strip_may_be_its_modes() {
    holds(&run_both_ways(&scenario("reduced = { modes = 12 }"), &[]));
}
