//! Resuming runs that the shipped scenes do not cover: every scheme, several interfaces, plastic rails, rigid clusters, a periodic
//! strip.
//!
//! Exact answer: the run that was not cut off, bit for bit, for any number of threads.

use std::fmt::Write as _;

use harness::runs::Scratch;
use harness::scene::{bar, body, glue, head};
use scenario::load::Loaded;

use super::resume::{loaded, resume_from_all, shipped};
use super::several;

/// A scenario text with overrides; it is read once, so its file may go.
fn scene(text: &str, sets: &[&str]) -> Loaded {
    let scratch = Scratch::new("resume-scene");
    let file = scratch.path().join("scenario.toml");
    std::fs::write(&file, text).expect("writable");
    let kept = ["run.checkpoints_kept=1000"];
    loaded(&file, &[sets, &kept].concat())
}

/// The beginning of `quick`, with checkpoints on the way.
fn short_quick(sets: &[&str]) -> Loaded {
    let short = [
        "run.end_s=4e-4",
        "run.checkpoint_every_windows=250",
        "run.checkpoints_kept=100",
    ];
    loaded(&shipped("quick"), &[&short, sets].concat())
}

/// An elastic bar and a body of an eighth of its mass.
fn light(scheme: &str) -> String {
    let keys = "relaxation = 0.1\ntolerance_rel = 1e-9\nrepeats_max = 60";
    [
        head("schemes", 1.0, ""),
        bar("bar", 40, 0.9, "left_fixed = true"),
        body(40.0, 5.0, -1.0, "end_s = 300.0"),
        glue(scheme, 4, keys),
    ]
    .concat()
}

#[test]
fn every_scheme_resumes() {
    let cases = [
        ("staggered-serial", "none"),
        ("staggered-parallel", "none"),
        ("dual-schur-cheap", "none"),
        ("fixed-point-serial", "aitken"),
        ("fixed-point-serial", "iqn-ils"),
        ("fixed-point-parallel", "iqn-ils"),
        ("velocity", "none"),
    ];
    for (scheme, acceleration) in cases {
        let acceleration = format!("interface.glue.acceleration={acceleration}");
        let mut sets = vec![
            "run.checkpoint_every_windows=11",
            "interface.glue.unsafe_window=true",
        ];
        if !acceleration.ends_with("none") {
            sets.push(&acceleration);
        }
        let (count, _, _) = resume_from_all(&scene(&light(scheme), &sets), scheme);
        assert!(count > 5, "{scheme}: {count}");
    }
}

#[test]
fn a_layer_that_repeats_between_two_rails_resumes() {
    let sets = [
        "run.end_s=1.5e-5",
        "run.output.exchange=true",
        "run.checkpoint_every_windows=9",
        "run.checkpoints_kept=100",
    ];
    let scene = loaded(&shipped("verification/layer-that-repeats"), &sets);
    let (count, _, _) = resume_from_all(&scene, "resume-repeating");
    assert!(count >= 5, "{count}");
}

#[test]
fn heat_through_an_interface_resumes() {
    let sets = [
        "run.end_s=1e-4",
        "run.output.exchange=true",
        "run.checkpoint_every_windows=37",
        "run.checkpoints_kept=100",
    ];
    let scene = loaded(&shipped("wheel-rail-heat"), &sets);
    let (count, _, _) = resume_from_all(&scene, "resume-heat");
    assert!(count >= 3, "{count}");
}

#[test]
fn a_strip_that_reciprocates_on_its_layer_resumes() {
    let sets = [
        "participant.upper.config.time.end_s=4e-5",
        "participant.upper.config.boundary.top={ load_table = [[0.0, 0.0], [1e-5, -1000.0]], motion = { amplitude_m = 1e-6, frequency_hz = 5e4, start_s = 1.5e-5 } }",
        "run.output.exchange=true",
        "run.checkpoint_every_windows=17",
        "run.checkpoints_kept=100",
    ];
    let scene = loaded(&shipped("two-rails-reciprocating"), &sets);
    let (count, _, _) = resume_from_all(&scene, "resume-reciprocating");
    assert!(count >= 5, "{count}");
}

