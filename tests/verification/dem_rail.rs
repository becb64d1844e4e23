//! The rail of grains and the promises of its recipe.
//!
//! Exact answers follow from areas: number of disks = solid fraction times area over the mean area of a disk, pi r_min
//! r_max for p ~ r^-2 (Renouf, Saulot and Berthier 2006, section 6: 65 mm by 20 mm contain 73 000 disks). The tolerance of 1 % covers
//! the disks along the faces: free sides pack looser, by about 1/2 of a diameter each. Moments of 1e5 samples scatter by 0.1 %.

use std::f64::consts::PI;

use dem_kernel::bodies::disk::Disk;
use dem_kernel::random::RandomNumbers;
use dem_node::config::DemConfig;
use dem_node::config::radii::{Radii, RadiusLaw};
use dem_node::config::sample::SampleConfig;
use dem_node::sample;
use dem_node::sample::types::Sample;
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::dem_support::{build, march, refusal, setting};

const RADII: [f64; 2] = [0.05e-3, 0.1e-3];
const WIDTH: f64 = 10e-3;
const HEIGHT: f64 = 3e-3;
const CROWN: f64 = 0.05;

/// A bonded rail, frictionless as the paper's, under a flat wheel.
fn config(changes: Value) -> Value {
    let mut config = json!({
        "law": {"kind": "cohesion", "friction": 0.0, "cn_pa_per_m": 1e18, "ct_pa_per_m": 1e18, "w_j_per_m2": 1e6, "b_pa_m_s": 0.0,
            "p": 1.0, "h_prime": "one", "alert_m": 8e-6},
        "solver": {"kind": "pcg", "tolerance": 1e-4, "max_iterations": 5000, "min_iterations": 1},
        "time": {"step_s": 2e-7, "pressure_pa": 1e9},
        "density_kg_per_m3": 7800.0,
        "mass_scale": 1000.0,
        "sample": {
            "kind": "rail", "width_m": WIDTH, "height_m": HEIGHT, "height_at": "edge", "crown_radius_m": CROWN,
            "radius_min_m": RADII[0], "radius_max_m": RADII[1], "law": "surface_uniform",
        },
        "wheel": {"load_n": 1000.0, "mass_kg": 0.01, "ramp_s": 1e-5, "hold_s": 1e-3},
    });
    for (key, value) in changes.as_object().into_iter().flatten() {
        config["sample"][key] = value.clone();
    }
    config
}

fn rail(changes: Value, seed: u64) -> Sample {
    let config: DemConfig = kit::read_config(config(changes)).expect("it is valid");
    config.validate().expect("it is valid");
    sample::prepare(&config, seed).expect("it comes to rest")
}

fn drop_at(x: f64) -> f64 {
    CROWN - (CROWN * CROWN - x * x).sqrt()
}

/// Depth of the base below the top of the crown (m).
fn depth() -> f64 {
    HEIGHT + drop_at(0.5 * WIDTH)
}

/// Area of the rail by Simpson's rule (m2), exact to 1e-9 here.
fn area() -> f64 {
    let n = 1000;
    let step = WIDTH / f64::from(n);
    let height = |i: i32| depth() - drop_at(-0.5 * WIDTH + f64::from(i) * step);
    let weight = |i: i32| match i {
        0 => 1.0,
        i if i == n => 1.0,
        i => [2.0, 4.0][(i % 2) as usize],
    };
    (0..=n).map(|i| weight(i) * height(i)).sum::<f64>() * step / 3.0
}

#[test]
fn the_number_of_disks_follows_from_the_area() {
    let sample = rail(json!({}), 1);
    let base = -depth();
    let inside = sample.glued.iter().filter(|disk| disk.centre[1] >= base);
    let found = (sample.free.len() + inside.count()) as f64;
    let expected = sample.solid_fraction * area() / (PI * RADII[0] * RADII[1]);
    assert!(
        (found / expected - 1.0).abs() < 0.01,
        "{found} disks, {expected} expected"
    );
    assert!(
        (0.82..0.85).contains(&sample.solid_fraction),
        "{}",
        sample.solid_fraction
    );
}

