//! A feed of grains into the middle row of the sheared layer of [`crate::dem_flow`].
//!
//! All grains have one radius R, so each fed grain has the mass m of the others. Reference: the n-th one comes in the
//! first step that ends n m / rate after the start; energies balance with the work of growth.

use dem_node::Dem;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_flow::{R, STEP, STEPS, followed, sheared, third_body, zone};
use crate::dem_support::{build, close, march, mass, refusal};

/// Steps from grain to grain, and step after which the feed ends.
const EVERY: u32 = 100;
const LAST: u32 = 450;
const START: u32 = 150;

/// The layer with a feed at this height (m): a grain every hundred steps, half of one more at the end.
fn fed(y: f64) -> Value {
    let mut config = sheared(followed());
    config["law"]["bonds_min"] = json!(2);
    config["injection"] = json!({
        "x_m": 0.0, "y_m": y, "rate_kg_per_s": mass(R) / (f64::from(EVERY) * STEP),
        "start_s": f64::from(START) * STEP, "end_s": (f64::from(LAST) + 0.5 * f64::from(EVERY)) * STEP,
    });
    config
}

fn present(dem: &Dem) -> usize {
    dem.state().present(dem.bodies())
}

/// True if a grain in store has a contact or a bond.
fn store_is_met(dem: &Dem) -> bool {
    let (bodies, state) = (dem.bodies(), dem.state());
    let slots = state.list.slots.iter().map(|slot| [slot.a, slot.b]);
    let bonds = state.bonds.iter().map(|bond| [bond.a, bond.b]);
    let mut met = slots.chain(bonds).flatten();
    met.any(|body| state.waits(bodies, body as usize))
}

#[test]
fn fed_grains_come_on_time_and_the_masses_balance() {
    let config = fed(3f64.sqrt() * R);
    let mut dem = build(&config);
    assert_eq!(present(&dem), 20);
    assert_eq!(dem.bodies().free, 24);
    assert!(!store_is_met(&dem));
    for step in 0..STEPS {
        let report = march(&mut dem, u64::from(step), 1);
        assert!(!store_is_met(&dem), "at {step}");
        // To within a step, because the due mass is rounded.
        let due = |step: u32| (step.saturating_sub(START) / EVERY).min((LAST - START) / EVERY);
        let came = (present(&dem) - 20) as u32;
        assert!(
            (due(step)..=due(step + 1)).contains(&came),
            "{came} at {step}"
        );
        let injected = report.signal("q_injected_total_kg");
        let expected = f64::from(came) * mass(R);
        close("fed", injected, expected, 1e-12 * mass(R));
        let found = report.signal("third_body_zone_kg");
        let expected = third_body(&dem, zone(&report));
        close("in the zone", found, expected, 1e-12 * mass(R));
    }
    let outcome = dem.finish().expect("it ends");
    let results = &outcome.results;
    assert_eq!(results["disks"], 23.0);
    close(
        "in the zone",
        results["q_external_kg"],
        3.0 * mass(R),
        1e-12 * mass(R),
    );
    close("balance", results["flow_balance_rel"], 0.0, 1e-15);
    assert!(!dem.state().feed.grows());
}

/// A layer without bonds to a growing grain is lifted: the work of growth is as large as the other works.
#[test]
fn the_work_of_growing_closes_the_balance_of_energies() {
    let mut dem = build(&fed(3f64.sqrt() * R));
    march(&mut dem, 0, START);
    let report = march(&mut dem, u64::from(START), STEPS - START);
    let work = report.energy("injection");
    let size = report.energy("wheel_drive").abs() + report.energy("wheel_load").abs();
    assert!(work.abs() > 1e-3 * size, "{work:e} of {size:e}");
    close("energies", report.imbalance(size + work.abs()), 0.0, 1e-9);
}

/// The loose grain looks for its two bonds at the place of the store.
#[test]
fn nothing_is_bonded_to_a_grain_in_store() {
    assert!(!store_is_met(&build(&fed(-3.9 * R))));
}