#[test]
fn swapped_roles_resume() {
    let schemes = [
        "staggered-serial",
        "staggered-parallel",
        "fixed-point-serial",
        "fixed-point-parallel",
    ];
    for scheme in schemes {
        let sets = [
            "run.checkpoint_every_windows=11",
            "interface.glue.unsafe_window=true",
            "interface.glue.dirichlet=continuum",
            "participant.body.config.point_mass_kg=1.0",
        ];
        let (count, _, summary) = resume_from_all(&scene(&light(scheme), &sets), scheme);
        assert!(count > 5, "{scheme}: {count}");
        let kinetic_j = summary["coupling"]["points_kinetic_j"].as_f64();
        assert!(
            kinetic_j.is_some_and(|energy| energy > 0.0),
            "{kinetic_j:?}"
        );
    }
}

#[test]
fn a_rail_that_follows_its_grains_resumes() {
    let sets = [
        "interface.layer-base.scheme=fixed-point-serial",
        "interface.layer-base.dirichlet=continuum",
        "interface.layer-base.tolerance_rel=1e-4",
    ];
    let (count, _, _) = resume_from_all(&short_quick(&sets), "resume-swapped");
    assert!(count >= 2, "{count}");
}

#[test]
fn connected_and_separate_interfaces_resume() {
    let sets = ["run.checkpoint_every_windows=5"];
    let scene = scene(&several::scenario(), &sets);
    let (count, _, _) = resume_from_all(&scene, "resume-several");
    assert!(count > 5, "{count}");
}

#[test]
fn modes_below_two_layers_resume_in_the_middle_of_halved_windows() {
    let sets = ["run.checkpoint_every_windows=3", "run.output.exchange=true"];
    let scene = scene(&several::halved_modes(), &sets);
    let (count, halved, _) = resume_from_all(&scene, "resume-halved-modes");
    assert!(count > 5 && halved > 0, "{count} with {halved} halved");
}

#[test]
fn the_modes_of_a_rail_resume() {
    // The last checkpoint comes before a window that the end cuts short; long windows are warned of.
    let sets = [
        "participant.rail.config.reduced.modes=20",
        "run.end_s=1.531e-4",
        "run.checkpoint_every_windows=50",
    ];
    let (count, _, _) = resume_from_all(&short_quick(&sets), "resume-modes");
    assert!(count >= 2, "{count}");
    let sets = [
        "interface.layer-base.substeps=100",
        "run.checkpoint_every_windows=10",
    ];
    let (count, _, _) = resume_from_all(&short_quick(&sets), "resume-long");
    assert!(count >= 2, "{count}");
}

#[test]
fn a_plastic_rail_resumes() {
    let sets = [
        "participant.rail.config.material.kind=j2",
        "participant.rail.config.material.yield_pa=2e7",
        "interface.layer-base.scheme=dual-schur-secant",
        "interface.layer-base.on_not_converged=halve",
    ];
    let (count, _, summary) = resume_from_all(&short_quick(&sets), "resume-plastic");
    assert!(count >= 2, "{count}");
    let flow_j = summary["participants"]["rail"]["energy"]["plastic_j"].as_f64();
    assert!(flow_j.is_some_and(|flow_j| flow_j > 0.0), "{flow_j:?}");
}

/// Couples, attractions, shared springs, feet and the mass detached from the steel are part of the state.
#[test]
fn loose_grains_that_resist_rolling_on_bare_steel_resume() {
    let scene = short_quick(&[
        "participant.third-body.config.sample.glued=false",
        "participant.third-body.config.law.rolling.coefficient=0.2",
        "participant.third-body.config.law.adhesion={ pull_off_pa = 1e8, range_m = 1e-5 }",
        "participant.third-body.config.detachment={ energy_j_per_m2 = 0.1, depth_m = 1e-8 }",
    ]);
    let (count, _, summary) = resume_from_all(&scene, "resume-rolling");
    assert!(count >= 2, "{count}");
    let detached = summary["results"]["detached_kg"].as_f64();
    assert!(detached.is_some_and(|mass| mass > 0.0), "{detached:?}");
}

