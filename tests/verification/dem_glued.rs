//! Glued disks on a compliant wall, v_g = a_g + W_g p.
//!
//! ```text
//!     O    grain, mass m, pressed down by its weight
//!     o    glued disk, massless, on a wall with the 2x2 compliance W_g
//! ```
//!
//! One contact, so the window is a 2x2 linear complementarity problem, solved by hand: with
//! W = diag(1/m, 3/m) + W_g in the contact frame and b = H^T v_free, sticking gives r = -W^-1 b, sliding
//! r_n = -b_n / (W_nn + s mu W_nt), r_t = s mu r_n. The force on the wall is -r / h, and v_g = a_g - W_g r.
//! Tolerance: rounding.

use protocol::{FaultCode, Node, Window};
use serde_json::{Value, json};

use crate::dem_support::{self, build, close, mass, refusal, scene};

const RADIUS: f64 = 1e-3;
const G: f64 = 9.81;
const H: f64 = 1e-4;

fn grain_on_glued(law: Value) -> Value {
    let disks = json!([
        {"x_m": 0.0, "y_m": RADIUS, "radius_m": RADIUS},
        {"x_m": 0.0, "y_m": -RADIUS, "radius_m": RADIUS, "glued": true},
    ]);
    let mut config = scene(
        law,
        H,
        json!({"kind": "disks", "disks": disks}),
        json!({"gravity_m_per_s2": [0.0, -G]}),
    );
    config["time"] = json!({"pressure_pa": 1.0});
    config
}

/// A grain without glued disks.
fn loose() -> Value {
    let disks = json!([{"x_m": 0.0, "y_m": RADIUS, "radius_m": RADIUS}]);
    let sample = json!({"kind": "disks", "disks": disks});
    scene(json!({"kind": "signorini"}), H, sample, json!({}))
}

fn window(index: u64) -> Window {
    dem_support::window(index, H)
}

/// Answer (force on the wall, v_g) of one window with this symmetric W_g = (xx, xy, yy) and a_g.
fn one_window(law: Value, w_g: [f64; 3], a_g: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
    let mut dem = build(&grain_on_glued(law));
    dem.couple("base").expect("it is glued");
    dem.set_boundary(H, &[w_g[0], w_g[1], w_g[1], w_g[2]])
        .expect("2 x 2 numbers");
    let answer = dem.solve(&window(0), &a_g).expect("it can be solved");
    // With a correct 2x2 block one sweep solves the only contact; the second finds nothing to change.
    assert!(answer.converged && answer.iterations <= 2, "{answer:?}");
    (answer.force, answer.velocity)
}

#[test]
fn a_frictionless_grain_presses_the_wall_as_computed_by_hand() {
    let m = mass(RADIUS);
    let w_g = [2.0 / m, 0.4 / m, 0.7 / m];
    let a_g = [0.3e-3, 0.2e-3];
    let (force, velocity) = one_window(json!({"kind": "signorini"}), w_g, a_g);
    let r = (H * G + a_g[1]) / (1.0 / m + w_g[2]);
    close("force x", force[0], 0.0, 0.0);
    close("force y", force[1], -r / H, 1e-12 * r / H);
    close("v_g x", velocity[0], a_g[0] - w_g[1] * r, 1e-15);
    close("v_g y", velocity[1], a_g[1] - w_g[2] * r, 1e-15);
}

#[test]
fn the_compliances_of_contact_and_wall_add_up() {
    let m = mass(RADIUS);
    let kn = 1e9 * 1e-3;
    let law = json!({"kind": "signorini", "contact_stiffness_pa": 1e9});
    let (force, _) = one_window(law, [0.0, 0.0, 0.7 / m], [0.0, 0.0]);
    let r = H * G / (1.7 / m + 1.0 / (kn * H * H));
    close("force y", force[1], -r / H, 1e-12 * r / H);
}

/// Impulse (r_x, r_y) of the wall on the grain by the closed 2x2 solution, in x and y: n = +y, t = -x.
fn by_hand(w_g: [f64; 3], a_g: [f64; 2], friction: f64) -> [f64; 2] {
    let m = mass(RADIUS);
    let (w_nn, w_tt, w_nt) = (1.0 / m + w_g[2], 3.0 / m + w_g[0], -w_g[1]);
    let (b_n, b_t) = (-H * G - a_g[1], a_g[0]);
    let determinant = w_nn * w_tt - w_nt * w_nt;
    let r_n = -(w_tt * b_n - w_nt * b_t) / determinant;
    let r_t = -(w_nn * b_t - w_nt * b_n) / determinant;
    if r_t.abs() <= friction * r_n {
        return [-r_t, r_n];
    }
    let s = r_t.signum();
    let r_n = -b_n / (w_nn + s * friction * w_nt);
    [-s * friction * r_n, r_n]
}

