//! Detachment: friction takes layers off a bare surface, whose steel comes as grains.
//!
//! ```text
//!        v ->              a slider under the load N passes over a strip that repeats: on each segment friction does the work mu N l,
//!        ( S )             which takes mu N / (e t) layers of the depth d off it, the same everywhere
//!   .____.____.____.
//! ```
//!
//! Masses are those of what has gone, d l t rho a layer, to rounding: between the line and its reference, in grains, and waiting.

use dem_node::Dem;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{DENSITY, THICKNESS, build, close, march, refusal, scene, window};

const R: f64 = 1e-3;
const H: f64 = 1e-5;
const LOAD: f64 = 0.1;
const MU: f64 = 0.4;
const SPEED: f64 = 0.2;
const LENGTH: f64 = 10.0 * R;
/// Depth of a layer over R.
const THIN: f64 = 1e-4;

/// A slider that does not turn, and what comes off under it: `layers` of `depth` each time that it has passed.
fn slider(layers: f64, depth: f64) -> Value {
    let energy = MU * LOAD / (layers * THICKNESS);
    let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "cluster": "slider"}]);
    let cluster = json!([{"name": "slider", "drive": {"velocity_m_per_s": [SPEED, "free"], "force_n": ["free", -LOAD], "damping_n_s_per_m": 1.0}}]);
    let surface = json!({"half_width_m": 0.5 * LENGTH, "spacing_m": 1.1 * R, "friction": MU});
    let sample = json!({"kind": "disks", "disks": disk, "clusters": cluster, "surface": surface,
        "periodic_x_m": [-0.5 * LENGTH, 0.5 * LENGTH]});
    let law = json!({"kind": "coulomb", "friction": MU, "contact_stiffness_pa": 1e8, "tangential_stiffness_ratio": 1.0, "damping": 0.4});
    let detachment = json!({"energy_j_per_m2": energy, "depth_m": depth, "growth_s": 1e-3});
    scene(law, H, sample, json!({"detachment": detachment}))
}

/// Area between the points of the surface and their reference (m2).
fn gone(dem: &Dem) -> f64 {
    let (bodies, state) = (dem.bodies(), dem.state());
    let points = bodies.surface.points.iter().zip(&state.surface).enumerate();
    points
        .map(|(k, (reference, now))| (reference[1] - now[1]) * bodies.surface.tributary(k))
        .sum()
}

#[test]
fn uniform_sliding_takes_the_same_depth_everywhere() {
    let mut dem = build(&slider(5.5, THIN * R));
    let steps = LENGTH / (SPEED * H);
    let report = march(&mut dem, 0, steps.round() as u32);
    let work = dem.state().worn.done[0];
    // It presses by its springs first, and layers let it sink.
    close("work", work, MU * LOAD * LENGTH, 2e-3 * work);
    assert!(
        report.imbalance(work) < 1e-9,
        "{:e}",
        report.imbalance(work)
    );
    // The two segments that it starts between have been passed in part twice.
    let depths: Vec<f64> = (0..10).map(|k| dem.state().worn.depth(k)).collect();
    let whole = depths
        .iter()
        .filter(|depth| (*depth - 5.0 * THIN * R).abs() < 1e-9 * R);
    assert!(whole.count() >= 7, "{depths:?}");
    let results = dem.finish().expect("it ends").results;
    let mass = gone(&dem) * THICKNESS * DENSITY;
    close("mass", results["detached_kg"], mass, 1e-12 * mass);
    assert_eq!(results["detached_waiting_kg"], results["detached_kg"]);
    let deepest = depths.iter().fold(0.0f64, |most, depth| most.max(*depth));
    close(
        "deepest",
        results["detached_depth_max_m"],
        deepest,
        1e-15 * R,
    );
}

/// Sixty times as deep: as much a pass as six disks of the slider's size, in grains of a fifth.
fn deep() -> Value {
    let mut config = slider(5.5, 60.0 * THIN * R);
    config["sample"]["disks"] = json!([
        {"x_m": 0.0, "y_m": R, "radius_m": R, "cluster": "slider"},
        {"x_m": 4.0 * R, "y_m": 0.2 * R, "radius_m": 0.2 * R}, {"x_m": -4.0 * R, "y_m": 0.2 * R, "radius_m": 0.2 * R}]);
    config
}

