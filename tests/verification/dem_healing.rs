//! Healing: the adhesion of a pair grows by h/T in every step with a pressure of at least p on its area.
//!
//! ```text
//!     O    lies on the floor:  a = t/T from 0.01 on if m g >= p r d, otherwise 0 (d: thickness)
//!   ------ bounces on a spring k: a = pi sqrt(m/k)/T when it leaves, which costs l w a of its energy
//! ```
//!
//! The bond follows the law of Raous, Cangemi and Cocou (1999) with h' = 1 and b = 0: separation takes w per area and adhesion.

use dem_node::Dem;
use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, mass, on_floor, refusal, scene, with};

const R: f64 = 1e-3;
const G: f64 = 9.81;
const H: f64 = 1e-5;
const W: f64 = 1e-3;

/// Bonds of 1e9 Pa/m; at the start there are no bonds.
fn law(time: f64, pressure: f64, more: Value) -> Value {
    let law = json!({"kind": "cohesion", "friction": 0.4, "cn_pa_per_m": 1e9, "ct_pa_per_m": 1e9, "w_j_per_m2": W, "b_pa_m_s": 0.0,
        "p": 1.0, "h_prime": "one", "alert_m": 1e-12, "healing": {"time_s": time, "pressure_pa": pressure}});
    with(law, &more)
}

fn lying(law: Value, gravity: f64, disks: Value, over: Value) -> Dem {
    on_floor(law, H, gravity, disks, &over)
}

#[test]
fn a_disk_at_rest_heals_to_the_floor_in_the_given_time_if_it_is_heavy_enough() {
    let pressure = mass(R) * G / (R * THICKNESS);
    let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]);
    for springs in [
        json!({}),
        json!({"contact_stiffness_pa": 1e3 * mass(R) * G / R / THICKNESS, "tangential_stiffness_ratio": 1.0, "damping": 0.2}),
    ] {
        let time = 1e4 * H;
        let mut dem = lying(law(time, 0.0, springs.clone()), G, disk.clone(), json!({}));
        for (step, steps) in [(0, 90), (90, 3910), (4000, 8000)] {
            march(&mut dem, step, steps);
            let now = (step + u64::from(steps)) as f64 * H;
            let adhesion = dem.state().bonds.first().map_or(0.0, |bond| bond.adhesion);
            let expected = if now < 0.01 * time {
                0.0
            } else {
                (now / time).min(1.0)
            };
            close("adhesion", adhesion, expected, 1e-9);
        }
        let area = R * THICKNESS;
        close(
            "healing",
            dem.state().ledger.healing,
            area * W,
            1e-9 * area * W,
        );
    }
    for (share, bonds) in [(1.0 + 1e-6, 0), (1.0 - 1e-6, 1)] {
        let mut dem = lying(
            law(H, share * pressure, json!({})),
            G,
            disk.clone(),
            json!({}),
        );
        march(&mut dem, 0, 100);
        assert_eq!(dem.state().bonds.len(), bonds, "{share}");
    }
}