#[test]
fn all_disks_are_inside_and_the_disks_on_the_base_are_glued_over_the_whole_width() {
    let sample = rail(json!({}), 1);
    let shrunk = sample.radii_shrunk.expect("a rail reports it");
    assert!((3e-4..0.01).contains(&shrunk), "{shrunk}");
    let before = |disk: &Disk| disk.radius / (1.0 - shrunk);
    let base = -depth();
    for disk in &sample.free {
        let [x, y] = disk.centre;
        assert!(y <= -drop_at(x), "{disk:?} is above the crown");
        assert!(
            y >= base + before(disk) * (1.0 - 1e-12),
            "{disk:?} crosses the base"
        );
    }
    for disk in &sample.glued {
        let off = (disk.centre[1] - base).abs();
        assert!(
            off <= before(disk) * (1.0 + 1e-12),
            "{disk:?} misses the base"
        );
    }
    for disk in sample.free.iter().chain(&sample.glued) {
        let reach = disk.centre[0].abs() + disk.radius - 0.5 * WIDTH;
        assert!(reach < 2e-3 * disk.radius, "{disk:?} is beyond a side");
    }
    let xs: Vec<f64> = sample.glued.iter().map(|disk| disk.centre[0]).collect();
    let mut ends = vec![-0.5 * WIDTH];
    ends.extend(&xs);
    ends.push(0.5 * WIDTH);
    for pair in ends.windows(2) {
        let apart = pair[1] - pair[0];
        assert!(
            (0.0..4.0 * RADII[1]).contains(&apart),
            "a hole of {apart:e} m in the base"
        );
    }
    // The surface has the roughness of grains: some stick out of the crown, and no dent is deeper than two grains.
    let tops = |range: std::ops::Range<f64>| {
        let here = sample
            .free
            .iter()
            .filter(|disk| range.contains(&disk.centre[0]));
        let top = here.map(|disk| disk.centre[1] + disk.radius + drop_at(disk.centre[0]));
        top.fold(f64::NEG_INFINITY, f64::max)
    };
    for k in -12..12 {
        let top = tops(f64::from(k) * 4e-4..f64::from(k + 1) * 4e-4);
        assert!((-2.0 * RADII[1]..RADII[1]).contains(&top), "{top:e} at {k}");
    }
}

/// Overlaps are at most 1e-3 of the smaller radius, for any law of the radii.
#[test]
fn no_overlap_is_above_its_bound() {
    for changes in [
        json!({}),
        json!({"radius_min_m": 0.1e-3}),
        json!({"law": "power", "power": -4.0, "radius_min_m": 0.03e-3}),
    ] {
        let sample = rail(changes, 2);
        let disks: Vec<&Disk> = sample.free.iter().chain(&sample.glued).collect();
        let mut touching = 0;
        for (i, a) in disks[..sample.free.len()].iter().enumerate() {
            for b in &disks[i + 1..] {
                let [x, y] = [0, 1].map(|k| a.centre[k] - b.centre[k]);
                let gap = x.hypot(y) - a.radius - b.radius;
                let smaller = a.radius.min(b.radius);
                assert!(gap >= -1e-3 * smaller * (1.0 + 1e-9), "{gap:e}");
                touching += usize::from(gap < 1e-2 * smaller);
            }
        }
        // A packing at rest has nearly 2 contacts per disk (Moukarzel 1998); rattlers have no contacts.
        assert!(touching as f64 > 1.5 * disks.len() as f64, "{touching}");
    }
}

#[test]
fn the_height_counts_at_the_edge_or_at_the_crown() {
    let lowest = |at: &str| {
        let sample = rail(json!({"height_at": at}), 1);
        let y = sample.glued.iter().map(|disk| disk.centre[1]);
        y.sum::<f64>() / sample.glued.len() as f64
    };
    let difference = lowest("crown") - lowest("edge");
    assert!(
        (difference - drop_at(0.5 * WIDTH)).abs() < 0.5 * RADII[0],
        "{difference:e}"
    );
}