#[test]
fn a_frictional_grain_sticks_or_slides_as_computed_by_hand() {
    let m = mass(RADIUS);
    let w_g = [2.0 / m, 0.4 / m, 0.7 / m];
    for a_g in [[0.1e-3, 0.0], [5e-3, 0.2e-3], [-5e-3, 0.2e-3]] {
        let law = json!({"kind": "coulomb", "friction": 0.3});
        let (force, velocity) = one_window(law, w_g, a_g);
        let [x, y] = by_hand(w_g, a_g, 0.3);
        close("force x", force[0], -x / H, 1e-12 * y / H);
        close("force y", force[1], -y / H, 1e-12 * y / H);
        close(
            "v_g x",
            velocity[0],
            a_g[0] - w_g[0] * x - w_g[1] * y,
            1e-15,
        );
        close(
            "v_g y",
            velocity[1],
            a_g[1] - w_g[1] * x - w_g[2] * y,
            1e-15,
        );
    }
}

#[test]
fn an_impulse_on_one_glued_disk_moves_the_other() {
    let m = mass(RADIUS);
    let mut config = grain_on_glued(json!({"kind": "signorini"}));
    let disks = config["sample"]["disks"].as_array_mut().expect("a list");
    disks.push(
        json!({"x_m": 0.5 * RADIUS, "y_m": -8.0 * RADIUS, "radius_m": RADIUS, "glued": true}),
    );
    let mut dem = build(&config);
    let surface = dem.couple("base").expect("two are glued");
    assert_eq!(surface.x_m, [0.0, 0.5 * RADIUS]);
    assert_eq!(surface.length_m, [0.5 * RADIUS, 0.5 * RADIUS]);
    let mut w_g = [0.0; 16];
    w_g[5] = 1.0 / m;
    (w_g[7], w_g[13]) = (0.25 / m, 0.25 / m);
    w_g[15] = 1.0 / m;
    dem.set_boundary(H, &w_g).expect("4 x 4 numbers");
    let answer = dem.solve(&window(0), &[0.0; 4]).expect("it can be solved");
    let r = H * G / (2.0 / m);
    close("v_g of the loaded disk", answer.velocity[1], -r / m, 1e-15);
    close("v_g of the other", answer.velocity[3], -0.25 * r / m, 1e-15);
}

/// Each point of a surface carries half the distances to its neighbours along x; a row of which all points have one x is upright.
#[test]
fn glued_disks_above_each_other_are_refused_as_a_surface() {
    let mut config = grain_on_glued(json!({"kind": "signorini"}));
    let disks = config["sample"]["disks"].as_array_mut().expect("a list");
    for x in [0.0, 3.0 * RADIUS] {
        disks.push(json!({"x_m": x, "y_m": -8.0 * RADIUS, "radius_m": RADIUS, "glued": true}));
    }
    let error = build(&config).couple("base").expect_err("no length");
    assert!(error.to_string().contains("`base` at x = 0e0 m"), "{error}");
}

#[test]
fn a_repeated_window_leaves_no_trace() {
    let law = json!({
        "kind": "coulomb", "friction": 0.3,
        "contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5,
    });
    let m = mass(RADIUS);
    let run = |repeats: &[[f64; 2]]| {
        let mut dem = build(&grain_on_glued(law.clone()));
        dem.couple("base").expect("it is glued");
        dem.set_boundary(H, &[1.0 / m, 0.2 / m, 0.2 / m, 1.0 / m])
            .expect("2 x 2 numbers");
        let mut reports = Vec::new();
        for index in 0..20 {
            for a_g in repeats {
                dem.solve(&window(index), a_g).expect("it can be solved");
            }
            dem.solve(&window(index), &[1e-4, 0.0])
                .expect("it can be solved");
            let moved = [1e-8 * (index + 1) as f64, 0.0];
            reports.push(dem.commit(&window(index), &moved).expect("it was solved"));
        }
        (reports, dem.finish().expect("it finishes").state_hash)
    };
    assert_eq!(run(&[]), run(&[[0.3, -2.0], [0.0, 0.5]]));
}

