//! Heat through an interface: the beginning of `wheel-rail-heat`.
//!
//! Exact: what the grains give the rail gets; on both sides heat produced and entered is stored or conducted away; the motion has the bits of the
//! same scene without heat. Over shared memory and in-process the bits are the same.

use harness::runs::{run_both_ways, run_in_process};

const SCENE: &str = include_str!("../../scenarios/wheel-rail-heat/scenario.toml");

/// Half of the ramp: grains settle, slip and damp.
const SHORT: &str = "run.end_s=2.5e-4";

#[test]
fn the_rail_gets_the_heat_that_the_grains_give() {
    let left = run_both_ways(SCENE, &[SHORT]);
    let given = left.number("results.heat_to_base_j");
    let taken = left.number("results.heat_interface_j");
    assert!(given > 0.0);
    // What has left since the last exchange, 20 windows of 490, waits with the grains.
    assert!(taken > 0.8 * given && taken <= given, "{taken} of {given}");
    let results = &left.ended.summary.value()["results"];
    for name in ["rail", "third-body"] {
        let balance = &results[format!("{name}.heat_balance_rel")];
        assert!(
            balance.as_f64().is_some_and(|rel| rel < 1e-12),
            "{name}: {balance}"
        );
    }
    let last = |name: &str| *left.signals[name].last().expect("there are windows");
    assert!(last("rail.surface_temperature_max_k") > 300.0);
    let plain = SCENE.lines().filter(|line| !line.starts_with("heat"));
    let plain = plain.collect::<Vec<_>>().join("\n");
    let plain = run_in_process(&plain, &[SHORT])
        .expect("it is valid")
        .completed();
    for (name, column) in &plain.signals {
        assert_eq!(column, &left.signals[name], "{name}");
    }
}

#[test]
fn heat_on_one_side_needs_no_exchange_and_on_both_sides_its_windows() {
    let refused = |text: &str| run_in_process(text, &[SHORT]).map(|left| left.ended.error);
    let error_of = |text: &str| match refused(text) {
        Ok(None) => String::new(),
        Ok(Some(error)) | Err(error) => error.to_string(),
    };
    let without = |unwanted: &str| {
        let lines = SCENE.lines().filter(|line| !line.starts_with(unwanted));
        lines.collect::<Vec<_>>().join("\n")
    };
    let error = error_of(&without("heat_every_windows"));
    assert!(error.contains("heat_every_windows is missing"), "{error}");
    let rail = SCENE.replacen("heat = {", "unused = {", 1);
    let rail: Vec<&str> = rail
        .lines()
        .filter(|line| !line.starts_with("unused"))
        .collect();
    let error = error_of(&rail.join("\n"));
    assert!(error.contains("`rail` has none there"), "{error}");
    let alone: Vec<&str> = rail
        .into_iter()
        .filter(|line| !line.starts_with("heat_every"))
        .collect();
    assert_eq!(error_of(&alone.join("\n")), "");
}
