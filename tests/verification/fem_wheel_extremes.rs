//! Problem: the quick rail of `fem_wheel` under rare conditions: no friction and very high friction, loads from 1 N to
//! 20 t, a wheel that bounces, a step at the limit, a wheel too light for the solver, a force that is not a number.
//! Exact: mu = 0 carries no shear. mu = 5 never slides as a whole. A crowned linear body sinks like Hertz's line
//! contact. A wheel that left comes back and the energy balance closes. Errors are reported.
//! Source: Coulomb; Hertz 1882 (approach grows a little less than the load); energy balance.
//! Tolerance: given at each assertion.

use protocol::{FaultCode, Node, NodeError};
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, reported, window, with};
use crate::fem_wheel::{balance, run, wheel_rail};

fn refused(config: &Value) -> NodeError {
    let mut rail = node(config);
    (0..200)
        .find_map(|index| rail.advance_alone(&window(index, 100)).err())
        .expect("it must fail")
}

#[test]
fn a_smooth_wheel_has_no_tangential_force() {
    let config = with(wheel_rail(0.25), json!({"contact": {"friction": 0.0}}));
    let mut rail = node(&config);
    run(&mut rail, |node, report| {
        assert_eq!(reported(node, report, "wheel_ft_n"), 0.0);
        assert!(balance(node, report) <= 1e-9);
    });
    let results = rail.finish().expect("it ends").results;
    for name in [
        "traction_ratio_mean",
        "traction_ratio_peak",
        "gross_sliding_friction",
    ] {
        assert_eq!(results[name], 0.0, "{name}");
    }
    assert_eq!(results["gross_sliding_share"], 1.0, "nothing sticks");
    assert_eq!(results["sn_sliding_mean_pct"], 100.0);
}

#[test]
fn a_very_rough_wheel_takes_the_surface_along() {
    let config = with(wheel_rail(0.25), json!({"contact": {"friction": 5.0}}));
    let mut rail = node(&config);
    let (mut pulled, mut closed) = (0.0, 0.0);
    run(&mut rail, |node, report| {
        pulled = reported(node, report, "wheel_ft_n");
        closed = reported(node, report, "sn_pct");
        assert!(balance(node, report) <= 1e-9);
    });
    // 0.05 mm at some 60 N/um is more than friction 0.3 could carry, and far less than friction 5 could.
    assert!((-4000.0..-2400.0).contains(&pulled), "{pulled}");
    assert!(closed < 20.0, "{closed} % slide");
    let results = rail.finish().expect("it ends").results;
    assert!(!results.contains_key("sn_sliding_mean_pct"));
}

#[test]
fn loads_from_one_newton_to_twenty_tonnes_are_carried() {
    // A line contact of half-width a on a body of height H sinks by d ~ F (1 + 2 ln(2H/a)) with a ~ F^(1/2), so d/F falls
    // logarithmically with the load. At one newton only one node is in contact.
    let results = |load: f64| {
        let config = with(wheel_rail(0.02), json!({"wheel": {"load_n": load}}));
        let mut rail = node(&config);
        run(&mut rail, |node, report| {
            assert!(balance(node, report) <= 1e-8)
        });
        rail.finish().expect("it ends").results
    };
    let [light, usual, heavy] = [1.0, 8e3, 200e3].map(results);
    for (results, load) in [(&light, 1.0), (&usual, 8e3), (&heavy, 200e3)] {
        let force = results["wheel_force_n"];
        assert!(
            (force / load - 1.0).abs() < 1e-2,
            "{force} N under {load} N"
        );
    }
    let flexibility = |results: &std::collections::BTreeMap<String, f64>| {
        results["approach_m"] / results["load_n"]
    };
    let [light, usual, heavy] = [&light, &usual, &heavy].map(flexibility);
    assert!(light > usual && usual > heavy);
}