#[test]
fn a_resumed_feed_continues_like_an_unbroken_one() {
    let config = fed(3f64.sqrt() * R);
    let mut whole = build(&config);
    // While the first grain grows.
    march(&mut whole, 0, START + EVERY + EVERY / 2);
    assert!(whole.state().feed.grows());
    let at = u64::from(START + EVERY + EVERY / 2);
    let checkpoint = whole.checkpoint().expect("it can be packed");
    let mut resumed = build(&config);
    resumed.restore(&checkpoint).expect("it is of these grains");
    for dem in [&mut whole, &mut resumed] {
        march(dem, at, 300);
    }
    let [whole, resumed] = [whole, resumed].map(|mut dem| dem.finish().expect("it ends"));
    assert_eq!(whole.state_hash, resumed.state_hash);
    assert_eq!(whole.results, resumed.results);
}

#[test]
fn impossible_feeds_are_refused() {
    let refused = |key: &str, value: Value, parts: &[&str]| {
        let mut config = fed(3f64.sqrt() * R);
        config["injection"][key] = value;
        let message = refusal(&config);
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?}");
        }
    };
    refused(
        "rate_kg_per_s",
        json!(0.0),
        &["injection.rate_kg_per_s", "above 0"],
    );
    refused(
        "rate_kg_per_s",
        json!(1e3),
        &["injection.rate_kg_per_s", "e6 grains"],
    );
    refused("start_s", json!(-1.0), &["injection.start_s", "at least 0"]);
    refused(
        "end_s",
        json!(1e-4),
        &["injection.end_s", "1.5e-4", "1e-4 (s)"],
    );
    refused("growth_s", json!(0.0), &["injection.growth_s", "above 0"]);
    let without = |change: fn(&mut Value), part: &str| {
        let mut config = fed(3f64.sqrt() * R);
        change(&mut config);
        let message = refusal(&config);
        assert!(
            message.contains("injection") && message.contains(part),
            "{message:?}"
        );
    };
    without(|config| config["flow"] = json!(null), "flow");
    without(
        |config| config["gravity_m_per_s2"] = json!([0.0, -9.81]),
        "gravity",
    );
    let rigid = |config: &mut Value| {
        let law = config["law"].as_object_mut().expect("a table");
        law.remove("contact_stiffness_pa");
        law.remove("tangential_stiffness_ratio");
    };
    without(rigid, "contact_stiffness_pa");
}

/// The first grain has grown after START + EVERY steps; no grain can be worn before the wear time.
#[test]
fn a_feed_is_reached_with_its_first_grain() {
    let config = fed(3f64.sqrt() * R);
    let moments = build(&config).describe().moments;
    let first = f64::from(START + EVERY) * STEP;
    close("feed", moments["injection.start_s"], first, 1e-12 * first);
    assert_eq!(config["flow"]["wear_s"], moments["flow.wear_s"]);
}

/// The fed grains leave sideways after a mean of a hundred steps, with their motion and their forces: masses and energies balance, and no
/// contact finds a grain that has left, also in a resumed run.
#[test]
fn grains_that_leave_sideways_take_their_mass_and_energy_along() {
    let mut config = fed(3f64.sqrt() * R);
    config["flow"]["lateral"] = json!({ "time_s": 1e2 * STEP });
    // The residual of the solver is in the balance: 2e-9 at 1e-6.
    config["solver"]["tolerance"] = json!(1e-8);
    let mut dem = build(&config);
    let middle = u64::from(STEPS / 2);
    march(&mut dem, 0, STEPS / 2);
    let checkpoint = dem.checkpoint().expect("it can be packed");
    let mut resumed = build(&config);
    resumed.restore(&checkpoint).expect("it is of these grains");
    march(&mut resumed, middle, STEPS - STEPS / 2);
    let report = march(&mut dem, middle, STEPS - STEPS / 2);
    assert!(!store_is_met(&dem));
    let taken = dem.state().taken.len() as f64;
    assert!(taken >= 2.0, "{taken} have left");
    let works = ["wheel_drive", "wheel_load", "injection"].map(|name| report.energy(name).abs());
    let size = works.iter().sum();
    assert!(report.energy("lateral") > 1e-5 * size);
    close("energies", report.imbalance(size), 0.0, 1e-9);
    let [ended, again] = [dem, resumed].map(|mut dem| dem.finish().expect("it ends"));
    assert_eq!(ended.state_hash, again.state_hash);
    let results = &ended.results;
    let left = results["q_lateral_kg"];
    close("left", left, taken * mass(R), 1e-12 * mass(R));
    close("balance", results["flow_balance_rel"], 0.0, 1e-15);
    assert_eq!(
        results["disks"],
        present(&build(&config)) as f64 + 3.0 - taken
    );
}
