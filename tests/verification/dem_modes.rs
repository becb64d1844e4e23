//! A compliant chain between two walls against its normal modes.
//!
//! ```text
//!   |/\O/\O/\O/\O/\O/\|      n masses m, n + 1 springs kn, all compressed so that no contact opens
//! ```
//!
//! Mode j has the shape sin(i j pi/(n + 1)) and omega_j = 2 sqrt(kn/m) sin(j pi/(2(n + 1))) (Lagrange 1759). Implicit Euler
//! multiplies a mode by (1 +- i h omega)/(1 + h^2 omega^2) per step: the phase turns by atan(h omega) and the amplitude shrinks by
//! 1/sqrt(1 + h^2 omega^2). A chain that starts at its rest positions with the velocity v_0 in one mode is after N steps at
//! (v_0/omega) rho^N sin(N atan(h omega)). Tolerance: rounding of the gaps (1e-19 m) against 1e-10 m of amplitude.

use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, mass, scene};

const N: usize = 6;
const R: f64 = 1e-3;
const STIFFNESS: f64 = 1e9;
const STEP: f64 = 5e-7;
const PRESSED: f64 = 1e-6;
const SPEED: f64 = 1e-3;

fn shape(mode: usize, i: usize) -> f64 {
    ((i + 1) as f64 * mode as f64 * std::f64::consts::PI / (N + 1) as f64).sin()
}

fn place(i: usize) -> f64 {
    (R - PRESSED) + i as f64 * (2.0 * R - PRESSED)
}

fn chain(mode: usize) -> Value {
    let disk = |i: usize| json!({"x_m": place(i), "y_m": 0.0, "radius_m": R, "vx_m_per_s": SPEED * shape(mode, i)});
    let right = place(N - 1) + R - PRESSED;
    json!({
        "kind": "disks", "disks": (0..N).map(disk).collect::<Vec<_>>(),
        "walls": [
            {"x_m": 0.0, "y_m": 0.0, "nx": 1.0, "ny": 0.0},
            {"x_m": right, "y_m": 0.0, "nx": -1.0, "ny": 0.0},
        ],
    })
}

#[test]
fn a_compliant_chain_oscillates_in_its_normal_modes() {
    let law = json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS});
    for mode in 1..=N {
        let quarter = 0.5 * mode as f64 * std::f64::consts::PI / (N + 1) as f64;
        let omega = 2.0 * (STIFFNESS * THICKNESS / mass(R)).sqrt() * quarter.sin();
        let (turn, shrink) = (
            (STEP * omega).atan(),
            1.0 / (1.0 + (STEP * omega).powi(2)).sqrt(),
        );
        let mut dem = build(&scene(law.clone(), STEP, chain(mode), json!({})));
        let reach = SPEED / omega;
        assert!(2.0 * reach < PRESSED, "no contact may open");
        let mut sign_changes = 0;
        let mut before = 0.0;
        for step in 0..200 {
            march(&mut dem, step, 1);
            let done = (step + 1) as f64;
            let expected = reach * shrink.powf(done) * (done * turn).sin();
            for i in 0..N {
                let moved = dem.state().centres[i][0] - place(i);
                let name = format!("mode {mode}, disk {i}, step {step}");
                close(&name, moved, expected * shape(mode, i), 1e-7 * reach);
            }
            sign_changes += usize::from(before * expected < 0.0);
            before = expected;
        }
        assert!(sign_changes >= 1, "mode {mode} must have swung");
    }
}
