//! One bond opened at a prescribed velocity: the participant of the scene `verification/pull-off`.
//!
//! ```text
//!    O  -> V      stress = -r_n / l, work = integral of stress d(opening)
//!    O  fixed
//! ```
//!
//! b = 0, h' = 1: stress Cn u up to u = delta_0 = sqrt(w/Cn), then w^2/(Cn u^3); peak sqrt(w Cn); total work w, of which
//! w delta_0^2/(2 u^2) remains at u. h' = a: all adhesion is lost at delta_0, work w/2. Viscous: b a' = w - a Cn u^2.
//! References: closed forms of Raous, Cangémi and Cocou (1999) with one normal opening, and the project's own tables
//! `reference/czm_pulloff_b0.csv` (the closed form) and `reference/czm_visc_V100_b1e-06.csv` (Runge-Kutta in 60 000 steps).
//! Tolerances: a step opens 3e-4 delta_0 and the scheme is of first order: 1e-3; brittle work may miss one step, 6e-4 w.

use serde_json::{Value, json};

use crate::dem_support::{Report, build, close, march, refusal};

const W: f64 = 60.0;
const CN: f64 = 4e14;
const STEPS: u32 = 100_000;

/// The node's keys of the scene `verification/pull-off`.
fn scene() -> Value {
    json!({
        "density_kg_per_m3": 7800.0,
        "solver": {"kind": "nsgs", "tolerance": 1e-10, "max_iterations": 100, "min_iterations": 1},
        "time": {"pressure_pa": 1e8},
        "drive": {"velocity_m_per_s": 0.1},
        "law": {
            "kind": "cohesion", "friction": 0.3, "contact_stiffness_pa": 1.4e10, "tangential_stiffness_ratio": 0.5,
            "cn_pa_per_m": CN, "ct_pa_per_m": 0.5 * CN, "w_j_per_m2": W, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one",
            "alert_m": 1e-6,
        },
        "sample": {"kind": "disks", "disks": [
            {"x_m": 0.0, "y_m": 0.14e-3, "radius_m": 0.07e-3},
            {"x_m": 0.0, "y_m": 0.0, "radius_m": 0.07e-3, "glued": true},
        ]},
    })
}

fn critical() -> f64 {
    (W / CN).sqrt()
}

/// Opening, adhesion, stress and work every `every` steps of the scene.
fn pull(config: &Value, steps: u32, every: u32) -> Vec<[f64; 4]> {
    let mut dem = build(config);
    (0..steps / every)
        .map(|k| row(&march(&mut dem, u64::from(k * every), every)))
        .collect()
}

fn row(report: &Report) -> [f64; 4] {
    ["opening_m", "adhesion", "stress_pa", "work_j_per_m2"].map(|name| report.signal(name))
}

/// The rows of numbers of a table; lines with `#` and the header are skipped.
fn table(text: &str) -> Vec<Vec<f64>> {
    let numbers = |line: &str| line.split(',').map(str::parse).collect::<Result<_, _>>();
    text.lines().filter_map(|line| numbers(line).ok()).collect()
}

/// The value of a column at an opening, interpolated between the rows.
fn at(rows: &[[f64; 4]], opening: f64, column: usize) -> f64 {
    let after = rows.partition_point(|row| row[0] < opening);
    let before = match after {
        0 => [0.0, 1.0, 0.0, 0.0],
        after => rows[after - 1],
    };
    let after = rows[after.min(rows.len() - 1)];
    let part = (opening - before[0]) / (after[0] - before[0]);
    before[column] + part * (after[column] - before[column])
}

#[test]
fn a_bond_without_viscosity_follows_the_closed_form_and_takes_w() {
    let rows = pull(&scene(), STEPS, 4);
    let strength = (W * CN).sqrt();
    let peak = rows.iter().map(|row| row[2]).fold(0.0, f64::max);
    close("strength", peak, strength, 5e-3 * strength);
    let mut compared = 0;
    for line in table(include_str!("reference/czm_pulloff_b0.csv")) {
        let opening = line[0] * 1e-3;
        if opening > 0.0 && opening < 30.0 * critical() {
            close("adhesion", at(&rows, opening, 1), line[1], 1e-3 * line[1]);
            let stress = line[2] * 1e6;
            // The tip of the curve lies between two rows.
            close("stress", at(&rows, opening, 2), stress, 4e-3 * stress);
            close("work", at(&rows, opening, 3), line[3] * 1e3, 1e-3 * W);
            compared += 1;
        }
    }
    assert!(compared >= 19, "{compared} rows");
    let last = rows[rows.len() - 1];
    close("end", last[0], 30.0 * critical(), 1e-8 * critical());
    close("work", last[3], W * (1.0 - 0.5 / 900.0), 1e-4 * W);
}

#[test]
fn a_brittle_bond_takes_half_of_w() {
    let mut config = scene();
    config["law"]["h_prime"] = json!("adhesion");
    let rows = pull(&config, 10_000, 1);
    let strength = (W * CN).sqrt();
    let peak = rows.iter().map(|row| row[2]).fold(0.0, f64::max);
    close("strength", peak, strength, 3e-4 * strength);
    let last = rows[rows.len() - 1];
    assert_eq!((last[1], last[2]), (0.0, 0.0), "it is broken");
    close("work", last[3], 0.5 * W, 6e-4 * W);
}

