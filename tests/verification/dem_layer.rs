//! The pressed layer and the promises of its recipe.
//!
//! From the project's own trials: about 840 T - 60 grains (T in mm) over |x| <= 8 mm for radii of 0.05 to 0.1 mm with
//! p ~ r^-2; a frictionless bed at rest is jammed at 4 contacts per grain without rattlers; solid fraction of such
//! beds 0.80 to 0.84. The tolerance of 15 % on the count is the scatter over seeds; the tolerance on the fraction is its
//! trend with the bed's height (grains at walls pack looser).

use dem_kernel::bodies::disk::Disk;
use dem_node::config::DemConfig;
use dem_node::config::layer::LayerConfig;
use dem_node::config::radii::RadiusLaw;
use dem_node::config::sample::SampleConfig;
use dem_node::config::surface::SurfaceConfig;
use dem_node::node::dem::Dem;
use dem_node::sample;
use dem_node::sample::types::Sample;
use dem_node::sample::{bed, layer};
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{build, refusal};

const CROWN: f64 = 0.3;
const STIFFNESS: f64 = 2.255e11;

fn recipe(thickness_m: f64) -> LayerConfig {
    LayerConfig {
        glued: true,
        surface: SurfaceConfig::default(),
        thickness_m,
        x_m: 0.0,
        half_width_m: 8e-3,
        half_width_load_n: None,
        crown_radius_m: CROWN,
        radius_min_m: 0.05e-3,
        radius_max_m: 0.1e-3,
        law: RadiusLaw::SurfaceUniform,
        power: None,
        seed: None,
        lid: false,
        lid_crown_radius_m: 0.0,
        bed_extra_m: 0.7e-3,
        press_pa: vec![300e6, 50e6],
        periodic_x_m: None,
    }
}

fn layer_of(thickness_m: f64, seed: u64) -> Sample {
    layer::prepare(&recipe(thickness_m), Some(STIFFNESS), false, seed).expect("the recipe works")
}

fn drop_at(x: f64) -> f64 {
    CROWN - (CROWN * CROWN - x * x).sqrt()
}

#[test]
fn a_layer_has_the_expected_number_of_grains() {
    for thickness in [0.3e-3, 0.6e-3] {
        for seed in 1..4 {
            let sample = layer_of(thickness, seed);
            let expected = 840.0 * thickness * 1e3 - 60.0;
            let found = sample.free.len() as f64;
            assert!(
                (found / expected - 1.0).abs() < 0.15,
                "{found} grains, {expected} expected"
            );
            assert!(
                (104..=130).contains(&sample.glued.len()),
                "{} glued",
                sample.glued.len()
            );
        }
    }
}

#[test]
fn the_pressed_bed_is_dense() {
    for seed in 1..4 {
        let bed = bed::press(&recipe(0.3e-3), STIFFNESS, seed).expect("it is jammed");
        assert!(
            (0.80..0.84).contains(&bed.solid_fraction),
            "{}",
            bed.solid_fraction
        );
        // 50 MPa on a mean diameter are about 7 N per contact, 3e-8 m at this stiffness.
        assert!(
            (2e-8..5e-8).contains(&bed.mean_overlap),
            "{:e}",
            bed.mean_overlap
        );
    }
}

#[test]
fn the_layer_follows_the_crown_with_constant_thickness() {
    let thickness = 0.3e-3;
    let sample = layer_of(thickness, 1);
    let surface = |disk: &Disk| disk.centre[1] + disk.radius + drop_at(disk.centre[0]);
    for millimetre in -7..7 {
        let range = f64::from(millimetre) * 1e-3..f64::from(millimetre + 1) * 1e-3;
        let here = sample
            .free
            .iter()
            .filter(|disk| range.contains(&disk.centre[0]));
        let highest = here.map(surface).fold(f64::NEG_INFINITY, f64::max);
        // The shift shears the flanks by x / R; the overlaps there push a few grains up when the layer relaxes,
        // by 3 to 5 um at 7 mm over four seeds.
        assert!(
            (highest - thickness).abs() < 6e-6,
            "top at {millimetre} mm: {highest:e}"
        );
    }
}

