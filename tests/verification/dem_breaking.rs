//! Bonds that break: no energy comes of it, in any mode and at any overlap, and what they take is the energy of their surface.
//!
//! ```text
//!   (O)(O) ->    pulled       ^(O)(O)v  sheared by spin      both at once, and sheared while pressed
//! ```
//!
//! Exact: a bond that opens slowly takes w l, l = r1 r2/(r1 + r2) x thickness, with h' = 1 and w l / 2 with h' = a (Raous, Cangémi
//! and Cocou 1999), whatever gap it was made at; the implicit step takes 3/4 of the step's part of delta_0 less, and
//! adhesion below 1e-4 counts as none, which leaves 5e-5. A pair that flies apart with the energy E keeps E - w l.

use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{Report, THICKNESS, build, close, march, mass, scene};

const R: f64 = 0.07e-3;
const W: f64 = 60.0;
const CN: f64 = 4e14;
/// delta_0 (m); l (m2).
const OPENING: f64 = 3.872_983_346_207_417e-7;
const AREA: f64 = 0.5 * R * THICKNESS;
/// Gaps at which bonds are made (m).
const GAPS: [f64; 4] = [-10e-6, -0.3e-6, 0.0, 1.5e-6];

fn law(springs: bool, h_prime: &str) -> Value {
    let mut law = json!({
        "kind": "cohesion", "friction": 0.0, "cn_pa_per_m": CN, "ct_pa_per_m": CN, "w_j_per_m2": W, "b_pa_m_s": 0.0, "p": 1.0,
        "h_prime": h_prime, "alert_m": 2e-6,
    });
    if springs {
        law["contact_stiffness_pa"] = json!(1.4e10);
        law["tangential_stiffness_ratio"] = json!(0.5);
    }
    law
}

/// Two disks with a gap, which part at the velocity `pull` along their line and shear at `shear` (m/s) by their spin.
fn pair(gap: f64, pull: f64, shear: f64) -> Value {
    let disk = |side: f64| {
        json!({
            "x_m": side * (R + 0.5 * gap), "y_m": 0.0, "radius_m": R, "vx_m_per_s": 0.5 * side * pull,
            "spin_rad_per_s": 0.5 * shear / (R + 0.5 * gap),
        })
    };
    json!({"kind": "disks", "disks": [disk(-1.0), disk(1.0)]})
}

/// Cohesion over w l of a pair that nothing slows and that moves `part` of delta_0 in a step, once its bond is broken, and
/// the least that any step dissipated.
fn taken(law: Value, gap: f64, direction: [f64; 2], part: f64) -> (f64, f64) {
    let speed = 0.1;
    let [pull, shear] = direction.map(|share| share * speed);
    // As heavy as flywheels: 1e7 times the energy of the bond.
    let overrides = json!({"density_kg_per_m3": 1.637e15});
    let mut dem = build(&scene(
        law,
        part * OPENING / speed,
        pair(gap, pull, shear),
        overrides,
    ));
    let (mut last, mut least, mut step) = (0.0, 0.0f64, 0);
    while step < (140.0 / part) as u64 {
        let count = (1.0 / part / 8.0) as u32;
        let report = march(&mut dem, step, count);
        let lost = ["cohesion", "numerical"].map(|term| report.energy(term));
        least = least.min(lost[0].min(lost[1]));
        last = lost[0];
        step += u64::from(count);
        if dem.state().bonds.is_empty() {
            break;
        }
    }
    assert!(dem.state().bonds.is_empty(), "it holds");
    (last / (W * AREA), least)
}

#[test]
fn a_bond_takes_its_surface_energy_in_every_mode_and_at_every_overlap() {
    let modes = [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]];
    for (mode, gap) in modes
        .into_iter()
        .flat_map(|mode| GAPS.map(|gap| (mode, gap)))
    {
        // Rigid grains that overlap by more are refused.
        for springs in [false, true]
            .into_iter()
            .filter(|springs| *springs || gap > -1e-6)
        {
            let of = |part: f64| taken(law(springs, "one"), gap, mode, part);
            let [(coarse, least), (fine, _)] = [of(1.0 / 250.0), of(1.0 / 500.0)];
            let what = format!("{mode:?} from {gap:e}, springs {springs}");
            // First order, and what both steps say of a step of nothing.
            let order = (1.0 - coarse) / (1.0 - fine);
            assert!((1.9..2.1).contains(&order), "{what}: {coarse} {fine}");
            close(&what, 2.0 * fine - coarse, 1.0 - 5e-5, 1e-4);
            assert!(least >= 0.0, "{what}: {least:e}");
        }
    }
}

#[test]
fn a_brittle_bond_takes_half_of_it() {
    for (mode, gap) in [
        ([1.0, 0.0], -10e-6),
        ([0.0, 1.0], -10e-6),
        ([0.6, 0.8], 1.5e-6),
    ] {
        let (share, least) = taken(law(true, "adhesion"), gap, mode, 1e-4);
        close(&format!("{mode:?}"), share, 0.5, 3e-4);
        assert!(least >= 0.0);
    }
}

/// Energy of two disks with this gap, relative velocity and shear (J).
fn kinetic(gap: f64, [pull, shear]: [f64; 2]) -> f64 {
    let spun = shear / (1.0 + 0.5 * gap / R);
    mass(R) * (0.25 * pull * pull + spun * spun / 8.0)
}