fn bits(sample: &Sample) -> Vec<[u64; 3]> {
    let all = sample.free.iter().chain(&sample.glued);
    all.map(|d| [d.centre[0], d.centre[1], d.radius].map(f64::to_bits))
        .collect()
}

#[test]
fn the_seed_decides_every_bit_and_threads_do_not() {
    assert_eq!(
        bits(&rail(json!({}), 7)),
        bits(&rail(json!({"seed": 7}), 3))
    );
    assert_ne!(bits(&rail(json!({}), 7)), bits(&rail(json!({}), 8)));
    let after = |threads: usize| {
        let config = kit::read_config(config(json!({}))).expect("it is valid");
        let setting = Setting {
            threads,
            ..setting(1)
        };
        let mut dem = dem_node::Dem::new(&config, &setting).expect("it can be prepared");
        march(&mut dem, 0, 5);
        dem.finish().expect("it finishes").state_hash
    };
    assert_eq!(after(1), after(2));
}

#[test]
fn a_small_rail_carries_its_wheel_for_fifty_steps() {
    let mut dem = build(&config(json!({})));
    let report = march(&mut dem, 0, 50);
    assert!(report.signal("bonds") > 1000.0);
    let outcome = dem.finish().expect("it finishes");
    let found: Vec<String> = outcome.findings.iter().map(|f| format!("{f:?}")).collect();
    assert!(found.is_empty() && outcome.warnings.is_empty(), "{found:?}");
    assert!(dem.describe().warnings.is_empty());
    let result = |name: &str| outcome.results[name];
    assert!((3e-4..0.01).contains(&result("radii_shrunk_rel")));
    assert!((0.82..0.85).contains(&result("solid_fraction")));
    assert_eq!(dem.describe().sets, ["base"]);
}

/// Each law with 1e5 samples, against its first two moments by a fine quadrature of p(r).
#[test]
fn radii_follow_their_law() {
    let laws = [
        (RadiusLaw::SurfaceUniform, None, -2.0),
        (RadiusLaw::NumberUniform, None, 0.0),
        (RadiusLaw::LogUniform, None, -1.0),
        (RadiusLaw::Power, Some(-3.5), -3.5),
        (RadiusLaw::Power, Some(-1.0), -1.0),
        (RadiusLaw::Power, Some(2.0), 2.0),
    ];
    for (law, power, k) in laws {
        let radii = Radii {
            law,
            power,
            ends: [1.0, 4.0],
        };
        let mut random = RandomNumbers::new(5);
        let draws: Vec<f64> = (0..100_000).map(|_| radii.at(random.unit())).collect();
        assert!(draws.iter().all(|r| (1.0..=4.0).contains(r)));
        let exact = |n: f64| {
            let points = (0..30_000).map(|i| 1.0 + (f64::from(i) + 0.5) * 1e-4);
            let sums = points.fold([0.0; 2], |[a, b], r: f64| {
                [a + r.powf(n + k), b + r.powf(k)]
            });
            sums[0] / sums[1]
        };
        for (n, computed) in [(1.0, radii.mean()), (2.0, radii.mean_square())] {
            let drawn = draws.iter().map(|r| r.powf(n)).sum::<f64>() / draws.len() as f64;
            assert!((drawn / exact(n) - 1.0).abs() < 0.01, "{radii:?}: {drawn}");
            assert!(
                (computed / exact(n) - 1.0).abs() < 1e-6,
                "{radii:?}: {computed}"
            );
        }
    }
}

