//! Bonds among moving grains: escape, decohesion by shear, birth at rest, breaking, energy.
//!
//! Escape (E = kinetic energy of the relative motion over w l, b = 0, h' = 1): below 1/2 the bond stays elastic and opens to
//! sqrt(2E) delta_0; below 1 the work w (1 - delta_0^2/(2u^2)) stops it at u = delta_0/sqrt(a), a = 2(1 - E); above, they part.
//! The same holds along the contact with Ct and the mass 1/W_tt = m/6 of two disks. Reference: closed form, tabulated in
//! the project's own `reference/bond_escape.csv`. Tolerances: implicit Euler damps omega h/2 per radian, 2e-4 here, and the
//! turning point of weak bonds is 1/(1 - E) times as sensitive; centres that slide 1 um past each other turn by 0.4 %.

use dem_node::Dem;
use protocol::{Node, Window};
use serde_json::{Value, json};

use crate::dem_support::{Report, THICKNESS, build, close, march, mass, scene};

const R: f64 = 0.07e-3;
const W: f64 = 60.0;
const CN: f64 = 4e14;
/// l of two disks of radius R (m2).
const AREA: f64 = 0.5 * R * THICKNESS;

fn rigid() -> Value {
    json!({
        "kind": "cohesion", "friction": 0.3, "cn_pa_per_m": CN, "ct_pa_per_m": CN, "w_j_per_m2": W,
        "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 2e-6,
    })
}

fn compliant() -> Value {
    let mut law = rigid();
    law["contact_stiffness_pa"] = json!(1.4e10);
    law["tangential_stiffness_ratio"] = json!(0.5);
    law
}

/// Two disks with a gap.
fn pair(gap: f64, first: Value, second: Value) -> Value {
    let mut disks = [
        json!({"x_m": 0.0, "y_m": 0.0, "radius_m": R}),
        json!({"x_m": 2.0 * R + gap, "y_m": 0.0, "radius_m": R}),
    ];
    for (disk, more) in disks.iter_mut().zip([first, second]) {
        for (key, value) in more.as_object().into_iter().flatten() {
            disk[key] = value.clone();
        }
    }
    json!({"kind": "disks", "disks": disks})
}

/// Largest opening and slip, and the last adhesion, until the motion turns or the steps end.
fn widest(dem: &mut Dem, steps: u64) -> ([f64; 2], f64) {
    let (mut widest, mut adhesion) = ([0.0f64; 2], 1.0);
    for step in 0..steps {
        march(dem, 10 * step, 10);
        let Some(bond) = dem.state().bonds.first() else {
            return (widest, 0.0);
        };
        if bond.opening.abs().max(bond.slip.abs()) < 0.9 * widest[0].max(widest[1]) {
            break;
        }
        widest = [widest[0].max(bond.opening), widest[1].max(bond.slip.abs())];
        adhesion = bond.adhesion;
    }
    (widest, adhesion)
}

fn table() -> Vec<Vec<f64>> {
    let text = include_str!("reference/bond_escape.csv");
    let numbers = |line: &str| line.split(',').map(str::parse).collect::<Result<_, _>>();
    text.lines().filter_map(|line| numbers(line).ok()).collect()
}

#[test]
fn two_disks_escape_their_bond_with_the_energy_w() {
    let h = 2e-11;
    let mut held = 0;
    for row in table() {
        let [energy, reach, adhesion, escape] = [row[0], row[1], row[2], row[3]];
        let speed = (2.0 * energy * W * AREA / (0.5 * mass(R))).sqrt();
        let sample = pair(
            0.5e-6,
            json!({"vx_m_per_s": -0.5 * speed}),
            json!({"vx_m_per_s": 0.5 * speed}),
        );
        let mut dem = build(&scene(rigid(), h, sample, json!({})));
        let ([opening, _], left) = widest(&mut dem, 20_000);
        if escape == 1.0 {
            // At E = 1 the scheme's damping decides, with a thousandth of the strength.
            assert!(
                energy == 1.0 || opening > 15.0 * (W / CN).sqrt(),
                "E = {energy}: {opening}"
            );
            continue;
        }
        let slack = 2e-3 / (1.0 - energy);
        close("opening", opening / (W / CN).sqrt(), reach, slack * reach);
        close("adhesion", left, adhesion, slack);
        held += 1;
    }
    assert_eq!(held, 7);
}