#[test]
fn a_bouncing_disk_loses_the_energy_of_the_bond_that_its_contact_made() {
    let (speed, area) = (0.1, R * THICKNESS);
    let k = 1e6 * THICKNESS;
    let touch = std::f64::consts::PI * (mass(R) / k).sqrt();
    let energy = 0.5 * mass(R) * speed * speed;
    let springs = json!({"contact_stiffness_pa": 1e6, "tangential_stiffness_ratio": 1.0});
    for share in [0.3, 0.6, 0.9] {
        // The bond takes this share of the energy.
        let adhesion = 0.5;
        let w = share * energy / (area * adhesion);
        let (step, disk) = (
            touch / 5000.0,
            json!([{"x_m": 0.0, "y_m": R + 1e-5, "radius_m": R, "vy_m_per_s": -speed}]),
        );
        let over = json!({"time": {"step_s": step, "pressure_pa": 1.0, "theta": 0.5}});
        let mut keys = springs.clone();
        (keys["w_j_per_m2"], keys["cn_pa_per_m"]) = (json!(w), json!(1e12 * w));
        let mut dem = lying(law(touch / adhesion, 0.0, keys), 0.0, disk, over);
        let (mut before, mut lost) = (energy, 0.0);
        for look in 0..600 {
            let report = march(&mut dem, 100 * look, 100);
            assert!(
                report.imbalance(energy) < 1e-9,
                "{:e}",
                report.imbalance(energy)
            );
            let cohesion = report.energy("cohesion");
            assert!(cohesion >= lost);
            (before, lost) = (dem.state().kinetic(dem.bodies()).min(before), cohesion);
        }
        assert!(dem.state().bonds.is_empty(), "it has left");
        let kinetic = dem.state().kinetic(dem.bodies());
        close("energy", kinetic, (1.0 - share) * energy, 5e-3 * energy);
        close("cohesion", lost, share * energy, 5e-3 * energy);
        assert!(
            dem.state().ledger.healing >= lost * (1.0 - 1e-12),
            "a bond takes at most its healed energy"
        );
    }
    // Short contacts never make a bond, nor does a disk that oscillates with too low a pressure half of the time.
    let weight = 20.0 * mass(R);
    let thrown = json!([{"x_m": 0.0, "y_m": R + 1e-5, "radius_m": R, "vy_m_per_s": -speed}]);
    let swinging = json!([{"x_m": 0.0, "y_m": R - 0.2 * weight / k, "radius_m": R}]);
    for (disk, pressure, theta) in [(thrown, 0.0, 1.0), (swinging, weight / area, 0.5)] {
        let over = json!({"time": {"step_s": touch / 500.0, "pressure_pa": 1.0, "theta": theta}});
        let law = law(150.0 * touch, pressure, springs.clone());
        let mut dem = lying(law, 20.0, disk, over);
        for look in 0..30 {
            march(&mut dem, 1000 * look, 1000);
            assert!(dem.state().bonds.is_empty());
        }
    }
}

/// Without stiffness across the bond a sliding disk decelerates by mu g (1 - a), a = t/T from t = 0.01 T on, and by mu g before.
#[test]
fn friction_beside_a_healing_bond_falls_with_its_adhesion() {
    let (time, mu) = (0.02, 0.4);
    for springs in [true, false] {
        let mut keys = json!({"ct_pa_per_m": 0.0});
        if springs {
            keys["contact_stiffness_pa"] = json!(1e6 * mass(R) * G / R / THICKNESS);
            keys["tangential_stiffness_ratio"] = json!(1.0);
            keys["damping"] = json!(0.2);
        }
        let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "vx_m_per_s": 1.0}]);
        let mut dem = lying(law(time, 0.0, keys), G, disk, json!({}));
        let report = march(&mut dem, 0, 1000);
        let (t, first) = (1000.0 * H, 0.01 * time);
        let healed = if springs {
            (t * t - first * first) / (2.0 * time)
        } else {
            0.0
        };
        let [speed, ..] = dem.state().velocities[0];
        close(
            "slowed",
            1.0 - speed,
            mu * G * (t - healed),
            2e-3 * mu * G * t,
        );
        assert!(report.energy("friction") > 0.0 && report.imbalance(mass(R)) < 1e-9);
    }
}