#[test]
fn the_glued_row_lies_within_a_radius_of_the_crowned_line() {
    let sample = layer_of(0.3e-3, 1);
    for disk in &sample.glued {
        let above = disk.centre[1] + drop_at(disk.centre[0]);
        assert!(
            above.abs() <= disk.radius * (1.0 + 1e-12),
            "{above:e} of {:e}",
            disk.radius
        );
    }
    assert!(sample.glued.is_sorted_by(|a, b| a.centre[0] <= b.centre[0]));
    let last = sample.glued.last().expect("there are some");
    assert!(last.centre[0] <= 8e-3, "it ends with the layer");
}

#[test]
fn rigid_grains_start_without_overlap() {
    let sample = layer::prepare(&recipe(0.15e-3), None, false, 1).expect("the recipe works");
    let disks: Vec<&Disk> = sample.free.iter().chain(&sample.glued).collect();
    for (i, a) in disks[..sample.free.len()].iter().enumerate() {
        for b in &disks[i + 1..] {
            let (dx, dy) = (a.centre[0] - b.centre[0], a.centre[1] - b.centre[1]);
            let gap = dx.hypot(dy) - a.radius - b.radius;
            assert!(gap > -1e-12, "overlap of {:e} m", -gap);
        }
    }
}

#[test]
fn only_the_seed_decides_the_bits() {
    let centres = |seed: u64| -> Vec<[u64; 2]> {
        let sample = layer_of(0.15e-3, seed);
        sample
            .free
            .iter()
            .map(|d| d.centre.map(f64::to_bits))
            .collect()
    };
    assert_eq!(centres(7), centres(7));
    assert_ne!(centres(7), centres(8));
}

fn config(changes: Value) -> Value {
    let mut config = json!({
        "law": {"kind": "coulomb", "friction": 0.3, "contact_stiffness_pa": STIFFNESS, "tangential_stiffness_ratio": 0.5},
        "solver": {"kind": "nsgs", "tolerance": 1e-4, "max_iterations": 1000, "min_iterations": 5},
        "time": {"pressure_pa": 1e9},
        "density_kg_per_m3": 7800.0,
        "mass_scale": 1000.0,
        "sample": {
            "kind": "layer", "thickness_m": 0.15e-3, "half_width_m": 8e-3, "crown_radius_m": CROWN,
            "radius_min_m": 0.05e-3, "radius_max_m": 0.1e-3, "law": "surface_uniform",
        },
        "wheel": {"load_n": 8000.0, "mass_kg": 0.01, "ramp_s": 5e-4, "hold_s": 4e-4},
    });
    for (key, value) in changes.as_object().into_iter().flatten() {
        config["sample"][key] = value.clone();
    }
    config
}

#[test]
fn the_seed_of_the_run_is_used_unless_the_sample_has_its_own() {
    let free = |changes: Value, seed: u64| {
        let config: DemConfig = kit::read_config(config(changes)).expect("it is valid");
        assert!(matches!(config.sample, SampleConfig::Layer(_)));
        sample::prepare(&config, seed)
            .expect("the recipe works")
            .free
    };
    assert_eq!(free(json!({}), 7), free(json!({"seed": 7}), 3));
    assert_ne!(free(json!({}), 7), free(json!({}), 3));
}