/// One pair parts with 1.5 w l, and the other stays at rest.
#[test]
fn the_mean_adhesion_counts_all_bonds_of_the_start() {
    let speed = (3.0 * W * AREA / (0.5 * mass(R))).sqrt();
    let apart = |v: f64| json!({"vx_m_per_s": 0.5 * v});
    let mut sample = pair(0.5e-6, apart(-speed), apart(speed));
    let others = pair(0.5e-6, json!({"y_m": 1.0}), json!({"y_m": 1.0}));
    let disks = sample["disks"].as_array_mut().expect("a list");
    disks.extend(others["disks"].as_array().expect("a list").iter().cloned());
    let mut dem = build(&scene(rigid(), 1e-9, sample, json!({})));
    march(&mut dem, 0, 200);
    let bonds = &dem.state().bonds;
    let (first, second) = (bonds[0].adhesion, bonds[1].adhesion);
    assert!(first < 0.9 && second == 1.0, "{first} {second}");
    let results = dem.finish().expect("it ends").results;
    close("mean", results["adhesion_mean"], 0.5 * (first + 1.0), 1e-15);
    assert_eq!(results["bonds_broken_share"], 0.0);
    march(&mut dem, 200, 12_000);
    let results = dem.finish().expect("it ends").results;
    assert_eq!(results["adhesion_mean"], 0.5);
    assert_eq!(results["bonds_broken_share"], 0.5);
}

#[test]
fn shear_breaks_a_bond_with_the_same_energy() {
    let h = 2e-11;
    for row in table().iter().filter(|row| row[0] < 0.92) {
        let [energy, reach, adhesion] = [row[0], row[1], row[2]];
        // 2 spin r = u_t, u_t^2 m/12 = E w l.
        let spin = 0.5 * (12.0 * energy * W * AREA / mass(R)).sqrt() / R;
        let turning = || json!({"spin_rad_per_s": spin});
        let mut dem = build(&scene(
            rigid(),
            h,
            pair(0.0, turning(), turning()),
            json!({}),
        ));
        let ([_, slip], left) = widest(&mut dem, 20_000);
        let slack = 2e-3 / (1.0 - energy) + 5e-3;
        close("slip", slip / (W / CN).sqrt(), reach, slack * reach);
        close("adhesion", left, adhesion, slack);
    }
}

#[test]
fn bonds_are_born_at_rest_at_any_gap() {
    for (law, gap) in [
        (rigid(), 1.5e-6),
        (rigid(), 0.0),
        (compliant(), 1.5e-6),
        (compliant(), -0.4e-6),
    ] {
        let mut dem = build(&scene(
            law,
            1e-8,
            pair(gap, json!({}), json!({})),
            json!({}),
        ));
        assert_eq!(dem.state().bonds.len(), 1);
        let report = march(&mut dem, 0, 1000);
        close("speed", report.signal("speed_max_m_per_s"), 0.0, 1e-9);
        close("force", dem.state().list.slots[0].force[0], 0.0, 1e-6);
        assert_eq!(report.signal("bonds"), 1.0);
    }
}

#[test]
fn grains_beyond_the_alert_distance_and_the_wheel_are_not_bonded() {
    let far = build(&scene(
        rigid(),
        1e-8,
        pair(2.1e-6, json!({}), json!({})),
        json!({}),
    ));
    assert!(far.state().bonds.is_empty());
    let wheel = json!({"load_n": 1.0, "mass_kg": 0.01, "ramp_s": 1e-4, "hold_s": 1e-4});
    let sample = pair(0.0, json!({}), json!({"glued": true}));
    let held = build(&scene(rigid(), 1e-8, sample, json!({"wheel": wheel})));
    let pairs: Vec<(u32, u32)> = held.state().bonds.iter().map(|b| (b.a, b.b)).collect();
    assert_eq!(pairs, [(0, 1)]);
}

/// Nine disks in a clump whose halves fly apart, one of them spinning.
fn clump() -> Value {
    let disk = |k: i32| {
        let (column, row) = (k % 3 - 1, k / 3);
        let x = f64::from(column) * 2.0 * R + f64::from(row % 2) * R;
        json!({
            "x_m": x, "y_m": f64::from(row) * 2.0 * R * 0.75f64.sqrt() * 1.002, "radius_m": R,
            "vx_m_per_s": 6.0 * f64::from(row), "vy_m_per_s": 3.0 * f64::from(column * row),
            "spin_rad_per_s": if k == 4 { 2e5 } else { 0.0 },
        })
    };
    json!({"kind": "disks", "disks": (0..9).map(disk).collect::<Vec<_>>()})
}