#[test]
fn a_bouncing_wheel_comes_back() {
    let config = with(
        wheel_rail(0.0),
        json!({"time": {"start_mass_damping_per_s": 0.0},
               // The surface drops by some 30 um, and the wheel falls and bounces.
               "boundary": {"top": {"traction_pa": [0.0, -2e8]}},
               "wheel": {"load_n": 50.0, "mass_kg": 1e-3, "ramp_s": 0.0, "hold_s": 6e-4}}),
    );
    let mut rail = node(&config);
    let (mut touching, mut lifts, mut returns) = (true, 0, 0);
    run(&mut rail, |node, report| {
        let closed = reported(node, report, "contact_nodes") > 0.0;
        let force = reported(node, report, "wheel_fn_n");
        assert_eq!(closed, force > 0.0, "no force without contact, no pull");
        lifts += usize::from(touching && !closed);
        returns += usize::from(!touching && closed);
        touching = closed;
        let defect = balance(node, report);
        assert!(defect <= 1e-6, "energy balance {defect:e}");
    });
    assert!(
        lifts >= 2 && returns >= 2,
        "{lifts} lifts, {returns} returns"
    );
}

#[test]
fn the_wheel_does_not_lower_the_stability_limit() {
    let limit = node(&wheel_rail(0.1)).model.step_limit;
    let at = |share: f64, more: Value| {
        with(
            with(wheel_rail(0.1), json!({"time": {"step_s": share * limit}})),
            more,
        )
    };
    let mut rail = node(&at(0.99, json!({})));
    run(&mut rail, |_, _| {});
    let force = rail.finish().expect("it ends").results["wheel_force_n"];
    assert!((force / 8000.0 - 1.0).abs() < 1e-2, "{force}");

    let beyond = fem_node::check(&at(1.01, json!({})), &crate::fem_bodies::setting(1));
    assert_eq!(beyond.expect_err("it is unstable").key, "time.step_s");

    let mut unsafe_rail = node(&at(1.01, json!({"time": {"unsafe_step": true}})));
    let found = (0..400).find_map(|index| unsafe_rail.advance_alone(&window(index, 100)).err());
    assert_eq!(found.expect("it is unstable").code, FaultCode::Diverged);
}

#[test]
fn sweeps_that_do_not_converge_are_an_error() {
    let config = with(
        wheel_rail(0.1),
        json!({"mesh": {"crown_radius_m": 0.0}, "wheel": {"radius_m": 0.3, "mass_kg": 1e-11, "ramp_s": 1e-6}}),
    );
    let error = refused(&config);
    assert_eq!(error.code, FaultCode::Diverged);
    assert!(error.message.contains("residual"), "{}", error.message);
    assert!(error.message.contains("wheel.mass_kg"), "{}", error.message);
}

#[test]
fn a_force_that_is_not_a_number_is_reported_at_once() {
    let mut rail = node(&block());
    let points = rail.couple("top").expect("a set").len();
    let mut force = vec![0.0; 2 * points];
    force[3] = f64::NAN;
    let error = rail.advance(&window(0, 5), &force).expect_err("no number");
    assert_eq!(error.code, FaultCode::Diverged);
    assert!(error.message.contains("window 0"), "{}", error.message);
    assert!(error.message.contains("y component"), "{}", error.message);
    assert!(error.message.contains("point 1"), "{}", error.message);
    // The committed state is untouched.
    rail.advance(&window(0, 5), &vec![0.0; 2 * points])
        .expect("stable");
}

#[test]
fn a_body_with_a_wheel_cannot_be_coupled() {
    let mut rail = node(&wheel_rail(1.0));
    for set in ["top", "left"] {
        let error = rail.couple(set).expect_err("it runs alone");
        assert_eq!(error.code, FaultCode::Configuration);
        assert!(error.message.contains("wheel"), "{}", error.message);
        assert!(error.message.contains(set), "{}", error.message);
    }
    assert!(!rail.describe().capabilities.advance);
}
