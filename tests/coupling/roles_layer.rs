//! A rail that follows a bonded layer of grains (`dirichlet = "continuum"`).
//!
//! Problem: `scenarios/extremes/coupled`, a short rail under a small layer and a wheel whose load comes in 0.1 ms, with bonds
//! as in `wheel-rail-coupled`. The glued grains have the same mass on the rail's surface as grains of their size in the layer.
//!
//! Exact answer: the window equations of scheme `velocity` with that mass added. A mass added to a system in motion
//! changes its frequencies by at most half of its ratio to the mass that moves there without it (Rayleigh's quotient). Over less
//! than one swing, as here, motions therefore differ by at most that ratio; a quarter of the mass makes a quarter of the difference.

use harness::runs::{Left, node, run_in_process};
use scenario::load::parse;
use scenario::source::ScenarioSource;

const SCENE: &str = include_str!("../../scenarios/extremes/coupled/scenario.toml");
const BONDED: &str = "participant.third-body.config.law={ kind = \"cohesion\", friction = 0.3, contact_stiffness_pa = 2.255e11, tangential_stiffness_ratio = 0.5, cn_pa_per_m = 6.4e15, ct_pa_per_m = 2.56e15, w_j_per_m2 = 15625.0, b_pa_m_s = 0.0, p = 1.0, h_prime = \"one\", alert_m = 8e-6, bonds_min = 2 }";
const FINE: &str = "participant.third-body.config.solver.tolerance=1e-8";

fn run(mass_scale: f64, sets: &[&str]) -> Left {
    let scale = format!("participant.third-body.config.mass_scale={mass_scale:?}");
    let closed = "interface.layer-base.tolerance_rel=1e-7";
    let all = [&[BONDED, FINE, &scale, closed], sets].concat();
    run_in_process(SCENE, &all)
        .expect("it is valid")
        .completed()
}

/// Mass of the glued grains over the mass of free grains and wheel.
fn added(mass_scale: f64) -> f64 {
    let source = ScenarioSource {
        name: "coupled".into(),
        text: SCENE.into(),
        overrides: vec![
            BONDED.into(),
            format!("participant.third-body.config.mass_scale={mass_scale:?}"),
        ],
    };
    let loaded = parse(source).expect("it is valid");
    let layer = &loaded.scenario.participant[1];
    let config = serde_json::to_value(&layer.config).expect("it is a table");
    let rules = &loaded.scenario.run;
    let described = node("dem", (rules.seed, rules.thickness_m), config).describe();
    let glued = &described.point_mass_kg["base"];
    let behind = described
        .boundary_inertia
        .expect("it stands on glued grains")
        .mass_kg;
    glued.iter().sum::<f64>() / (behind * glued.len() as f64)
}

#[test]
fn a_rail_that_follows_a_bonded_layer_moves_as_with_scheme_velocity_but_for_the_added_mass() {
    let swapped = [
        "interface.layer-base.scheme=fixed-point-serial",
        "interface.layer-base.dirichlet=continuum",
        "interface.layer-base.repeats_max=60",
    ];
    let apart = |mass_scale: f64| {
        let left = run(mass_scale, &swapped);
        let velocity = run(mass_scale, &["interface.layer-base.scheme=velocity"]);
        assert_eq!(left.number("coupling.not_converged_windows"), 0.0);
        assert!(left.number("coupling.gap_max_rel") <= 1e-7);
        assert!(left.number("coupling.force_residual_rel") <= 1e-9);
        let y = [&left, &velocity].map(|left| &left.signals["third-body.wheel_y_m"]);
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let range = largest(&mut y[1].iter().map(|y_1| (y_1 - y[1][0]).abs()));
        let distance = largest(&mut y[0].iter().zip(y[1]).map(|(a, b)| (a - b).abs())) / range;
        println!(
            "masses x {mass_scale}: {:.1} repeats, wheel {distance:.4} of its way apart, {:.4} of the mass added",
            left.number("repeats_mean"),
            added(mass_scale)
        );
        assert!(distance <= added(mass_scale), "{distance}");
        distance
    };
    let (whole, quarter) = (apart(1000.0), apart(250.0));
    assert!(quarter <= 0.45 * whole, "{quarter} and {whole}");
}

