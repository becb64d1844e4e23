//! Detachment: friction takes layers off a bare surface, whose steel becomes grains.
//!
//! ```text
//!        v ->              a slider under the load N passes over a periodic strip: on each segment friction does the work mu N l,
//!        ( S )             which detaches mu N / (e t) layers of the depth d, the same everywhere
//!   .____.____.____.
//! ```
//!
//! The detached mass is d l t rho per layer, to rounding: between the line and its reference, in grains, and waiting.

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

/// A slider that does not turn; each pass detaches `layers` of `depth`.
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
    // At first the slider compresses its springs, and detached layers let it sink.
    close("work", work, MU * LOAD * LENGTH, 2e-3 * work);
    assert!(
        report.imbalance(work) < 1e-9,
        "{:e}",
        report.imbalance(work)
    );
    // The slider passes the two segments of its start partly twice.
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

/// Layers sixty times as deep: a pass detaches the mass of six disks of the slider's size, as grains of a fifth of its size.
fn deep() -> Value {
    let mut config = slider(5.5, 60.0 * THIN * R);
    config["sample"]["disks"] = json!([
        {"x_m": 0.0, "y_m": R, "radius_m": R, "cluster": "slider"},
        {"x_m": 4.0 * R, "y_m": 0.2 * R, "radius_m": 0.2 * R}, {"x_m": -4.0 * R, "y_m": 0.2 * R, "radius_m": 0.2 * R}]);
    config
}

#[test]
fn detached_steel_comes_as_grains_without_loss_of_mass() {
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
fn a_resumed_surface_continues_like_an_unbroken_one() {
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

/// Coupled to a rigid body, with each window requested twice, the surface wears as in an uncoupled run.
#[test]
fn a_coupled_surface_wears_like_an_uncoupled_one() {
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

/// The limit is a third of a segment: then no more layers are detached, and the run reports it.
#[test]
fn no_layer_is_detached_beyond_a_third_of_a_segment() {
    let mut config = slider(100.0, 0.02 * R);
    config["time"]["end_s"] = json!(0.05);
    // Any number of layers takes no more computing time.
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
fn impossible_detachment_is_refused() {
    let refused = |change: fn(&mut Value), expected: &str| {
        let mut config = slider(5.5, THIN * R);
        change(&mut config);
        let message = refusal(&config);
        assert!(message.contains(expected), "{expected}: {message}");
    };
    refused(
        |config| config["detachment"]["energy_j_per_m2"] = json!(0.0),
        "detachment.energy_j_per_m2",
    );
    refused(
        |config| config["detachment"]["depth_m"] = json!(0.5 * R),
        "detachment.depth_m",
    );
    refused(
        |config| config["gravity_m_per_s2"] = json!([0.0, -9.81]),
        "gravity",
    );
    refused(
        |config| config["sample"]["surface"] = json!(null),
        "bare surfaces",
    );
}
