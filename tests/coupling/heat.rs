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
    // The last window is followed by an exchange.
    assert!((taken / given - 1.0).abs() < 1e-12, "{taken} of {given}");
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

/// Grains of 400 K between two rails of 300 K: each rail gets what the grains give it, and both are warmed at the edge that they couple.
#[test]
fn a_layer_between_two_rails_warms_both() {
    let scene = include_str!("../../scenarios/two-rails-reciprocating/scenario.toml");
    let [rail, grains] = ["", "young_pa = 205e9, poisson = 0.3, spread_m = 0.2e-3, "];
    let heat = |name: &str, more: &str, start: f64| {
        format!(
            "participant.{name}.config.heat={{ {more}conductivity_w_per_m_k = 45.0, capacity_j_per_kg_k = 460.0, start_k = {start:.1} }}"
        )
    };
    let sets = [
        "run.end_s=2.5e-4".to_string(),
        heat("lower", rail, 300.0),
        heat("upper", rail, 300.0),
        heat("third-body", grains, 400.0),
        "interface.below.heat_every_windows=10".into(),
        "interface.above.heat_every_windows=10".into(),
    ];
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let left = run_both_ways(scene, &sets);
    let results = &left.ended.summary.value()["results"];
    for (body, group) in [("lower", "base"), ("upper", "lid")] {
        let of = |name: &str| results[name].as_f64().expect(name);
        let given = of(&format!("heat_to_{group}_j"));
        let taken = of(&format!("{body}.heat_interface_j"));
        assert!(given > 0.0);
        assert!(
            (taken / given - 1.0).abs() < 1e-12,
            "{body}: {taken} of {given}"
        );
        assert!(of(&format!("{body}.heat_balance_rel")) < 1e-12);
        let peak = of(&format!("{body}.surface_temperature_peak_k"));
        assert!((301.0..400.0).contains(&peak), "{body}: {peak}");
    }
    let balance = results["third-body.heat_balance_rel"].as_f64();
    assert!(balance.expect("it has heat") < 1e-12);
}

/// Lowest and highest temperature of the rail at the end (K).
fn rail_at_the_end(scene: &str, sets: &[String]) -> [f64; 2] {
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let left = run_in_process(scene, &sets)
        .expect("it is valid")
        .completed();
    let range = &left.ended.summary.value()["fields"]["last"]["rail"]["temperature_k"];
    [0, 1].map(|end| range[end].as_f64().expect("there are fields"))
}

/// A rail on four layers whose contacts are solved loosely, so that some gain energy: no node is colder than at the start.
#[test]
fn no_node_gets_colder_than_the_start() {
    let scene = include_str!("../../scenarios/rail-over-layers/scenario.toml");
    let steel = "conductivity_w_per_m_k = 45.0, capacity_j_per_kg_k = 460.0, start_k = 300.0";
    let mut sets = vec![
        "participant.rail.config.time.end_s=3e-4".to_string(),
        format!("participant.rail.config.heat={{ {steel} }}"),
    ];
    for layer in 1..=4 {
        let config = format!("participant.third-body-{layer}.config");
        sets.push(format!(
            "{config}.heat={{ {steel}, young_pa = 205e9, poisson = 0.3 }}"
        ));
        sets.push(format!("{config}.solver.tolerance=1e-3"));
        sets.push(format!("interface.patch-{layer}.heat_every_windows=5"));
    }
    let [lowest, highest] = rail_at_the_end(scene, &sets);
    assert!(
        lowest > 300.0 - 1e-9 && highest > 300.05,
        "{lowest} {highest}"
    );
}

/// Nor where bonded points lie between nodes of other temperatures: each node takes heat by its own.
#[test]
fn no_node_pays_for_a_hotter_one_beside_it() {
    let scene = include_str!("../../scenarios/quick-bonded/scenario.toml");
    let heat = |name: &str, more: &str| {
        format!(
            "participant.{name}.config.heat={{ {more}, capacity_j_per_kg_k = 460.0, start_k = 300.0 }}"
        )
    };
    let rail = heat("rail", "conductivity_w_per_m_k = 45.0");
    let grains = "conductivity_w_per_m_k = 400.0, young_pa = 205e9, poisson = 0.3";
    let grains = heat("third-body", grains);
    let windows = "interface.layer-base.heat_every_windows=5".to_string();
    let [lowest, highest] = rail_at_the_end(scene, &[rail, grains, windows]);
    assert!(
        lowest > 300.0 - 1e-9 && highest > 301.0,
        "{lowest} {highest}"
    );
}

/// A rail that expands and softens as it warms: the motion changes, and the bits are the same both ways.
#[test]
fn a_rail_expands_and_softens_under_its_grains() {
    let rail = "participant.rail.config";
    let more = [
        format!(
            "{rail}.material={{ young_pa = 102.5e9, poisson = 0.3, density_kg_per_m3 = 7800.0, yield_pa = 5e8 }}"
        ),
        format!("{rail}.heat.alpha_per_k=1e-3"),
        format!("{rail}.heat.softening.yield_stress=[[300.0, 1.0], [301.0, 0.5]]"),
        format!("{rail}.heat.conductivity_factor=[[300.0, 1.0], [301.0, 0.5]]"),
    ];
    let secant = "interface.layer-base.scheme=dual-schur-secant";
    let sets: Vec<&str> = [SHORT, secant]
        .into_iter()
        .chain(more.iter().map(String::as_str))
        .collect();
    let hash = |sets: &[&str]| {
        let left = run_both_ways(SCENE, sets);
        let summary = left.ended.summary.value();
        assert!(left.number("results.energy_balance_rel").abs() < 1e-6);
        summary["participants"]["rail"]["state_hash"].clone()
    };
    let all = hash(&sets);
    for without in 3..6 {
        let mut fewer = sets.clone();
        fewer.remove(without);
        assert_ne!(hash(&fewer), all, "without {}", sets[without]);
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

/// Grains of 400 K on a rail of 300 K: nothing becomes hotter than the grains, and five exchanges are warned of.
#[test]
fn a_surface_is_no_hotter_than_what_warms_it() {
    let hot = "participant.third-body.config.heat.start_k=400.0";
    let keys = ["rail", "third-body"];
    let keys =
        keys.map(|name| format!("participant.{name}.config.heat.conductivity_w_per_m_k=400.0"));
    for windows in [2, 100] {
        let every = format!("interface.layer-base.heat_every_windows={windows}");
        let sets = [SHORT, hot, &keys[0], &keys[1], &every];
        let left = run_in_process(SCENE, &sets)
            .expect("it is valid")
            .completed();
        assert!(left.number("results.surface_temperature_peak_k") < 400.0);
        let mut found = left.ended.summary.warnings.iter();
        let warned = found.any(|warning| warning.code == "heat_exchange");
        assert!(warned || windows == 2);
    }
}