/// Runs the clump and returns its last report, kinetic energy at the start, and bonds before and after.
fn burst(law: Value, theta: f64) -> (Report, f64, [usize; 2]) {
    let mut config = scene(law, 5e-11, clump(), json!({}));
    config["time"]["theta"] = json!(theta);
    config["solver"]["tolerance"] = json!(1e-9);
    let mut dem = build(&config);
    let (before, born) = (dem.state().kinetic(dem.bodies()), dem.state().bonds.len());
    let report = march(&mut dem, 0, 20_000);
    let left = dem.state().bonds.len();
    (report, before, [born, left])
}

#[test]
fn the_ledger_of_breaking_bonds_closes() {
    for (h_prime, viscosity) in [("one", 0.0), ("one", 1e-5), ("adhesion", 0.0)] {
        for (mut law, theta) in [(rigid(), 1.0), (compliant(), 1.0), (compliant(), 0.5)] {
            law["h_prime"] = json!(h_prime);
            law["b_pa_m_s"] = json!(viscosity);
            let (report, before, [born, left]) = burst(law, theta);
            let what = format!("{h_prime} {viscosity} theta {theta}");
            assert!(born >= 12, "{what}: {born} bonds");
            assert!(left < born || h_prime == "one", "{what}: none broke");
            assert!(
                report.energy("cohesion") > 0.02 * before,
                "{what}: {:e} of {before:e}",
                report.energy("cohesion")
            );
            let imbalance = report.imbalance(before);
            assert!(imbalance < 1e-8, "{what}: {imbalance:e}");
        }
    }
}

#[test]
fn decohesion_dissipates_w_for_each_bond_that_opens() {
    let mut law = rigid();
    law["ct_pa_per_m"] = json!(0.0);
    let speed = (2.0 * 4.0 * W * AREA / (0.5 * mass(R))).sqrt();
    let sample = pair(
        0.0,
        json!({"vx_m_per_s": -0.5 * speed}),
        json!({"vx_m_per_s": 0.5 * speed}),
    );
    let mut dem = build(&scene(law, 4e-11, sample, json!({})));
    let report = march(&mut dem, 0, 60_000);
    assert_eq!(report.signal("bonds"), 0.0);
    close(
        "cohesion",
        report.energy("cohesion"),
        W * AREA,
        2e-3 * W * AREA,
    );
    let kinetic = dem.state().kinetic(dem.bodies());
    close("kinetic", kinetic, 3.0 * W * AREA, 5e-3 * W * AREA);
}

#[test]
fn equal_runs_give_equal_bits_which_include_the_bonds() {
    let hash = || {
        let mut config = scene(compliant(), 5e-11, clump(), json!({}));
        config["solver"]["tolerance"] = json!(1e-9);
        let mut dem = build(&config);
        march(&mut dem, 0, 2000);
        let mut weaker = dem.state().clone();
        weaker.bonds[0].adhesion *= 0.5;
        assert_ne!(weaker.hash(), dem.state().hash());
        dem.state().hash()
    };
    assert_eq!(hash(), hash());
}

#[test]
fn a_long_step_is_reported_against_the_bond_limit() {
    use protocol::Node;
    let mut dem = build(&scene(
        rigid(),
        1e-8,
        pair(0.0, json!({}), json!({})),
        json!({}),
    ));
    let omega = (AREA * CN / (0.5 * mass(R))).sqrt();
    let results = dem.finish().expect("it finishes").results;
    close(
        "limit",
        results["bond_step_limit_s"],
        1.0 / (3f64.sqrt() * omega),
        1e-20,
    );
    assert_eq!((results["bonds"], results["bonds_broken"]), (1.0, 0.0));
}

