//! Problem: Rayleigh damping C = c M + beta K: standing waves of a periodic strip decay; a block gets an impulse, at steps
//! around its stability limit.
//! Exact: a mode omega has the damping ratio xi = (c/omega + beta omega)/2. The scheme applies beta K to the mean velocity of
//! the last step. For b = 1/2 and c = 0 its trace is then 2 - (omega h)^2 (1 + beta/h) and its determinant
//! 1 - (omega h)^2 beta/h. It is stable below h = (sqrt(2/b + 4 xi^2) - 2 xi)/omega_max, with xi at omega_max.
//! Source: Rayleigh 1877, section 102; Belytschko, Liu, Moran 2000, section 6.2; `fem_kernel::integrate`.
//! Tolerance: 1e-9 against the scheme; 0.2 % against the continuous ratio at omega h = 0.002 to 0.02, as the lag gives an error
//! of that order; 1e-10 for the energy balance, as in `fem_energy`.

use fem_kernel::spectrum;
use protocol::{FaultCode, Node};
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, reported, set_in_motion, setting, window, with};
use crate::fem_dispersion::{Wave, exact, number};
use crate::fem_wheel::{balance, run, wheel_rail};

/// Trace and determinant over `stride` steps, from the amplitudes of a standing wave with n periods.
fn oscillation(wave: Wave, periods: usize, time: Value, stride: u32) -> [f64; 2] {
    let strip = node(&with(wave.strip(0.5), json!({"time": time})));
    let shape = move |x: f64| 1e-9 * (number(periods) * x).cos();
    let start = move |[x, _]: [f64; 2]| match wave {
        Wave::P => [[shape(x), 0.0], [0.0, 0.0]],
        Wave::S => [[0.0, shape(x)], [0.0, 0.0]],
    };
    let mut strip = set_in_motion(&strip, start);
    let component = usize::from(matches!(wave, Wave::S));
    let mut amplitudes = Vec::new();
    for index in 0..5 {
        strip.advance_alone(&window(index, stride)).expect("stable");
        let (mesh, layout) = (&strip.model.mesh, strip.model.body.layout);
        let u = |i: usize| strip.state().u[layout.index([i, 0], component)];
        let projected = (0..mesh.columns).map(|i| u(i) * shape(mesh.point(i, 0)[0]));
        amplitudes.push(projected.sum::<f64>());
    }
    // x2 = T x1 - D x0, x3 = T x2 - D x1
    let [x0, x1, x2, x3] = [1, 2, 3, 4].map(|k| amplitudes[k]);
    let determinant = x1 * x1 - x0 * x2;
    [
        (x1 * x2 - x0 * x3) / determinant,
        (x2 * x2 - x1 * x3) / determinant,
    ]
}

#[test]
fn the_scheme_damps_as_derived() {
    for periods in [1, 4] {
        let auto = node(&Wave::P.strip(0.5));
        let step = 0.3 * auto.model.step_limit;
        let beta = 0.2 * step;
        let time = json!({"step_s": step, "stiffness_damping_s": beta});
        let [trace, determinant] = oscillation(Wave::P, periods, time, 1);
        let phase = exact(Wave::P, periods, step, 0.5).phase;
        let omega = 2.0 * (0.5 * phase).sin();
        let expected = [2.0 - omega * omega * 1.2, 1.0 - omega * omega * 0.2];
        assert!((trace - expected[0]).abs() <= 1e-9, "{trace} {expected:?}");
        assert!(
            (determinant - expected[1]).abs() <= 1e-9,
            "{determinant} {expected:?}"
        );
    }
}

#[test]
fn a_mode_is_damped_by_the_ratio_of_rayleigh() {
    for wave in [Wave::P, Wave::S] {
        for periods in [1, 2, 4] {
            let step = 0.02 * node(&wave.strip(0.5)).model.step_limit;
            let omega = exact(wave, periods, step, 0.5).phase / step;
            for [by_mass, by_stiffness] in [[0.02, 0.0], [0.0, 0.02], [0.01, 0.015]] {
                let time = json!({"step_s": step, "mass_damping_per_s": 2.0 * by_mass * omega,
                                  "stiffness_damping_s": 2.0 * by_stiffness / omega});
                // About a seventh of a period.
                let stride = (0.9 / (omega * step)) as u32;
                let [trace, determinant] = oscillation(wave, periods, time, stride);
                let decay = -0.5 * determinant.ln();
                let turned = (0.5 * trace / determinant.sqrt()).acos();
                let ratio = decay / decay.hypot(turned);
                let error = ratio / (by_mass + by_stiffness) - 1.0;
                assert!(
                    error.abs() <= 2e-3,
                    "{wave:?} {periods} {by_mass} {by_stiffness}: {error:e}"
                );
            }
        }
    }
}