#[test]
fn commit_places_the_glued_disks_at_the_given_displacement() {
    let mut dem = build(&grain_on_glued(json!({"kind": "signorini"})));
    dem.couple("base").expect("it is glued");
    dem.set_boundary(H, &[0.0; 4]).expect("2 x 2 numbers");
    dem.solve(&window(0), &[0.0; 2]).expect("it can be solved");
    dem.commit(&window(0), &[1e-6, -2e-6])
        .expect("it was solved");
    assert_eq!(dem.state().centres[1], [1e-6, -RADIUS - 2e-6]);
    let error = dem
        .commit(&window(0), &[0.0; 2])
        .expect_err("nothing is pending");
    assert_eq!(error.code, FaultCode::Protocol);
}

#[test]
fn a_starved_solver_reports_it_when_coupled_and_stops_an_uncoupled_run() {
    let stack =
        |i: usize| json!({"x_m": 0.0, "y_m": RADIUS * (2 * i + 1) as f64, "radius_m": RADIUS});
    let mut disks: Vec<Value> = (0..10).map(stack).collect();
    disks.push(json!({"x_m": 0.0, "y_m": -RADIUS, "radius_m": RADIUS, "glued": true}));
    let mut config = grain_on_glued(json!({"kind": "signorini"}));
    config["sample"]["disks"] = json!(disks);
    config["solver"] =
        json!({"kind": "nsgs", "tolerance": 1e-4, "max_iterations": 3, "min_iterations": 1});
    let mut dem = build(&config);
    dem.couple("base").expect("it is glued");
    dem.set_boundary(H, &[0.0; 4]).expect("2 x 2 numbers");
    let answer = dem.solve(&window(0), &[0.0; 2]).expect("an answer");
    assert!(!answer.converged && answer.residual > 1e-2, "{answer:?}");
    assert_eq!(answer.iterations, 3);

    config["time"]["step_s"] = json!(H);
    let error = build(&config).advance_alone(&Window {
        substeps: 1,
        ..Window::default()
    });
    let error = error.expect_err("three sweeps do not carry ten disks");
    assert_eq!(error.code, FaultCode::Diverged);
    assert!(
        error.message.contains("window 0") && error.message.contains("max_iterations"),
        "{error}"
    );
}

#[test]
fn a_wall_that_moves_against_its_force_is_refused() {
    let mut dem = build(&grain_on_glued(json!({"kind": "signorini"})));
    dem.couple("base").expect("it is glued");
    let error = dem
        .set_boundary(H, &[1.0, 0.0, 0.0, -1.0])
        .expect_err("the diagonal is negative");
    assert!(error.message.contains("diagonal"), "{error}");
    let coupled = dem.set_boundary(H, &[1.0, 9e9, 9e9, 1.0]);
    coupled.expect("only a contact shows it");
    let error = dem
        .solve(&window(0), &[0.0; 2])
        .expect_err("W_nt is larger than W_nn");
    assert!(error.message.contains("W_nn"), "{error}");
}

#[test]
fn keys_of_an_uncoupled_run_are_refused_when_coupled() {
    for (key, value) in [("theta", json!(0.5)), ("step_s", json!(H))] {
        let mut config = grain_on_glued(json!({"kind": "signorini"}));
        config["time"][key] = value;
        let error = build(&config)
            .couple("base")
            .expect_err("it cannot be coupled");
        assert_eq!(error.code, FaultCode::Configuration);
        assert!(error.message.contains(&format!("time.{key}")), "{error}");
    }
    let mut config = grain_on_glued(json!({"kind": "signorini"}));
    config["sample"]["disks"][1]["y_m"] = json!(-0.9 * RADIUS);
    assert!(
        refusal(&config).contains("overlap"),
        "rigid disks may not start in each other"
    );
}