#[test]
fn what_comes_off_comes_as_grains_and_nothing_is_lost() {
    let mut dem = build(&deep());
    let store = dem.state().feed.waiting;
    let fed = &dem.bodies().radii[3..dem.bodies().free];
    assert!(
        fed.iter().all(|radius| *radius == 0.2 * R),
        "the slider is no grain: {fed:?}"
    );
    let mut from = 0;
    let scale = MU * LOAD * LENGTH;
    for _ in 0..20 {
        let report = march(&mut dem, from, 250);
        from += 250;
        let state = dem.state();
        let present = &state.centres[..state.present(dem.bodies())];
        let heights = present.iter().map(|centre| centre[1]);
        let least = heights.fold(f64::INFINITY, f64::min);
        assert!(least > 0.0, "a grain below the steel: {least}");
        assert!(
            report.imbalance(scale) < 1e-8,
            "{:e}",
            report.imbalance(scale)
        );
        let detection = dem.state().ledger.detection;
        close("detection", detection, 0.0, 1e-3 * scale);
    }
    let (bodies, state) = (dem.bodies(), dem.state());
    let came = state.present(bodies) - 3;
    assert!(came > 0 && came + state.feed.waiting as usize == store as usize);
    let grains: f64 = bodies.masses[3..state.present(bodies)].iter().sum();
    close("grains", grains, state.feed.delivered, 1e-12 * grains);
    let mass = gone(&dem) * THICKNESS * DENSITY;
    close("gone", state.worn.mass, mass, 1e-12 * mass);
    let results = dem.finish().expect("it ends").results;
    let waiting = results["detached_waiting_kg"];
    close("mass", grains + waiting, mass, 1e-12 * mass);
}

#[test]
fn a_resumed_surface_goes_on_as_an_unbroken_one() {
    let mut whole = build(&deep());
    march(&mut whole, 0, 2500);
    assert!(whole.state().worn.mass > 0.0);
    let checkpoint = whole.checkpoint().expect("it can be packed");
    let mut resumed = build(&deep());
    resumed.restore(&checkpoint).expect("it is of these grains");
    for dem in [&mut whole, &mut resumed] {
        march(dem, 2500, 2500);
    }
    let [whole, resumed] = [whole, resumed].map(|mut dem| dem.finish().expect("it ends"));
    assert_eq!(whole.state_hash, resumed.state_hash);
    assert_eq!(whole.results, resumed.results);
}

/// Under a body that does not yield, window by window and each asked for twice, it is what it is alone.
#[test]
fn a_coupled_surface_stays_as_deep_as_it_is() {
    let mut alone = build(&deep());
    let mut config = deep();
    config["time"] = json!({"pressure_pa": 1.0});
    let mut coupled = build(&config);
    let points = coupled
        .couple("base")
        .expect("the surface is a set")
        .x_m
        .len();
    let rigid = vec![0.0; 4 * points * points];
    coupled.set_boundary(H, &rigid).expect("a rigid body");
    let rest = vec![0.0; 2 * points];
    for index in 0..3000 {
        march(&mut alone, index, 1);
        let window = window(index, H);
        for _ in 0..2 {
            let answer = coupled.solve(&window, &rest).expect("it can be solved");
            assert!(answer.converged);
        }
        coupled.commit(&window, &rest).expect("it is committed");
    }
    let [alone, coupled] = [&alone, &coupled].map(|dem| dem.state());
    assert!(alone.worn.mass > 0.0);
    assert_eq!(alone.worn, coupled.worn);
    let points = alone.surface.iter().zip(&coupled.surface);
    for (alone, coupled) in points.flat_map(|(a, b)| a.iter().zip(b)) {
        close("surface", *coupled, *alone, 1e-15);
    }
    for (alone, coupled) in alone.centres.iter().zip(&coupled.centres) {
        (0..2).for_each(|k| close("centre", coupled[k], alone[k], 1e-12));
    }
}

/// A third of a segment is the most: then nothing more goes, and the run is told so.
#[test]
fn nothing_goes_beyond_a_third_of_a_segment() {
    let mut config = slider(100.0, 0.02 * R);
    config["time"]["end_s"] = json!(0.05);
    // As many layers as one wants are no more work.
    let mut soft = config.clone();
    soft["detachment"]["energy_j_per_m2"] = json!(1e-200);
    let mut soft = build(&soft);
    march(&mut soft, 0, 1000);
    assert!(soft.state().worn.depth(5) <= soft.bodies().surface.deepest());
    let mut dem = build(&config);
    march(&mut dem, 0, 5000);
    let limit = dem.bodies().surface.deepest();
    let depths: Vec<f64> = (0..10).map(|k| dem.state().worn.depth(k)).collect();
    assert!(
        depths.iter().all(|depth| *depth <= limit),
        "{depths:?} {limit}"
    );
    assert!(
        depths.iter().any(|depth| *depth > limit - 0.02 * R),
        "{depths:?}"
    );
    let findings = dem.finish().expect("it ends").findings;
    assert!(
        findings.iter().any(|finding| finding.code == "detachment"),
        "{findings:?}"
    );
}

#[test]
fn detachment_that_cannot_be_is_refused() {
    let told = |change: fn(&mut Value), expected: &str| {
        let mut config = slider(5.5, THIN * R);
        change(&mut config);
        let message = refusal(&config);
        assert!(message.contains(expected), "{expected}: {message}");
    };
    told(
        |config| config["detachment"]["energy_j_per_m2"] = json!(0.0),
        "detachment.energy_j_per_m2",
    );
    told(
        |config| config["detachment"]["depth_m"] = json!(0.5 * R),
        "detachment.depth_m",
    );
    told(
        |config| config["gravity_m_per_s2"] = json!([0.0, -9.81]),
        "gravity",
    );
    told(
        |config| config["sample"]["surface"] = json!(null),
        "bare surfaces",
    );
}