/// Of loose grains only the glued ones resist for certain: the stiffest motion of the rail against their masses
/// decides. The tolerance around the limit is the map's, 5 %.
#[test]
fn constant_relaxation_fails_where_it_is_predicted_to() {
    let run = |mass_scale: f64, insist: bool| {
        let scale = format!("participant.third-body.config.mass_scale={mass_scale:?}");
        let insist = format!("interface.layer-base.unsafe_window={insist}");
        let sets = [
            "interface.layer-base.scheme=fixed-point-serial",
            "interface.layer-base.dirichlet=continuum",
            "interface.layer-base.acceleration=constant",
            "interface.layer-base.repeats_max=4000",
            "interface.layer-base.tolerance_rel=1e-6",
            "participant.third-body.config.solver.tolerance=1e-6",
            "participant.third-body.config.wheel.ramp_s=0.02e-3",
            "participant.third-body.config.wheel.hold_s=0.01e-3",
            &scale,
            &insist,
        ];
        run_in_process(SCENE, &sets).expect("it is valid")
    };
    let log = |left: &Left| {
        std::fs::read_to_string(left.scratch.path().join("logs/coordinator.log"))
            .expect("every run has one")
    };
    let margin = |left: &Left| -> f64 {
        let log = log(left);
        let line = log
            .lines()
            .find(|line| line.ends_with("added mass (stability)"));
        let margin = line.and_then(|line| line.split("margin").nth(1)?.split_whitespace().next());
        margin
            .expect("it is written down")
            .parse()
            .expect("it is a number")
    };
    let limit = 1000.0 / margin(&run(1000.0, false));
    println!("smallest scale of masses predicted to converge: {limit:.0}");
    run(1.05 * limit, false).completed();
    let refused = run(0.95 * limit, false)
        .ended
        .error
        .expect("it is predicted");
    assert_eq!(refused.exit_code(), 2, "{refused}");
    let found = run(0.95 * limit, true)
        .ended
        .error
        .expect("it does not contract");
    assert_eq!(found.exit_code(), 3, "{found}");
}

/// Both strips of `two-rails` follow the layer between them, which is heavier than the part of a strip that moves in a window. If the
/// grains follow the strips instead, they need several times as many repeats.
#[test]
fn two_bodies_follow_the_layer_between_them() {
    let scene = include_str!("../../scenarios/two-rails/scenario.toml");
    let run = |scheme: &str, dirichlet: &str| {
        let keys = |name: &str| {
            let of = |key: &str| format!("interface.{name}.{key}");
            [
                of(&format!("scheme={scheme}")),
                of(&format!("dirichlet={dirichlet}")),
                of("tolerance_rel=1e-6"),
                of("repeats_max=60"),
            ]
        };
        let mut sets = [keys("below"), keys("above")].concat();
        sets.push("participant.third-body.config.solver.tolerance=1e-6".into());
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        run_in_process(scene, &sets).expect("it is valid")
    };
    let left = run("fixed-point-serial", "continuum").completed();
    let repeats = left.number("repeats_mean");
    println!("{repeats:.2} repeats");
    assert!(repeats <= 4.0, "{repeats}");
    for name in ["below", "above"] {
        let number = |key: &str| left.number(&format!("interfaces.{name}.{key}"));
        assert!(number("gap_max_rel") <= 1e-6);
        assert!(number("force_residual_rel") <= 1e-9);
        assert!(number("points_kinetic_j") > 0.0);
    }
    let velocity = run("velocity", "wall").completed();
    let balance = [&left, &velocity].map(|left| left.number("results.energy_balance_rel"));
    assert!(balance[0] <= 1.5 * balance[1], "{balance:?}");
    let other = run("fixed-point-serial", "wall").completed();
    let other = other.number("repeats_mean");
    assert!(other >= 4.0 * repeats, "{other} and {repeats} repeats");
}