/// Checkpoints fall into the time that a pair is pressed before it has a bond, and into the growth of bonds.
#[test]
fn bonds_resume_in_the_middle_of_healing() {
    let cohesion = "participant.third-body.config.law={ kind = \"cohesion\", friction = 0.3, contact_stiffness_pa = 2.255e11, tangential_stiffness_ratio = 0.5, cn_pa_per_m = 6.4e15, ct_pa_per_m = 6.4e15, w_j_per_m2 = 39.0, b_pa_m_s = 0.0, p = 1.0, h_prime = \"one\", alert_m = 1e-9, healing = { time_s = 2e-3, pressure_pa = 1e7 } }";
    let (count, _, summary) = resume_from_all(&short_quick(&[cohesion]), "resume-healing");
    assert!(count >= 2, "{count}");
    let results = &summary["participants"]["third-body"]["results"];
    let made = results["bonds_made"]
        .as_f64()
        .or(summary["results"]["bonds_made"].as_f64());
    assert!(made.is_some_and(|made| made > 20.0), "{made:?}");
    let mean = summary["results"]["healing_j"].as_f64();
    assert!(mean.is_some_and(|healing| healing > 0.0), "{mean:?}");
}

#[test]
fn a_rail_under_the_velocity_scheme_resumes() {
    let scene = short_quick(&["interface.layer-base.scheme=velocity"]);
    let (count, _, _) = resume_from_all(&scene, "resume-velocity");
    assert!(count >= 2, "{count}");
}

/// Disks on a floor, without coupling; `sample` holds further keys of the sample.
fn heap(disks: &str, sample: &str) -> Loaded {
    let text = format!(
        r#"
[run]
name = "heap"
thickness_m = 1e-3
output = {{ alone_steps = 5 }}
[[participant]]
name = "heap"
kind = "dem"
[participant.config]
density_kg_per_m3 = 7800.0
gravity_m_per_s2 = [196.0, -981.0]
law = {{ kind = "coulomb", friction = 0.3, contact_stiffness_pa = 1e8, tangential_stiffness_ratio = 0.5 }}
solver = {{ kind = "nsgs", tolerance = 1e-8, max_iterations = 5000, min_iterations = 2 }}
time = {{ step_s = 1e-4, pressure_pa = 1e5, end_s = 0.02 }}
[participant.config.sample]
kind = "disks"
walls = [{{ x_m = 0.0, y_m = 0.0, nx = 0.0, ny = 1.0 }}]
{sample}
disks = [
{disks}]
"#
    );
    scene(&text, &["run.checkpoint_every_windows=4"])
}

#[test]
fn a_periodic_strip_resumes() {
    let disks = (0..30).fold(String::new(), |mut text, i| {
        let (column, row) = (i % 6, i / 6);
        let x = 1e-3 * (2.05 * f64::from(column) + 0.9 * f64::from(row % 2));
        let y = 1e-3 * (1.0 + 1.85 * f64::from(row));
        let radius = [0.95e-3, 0.9e-3, 0.8e-3][i as usize % 3];
        let _ = writeln!(
            text,
            "{{ x_m = {x:e}, y_m = {y:e}, radius_m = {radius:e} }},"
        );
        text
    });
    let scene = heap(&disks, "periodic_x_m = [0.0, 12.5e-3]");
    let (count, _, _) = resume_from_all(&scene, "resume-strip");
    assert!(count > 5, "{count}");
}

#[test]
fn rigid_clusters_resume() {
    let disks = (0..12).fold(String::new(), |mut text, i| {
        let (column, row) = (i % 3, i / 3);
        let x = 5e-3 * f64::from(column) + 0.7e-3 * f64::from(row);
        let y = 1e-3 * (1.2 + 2.3 * f64::from(row));
        for (side, lift) in [(0.0, 0.0), (1.6e-3, 0.3e-3)] {
            let (x, y) = (x + side, y + lift);
            let _ = writeln!(
                text,
                "{{ x_m = {x:e}, y_m = {y:e}, radius_m = 1e-3, cluster = \"c{i}\" }},"
            );
        }
        text
    });
    let (count, _, _) = resume_from_all(&heap(&disks, ""), "resume-clusters");
    assert!(count > 5, "{count}");
}