/// A grain on the first of two glued disks, 30 um from the second one, under a wheel that presses and then moves sideways.
///
/// ```text
///   ______ -> wheel
///    (O)
///   (G) (G)
/// ```
///
/// The grain's centre is 0.3 R beside the centre of the disk below. With one bond it turns about the contact and rolls under the
/// wheel; with two it stays, and the wheel slides on it with full friction.
fn ridden(bonds_min: u32) -> Report {
    let (x, y) = (0.3 * R, (4.0f64 - 0.09).sqrt() * R);
    let reach = 2.0 * R + 30e-6;
    let second = x + (reach * reach - y * y).sqrt();
    let mut law = compliant();
    law["w_j_per_m2"] = json!(6e7);
    law["bonds_min"] = json!(bonds_min);
    let sample = json!({"kind": "disks", "disks": [
        {"x_m": x, "y_m": y, "radius_m": R},
        {"x_m": 0.0, "y_m": 0.0, "radius_m": R, "glued": true},
        {"x_m": second, "y_m": 0.0, "radius_m": R, "glued": true},
    ]});
    let wheel = json!({
        "load_n": 1.0, "mass_kg": 1e-4, "amplitude_m": 2e-5, "frequency_hz": 300.0, "ramp_s": 2e-4, "hold_s": 2e-4, "cycles": 1.0,
    });
    let mut dem = build(&scene(law, 1e-7, sample, json!({"wheel": wheel})));
    assert_eq!(dem.state().bonds.len(), 1 + (bonds_min / 2) as usize);
    // To the middle of the first quarter of a cycle.
    march(&mut dem, 0, 4000 + 4166)
}

#[test]
fn a_grain_with_a_single_bond_rolls_and_one_with_two_stays() {
    let friction = |report: &Report| report.signal("wheel_ft_n") / report.signal("wheel_fn_n");
    let rolled = friction(&ridden(0));
    assert!(rolled.abs() < 0.2, "{rolled}");
    close("friction", friction(&ridden(2)), -0.3, 1e-6);
}

#[test]
fn every_grain_of_a_layer_has_its_least_number_of_bonds() {
    let config = |bonds_min: u32| {
        let mut law = compliant();
        law["contact_stiffness_pa"] = json!(2.255e11);
        law["alert_m"] = json!(8e-6);
        law["bonds_min"] = json!(bonds_min);
        let sample = json!({
            "kind": "layer", "thickness_m": 0.3e-3, "half_width_m": 8e-3, "crown_radius_m": 0.3,
            "radius_min_m": 0.05e-3, "radius_max_m": 0.1e-3, "law": "surface_uniform", "seed": 8,
        });
        let wheel = json!({"load_n": 0.0, "mass_kg": 0.01, "ramp_s": 1e-4, "hold_s": 1e-4});
        let mut config = scene(law, 1e-8, sample, json!({"wheel": wheel}));
        config["time"]["pressure_pa"] = json!(1e9);
        config
    };
    let least = |dem: &Dem| {
        let mut bonds = vec![0; dem.bodies().disks()];
        for bond in &dem.state().bonds {
            bonds[bond.a as usize] += 1;
            bonds[bond.b as usize] += 1;
        }
        bonds[..dem.bodies().free].iter().copied().min()
    };
    let (loose, mut held) = (build(&config(0)), build(&config(2)));
    assert_eq!((least(&loose), least(&held)), (Some(0), Some(2)));
    let spans = |dem: &Dem| {
        dem.state()
            .bonds
            .iter()
            .filter(|b| b.reference > 8e-6)
            .count()
    };
    assert_eq!((spans(&loose), spans(&held)), (0, 4));
    assert_eq!(held.state().bonds.len(), loose.state().bonds.len() + 4);
    assert!(held.state().bonds.is_sorted_by_key(|b| (b.a, b.b)));
    // The bonds are in the contact problem from the first step on, at rest.
    let report = march(&mut held, 0, 50);
    close("speed", report.signal("speed_max_m_per_s"), 0.0, 1e-9);
}

/// Under the policy `accept` a window with a starved contact solve is kept, here the very first one: no solution determines
/// the loss of adhesion.
#[test]
fn an_accepted_starved_window_leaves_the_bonds_unchanged() {
    let disks: Vec<Value> = (0..5)
        .map(|i| json!({"x_m": 0.0, "y_m": 2.0 * R * f64::from(i), "radius_m": R, "glued": i == 0, "vy_m_per_s": if i == 0 { 0.0 } else { 3.0 }}))
        .collect();
    let mut config = scene(
        rigid(),
        1e-7,
        json!({"kind": "disks", "disks": disks}),
        json!({}),
    );
    config["solver"] =
        json!({"kind": "nsgs", "tolerance": 1e-10, "max_iterations": 1, "min_iterations": 1});
    config["time"] = json!({"pressure_pa": 1e6});
    let mut dem = build(&config);
    dem.couple("base").expect("one disk is glued");
    dem.set_boundary(1e-7, &[0.0; 4]).expect("2 x 2 numbers");
    let window = Window {
        substeps: 1,
        t1_s: 1e-7,
        ..Window::default()
    };
    let answer = dem
        .solve(&window, &[0.0; 2])
        .expect("an answer, not a solution");
    assert!(!answer.converged, "{answer:?}");
    dem.commit(&window, &[0.0; 2]).expect("it was accepted");
    let adhesion: Vec<f64> = dem.state().bonds.iter().map(|b| b.adhesion).collect();
    assert_eq!(adhesion, [1.0; 4]);
}