/// Runs the block at a share of its limit after an impulse at the crown, and returns the largest displacement (m).
fn kicked(b: f64, ratio: f64, more: f64, share: f64) -> Result<f64, protocol::NodeError> {
    let fastest = node(&block()).model.omega_max;
    let beta = 2.0 * ratio / fastest;
    let limit = ((2.0 / b + 4.0 * ratio * ratio).sqrt() - 2.0 * ratio) / fastest;
    assert_eq!(limit, spectrum::step_limit(fastest, b, beta));
    let time = json!({"time": {"damping": b, "stiffness_damping_s": beta, "mass_damping_per_s": more,
                               "step_s": share * limit, "unsafe_step": share >= 1.0}});
    let mut body = node(&with(block(), time));
    let points = body.couple("top")?.len();
    let mut force = vec![0.0; 2 * points];
    force[points] = -1.0;
    body.advance(&window(0, 1), &force)?;
    body.commit(&window(0, 1), &[])?;
    // Beyond the limit, damping slows the growth of the fastest mode.
    for index in 1..if share >= 1.0 { 1000 } else { 100 } {
        body.advance_alone(&window(index, 10))?;
    }
    Ok(body
        .state()
        .u
        .iter()
        .fold(0.0, |far: f64, u| far.max(u.abs())))
}

#[test]
fn the_block_is_stable_only_below_the_limit() {
    for b in [0.5, 0.75, 1.0] {
        for ratio in [0.05, 0.5, 3.0] {
            for more in [0.0, 3e6] {
                let far = kicked(b, ratio, more, 0.999).expect("it is stable");
                assert!(far < 1e-7, "1 N for one step moves it by {far} m");
            }
            let fault = kicked(b, ratio, 0.0, 1.01).expect_err("it is unstable");
            assert_eq!(fault.code, FaultCode::Diverged);
        }
    }
}

#[test]
fn a_step_stable_only_without_damping_is_refused() {
    let limit = node(&block()).model.step_limit;
    let damped = |step: Value| {
        with(
            block(),
            json!({"time": {"step_s": step, "stiffness_damping_s": limit}}),
        )
    };
    let error = fem_node::check(&damped(json!(0.9 * limit)), &setting(1)).expect_err("above");
    assert_eq!(error.key, "time.step_s");
    assert!(
        error.problem.contains("stiffness_damping_s"),
        "{}",
        error.problem
    );
    let auto = node(&damped(json!("auto")));
    assert_eq!(auto.model.scheme.step, 0.9 * auto.model.step_limit);
    assert!(auto.model.step_limit < 0.6 * limit);
}

#[test]
fn stiffness_damping_has_its_own_term_in_the_ledger() {
    for b in [0.5, 0.75, 1.0] {
        let config = with(
            block(),
            json!({"time": {"damping": b, "stiffness_damping_s": 2e-9, "mass_damping_per_s": 1e5},
                   "boundary": {"top": {"traction_pa": [1e6, -3e6], "ramp_s": 1e-6},
                                "right": {"velocity_m_per_s": [-0.5, "free"]}}}),
        );
        let mut body = node(&config);
        for index in 0..40 {
            let report = body.advance_alone(&window(index, 13)).expect("stable");
            let defect = balance(&body, &report);
            assert!(defect <= 1e-10, "b = {b}: {defect:e}");
            assert!(reported(&body, &report, "stiffness_damping") > 0.0);
        }
    }
    let plain = node(&block()).describe();
    assert!(
        plain
            .ledger
            .iter()
            .all(|term| term.name != "stiffness_damping")
    );
}

#[test]
fn under_a_wheel_every_joule_is_accounted_for() {
    let config = with(
        wheel_rail(0.1),
        json!({"time": {"stiffness_damping_s": 2e-9, "step_s": "auto"}}),
    );
    let mut rail = node(&config);
    run(&mut rail, |node, report| {
        let defect = balance(node, report);
        assert!(defect <= 1e-9, "energy balance {defect:e}");
    });
    let results = rail.finish().expect("it ends").results;
    assert!((results["wheel_force_n"] / 8000.0 - 1.0).abs() < 2e-3);
    assert!((results["p0_pa"] / 1054.5e6 - 1.0).abs() < 5e-3);
}

/// The columns for a coupler belong to the damped body.
#[test]
fn the_compliance_belongs_to_the_damped_body() {
    let config = with(
        block(),
        json!({"time": {"stiffness_damping_s": 3e-9, "mass_damping_per_s": 1e5}}),
    );
    let mut body = node(&config);
    let count = 2 * body.couple("top").expect("a set").len();
    let columns = body.columns(&window(0, 9)).expect("stable");
    for column in [0, 7, count - 1] {
        let mut force = vec![0.0; count];
        force[column] = 1.0;
        let moved = body.advance(&window(0, 9), &force).expect("stable");
        assert_eq!(moved, columns[column * count..(column + 1) * count]);
    }
}