#[test]
fn recipes_that_make_no_layer_are_refused_by_key() {
    let cases = [
        (
            json!({"radius_min_m": -5e-5}),
            "sample.radius_min_m: must be above 0, got -5e-5; the key means: Smallest radius of the grains (m)",
        ),
        (
            json!({"radius_max_m": 4e-5}),
            "sample.radius_min_m: must be at most radius_max_m = 4e-5",
        ),
        (
            json!({"radius_min_m": 2e-4}),
            "sample.radius_min_m: must be at most radius_max_m = 1e-4",
        ),
        (
            json!({"press_pa": []}),
            "sample.press_pa: must have a length of at least 1",
        ),
        (
            json!({"press_pa": [1e6, 0.0]}),
            "sample.press_pa[1]: must be above 0",
        ),
        (json!({"crown_radius_m": 1e-3}), "sample.crown_radius_m"),
        (json!({"thickness_m": 0.0}), "sample.thickness_m"),
        (
            json!({"lid_crown_radius_m": 0.3}),
            "sample.lid_crown_radius_m: is the radius of a body above the layer, and there is no lid",
        ),
        (
            json!({"lid": true, "lid_crown_radius_m": 10e-3}),
            "sample.lid_crown_radius_m: must be at least 1.6e-2",
        ),
        (
            json!({"lid": true, "crown_radius_m": 0.0, "lid_crown_radius_m": 0.3, "periodic_x_m": [-8e-3, 8e-3]}),
            "sample.lid_crown_radius_m: a crown does not repeat along x",
        ),
        (
            json!({"x_m": 1e-3, "crown_radius_m": 0.0}),
            "sample.x_m: places a layer between two straight bodies, and this one has a wheel",
        ),
        (json!({"x_m": 1e-3, "lid": true}), "sample.x_m"),
        (
            json!({"x_m": 1e-3, "lid": true, "crown_radius_m": 0.0, "periodic_x_m": [-8e-3, 8e-3]}),
            "sample.x_m",
        ),
    ];
    for (changes, expected) in cases {
        let mut changed = config(changes);
        if changed["sample"]["lid"] == true {
            changed.as_object_mut().expect("a table").remove("wheel");
        }
        let message = refusal(&changed);
        assert!(message.contains(expected), "{message}");
    }
    let mut without_wheel = config(json!({}));
    without_wheel
        .as_object_mut()
        .expect("a table")
        .remove("wheel");
    assert!(refusal(&without_wheel).contains("wheel"));
}

#[test]
fn a_lid_is_cut_from_the_same_packing_and_holds_the_disks_that_cross_its_line() {
    let thickness = 0.5e-3;
    let with_lid = LayerConfig {
        lid: true,
        half_width_m: 2e-3,
        crown_radius_m: 0.0,
        ..recipe(thickness)
    };
    let sample = layer::prepare(&with_lid, Some(STIFFNESS), false, 1).expect("the recipe works");
    let (base, lid) = sample.glued.split_at(sample.glued.len() - sample.lid);
    assert!(base.len() > 20 && lid.len() > 20);
    for (row, height) in [(base, 0.0), (lid, thickness)] {
        for pair in row.windows(2) {
            assert!(pair[0].centre[0] < pair[1].centre[0], "by ascending x");
        }
        for disk in row {
            let off = (disk.centre[1] - height).abs();
            assert!(
                off <= disk.radius * (1.0 + 1e-12),
                "{disk:?} misses its line"
            );
        }
    }
    for disk in &sample.free {
        assert!(
            disk.centre[1] > 0.0 && disk.centre[1] < thickness,
            "{disk:?}"
        );
    }
}

/// Both faces are so curved that the layer is 0.3 mm thicker at its ends; the rows are cut there as in the middle.
#[test]
fn base_and_lid_follow_each_its_own_crown() {
    let (thickness, half_width, [below, above]) = (0.4e-3, 2e-3, [0.02, 0.01]);
    let drop = |x: f64, crown: f64| -> f64 { crown - (crown * crown - x * x).sqrt() };
    for (crown, lid_crown) in [(below, above), (0.0, above), (below, 0.0)] {
        let recipe = LayerConfig {
            lid: true,
            half_width_m: half_width,
            crown_radius_m: crown,
            lid_crown_radius_m: lid_crown,
            ..recipe(thickness)
        };
        let sample = layer::prepare(&recipe, Some(STIFFNESS), false, 1).expect("it works");
        let (base, lid) = sample.glued.split_at(sample.glued.len() - sample.lid);
        let lines: [&dyn Fn(f64) -> f64; 2] =
            [&|x| if crown > 0.0 { -drop(x, crown) } else { 0.0 }, &|x| {
                thickness
                    + if lid_crown > 0.0 {
                        drop(x, lid_crown)
                    } else {
                        0.0
                    }
            }];
        for ((row, line), side) in [base, lid].into_iter().zip(lines).zip([-1.0, 1.0]) {
            for pair in row.windows(2) {
                let dx = pair[1].centre[0] - pair[0].centre[0];
                assert!(dx > 0.0 && dx < 0.4e-3, "a hole of {dx:e} m in a row");
            }
            for disk in row {
                let off = (disk.centre[1] - line(disk.centre[0])).abs();
                assert!(off <= disk.radius * (1.0 + 1e-9), "{disk:?}: {off:e}");
                let beside = disk.centre[0].abs() > half_width;
                let flush = side * (disk.centre[1] - line(disk.centre[0])) - disk.radius;
                assert!(!beside || flush.abs() < 1e-15, "a catch row: {flush:e}");
            }
        }
        for Disk { centre: [x, y], .. } in &sample.free {
            let [floor, face] = lines.map(|line| line(*x));
            assert!(*y > floor && *y < face, "({x:e}, {y:e}) is outside");
        }
        let highest = sample.free.iter().map(|disk| disk.centre[1]);
        let highest = highest.fold(0.0, f64::max);
        let opens = lid_crown == 0.0 || highest > thickness;
        assert!(opens, "the grains go up to {highest:e} m");
    }
}