/// The weight of grains opens the bonds by which they hang, one below the other, below a glued disk.
#[test]
fn grains_that_hang_on_a_glued_disk_have_not_left() {
    let disk = |k: i32| json!({"x_m": 0.0, "y_m": -2e-3 * f64::from(k), "radius_m": 1e-3, "glued": k == 0});
    let disks = Vec::from_iter((0..5).map(disk));
    let law = json!({"kind": "cohesion", "friction": 0.3, "cn_pa_per_m": 1e9, "ct_pa_per_m": 1e9, "w_j_per_m2": 1.0, "b_pa_m_s": 0.0, "p": 1.0,
        "h_prime": "one", "alert_m": 1e-6});
    let sample = json!({"kind": "disks", "disks": disks});
    let config = scene(law, 1e-6, sample, json!({"gravity_m_per_s2": [0.0, -9.81]}));
    let mut dem = build(&config);
    let report = march(&mut dem, 0, 100);
    assert!(dem.state().centres[0][1] < -2e-3, "the bond is open");
    assert_eq!(report.signal("lost_grains"), 0.0);
    let findings = dem.finish().expect("it ends").findings;
    assert!(findings.iter().all(|f| f.code != "ejected"));
}

/// Four disks in a row with gaps of 0.3, 0.1 and 0.3 mm: the two in the middle choose each other, the outer ones their only neighbour.
#[test]
fn the_order_of_the_disks_does_not_decide_which_bonds_they_lack() {
    let at = [0.0, 2.3e-3, 4.4e-3, 6.7e-3];
    for order in [[0, 1, 2, 3], [0, 3, 1, 2], [3, 2, 1, 0]] {
        let disk = |k: usize| json!({"x_m": at[k], "y_m": 0.0, "radius_m": 1e-3});
        let sample = json!({"kind": "disks", "disks": order.map(disk)});
        let law = json!({"kind": "cohesion", "friction": 0.3, "cn_pa_per_m": 1e9, "ct_pa_per_m": 4e8, "w_j_per_m2": 1.0, "b_pa_m_s": 0.0, "p": 1.0,
            "h_prime": "one", "alert_m": 1e-9, "bonds_min": 1});
        let dem = build(&scene(law, 1e-6, sample, json!({})));
        let place = |disk: u32| order[disk as usize];
        let bonds = dem.state().bonds.iter();
        let mut pairs: Vec<[usize; 2]> = bonds
            .map(|bond| {
                [
                    place(bond.a).min(place(bond.b)),
                    place(bond.a).max(place(bond.b)),
                ]
            })
            .collect();
        pairs.sort_unstable();
        assert_eq!(pairs, [[0, 1], [1, 2], [2, 3]], "{order:?}");
    }
}

/// Grains that lie beside an upright row of glued disks, or along a slope of 60 degrees, have not left it.
#[test]
fn grains_on_a_steep_row_have_not_left() {
    for degrees in [90.0f64, 60.0, -60.0] {
        let (c, s) = (degrees.to_radians().cos(), degrees.to_radians().sin());
        let disk = |along: f64, above: f64, glued: bool| json!({"x_m": c * along - s * above, "y_m": s * along + c * above, "radius_m": 1e-3, "glued": glued});
        let places = [-6e-3, -2e-3, 2e-3, 6e-3];
        let rows = places.map(|along| [disk(along, 0.0, true), disk(along, 4e-3, false)]);
        let sample = json!({"kind": "disks", "disks": rows.concat()});
        let mut dem = build(&scene(
            json!({"kind": "signorini"}),
            1e-6,
            sample,
            json!({}),
        ));
        march(&mut dem, 0, 2);
        let findings = dem.finish().expect("it ends").findings;
        assert!(findings.iter().all(|f| f.code != "ejected"), "{degrees}");
    }
}