/// Spins shear the disks: bonds come and go, and lost energy never comes back.
#[test]
fn a_pile_that_heals_and_breaks_loses_energy_in_every_term_and_step() {
    let disk = |k: u32| {
        let (column, row) = (f64::from(k % 5), f64::from(k / 5));
        json!({"x_m": 2.02 * R * column + 0.9 * R * (row % 2.0), "y_m": R + 1.9 * R * row, "radius_m": R * (1.0 - 0.06 * f64::from(k % 4)),
            "spin_rad_per_s": 200.0 * f64::from(k % 3), "vx_m_per_s": 0.05 * f64::from(k / 5)})
    };
    let disks: Vec<Value> = (0..20).map(disk).collect();
    let weight = mass(R) * G;
    let springs = json!({"contact_stiffness_pa": 1e4 * weight / R / THICKNESS, "tangential_stiffness_ratio": 0.5});
    for springs in [json!({}), springs] {
        let over = json!({"time": {"step_s": 2e-5, "pressure_pa": 1.0},
            "solver": {"kind": "nsgs", "tolerance": 1e-10, "max_iterations": 50_000, "min_iterations": 1}});
        let mut keys = springs.clone();
        keys["cn_pa_per_m"] = json!(1e4 * weight / R / (R * THICKNESS));
        keys["ct_pa_per_m"] = keys["cn_pa_per_m"].clone();
        keys["w_j_per_m2"] = json!(1e-2 * weight / THICKNESS);
        let mut dem = lying(law(5e-3, 0.0, keys), G, json!(disks), over);
        let scale = 20.0 * weight * R;
        // Rigid contacts use the mean of two velocities, whose sign may change in a step.
        let allowed = if springs == json!({}) {
            1e-6 * scale
        } else {
            1e-9 * scale
        };
        let (mut lost, mut most, mut broken) = ([0.0; 3], 0, 0);
        for step in 0..3000 {
            let report = march(&mut dem, step, 1);
            let now = ["friction", "cohesion", "relaxation"].map(|name| report.energy(name));
            for (now, before) in now.iter().zip(lost) {
                assert!(
                    *now >= before - allowed,
                    "step {step}: {now:e} after {before:e}"
                );
            }
            lost = now;
            assert!(
                report.imbalance(scale) < 1e-8,
                "step {step}: {:e}",
                report.imbalance(scale)
            );
            let bonds = dem.state().bonds.len();
            broken += usize::from(bonds < most);
            most = bonds;
        }
        assert!(
            dem.state().ledger.bonds_made > 20 && broken > 5,
            "{} {broken}",
            dem.state().ledger.bonds_made
        );
        assert!(lost.iter().all(|lost| *lost > 0.0), "{lost:?}");
        assert!(lost[1] <= dem.state().ledger.healing);
    }
}

/// A bonded disk that turns and slides over the seams of straight polylines moves as on a half-plane.
#[test]
fn a_bond_moves_along_over_the_seams_of_walls_and_surfaces() {
    let line = [-3.0, -0.5, 0.05, 0.1, 4.0].map(|x| [x * R, 0.0]);
    let floors = [
        (
            "walls",
            json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]),
        ),
        ("walls", json!([{"points_m": line}])),
        ("surface", json!({"points_m": line})),
    ];
    for springs in [false, true] {
        let mut keys = json!({"ct_pa_per_m": 1e4});
        if springs {
            keys["contact_stiffness_pa"] = json!(1e7);
            keys["damping"] = json!(0.2);
            keys["tangential_stiffness_ratio"] = json!(1.0);
        }
        let moved = floors.clone().map(|(kind, floor)| {
            let disk = json!({"x_m": -0.6 * R, "y_m": R, "radius_m": R, "vx_m_per_s": 0.15});
            let mut sample = json!({"kind": "disks", "disks": [disk]});
            sample[kind] = floor;
            let over = json!({"gravity_m_per_s2": [0.0, -G]});
            let mut dem = build(&scene(law(0.01, 0.0, keys.clone()), H, sample, over));
            march(&mut dem, 0, 900);
            let (state, bond) = (dem.state(), dem.state().bonds[0]);
            let [x, y] = state.centres[0];
            assert!(x > 0.15 * R && bond.adhesion > 0.8, "{x} {bond:?}");
            let of_bond = [bond.adhesion, bond.opening / R, bond.slip / R];
            [[x / R, y / R, 0.0], of_bond, state.velocities[0]]
        });
        // On a surface the force acts at the foot: the lever is shorter by the overlap of the disk, 2.4e-5 of its radius.
        let allowed = [1e-9, if springs { 5e-5 } else { 1e-9 }];
        for (other, allowed) in moved[1..].iter().zip(allowed) {
            for (value, expected) in other.iter().flatten().zip(moved[0].iter().flatten()) {
                close("motion", *value, *expected, allowed);
            }
        }
    }
}