/// A coupler gets the line of each row from the layer, in addition to the rough disks.
#[test]
fn each_row_describes_its_own_line() {
    let mut lidded = config(
        json!({"lid": true, "half_width_m": 2e-3, "crown_radius_m": 0.02,
                                   "lid_crown_radius_m": 0.01, "thickness_m": 0.4e-3}),
    );
    lidded.as_object_mut().expect("a table").remove("wheel");
    let description = build(&lidded).describe();
    for (set, height, side, crown) in [("base", 0.0, -1.0, 0.02_f64), ("lid", 0.4e-3, 1.0, 0.01)] {
        assert!(description.smooth_m[set].len() > 30);
        for [x, y] in &description.smooth_m[set] {
            let line: f64 = height + side * (crown - (crown * crown - x * x).sqrt());
            assert!((y - line).abs() < 1e-15, "{set}: {y:e} for {line:e}");
        }
    }
}

/// A layer at another x is the layer at x = 0, moved: its rows, their surfaces and the ends beyond which grains are lost.
#[test]
fn a_layer_stands_at_its_x() {
    let at = |x_m: f64| {
        let mut layer =
            config(json!({"x_m": x_m, "lid": true, "half_width_m": 2e-3, "crown_radius_m": 0.0}));
        layer.as_object_mut().expect("a table").remove("wheel");
        build(&layer)
    };
    let (mut middle, mut beside) = (at(0.0), at(7e-3));
    let ends = |dem: &Dem| dem.bodies().ends.expect("it does not repeat");
    for [a, b] in [0, 1].map(|end| [ends(&middle)[end], ends(&beside)[end]]) {
        assert!((b - a - 7e-3).abs() < 1e-15, "{a:e} and {b:e}");
    }
    for set in ["base", "lid"] {
        let [a, b] = [&mut middle, &mut beside].map(|dem| dem.couple(set).expect("it is there"));
        assert!(a.len() > 30 && a.len() == b.len());
        assert_eq!(a.y_m, b.y_m);
        for (a, b) in a.x_m.iter().zip(&b.x_m) {
            assert!((b - a - 7e-3).abs() < 1e-15, "{a:e} and {b:e}");
        }
    }
    let free = [&middle, &beside].map(|dem| dem.bodies().free);
    assert_eq!(free[0], free[1]);
}

/// The half-width (m) of a layer designed for 1 000 N, under a wheel with this load.
fn half_width_under(load_n: f64) -> f64 {
    let mut changed = config(json!({"half_width_load_n": 1000.0}));
    changed["wheel"]["load_n"] = json!(load_n);
    let read: DemConfig = kit::read_config(&changed).expect("the scene is valid");
    let resolved = read.resolved().expect("there is a wheel");
    match resolved.sample {
        SampleConfig::Layer(layer) => layer.half_width_m,
        _ => panic!("it is a layer"),
    }
}

/// A Hertzian line contact widens with the square root of its load (Hertz 1882).
#[test]
fn a_layer_widens_with_its_design_load() {
    let meant = half_width_under(1000.0);
    assert_eq!(half_width_under(4000.0), 2.0 * meant);
    assert_eq!(half_width_under(250.0), 0.5 * meant);
    let idle = config(json!({"half_width_load_n": 1000.0}));
    let mut idle = idle;
    idle["wheel"]["load_n"] = json!(0.0);
    let message = refusal(&idle);
    assert!(message.contains("sample.half_width_load_n"), "{message}");
}