#[test]
fn a_viscous_bond_follows_its_differential_equation() {
    let mut config = scene();
    config["law"]["b_pa_m_s"] = json!(1e-3);
    let rows = pull(&config, STEPS, 20);
    let mut compared = 0;
    for line in table(include_str!("reference/czm_visc_V100_b1e-06.csv")) {
        let opening = line[1] * 1e-3;
        if opening > 0.0 && opening <= 30.0 * critical() {
            close("adhesion", at(&rows, opening, 1), line[2], 1e-3 * line[2]);
            close(
                "stress",
                at(&rows, opening, 2),
                line[3] * 1e6,
                2e-3 * line[3] * 1e6,
            );
            close(
                "work",
                at(&rows, opening, 3),
                line[4] * 1e3,
                1e-3 * line[4] * 1e3,
            );
            compared += 1;
        }
    }
    assert!(compared >= 90, "{compared} rows");
}

/// Adhesion at 3 delta_0 for V = 0.1 m/s, b = 1e-3 Pa m s, with n steps of the law itself.
fn adhesion_in(steps: u32) -> f64 {
    let law = dem_kernel::law::cohesion::Cohesion {
        normal: CN,
        tangential: 0.0,
        energy: W,
        viscosity: 1e-3,
        power: 1.0,
        h_prime: dem_kernel::law::cohesion::HPrime::One,
        thickness: 1e-3,
        alert: 1e-6,
        bonds_min: 0,
        damping: 0.0,
    };
    let end = 3.0 * critical();
    let h = end / 0.1 / f64::from(steps);
    (1..=steps).fold(1.0, |a, k| {
        law.adhesion_after(a, law.drive(end * f64::from(k) / f64::from(steps), 0.0), h)
    })
}

#[test]
fn viscous_decohesion_converges_at_first_order() {
    let exact = 2.0 * adhesion_in(480_000) - adhesion_in(240_000);
    // Multiples of 3: the decohesion begins at the end of a step.
    let error = [150, 300, 600, 1200].map(|steps| (adhesion_in(steps) - exact).abs());
    for pair in error.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        close("order", order, 1.0, 0.05);
    }
}

#[test]
fn a_bond_that_closes_keeps_its_adhesion_and_presses() {
    let mut config = scene();
    config["drive"]["velocity_m_per_s"] = json!(-0.1);
    let mut dem = build(&config);
    let report = march(&mut dem, 0, STEPS);
    let [opening, adhesion, stress, work] = row(&report);
    close("opening", opening, -30.0 * critical(), 1e-8 * critical());
    assert_eq!(adhesion, 1.0);
    // kn = l Cn in this scene.
    close("stress", stress, CN * opening, 1e-9 * CN * critical());
    close("work", work, 0.5 * CN * opening * opening, 1e-6 * W);
    assert!(report.imbalance(0.0) < 1e-6);
}

#[test]
fn a_bond_lasts_beyond_the_reach_of_detection() {
    let mut config = scene();
    config["law"]["cn_pa_per_m"] = json!(4e13);
    config["law"]["w_j_per_m2"] = json!(600.0);
    let mut dem = build(&config);
    let [opening, _, stress, work] = row(&march(&mut dem, 0, STEPS));
    assert!(opening > 100e-6, "skin and alert are 16 um: {opening}");
    let expected = 600.0f64.powi(2) / (4e13 * opening.powi(3));
    close("stress", stress, expected, 1e-3 * expected);
    close("work", work, 600.0 * (1.0 - 0.5 / 900.0), 0.06);
}

#[test]
fn impossible_drives_and_bonds_are_refused_by_name() {
    let refused = |change: fn(&mut Value)| {
        let mut config = scene();
        change(&mut config);
        refusal(&config)
    };
    let says = |message: String, words: [&str; 2]| {
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    says(
        refused(|c| c["drive"]["velocity_m_per_s"] = json!(0.0)),
        ["drive.velocity_m_per_s", "not be 0"],
    );
    says(
        refused(|c| c["law"]["w_j_per_m2"] = json!(0.0)),
        ["law.w_j_per_m2", "above 0"],
    );
    says(
        refused(|c| c["law"]["b_pa_m_s"] = json!(-1.0)),
        ["law.b_pa_m_s", "at least"],
    );
    says(
        refused(|c| c["law"]["h_prime"] = Value::Null),
        ["law.h_prime", "missing"],
    );
    says(
        refused(|c| c["law"]["p"] = Value::Null),
        ["law.p", "missing"],
    );
    says(
        refused(|c| c["law"]["contact_stiffness_pa"] = Value::Null),
        ["law.tangential_stiffness_ratio", "rigid"],
    );
    says(
        refused(|c| c["time"]["step_s"] = json!(1e-9)),
        ["time.step_s", "drive.velocity_m_per_s"],
    );
    says(
        refused(|c| c["sample"]["disks"][1]["glued"] = json!(false)),
        ["drive", "glued = true"],
    );
    says(
        refused(|c| c["sample"]["disks"][0]["vx_m_per_s"] = json!(1.0)),
        ["sample.disks[0].vx_m_per_s: has no effect", "drive"],
    );
    says(
        refused(|c| c["sample"]["disks"][0]["y_m"] = json!(0.0)),
        ["sample.disks[1]", "sample.disks[0]"],
    );
    says(
        refused(|c| c["law"]["bonds_min"] = json!(7)),
        ["law.bonds_min", "7"],
    );
    says(
        refused(|c| c["law"] = json!({"kind": "coulomb", "friction": 0.3, "bonds_min": 2})),
        ["law.bonds_min", "cohesion"],
    );
    says(
        refused(|c| c["law"]["kind"] = json!("coulomb")),
        ["law.cn_pa_per_m", "cohesion"],
    );
}