#[test]
fn recipes_that_make_no_rail_are_refused_by_key() {
    let cases = [
        (
            json!({"radius_min_m": -5e-5}),
            "sample.radius_min_m: must be above 0",
        ),
        (
            json!({"radius_max_m": 4e-5}),
            "sample.radius_min_m: must be at most radius_max_m = 4e-5",
        ),
        (
            json!({"radius_min_m": 1e-7, "radius_max_m": 1e-7}),
            "sample.radius_min_m: a rail of",
        ),
        (json!({"width_m": 1e-3}), "sample.width_m: must be at least"),
        (json!({"height_m": 0.0}), "sample.height_m: must be above 0"),
        (json!({"height_m": 5e-4}), "sample.height_m: the sides are"),
        (
            json!({"height_at": "crown", "height_m": 9e-4}),
            "sample.height_m: the sides are",
        ),
        (
            json!({"height_at": "side"}),
            "sample.height_at: `side` is not one of the choices",
        ),
        (
            json!({"crown_radius_m": 9e-3}),
            "sample.crown_radius_m: must be at least 1e-2",
        ),
        (
            json!({"crown_radius_m": -1.0}),
            "sample.crown_radius_m: must be at least 0",
        ),
        (
            json!({"law": "power"}),
            "sample.power: this key is required and missing",
        ),
        (
            json!({"power": -2.0}),
            "sample.power: belongs to law = \"power\"",
        ),
        (
            json!({"law": "power", "power": 50.0}),
            "sample.power: must be at least -20 and at most 20",
        ),
        (
            json!({"periodic_x_m": [-1.0, 1.0]}),
            "sample.periodic_x_m: no such key",
        ),
    ];
    for (changes, expected) in cases {
        let message = refusal(&config(changes));
        assert!(message.contains(expected), "{message}");
    }
    let mut changed = config(json!({}));
    changed["wheel"]["radius_m"] = json!(1e-4);
    assert!(refusal(&changed).contains("wheel.radius_m"));
    changed.as_object_mut().expect("a table").remove("wheel");
    assert!(refusal(&changed).contains("wheel: a rail needs a wheel"));
}

/// A run of a few steps under a wheel of disks, bonded or not: bonding adds one bond for each near pair of wheel and rail.
#[test]
fn a_wheel_of_disks_stands_on_the_rail_and_may_be_bonded_to_it() {
    let mut counts = Vec::new();
    for bonded in [false, true] {
        let mut config = config(json!({}));
        config["wheel"]["face"] = json!("disks");
        config["wheel"]["bonded"] = json!(bonded);
        let mut dem = build(&config);
        march(&mut dem, 0, 20);
        let outcome = dem.finish().expect("it has run");
        assert!(outcome.results["true_residual_max"] <= 1e-4);
        assert_eq!(outcome.results["bonds_broken"], 0.0);
        counts.push(outcome.results["bonds"]);
    }
    // 72 disks; the crown drops by more than the reach of a bond within a fifth of the width.
    assert!((1.0..72.0).contains(&(counts[1] - counts[0])), "{counts:?}");
}

#[test]
fn impossible_faces_are_refused() {
    let under = |changes: Value| {
        let mut config = config(json!({}));
        for (key, value) in changes.as_object().expect("a table") {
            config["wheel"][key] = value.clone();
        }
        config
    };
    for (changes, expected) in [
        (
            json!({"face": "disks", "radius_m": 0.4}),
            "wheel.radius_m: face = \"disks\" lies on a line",
        ),
        (json!({"bonded": true}), "wheel.bonded: bonds join disks"),
    ] {
        let message = refusal(&under(changes));
        assert!(message.contains(expected), "{message}");
    }
    let mut listed = under(json!({"face": "disks"}));
    listed["sample"] =
        json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": 0.0, "radius_m": 1e-4}]});
    let message = refusal(&listed);
    assert!(message.contains("wheel.face: \"disks\" takes"), "{message}");
}

#[test]
fn rails_are_read_as_such() {
    let config: DemConfig = kit::read_config(config(json!({}))).expect("it is valid");
    assert!(matches!(config.sample, SampleConfig::Rail(_)));
}