/// A grain between two glued rows that approach each other. With r_1, r_2 the impulses below and above it, contact stays closed:
/// (r_1 - r_2) / m = a_b - w_b r_1 below and a_l + w_l r_2 = (r_1 - r_2) / m above.
#[test]
fn a_grain_between_base_and_lid_is_squeezed_as_computed_by_hand() {
    let m = mass(RADIUS);
    let mut config = grain_on_glued(json!({"kind": "signorini"}));
    config["gravity_m_per_s2"] = json!([0.0, 0.0]);
    let lid =
        json!({"x_m": 0.0, "y_m": 3.0 * RADIUS, "radius_m": RADIUS, "glued": true, "lid": true});
    let disks = config["sample"]["disks"].as_array_mut().expect("a list");
    disks.push(lid);
    let mut dem = build(&config);
    assert_eq!(dem.describe().sets, ["base", "lid"]);
    let (w_b, w_l, a_b, a_l) = (0.7 / m, 0.4 / m, 0.3e-3, -0.2e-3);
    // (1/m + w_b) r_1 - r_2 / m = a_b and -r_1 / m + (1/m + w_l) r_2 = -a_l.
    let (below, above) = (1.0 / m + w_b, 1.0 / m + w_l);
    let determinant = below * above - 1.0 / (m * m);
    let r_1 = (above * a_b - a_l / m) / determinant;
    let r_2 = (-below * a_l + a_b / m) / determinant;

    // The lid is coupled first, so it comes first in every vector.
    dem.couple("lid").expect("it is glued");
    dem.couple("base").expect("it is glued");
    let mut compliance = [0.0; 16];
    (compliance[5], compliance[15]) = (w_l, w_b);
    dem.set_boundary(H, &compliance).expect("4 x 4 numbers");
    let answer = dem
        .solve(&window(0), &[0.0, a_l, 0.0, a_b])
        .expect("it can be solved");
    assert!(answer.converged);
    close("force on the lid", answer.force[1], r_2 / H, 1e-9 * r_2 / H);
    close(
        "force on the base",
        answer.force[3],
        -r_1 / H,
        1e-9 * r_1 / H,
    );
    close("v of the lid", answer.velocity[1], a_l + w_l * r_2, 1e-12);
    close("v of the base", answer.velocity[3], a_b - w_b * r_1, 1e-12);
}

/// Glued disks are described by the masses m = rho pi r^2 b times the factor on the inertia of the grains, row by row and by
/// ascending x; their surface has no mass.
#[test]
fn glued_disks_declare_masses_that_their_surface_does_not_have() {
    let mut config = grain_on_glued(json!({"kind": "signorini"}));
    config["mass_scale"] = json!(50.0);
    let rows = [(-3.0, 0.5, false), (3.0, 0.8, true), (6.0, 0.6, true)];
    let disks = config["sample"]["disks"].as_array_mut().expect("a list");
    for (x, radius, lid) in rows {
        disks.push(
            json!({"x_m": x * RADIUS, "y_m": 5.0 * RADIUS, "radius_m": radius * RADIUS, "glued": true, "lid": lid}),
        );
    }
    let mut dem = build(&config);
    let declared = dem.describe().point_mass_kg;
    let expected = [("base", vec![0.5, 1.0]), ("lid", vec![0.8, 0.6])];
    assert_eq!(declared.len(), 2);
    for (set, radii) in expected {
        assert_eq!(declared[set].len(), radii.len());
        for (found, radius) in declared[set].iter().zip(radii) {
            let expected = 50.0 * mass(radius * RADIUS);
            close(set, *found, expected, 1e-12 * expected);
        }
        let surface = dem.couple(set).expect("it is glued");
        assert!(surface.mass_kg.iter().all(|mass| *mass == 0.0));
    }
    assert!(build(&loose()).describe().point_mass_kg.is_empty());
}

#[test]
fn an_uncoupled_lid_stays_where_it_is() {
    let mut config = grain_on_glued(json!({"kind": "signorini"}));
    let lid =
        json!({"x_m": 0.0, "y_m": 3.0 * RADIUS, "radius_m": RADIUS, "glued": true, "lid": true});
    let disks = config["sample"]["disks"].as_array_mut().expect("a list");
    disks.push(lid);
    let mut dem = build(&config);
    dem.couple("base").expect("it is glued");
    dem.set_boundary(H, &[0.0; 4]).expect("2 x 2 numbers");
    // The base pushes the grain against a rigid lid: nothing can move.
    let free = dem
        .solve(&window(0), &[0.0, 0.0])
        .expect("it can be solved");
    assert_eq!(free.force.len(), 2);
    let refused = dem.couple("lid").and(dem.couple("lid"));
    let error = refused.expect_err("it is coupled already");
    assert!(error.message.contains("already"), "{error}");
}
