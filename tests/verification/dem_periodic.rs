//! A strip that is periodic along x.
//!
//! ```text
//!   :O   O  O :O       a disk that leaves on the right enters on the left; the seam (:) has no effect
//!   :_________:
//! ```
//!
//! Reference: invariance under translation, and the same scenes inside the strip. Tolerance: rounding of positions, 1e-18 m over the
//! step, which a heap multiplies by its condition (below 1e3).

use dem_kernel::contact::detect::Slot;
use dem_node::Dem;
use dem_node::config::DemConfig;
use dem_node::config::sample::SampleConfig;
use dem_node::sample::bed;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{Report, build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const LENGTH: f64 = 12.5 * R;
const G: f64 = 9.81;

fn strip(disks: Value) -> Value {
    json!({
        "kind": "disks", "disks": disks, "periodic_x_m": [0.0, LENGTH],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    })
}

/// Disks high above the floor.
fn flying(law: Value, step: f64, disks: Value) -> Dem {
    build(&scene(law, step, strip(disks), json!({})))
}

/// A heap of disks of three sizes that fills the strip, shifted and folded back or not.
fn heap(shift: f64, fold: bool, law: Value) -> Dem {
    let place = |x: f64| {
        let x = x + shift;
        if fold { x.rem_euclid(LENGTH) } else { x }
    };
    let disk = |i: i32| {
        let (column, row) = (i % 6, i / 6);
        let x = R * (2.05 * f64::from(column) + 0.9 * f64::from(row % 2));
        let radius = R * [0.95, 0.9, 0.8][i as usize % 3];
        json!({"x_m": place(x), "y_m": R * (1.0 + 1.85 * f64::from(row)), "radius_m": radius})
    };
    let disks: Vec<Value> = (0..30).map(disk).collect();
    let gravity = json!({"gravity_m_per_s2": [20.0 * G, -100.0 * G]});
    build(&scene(law, 1e-4, strip(json!(disks)), gravity))
}

/// The contacts that carry force.
fn pressed(dem: &Dem) -> Vec<Slot> {
    let slots = dem.state().list.slots.iter();
    slots.filter(|slot| slot.force[0] > 0.0).copied().collect()
}

#[track_caller]
fn move_alike(one: &Dem, other: &Dem, tolerance: f64) {
    let numbers = |dem: &Dem| dem.state().velocities.concat();
    for (a, b) in numbers(one).into_iter().zip(numbers(other)) {
        close("velocity", b, a, tolerance);
    }
}

/// The same scene inside and across the seam after this many steps, and the report of the scene inside.
#[track_caller]
fn inside_and_across(make: fn(f64) -> Dem, places: [f64; 2], steps: u32) -> ([Dem; 2], Report) {
    let [mut inside, mut across] = places.map(make);
    let report = march(&mut inside, 0, steps);
    march(&mut across, 0, steps);
    move_alike(&inside, &across, 1e-9);
    ([inside, across], report)
}

#[test]
fn a_shifted_heap_moves_alike() {
    for law in [
        json!({"kind": "signorini", "contact_stiffness_pa": 1e8}),
        json!({
            "kind": "coulomb", "friction": 0.3,
            "contact_stiffness_pa": 1e8, "tangential_stiffness_ratio": 0.5,
        }),
    ] {
        let mut plain = heap(0.0, false, law.clone());
        let report = march(&mut plain, 0, 60);
        assert!(
            report.signal("contacts") > 30.0,
            "the heap must have formed"
        );
        let x = |disk: u32| plain.state().centres[disk as usize][0];
        let crosses = |slot: &&Slot| slot.b < 30 && (x(slot.a) - x(slot.b)).abs() > 0.5 * LENGTH;
        let across = pressed(&plain).iter().filter(crosses).count();
        assert!(across > 1, "contacts must cross the seam");
        for (shift, fold) in [
            (0.371 * LENGTH, false),
            (0.371 * LENGTH, true),
            (-7.9 * LENGTH, false),
        ] {
            let mut moved = heap(shift, fold, law.clone());
            march(&mut moved, 0, 60);
            move_alike(&plain, &moved, 1e-9 * report.signal("speed_max_m_per_s"));
            let (plain, moved) = (pressed(&plain), pressed(&moved));
            assert_eq!(plain.len(), moved.len());
            for (a, b) in plain.iter().zip(&moved) {
                assert_eq!((a.a, a.b), (b.a, b.b), "{shift:e} {fold}");
                close("force", b.force[0], a.force[0], 1e-5 * mass(R) * G);
            }
        }
    }
}

#[test]
fn a_disk_that_leaves_hits_the_disk_behind_the_seam() {
    let disks = json!([
        {"x_m": 0.9 * LENGTH, "y_m": 5.0 * R, "radius_m": R, "vx_m_per_s": 1.0},
        {"x_m": 0.3 * LENGTH, "y_m": 5.0 * R, "radius_m": R},
    ]);
    let mut dem = flying(json!({"kind": "signorini"}), 1e-5, disks);
    let way = 0.4 * LENGTH - 2.0 * R;
    let steps = (way / 1e-5) as u32;
    march(&mut dem, 0, steps - 1);
    close("before", dem.state().velocities[0][0], 1.0, 0.0);
    let report = march(&mut dem, u64::from(steps) - 1, 3);
    for v in &dem.state().velocities {
        close("after", v[0], 0.5, 1e-10);
    }
    close(
        "momentum",
        report.signal("momentum_x_kg_m_per_s"),
        mass(R),
        1e-14 * mass(R),
    );
}

#[test]
fn a_crowd_keeps_its_momentum_across_the_seam() {
    let disk = |i: i32| {
        let (x, y) = (
            f64::from(i % 5) * 2.5 * R,
            R * (50.0 + 2.4 * f64::from(i / 5)),
        );
        let (vx, vy) = (f64::from(i * 7 % 11) - 4.0, f64::from(i * 5 % 7) - 3.0);
        json!({"x_m": x, "y_m": y, "radius_m": R, "vx_m_per_s": vx, "vy_m_per_s": vy, "spin_rad_per_s": 100.0 * vx})
    };
    let disks: Vec<Value> = (0..20).map(disk).collect();
    let mut dem = flying(
        json!({"kind": "coulomb", "friction": 0.4}),
        1e-5,
        json!(disks),
    );
    let before = dem.state().momentum(dem.bodies());
    let energy = dem.state().kinetic(dem.bodies());
    let report = march(&mut dem, 0, 600);
    let beyond = |c: &[f64; 2]| !(0.0..LENGTH).contains(&c[0]);
    assert!(
        dem.state().centres.iter().any(beyond),
        "some must have left"
    );
    assert!(report.energy("friction") > 1e-3 * energy);
    let after = dem.state().momentum(dem.bodies());
    for (now, then) in after.into_iter().zip(before) {
        close("momentum", now, then, 1e-11 * 20.0 * mass(R));
    }
    assert!(
        report.imbalance(energy) < 1e-10,
        "{:e}",
        report.imbalance(energy)
    );
}

/// Two bonded disks that part, turn and shear, the first one at x.
fn bonded(x: f64) -> Dem {
    let law = json!({
        "kind": "cohesion", "friction": 0.3, "contact_stiffness_pa": 5e8, "tangential_stiffness_ratio": 0.5,
        "cn_pa_per_m": 1e12, "ct_pa_per_m": 5e11, "w_j_per_m2": 10.0, "b_pa_m_s": 0.0, "p": 1.0,
        "h_prime": "one", "alert_m": 1e-6,
    });
    let disks = json!([
        {"x_m": x, "y_m": 5.0 * R, "radius_m": R, "vx_m_per_s": 0.25, "vy_m_per_s": 0.1},
        {"x_m": (x + 2.0 * R).rem_euclid(LENGTH), "y_m": 5.0 * R, "radius_m": R, "vx_m_per_s": 1.05},
    ]);
    flying(law, 1e-7, disks)
}

#[test]
fn a_bond_across_the_seam_behaves_as_one_inside() {
    let places = [2.0 * R, LENGTH - 0.7 * R];
    let ([inside, across], report) = inside_and_across(bonded, places, 150);
    assert!(
        report.energy("cohesion") > 0.0,
        "the bond must give way in part"
    );
    let (a, b) = (&inside.state().bonds[0], &across.state().bonds[0]);
    assert!(a.adhesion < 0.9 && a.adhesion > 0.05, "{}", a.adhesion);
    close("adhesion", b.adhesion, a.adhesion, 1e-9);
    close("opening", b.opening, a.opening, 1e-9 * a.opening);
}

/// Two bars that turn and meet; the first disk lies at x.
fn bars(x: f64) -> Dem {
    let member = |dx: f64, y: f64, cluster: &str| {
        let x = (x + dx * R).rem_euclid(LENGTH);
        json!({"x_m": x, "y_m": (y + 6.0) * R, "radius_m": R, "cluster": cluster})
    };
    let mut sample = strip(json!([
        member(0.0, 0.0, "left"),
        member(1.8, 0.9, "left"),
        member(5.0, 0.3, "right"),
        member(6.8, -0.6, "right"),
    ]));
    sample["clusters"] = json!([
        {"name": "left", "vx_m_per_s": 1.0, "spin_rad_per_s": 150.0},
        {"name": "right", "vx_m_per_s": -1.5, "vy_m_per_s": 0.1, "spin_rad_per_s": -80.0},
    ]);
    let law = json!({"kind": "coulomb", "friction": 0.5});
    build(&scene(law, 1e-5, sample, json!({})))
}

#[test]
fn clusters_meet_across_the_seam_as_they_do_inside() {
    // The seam lies between the bars: each is listed whole, one on either side.
    let (_, report) = inside_and_across(bars, [2.0 * R, LENGTH - 3.0 * R], 300);
    let start = bars(2.0 * R);
    let before = start.state().kinetic(start.bodies());
    assert!(report.energy("impact") > 0.01 * before, "they must meet");
}

/// A layer between a straight base and the wheel, periodic along x.
fn layer(changes: Value) -> Value {
    let mut config = json!({
        "law": {"kind": "coulomb", "friction": 0.3, "contact_stiffness_pa": 2.255e11, "tangential_stiffness_ratio": 0.5},
        "solver": {"kind": "nsgs", "tolerance": 1e-4, "max_iterations": 2000, "min_iterations": 2},
        "time": {"step_s": 6e-7, "pressure_pa": 1e9},
        "density_kg_per_m3": 7800.0,
        "mass_scale": 1000.0,
        "sample": {
            "kind": "layer", "thickness_m": 0.4e-3, "half_width_m": 2e-3, "crown_radius_m": 0.0,
            "radius_min_m": 0.05e-3, "radius_max_m": 0.1e-3, "law": "surface_uniform",
            "periodic_x_m": [-2e-3, 2e-3],
        },
        "wheel": {"load_n": 1200.0, "mass_kg": 0.01, "ramp_s": 3e-4, "hold_s": 3e-4},
    });
    for (key, value) in changes.as_object().into_iter().flatten() {
        config["sample"][key] = value.clone();
    }
    config
}

#[test]
fn a_layer_without_ends_carries_the_wheel_everywhere() {
    let mut dem = build(&layer(json!({})));
    let widest = 0.1e-3;
    let glued = &dem.bodies().reference;
    let row: Vec<f64> = glued.iter().map(|c| c[0]).collect();
    assert!(row.iter().all(|x| (-2e-3..2e-3).contains(x)));
    let ends = row[0] + 4e-3 - row[row.len() - 1];
    assert!(
        ends < 2.0 * widest,
        "the row has a hole at the seam: {ends:e}"
    );
    let report = march(&mut dem, 0, 1000);
    close("load", report.signal("wheel_fn_n"), 1200.0, 12.0);
    close("base", report.signal("glued_fy_n"), -1200.0, 12.0);
    // The lateral forces on wheel and base are opposite.
    let sideways = report.signal("wheel_ft_n") + report.signal("glued_fx_n");
    close("sideways", sideways, 0.0, 12.0);
    assert_eq!(report.signal("lost_grains"), 0.0);
    // Quarters of the wheel: no end carries less. About 7 contacts per quarter scatter by a third.
    let mut quarters = [0.0; 4];
    let wheel = dem.bodies().disks() as u32;
    for slot in dem.state().list.slots.iter().filter(|slot| slot.b == wheel) {
        let x = dem.state().centres[slot.a as usize][0].clamp(-1.999e-3, 1.999e-3);
        quarters[((x + 2e-3) / 1e-3) as usize] += slot.force[0];
    }
    assert!(
        quarters.iter().all(|f| (150.0..450.0).contains(f)),
        "{quarters:?}"
    );
}

#[test]
fn the_bed_of_a_strip_has_no_walls() {
    let config: DemConfig = kit::read_config(layer(json!({}))).expect("it is valid");
    let SampleConfig::Layer(recipe) = &config.sample else {
        panic!("it is a layer");
    };
    let bed = bed::press(recipe, 2.255e11, 1).expect("it is jammed");
    // As between side walls, `dem_layer`.
    assert!(
        (0.80..0.84).contains(&bed.solid_fraction),
        "{}",
        bed.solid_fraction
    );
    let mut pairs = bed.packing.contacts();
    pairs.retain(|[_, other]| *other < bed.packing.centres.len());
    let x = |disk: usize| bed.packing.centres[disk][0];
    assert!(
        bed.packing
            .centres
            .iter()
            .all(|c| (-2e-3..2e-3).contains(&c[0]))
    );
    let opposite = pairs.into_iter().filter(|[a, b]| x(*a) * x(*b) < 0.0);
    let (across, middle): (Vec<[usize; 2]>, Vec<_>) =
        opposite.partition(|[a, b]| (x(*a) - x(*b)).abs() > 2e-3);
    let [across, middle] = [across.len(), middle.len()];
    assert!(
        middle >= 6 && (middle / 2..2 * middle).contains(&across),
        "{across} at the seam, {middle} in the middle"
    );
}

#[test]
fn keys_that_exclude_a_periodic_strip_are_refused() {
    let with = |changes: Value| {
        let mut sample = strip(json!([{"x_m": R, "y_m": R, "radius_m": R}]));
        for (key, value) in changes.as_object().into_iter().flatten() {
            sample[key] = value.clone();
        }
        scene(json!({"kind": "signorini"}), 1e-5, sample, json!({}))
    };
    let wall = |wall: Value| with(json!({"walls": [wall]}));
    let bar = |x: f64| json!({"x_m": x, "y_m": R, "radius_m": R, "cluster": "bar"});
    let mut curved = with(json!({"walls": []}));
    curved["wheel"] =
        json!({"load_n": 1.0, "mass_kg": 1.0, "radius_m": 10.0 * R, "ramp_s": 0.0, "hold_s": 1.0});
    let cases = [
        (
            with(json!({"periodic_x_m": [0.0, 7.9 * R]})),
            "sample.periodic_x_m: a strip of",
        ),
        (
            with(json!({"periodic_x_m": [1.0, 0.0]})),
            "sample.periodic_x_m: a strip of",
        ),
        (
            wall(json!({"x_m": 0.0, "y_m": 0.0, "nx": 0.1, "ny": 1.0})),
            "sample.walls[0]: only a level",
        ),
        (
            wall(json!({"points_m": [[0.0, 0.0], [1.0, 0.0]]})),
            "sample.walls[0]: only a level",
        ),
        (curved, "wheel.radius_m"),
        (
            with(json!({"disks": [bar(0.5 * R), bar(LENGTH - 0.5 * R)]})),
            "sample.disks[1].x_m: lies more than half the strip",
        ),
        (
            layer(json!({"periodic_x_m": [0.0, 4e-3]})),
            "sample.periodic_x_m: a layer covers",
        ),
        (
            layer(json!({"crown_radius_m": 0.3})),
            "sample.crown_radius_m",
        ),
    ];
    for (config, expected) in cases {
        let message = refusal(&config);
        assert!(message.contains(expected), "{expected}: {message}");
    }
}

/// The points of a coupled row lie in the strip and represent its whole length once; neighbours, also across the seam, lie
/// beside each other, with less than the largest diameter between them.
#[test]
fn the_glued_rows_of_a_coupled_layer_cover_its_strip_once() {
    let mut coupled = layer(json!({"lid": true}));
    coupled["time"] = json!({"pressure_pa": 1e9});
    coupled.as_object_mut().expect("a table").remove("wheel");
    let mut dem = build(&coupled);
    let description = dem.describe();
    for set in ["base", "lid"] {
        assert_eq!(description.period_m[set], 4e-3);
        let row = dem.couple(set).expect("a strip can be coupled");
        assert!(row.x_m.iter().all(|x| (-2e-3..2e-3).contains(x)));
        close(set, row.length_m.iter().sum(), 4e-3, 1e-15);
        for i in 0..row.len() {
            let next = (i + 1) % row.len();
            let turn = if next == 0 { 4e-3 } else { 0.0 };
            let [x, y] = [
                row.x_m[next] + turn - row.x_m[i],
                row.y_m[next] - row.y_m[i],
            ];
            let reach = row.radius_m[i] + row.radius_m[next];
            assert!(x.hypot(y) > 0.99 * reach, "{set}: {i} and the next overlap");
            assert!(
                x < reach + 2.0 * 0.1e-3,
                "{set}: nothing between {i} and the next"
            );
        }
    }
}
