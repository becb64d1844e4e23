//! The main job, `thirdbody run quick`, as a user runs it: three processes, shared memory, one command.
//!
//! Its claims are exact, or the solvers' tolerances bound them: the interface carries the wheel's load, forces and
//! momentum balance to rounding, friction stays inside Coulomb's cone, the gap is closed, the energy balances.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use harness::runs::read_csv;
use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::Value;

const LOAD_N: f64 = 8000.0;
const FRICTION: f64 = 0.3;

fn number(summary: &Value, path: &str) -> f64 {
    let value = path.split('.').fold(summary, |value, key| &value[key]);
    value
        .as_f64()
        .unwrap_or_else(|| panic!("no number {path} in {summary:#}"))
}

fn distinct_pids(log: &str) -> usize {
    let pids: BTreeSet<&str> = log
        .lines()
        .filter_map(|line| line.split("pid ").nth(1))
        .filter_map(|rest| rest.split([',', ' ']).next())
        .collect();
    pids.len()
}

/// Runs a shipped scene; returns its summary, its run directory and the coordinator's log.
fn run_scene(work: &Scratch, name: &str) -> (Value, PathBuf, String) {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
    let out = work.path().join("out");
    let mut command = thirdbody(work.path());
    command
        .arg("run")
        .arg(scenes.join(name))
        .arg("--out")
        .arg(&out)
        .arg("--json");
    let output = command.output().expect("the program starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let log = std::fs::read_to_string(out.join("logs/coordinator.log")).expect("it was written");
    (parse_json(&output.stdout), out, log)
}

#[test]
fn quick_carries_the_load_through_three_processes() {
    let work = Scratch::new("quick");
    let (summary, out, log) = run_scene(&work, "quick");
    assert_eq!(summary["status"], "completed");
    assert_eq!(distinct_pids(&log), 3, "{log}");

    let force = number(&summary, "results.interface_force_n");
    // The layer still rings a little at the end of the hold: 6.2e-4 and 3.9e-4.
    assert!(
        (force / LOAD_N - 1.0).abs() <= 8e-4,
        "interface force {force}"
    );
    let wheel = number(&summary, "results.wheel_force_n");
    assert!(
        (force / wheel - 1.0).abs() <= 5e-4,
        "interface {force}, wheel {wheel}"
    );
    assert!(number(&summary, "coupling.gap_max_rel") <= 1e-15);
    assert!(number(&summary, "coupling.energy_defect_rel") <= 1e-12);
    assert!(number(&summary, "coupling.force_residual_rel") <= 1e-14);
    // The contact solver's tolerance of 1e-4 leaves 5.9e-7.
    assert!(number(&summary, "results.energy_balance_rel") <= 2e-6);
    assert!(number(&summary, "participants.rail.energy_balance_rel") <= 1e-13);
    assert!(number(&summary, "results.true_residual_max") <= 1e-4);
    assert_eq!(number(&summary, "coupling.not_converged_windows"), 0.0);

    let wall = number(&summary, "wall_s");
    for name in ["rail", "third-body"] {
        let of = |key: &str| number(&summary, &format!("participants.{name}.{key}"));
        let spent_s = of("setup_wall_s") + of("solve_wall_s") + of("wait_s");
        assert!(
            spent_s <= 1.02 * wall && spent_s >= 0.7 * wall,
            "{name}: set-up, solves and waits take {spent_s} s of {wall} s"
        );
    }
    let coupling = number(&summary, "coupling.wall_s");
    let share = number(&summary, "coupling.share");
    assert!(coupling > 0.0 && coupling < wall, "{coupling} of {wall} s");
    assert!(
        (0.0..1.0).contains(&share) && share >= coupling / wall,
        "{share}"
    );

    let signals = read_csv(&out.join("signals.csv"));
    let of = |name: &str| &signals[&format!("third-body.{name}")];
    let (normal, tangential) = (of("wheel_fn_n"), of("wheel_ft_n"));
    for (n, t) in normal.iter().zip(tangential) {
        assert!(
            t.abs() <= FRICTION * n * (1.0 + 1e-9) + 1e-9,
            "F_T = {t}, F_N = {n}"
        );
    }
    // Vertical momentum of the free grains: only the wall pushes up, only the wheel pushes down.
    let (wall, momentum) = (&signals["interface_fy_n"], of("momentum_y_kg_m_per_s"));
    let t = &signals["t_s"];
    for i in 1..wall.len() {
        // The last window is shorter than the others.
        let rate = (momentum[i] - momentum[i - 1]) / (t[i] - t[i - 1]);
        let defect = -wall[i] - normal[i] - rate;
        assert!(defect.abs() <= 1e-9 * LOAD_N, "window {i}: {defect} N");
    }
}

#[test]
fn a_solver_without_interface_runs_alone() {
    let work = Scratch::new("alone");
    let (summary, _, log) = run_scene(&work, "layer-alone");
    assert_eq!(distinct_pids(&log), 2, "{log}");
    assert!(summary.get("coupling").is_none());
    let wheel = number(&summary, "results.wheel_force_n");
    assert!((wheel / LOAD_N - 1.0).abs() <= 1e-3, "wheel force {wheel}");
}