/// Round a convex corner, and through a concave one on springs, the bond moves along without gaining energy. A rigid disk stands on both
/// sides of a concave corner: it tears the bond to the first, and heals to the second.
#[test]
fn a_bond_goes_round_corners_without_gaining_energy() {
    for (bend, springs) in [(0.02, true), (-0.02, true), (0.02, false), (-0.02, false)] {
        let points = [
            [-6.0 * R, 6.0 * R * bend],
            [0.0, 0.0],
            [6.0 * R, 6.0 * R * bend],
        ];
        let (speed, weight) = (0.1, mass(R) * G);
        let (sin, cos) = f64::atan(bend).sin_cos();
        let disk = json!({"x_m": -R * cos + R * sin, "y_m": R * sin + R * cos, "radius_m": R,
            "vx_m_per_s": speed * cos, "vy_m_per_s": -speed * sin, "spin_rad_per_s": -speed / R});
        let sample = json!({"kind": "disks", "disks": [disk], "walls": [{"points_m": points}]});
        let over = json!({"gravity_m_per_s2": [0.0, -G]});
        let mut keys = json!({"ct_pa_per_m": 0.0});
        if springs {
            keys["contact_stiffness_pa"] = json!(1e2 * weight / R / THICKNESS);
            keys["tangential_stiffness_ratio"] = json!(1.0);
            (keys["damping"], keys["bond_damping_ratio"]) = (json!(1.0), json!(1.0));
        }
        let mut dem = build(&scene(law(2e-3, 0.0, keys), H, sample, over));
        let energy = 0.75 * mass(R) * speed * speed;
        let mut alone = false;
        for step in 0..2000 {
            let report = march(&mut dem, step, 1);
            assert!(
                report.imbalance(energy) < 1e-9,
                "{:e}",
                report.imbalance(energy)
            );
            let ledger = &dem.state().ledger;
            assert!(ledger.detection > -1e-6 * energy, "{:e}", ledger.detection);
            let slots = &dem.state().list.slots;
            alone |= slots.iter().any(|slot| slot.joined == f64::INFINITY);
            let pressing = slots.iter().filter(|slot| slot.force[0] > 0.0);
            assert!(!springs || pressing.count() < 2, "{bend} {step}");
        }
        let (state, torn) = (dem.state(), u64::from(!springs && bend > 0.0));
        let [x, y] = state.centres[0];
        assert!(x > 0.5 * R, "it has passed the corner: {x}");
        close("height", y * cos - x * sin, R, 0.012 * R);
        let made = (state.ledger.bonds_made, state.bonds.len());
        assert_eq!(made, (1 + torn, 1), "{bend} {springs}");
        assert_eq!(state.ledger.surface > 0.0, torn > 0);
        assert_eq!(state.bonds[0].b, 2, "the second segment");
        assert_eq!(alone, springs && bend > 0.0, "{bend}");
    }
}

#[test]
fn healing_is_refused_where_there_are_no_bonds_to_heal() {
    let refused = |law: Value, solver: &str| {
        let sample = json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": R, "radius_m": R}]});
        let over = json!({"solver": {"kind": solver, "tolerance": 1e-9, "max_iterations": 20_000, "min_iterations": 1}});
        refusal(&scene(law, H, sample, over))
    };
    let healing = json!({"time_s": 1.0, "pressure_pa": 0.0});
    let loose = json!({"kind": "coulomb", "friction": 0.4, "healing": healing});
    assert!(refused(loose, "nsgs").contains("law.healing"));
    assert!(refused(law(1.0, 0.0, json!({"friction": 0.0})), "pcg").contains("law.healing"));
    assert!(refused(law(0.0, 0.0, json!({})), "nsgs").contains("law.healing.time_s"));
}