/// The pair flies or spins apart with a multiple of w l, at a fiftieth of the bond's bound on the step.
#[test]
fn a_pair_that_breaks_keeps_what_its_surface_does_not_take() {
    let limit = 1.0 / (3.0 * AREA * CN * 2.0 / mass(R)).sqrt();
    for (gap, springs) in [
        (-10e-6, true),
        (-0.3e-6, false),
        (1.5e-6, true),
        (0.0, true),
    ] {
        for (pull, shear) in [(1.0, 0.0), (0.0, 1.0), (-0.5, 1.0)] {
            let unit = (4.0 * W * AREA / kinetic(gap, [pull, shear])).sqrt();
            let sample = pair(gap, pull * unit, shear * unit);
            let mut dem = build(&scene(law(springs, "one"), limit / 50.0, sample, json!({})));
            let before = dem.state().kinetic(dem.bodies());
            close("before", before, 4.0 * W * AREA, 1e-9);
            let report = march(&mut dem, 0, 40_000);
            let what = format!("({pull}, {shear}) from {gap:e}, springs {springs}");
            assert!(dem.state().bonds.is_empty(), "{what}: it holds");
            let after = dem.state().kinetic(dem.bodies()) / (W * AREA);
            // Rigid grains that meet lose the energy of their approach.
            let approach = kinetic(gap, [pull.min(0.0) * unit, 0.0]) / (W * AREA);
            // Springs rebound with exp(-pi h omega / 2) of their speed, kn being l Cn.
            let rebound = (-std::f64::consts::PI / 50.0 / 3f64.sqrt()).exp();
            let stopped = approach * if springs { 1.0 - rebound } else { 1.0 };
            close(&what, after, 3.0 - stopped, 0.03);
            let [cohesion, numerical] =
                ["cohesion", "numerical"].map(|term| report.energy(term) / (W * AREA));
            close(&what, cohesion, 1.0, 0.03);
            assert!((0.0..0.07).contains(&numerical), "{what}: {numerical}");
            assert!(report.imbalance(before) < 1e-9, "{what}");
        }
    }
}

/// Three disks that overlap turn as one for a whole turn: nothing opens, slips or breaks.
#[test]
fn bonds_turn_with_their_grains() {
    let (spin, side) = (2e4, 2.0 * R - 5e-6);
    let corner = |k: i32| {
        let angle = std::f64::consts::TAU / 3.0 * f64::from(k);
        let reach = side / 3f64.sqrt();
        let [x, y] = [reach * angle.cos(), reach * angle.sin()];
        json!({"x_m": x, "y_m": y, "radius_m": R, "vx_m_per_s": -spin * y, "vy_m_per_s": spin * x, "spin_rad_per_s": spin})
    };
    let sample = json!({"kind": "disks", "disks": (0..3).map(corner).collect::<Vec<_>>()});
    let mut law = law(true, "one");
    law["w_j_per_m2"] = json!(600.0);
    let mut dem = build(&scene(law, 1e-9, sample, json!({})));
    let before = dem.state().kinetic(dem.bodies());
    march(&mut dem, 0, 314_159);
    assert_eq!(dem.state().bonds.len(), 3);
    assert!(dem.state().bonds.iter().all(|bond| bond.adhesion == 1.0));
    let after = dem.state().kinetic(dem.bodies());
    close("energy", after, before, 0.01 * before);
}

/// A pair that has come apart once meets at its surfaces, one that has not at the gap of its bond.
#[test]
fn a_broken_pair_touches_at_its_reference_until_it_has_come_apart() {
    let spun = |gap: f64| {
        let shear = (16.0 * W * AREA * 8.0 / mass(R)).sqrt();
        let mut dem = build(&scene(
            law(true, "one"),
            1e-10,
            pair(gap, 0.0, shear),
            json!({}),
        ));
        march(&mut dem, 0, 20_000);
        assert!(dem.state().bonds.is_empty());
        dem
    };
    let dem = spun(-10e-6);
    close(
        "reference",
        dem.state().list.slots[0].reference,
        -10e-6,
        1e-12,
    );
    let speed = dem.state().velocities[0][0].abs();
    assert!(speed < 1e-3, "nothing pushes them: {speed}");
    let energy = |report: &Report| report.energy("springs_normal");
    let mut apart = spun(-10e-6);
    let mut state = apart.state().clone();
    let slot = &mut state.list.slots[0];
    close("from the reference", slot.gap(-4e-6), 6e-6, 1e-12);
    assert_eq!(slot.gap(1e-6), 1e-6);
    assert_eq!(slot.gap(-4e-6), -4e-6);
    let report = march(&mut apart, 20_000, 1);
    close("energy", energy(&report), 0.0, 1e-15);
}

#[test]
fn steps_above_the_bound_of_bonds_are_judged_where_bonds_are_loaded() {
    let limit = 1.0 / (3.0 * AREA * CN * 2.0 / mass(R)).sqrt();
    // Energy over w l: sqrt(2 E) delta_0 is reached.
    let found = |energy: f64, step: f64| {
        let unit = (energy * W * AREA / kinetic(0.0, [1.0, 0.0])).sqrt();
        let mut dem = build(&scene(
            law(true, "one"),
            step,
            pair(0.0, unit, 0.0),
            json!({}),
        ));
        march(&mut dem, 0, (4.0 * limit / step) as u32);
        let outcome = dem.finish().expect("it ends");
        let findings = outcome.findings.into_iter();
        let found = findings
            .filter(|finding| finding.code == "bond_step")
            .map(|finding| finding.suspect);
        (
            found.collect::<Vec<bool>>(),
            outcome.results["bond_load_max"],
        )
    };
    let (none, load) = found(0.1, 0.02 * limit);
    assert!(none.is_empty());
    close("load", load, 0.2f64.sqrt(), 0.02);
    assert!(found(0.3, 0.1 * limit).0.is_empty());
    assert!(found(0.05, 1.5 * limit).0.is_empty());
    let (found, load) = found(2.0, 1.5 * limit);
    assert_eq!(found, [false]);
    assert!(load > 0.5, "{load}");
}
