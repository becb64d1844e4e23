//! Heat of the grains.
//!
//! ```text
//!    wheel, T_w      a column of n equal disks between a glued disk and the wheel: the discrete chain
//!   (O)(O)...(O)     m c T_i' = H (T_i-1 - 2 T_i + T_i+1), its steady state and its modes
//!    glued, T_r
//! ```
//! Half-spaces on both sides are compared with Carslaw and Jaeger (1959): they meet at (b1 T1 + b2 T2)/(b1 + b2) (section 2.15), share a source by their
//! effusivities b, and warm through a film as in section 2.7.
//!
//! The conductance of a contact is compared with the Fourier series of a disk with a source and a sink on its rim.

use std::f64::consts::PI;

use dem_kernel::law::heat::Conduction;
use dem_node::Dem;
use protocol::Node;
use serde_json::{Value, json};

use crate::dem_support::{
    build, close, march, mass, on_floor, refusal, scene, setting, window, with,
};
use crate::vtk_file::array;

/// Radius of the disks (m).
const R: f64 = 1e-4;

/// Heat capacity (J/(kg K)), conductance (W/K) and temperature of the start (K).
const CAPACITY: f64 = 500.0;
const CONDUCTANCE: f64 = 0.02;
const START: f64 = 300.0;

fn heat(more: Value) -> Value {
    let mut keys = json!({"capacity_j_per_kg_k": CAPACITY, "conductance_w_per_k": CONDUCTANCE, "start_k": START});
    let table = keys.as_object_mut().expect("it is a table");
    table.extend(more.as_object().expect("it is a table").clone());
    json!({ "heat": keys })
}

/// A column of `count` disks on a glued disk, under a flat wheel.
fn column(count: usize, step: f64, heat: Value) -> Value {
    let disks: Vec<Value> = (0..=count)
        .map(|i| {
            let y = (2.0 * i as f64 + 1.0) * R;
            json!({"x_m": 0.0, "y_m": y, "radius_m": R, "glued": i == 0})
        })
        .collect();
    let sample = json!({"kind": "disks", "disks": disks, "walls": []});
    let law = json!({"kind": "signorini"});
    let mut keys = heat;
    keys["wheel"] =
        json!({"load_n": 1e-3, "mass_kg": 1e-7, "radius_m": 0.0, "ramp_s": 0.0, "hold_s": 1e3});
    scene(law, step, sample, keys)
}

fn result(dem: &mut Dem, name: &str) -> f64 {
    let results = dem.finish().expect("it ends").results;
    let found = results.get(name);
    *found.unwrap_or_else(|| panic!("there is no result {name}"))
}

/// Deviations from the temperature of both ends decay by 4 H/(m c) sin^2(j pi/(2 (n + 1))), in steps h by 1 + h times this: one disk and two disks
/// have the first mode alone.
#[test]
fn a_column_between_equal_temperatures_decays_by_its_first_mode() {
    for (count, step) in [(1, 1e-3), (2, 1e-3), (2, 0.015)] {
        let ends = json!({"held_k": {"base": START + 10.0, "wheel": START + 10.0}});
        let mut dem = build(&column(count, step, heat(ends)));
        let sine = (PI / (2.0 * (count as f64 + 1.0))).sin();
        let rate = 4.0 * CONDUCTANCE / (mass(R) * CAPACITY) * sine * sine;
        let report = march(&mut dem, 0, 7);
        let expected = START + 10.0 - 10.0 / (1.0 + step * rate).powi(7);
        close("mean", report.signal("temperature_mean_k"), expected, 1e-10);
        close(
            "highest",
            report.signal("temperature_max_k"),
            expected,
            1e-10,
        );
        close("balance", result(&mut dem, "heat_balance_rel"), 0.0, 1e-12);
    }
}

/// Five disks between 300 and 400 K: the fifth has 5/6 of the difference, and as much heat enters as leaves.
#[test]
fn a_column_between_two_temperatures_becomes_linear() {
    let ends = json!({"held_k": {"base": 300.0, "wheel": 400.0}, "every_steps": 3});
    let mut dem = build(&column(5, 0.015, heat(ends)));
    march(&mut dem, 0, 3000);
    let before = ["heat_to_base_j", "heat_to_wheel_j"].map(|name| result(&mut dem, name));
    let report = march(&mut dem, 3000, 300);
    close("mean", report.signal("temperature_mean_k"), 350.0, 1e-8);
    let highest = 300.0 + 100.0 * 5.0 / 6.0;
    close("highest", report.signal("temperature_max_k"), highest, 1e-8);
    let flow = CONDUCTANCE * 100.0 / 6.0 * 300.0 * 0.015;
    let after = ["heat_to_base_j", "heat_to_wheel_j"].map(|name| result(&mut dem, name));
    close("rows", after[0] - before[0], flow, 1e-9 * flow);
    close("wheel", after[1] - before[1], -flow, 1e-9 * flow);
}

/// A disk that slides until it rolls loses a third of its energy: this warms it alone over a floor that lets no heat through, and by half over a floor
/// of one temperature. Its true mass sets its capacity, its scaled mass its energy.
#[test]
fn slip_warms_a_disk_by_its_loss() {
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "vx_m_per_s": 0.1}]);
    for (scale, floor_k, share) in [
        (1.0, None, 1.0),
        (100.0, None, 1.0),
        (1.0, Some(START), 0.5),
    ] {
        let mut keys = heat(json!({"conductance_w_per_k": 0.0}));
        keys["heat"]["held_k"] = floor_k.map_or(json!({}), |floor: f64| json!({"floor": floor}));
        keys["mass_scale"] = json!(scale);
        let mut dem = on_floor(law.clone(), 1e-5 * scale, 9.81, disk.clone(), &keys);
        let report = march(&mut dem, 0, 2000);
        let lost = scale * mass(R) * 0.1 * 0.1 / 6.0;
        close("friction", report.energy("friction"), lost, 2e-3 * lost);
        let (slip, jolts) = (report.energy("friction"), report.energy("impact"));
        let rise = (share * slip + jolts) / (mass(R) * CAPACITY);
        let found = report.signal("temperature_max_k") - START;
        close("rise", found, rise, 1e-7 * rise);
        close("balance", result(&mut dem, "heat_balance_rel"), 0.0, 1e-12);
        let at = result(&mut dem, "temperature_peak_k") - START;
        close("peak", at, rise, 1e-7 * rise);
    }
}

/// Springs, rigid contacts, and bonds with this friction and this w (J/m2).
fn laws(friction: f64, w: f64) -> [Value; 3] {
    let springs = json!({"kind": "coulomb", "friction": friction, "contact_stiffness_pa": 1e8, "tangential_stiffness_ratio": 0.5, "damping": 0.3});
    let rigid = json!({"kind": "coulomb", "friction": friction, "rolling": {"coefficient": 0.1}});
    let bonds = json!({"kind": "cohesion", "friction": friction, "contact_stiffness_pa": 1e8, "damping": 0.3, "tangential_stiffness_ratio": 0.5,
        "cn_pa_per_m": 1e12, "ct_pa_per_m": 5e11, "w_j_per_m2": w, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 1e-6, "bonds_min": 0});
    [springs, rigid, bonds]
}

/// Sixteen disks that fall on each other.
fn pile() -> Value {
    let mut disks = Vec::new();
    for row in 0..4 {
        for column in 0..4 {
            let (x, y) = (2.0 * R * f64::from(column), 2.0 * R * f64::from(row));
            let shift = if row % 2 == 1 { 0.7 * R } else { 0.0 };
            disks.push(json!({"x_m": x + shift, "y_m": y + 1.5 * R, "radius_m": R, "vy_m_per_s": -0.5 + 0.1 * f64::from(column)}));
        }
    }
    json!(disks)
}

/// Disks that fall on each other with friction, dampers or impacts, and bonds that break: all that they lose is heat, by the shares.
#[test]
fn heat_is_what_the_contacts_lose() {
    for (law, name) in laws(0.3, 1e-6)
        .into_iter()
        .zip(["damping", "impact", "bonds"])
    {
        let mut keys = heat(
            json!({"held_k": {"floor": START}, "every_steps": 4, "sources": {"friction": 0.7, "bonds": 0.5}}),
        );
        keys["solver"] = json!({"kind": "nsgs", "tolerance": 1e-8, "max_iterations": 20_000, "min_iterations": 1});
        let mut dem = on_floor(law, 1e-6, 9.81, pile(), &keys);
        let report = march(&mut dem, 0, 3000);
        let results = dem.finish().expect("it ends").results;
        let of = |name: &str| results[name];
        let friction = 0.7 * report.energy("friction");
        close(
            "friction",
            of("heat_friction_j"),
            friction,
            1e-12 * friction,
        );
        assert!(
            friction > 0.0 && of(&format!("heat_{name}_j")) > 0.0,
            "{name}: {results:?}"
        );
        assert!(
            of("heat_to_floor_j") != 0.0 && of("heat_balance_rel") < 1e-12,
            "{name}: {results:?}"
        );
    }
}

/// Difference of temperature between source and sink of a disk, weighted as the flux 1/sqrt(a^2 - s^2) of strips of one temperature, over heat and
/// 1/(k t): (4/pi) sum J0(n a/r)^2 / n over odd n, the Fourier series of a disk with this flux on its rim.
#[test]
fn the_conductance_is_that_of_a_disk_between_two_strips() {
    let bessel = |x: f64| {
        let points = 64 + x as usize;
        let angles = (0..points).map(|i| (i as f64 + 0.5) * PI / points as f64);
        angles.map(|angle| (x * angle.sin()).cos()).sum::<f64>() / points as f64
    };
    let (conductivity, modulus) = (50.0, 1e8);
    for ratio in [0.01, 0.05, 0.1, 0.2] {
        let odd = (0..3000).map(|i| 2 * i + 1);
        let terms = odd.map(|n| bessel(f64::from(n) * ratio).powi(2) / f64::from(n));
        let exact = conductivity * PI / (4.0 * terms.sum::<f64>());
        // Two equal disks: half of each.
        let width = ratio * R;
        let force = width * width * PI * modulus / (4.0 * 0.5 * R);
        let hertz = |spread: Option<f64>| Conduction::Hertz {
            conductivity,
            modulus,
            spread,
        };
        let law = hertz(None);
        let found = law.conductance(force, 0.5 * R, [Some(R), Some(R)]);
        close("two disks", found, exact, 0.02 * exact);
        let found = law.conductance(force, 0.5 * R, [Some(R), None]);
        close("disk and body", found, 2.0 * exact, 0.02 * 2.0 * exact);
        // Strips that touch resist nothing, and strips 6 a apart ln 2/(pi k t).
        let wide = hertz(Some(2.0 * width)).conductance(force, 0.5 * R, [Some(R), None]);
        close("no room", wide, found, 1e-12 * found);
        let apart = hertz(Some(6.0 * width)).conductance(force, 0.5 * R, [None, Some(R)]);
        let more = PI * conductivity * (1.0 / apart - 1.0 / found);
        close("six half-widths apart", more, 2.0_f64.ln(), 1e-12);
    }
}

/// A disk slides on a driven block of two disks, which have no temperatures of their own: half of the loss goes into the block that has one, and nothing
/// into the block that lets no heat through.
#[test]
fn a_cluster_takes_its_half_or_nothing() {
    for (held, share) in [(json!({"block": START}), 0.5), (json!({}), 0.0)] {
        let disks = json!([
            {"x_m": -R, "y_m": -R, "radius_m": R, "cluster": "block"},
            {"x_m": R, "y_m": -R, "radius_m": R, "cluster": "block"},
            {"x_m": 0.0, "y_m": (3.0f64.sqrt() - 1.0) * R, "radius_m": R, "spin_rad_per_s": 1e3},
        ]);
        let drive = json!({"velocity_m_per_s": [0.0, 0.0]});
        let clusters = json!([{"name": "block", "drive": drive}]);
        let sample = json!({"kind": "disks", "disks": disks, "walls": [], "clusters": clusters});
        let mut keys = heat(json!({"conductance_w_per_k": 0.0, "held_k": held}));
        keys["gravity_m_per_s2"] = json!([0.0, -9.81]);
        let law = json!({"kind": "coulomb", "friction": 0.3});
        let mut dem = build(&scene(law, 1e-5, sample, keys));
        let report = march(&mut dem, 0, 500);
        let slip = report.energy("friction");
        assert!(slip > 0.0);
        let into = result(&mut dem, "heat_to_block_j");
        close("block", into, share * slip, 1e-9 * slip);
        close("balance", result(&mut dem, "heat_balance_rel"), 0.0, 1e-12);
    }
}

/// The keys of a half-space on the area of a disk's diameter.
fn half_space(effusivity: f64, start: f64) -> Value {
    json!({"effusivity_w_s05_per_m2_k": effusivity, "start_k": start, "length_m": 2.0 * R})
}

/// Area of these half-spaces (m2).
const AREA: f64 = 2.0 * R * 1e-3;

/// Three disks between half-spaces of other effusivities: once the heat that has passed exceeds theirs, the surfaces meet at (b1 T1 + b2 T2)/(b1 + b2).
/// After 1 s the contacts, of the resistance R = 4/H together, keep A R/((1/b1 + 1/b2) sqrt(pi t)) = 0.07 % of the difference, and the disks 0.14 % of the
/// heat.
#[test]
fn half_spaces_meet_at_the_temperature_of_their_effusivities() {
    let ([b1, b2], [t1, t2]) = ([12e3, 4e3], [300.0, 500.0]);
    let spaces = json!({"base": half_space(b1, t1), "wheel": half_space(b2, t2)});
    for every in [1, 3] {
        let keys = json!({"capacity_j_per_kg_k": 5.0, "conductance_w_per_k": 2.0, "half_spaces": spaces, "every_steps": every});
        let mut dem = build(&column(3, 1e-3, heat(keys)));
        march(&mut dem, 0, 1000);
        let met = (b1 * t1 + b2 * t2) / (b1 + b2);
        for name in [
            "half_space_base_k",
            "half_space_wheel_k",
            "temperature_end_k",
        ] {
            close(name, result(&mut dem, name), met, 0.01 * (t2 - t1));
        }
        let passed = b1 * b2 / (b1 + b2) * (t2 - t1) * 2.0 / PI.sqrt() * AREA;
        for (name, sign) in [("heat_to_base_j", 1.0), ("heat_to_wheel_j", -1.0)] {
            close(name, result(&mut dem, name), sign * passed, 0.01 * passed);
        }
        close("balance", result(&mut dem, "heat_balance_rel"), 0.0, 1e-12);
    }
}

/// A disk that a belt presses against a wall, at which it does not slip: the belt rubs it with mu m g/(1 - mu). Belt and wall are half-spaces of one
/// temperature and share the heat by their effusivities, however contacts halve it; without conduction the belt has its half alone.
#[test]
fn half_spaces_share_a_source_by_their_effusivities() {
    let (mu, g, speed, [b1, b2]) = (0.3, 1e4, 1.0, [12e3, 4e3]);
    for (conductance, shares, warmed) in [
        (2.0, [b1 / (b1 + b2), b2 / (b1 + b2)], [1.0; 2]),
        (0.0, [0.5, 0.0], [0.5 * (b1 + b2) / b1, 0.0]),
    ] {
        let disks = json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]);
        let walls = json!([{"name": "belt", "x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0, "velocity_m_per_s": [speed, 0.0]},
            {"name": "wall", "x_m": R, "y_m": 0.0, "nx": -1.0, "ny": 0.0}]);
        let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
        let pairs = json!([{"between": ["grains", "wall"], "friction": 1.5}]);
        let spaces = json!({"belt": half_space(b1, START), "wall": half_space(b2, START)});
        let mut keys = heat(
            json!({"capacity_j_per_kg_k": 5.0, "conductance_w_per_k": conductance, "half_spaces": spaces, "every_steps": 4}),
        );
        keys["gravity_m_per_s2"] = json!([0.0, -g]);
        let law = json!({"kind": "coulomb", "friction": mu, "pairs": pairs});
        let mut dem = build(&scene(law, 1e-3, sample, keys));
        let made = march(&mut dem, 0, 1000).energy("friction");
        close(
            "source",
            made,
            mu * mass(R) * g / (1.0 - mu) * speed,
            0.01 * made,
        );
        // Of both half-spaces under the whole flux.
        let rise = 2.0 * made / AREA / PI.sqrt() / (b1 + b2);
        for ((name, share), warmed) in ["belt", "wall"].into_iter().zip(shares).zip(warmed) {
            let into = result(&mut dem, &format!("heat_to_{name}_j"));
            close(name, into, share * made, 0.005 * made);
            let at = result(&mut dem, &format!("half_space_{name}_k")) - START;
            close(name, at, warmed * rise, 0.01 * rise);
        }
        close("balance", result(&mut dem, "heat_balance_rel"), 0.0, 1e-12);
    }
}

/// A disk whose capacity keeps it 100 K hotter warms a half-space through its contact by 100 K (1 - exp(x^2) erfc(x)), x = H sqrt(t)/(A b): at first by
/// 2 q sqrt(t/pi)/b, as a constant flux does.
#[test]
fn a_hot_disk_warms_a_half_space_through_its_contact() {
    for (conductance, every) in [(1e-6, 1), (3e-3, 1), (3e-3, 5), (0.1, 2)] {
        let (b, steps, step) = (12e3, 1000, 1e-3);
        let mut keys = heat(
            json!({"capacity_j_per_kg_k": 1e30, "conductance_w_per_k": conductance, "start_k": START + 100.0, "every_steps": every}),
        );
        keys["heat"]["half_spaces"] = json!({"floor": half_space(b, START)});
        let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]);
        let law = json!({"kind": "signorini"});
        let mut dem = on_floor(law, step, 9.81, disk, &keys);
        march(&mut dem, 0, steps);
        let time = f64::from(steps) * step;
        let x = conductance * time.sqrt() / (AREA * b);
        let points = (0..60_000).map(|k| 1e-4 * (f64::from(k) + 0.5));
        let left: f64 = points.map(|u| (-u * u - 2.0 * x * u).exp()).sum();
        let rise = 100.0 * (1.0 - 2.0 / PI.sqrt() * 1e-4 * left);
        let found = result(&mut dem, "half_space_floor_k") - START;
        close("rise", found, rise, 2e-3 * rise);
        if conductance < 1e-5 {
            let flux = 100.0 * conductance / AREA;
            close(
                "flux",
                found,
                2.0 * flux * (time / PI).sqrt() / b,
                2e-3 * rise,
            );
        }
    }
}

/// A disk that slides until it rolls, with a capacity that doubles over 100 K: x + x^2/200 is its heat over m c.
#[test]
fn heat_warms_a_disk_by_the_integral_of_its_capacity() {
    let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "vx_m_per_s": 0.1}]);
    let keys = heat(
        json!({"capacity_j_per_kg_k": 2e-5, "capacity_factor": [[300.0, 1.0], [400.0, 2.0]], "conductance_w_per_k": 0.0}),
    );
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let mut dem = on_floor(law, 1e-5, 9.81, disk, &keys);
    let report = march(&mut dem, 0, 2000);
    let joules = report.energy("friction") + report.energy("impact");
    let heat = joules / (mass(R) * 2e-5);
    let rise = 100.0 * ((1.0 + heat / 50.0).sqrt() - 1.0);
    assert!(rise > 50.0 && rise < 100.0, "{rise}");
    close(
        "rise",
        report.signal("temperature_max_k") - START,
        rise,
        1e-7 * rise,
    );
    let peak = result(&mut dem, "temperature_peak_k") - START;
    close("peak", peak, rise, 1e-7 * rise);
    close(
        "stored",
        result(&mut dem, "heat_stored_j"),
        joules,
        1e-12 * joules,
    );
    close("balance", result(&mut dem, "heat_balance_rel"), 0.0, 1e-12);
}

/// A disk between ends 100 K hotter, with this capacity: C x' = 2 H (100 - x), that is 2 ln(100/s) - (100 - s)/100 = 2 H t/(m c) with s = 100 - x.
#[test]
fn a_capacity_that_grows_slows_conduction() {
    let ends = json!({"base": START + 100.0, "wheel": START + 100.0});
    let keys = json!({"held_k": ends, "capacity_factor": [[300.0, 1.0], [400.0, 2.0]]});
    let (step, steps) = (1e-5, 400);
    let mut dem = build(&column(1, step, heat(keys)));
    let report = march(&mut dem, 0, steps);
    let left = START + 100.0 - report.signal("temperature_mean_k");
    let found = 2.0 * (100.0 / left).ln() - (100.0 - left) / 100.0;
    let exact = 2.0 * CONDUCTANCE * step * f64::from(steps) / (mass(R) * CAPACITY);
    close("time", found, exact, 2e-3 * exact);
    close("balance", result(&mut dem, "heat_balance_rel"), 0.0, 1e-12);
}

/// Five disks between 300 and 400 K, with a conductance that triples between: x + x^2/100 is linear along the column (Kirchhoff 1894), since the factor at
/// the mean of two temperatures is its mean between them.
#[test]
fn a_conductivity_over_temperature_bends_the_column() {
    let ends = json!({"held_k": {"base": 300.0, "wheel": 400.0}, "conductivity_factor": [[300.0, 1.0], [400.0, 3.0]],
        "capacity_factor": [[300.0, 1.0], [400.0, 2.0]]});
    let mut dem = build(&column(5, 0.015, heat(ends)));
    march(&mut dem, 0, 3000);
    let before = result(&mut dem, "heat_to_base_j");
    let report = march(&mut dem, 3000, 300);
    let rise = |k: usize| 50.0 * ((1.0 + 8.0 * k as f64 / 6.0).sqrt() - 1.0);
    let mean = (1..6).map(rise).sum::<f64>() / 5.0;
    close(
        "mean",
        report.signal("temperature_mean_k"),
        START + mean,
        1e-8,
    );
    close(
        "highest",
        report.signal("temperature_max_k"),
        START + rise(5),
        1e-8,
    );
    let flow = CONDUCTANCE * 200.0 / 6.0 * 300.0 * 0.015;
    let after = result(&mut dem, "heat_to_base_j");
    close("flow", after - before, flow, 1e-9 * flow);
    let content = (1..6).map(|k| rise(k) + rise(k).powi(2) / 200.0);
    let stored = mass(R) * CAPACITY * content.sum::<f64>();
    close(
        "stored",
        result(&mut dem, "heat_stored_j"),
        stored,
        1e-9 * stored,
    );
    close("balance", result(&mut dem, "heat_balance_rel"), 0.0, 1e-12);
}

#[test]
fn a_checkpoint_keeps_the_temperatures() {
    a_checkpoint_keeps(json!({"held_k": {"base": 320.0, "wheel": 400.0}, "every_steps": 3}));
}

#[test]
fn a_checkpoint_keeps_half_spaces_and_contents() {
    a_checkpoint_keeps(
        json!({"half_spaces": {"base": half_space(4e3, 320.0)}, "held_k": {"wheel": 400.0}, "every_steps": 3,
        "capacity_factor": [[300.0, 1.0], [400.0, 2.0]], "conductivity_factor": [[300.0, 1.0], [400.0, 2.0]]}),
    );
}

fn a_checkpoint_keeps(more: Value) {
    let keys = || heat(more.clone());
    let mut whole = build(&column(3, 1e-3, keys()));
    march(&mut whole, 0, 4);
    let state = whole.checkpoint().expect("it is written");
    let expected = march(&mut whole, 4, 4).signal("temperature_mean_k");
    let mut rest = build(&column(3, 1e-3, keys()));
    rest.restore(&state).expect("it is read");
    assert_eq!(
        march(&mut rest, 4, 4).signal("temperature_mean_k"),
        expected
    );
    let [one, other] = [&mut whole, &mut rest].map(|dem| dem.finish().expect("it ends"));
    assert_eq!(one.state_hash, other.state_hash);
    assert_eq!(one.results, other.results);
}

#[test]
fn heat_without_its_numbers_is_refused() {
    let refused = |more: Value| refusal(&column(1, 1e-3, heat(more)));
    let words = [
        (json!({"conductivity_w_per_m_k": 50.0}), "either"),
        (json!({"conductance_w_per_k": null}), "either"),
        (
            json!({"conductance_w_per_k": null, "conductivity_w_per_m_k": 50.0}),
            "heat.young_pa",
        ),
        (json!({"young_pa": 2e11}), "heat.young_pa"),
        (
            json!({"sources": {"friction": 1.5}}),
            "heat.sources.friction",
        ),
        (json!({"start_k": 0.0}), "heat.start_k"),
        (json!({"held_k": {"lid": 300.0}}), "wheel, base"),
        (json!({"held_k": {"base": -1.0}}), "heat.held_k.base"),
        (
            json!({"half_spaces": {"lid": half_space(1.0, 300.0)}}),
            "heat.half_spaces.lid",
        ),
        (
            json!({"half_spaces": {"base": half_space(1.0, 300.0)}, "held_k": {"base": 300.0}}),
            "heat.half_spaces.base",
        ),
        (
            json!({"half_spaces": {"base": half_space(0.0, 300.0)}}),
            "heat.half_spaces.base.effusivity_w_s05_per_m2_k",
        ),
        (
            json!({"half_spaces": {"base": {"start_k": 300.0}}}),
            "effusivity",
        ),
        (
            json!({"capacity_factor": [[300.0, 0.0]]}),
            "factors above 0",
        ),
        (
            json!({"conductivity_factor": [[300.0, -0.1]]}),
            "no less than 0",
        ),
        (
            json!({"conductivity_factor": []}),
            "heat.conductivity_factor",
        ),
    ];
    for (more, word) in words {
        let message = refused(more);
        assert!(message.contains(word), "{message}");
    }
    let mut glued = column(1, 1e-3, heat(json!({})));
    glued["sample"]["disks"][1]["cluster"] = json!("block");
    let message = refusal(&glued);
    assert!(message.contains("of its own"), "{message}");
}

/// Conduction that rounding would spoil, or that is no number, is an error, and the units are named.
#[test]
fn conduction_beyond_the_numbers_is_an_error() {
    let held = json!({"held_k": {"base": 400.0}});
    for more in [
        json!({"conductance_w_per_k": 3e13}),
        json!({"capacity_j_per_kg_k": 1e-30}),
        json!({"half_spaces": {"wheel": half_space(1e-30, 300.0)}}),
    ] {
        let mut keys = heat(held.clone());
        let table = keys["heat"].as_object_mut().expect("it is a table");
        table.extend(more.as_object().expect("it is a table").clone());
        let mut dem = build(&column(1, 1e-3, keys));
        let error = dem
            .advance_alone(&window(0, 1e-2))
            .expect_err("it is too much");
        assert!(
            error.to_string().contains("heat.capacity_j_per_kg_k"),
            "{error}"
        );
    }
}

/// A factor on the capacity that falls a hundredfold in a conduction overshoots the held temperature, and a run says so.
#[test]
fn a_capacity_that_falls_within_a_conduction_is_warned_of() {
    for (factor, warns) in [(0.01, true), (0.9, false)] {
        let keys = json!({"held_k": {"base": 400.0, "wheel": 400.0}, "capacity_factor": [[340.0, 1.0], [340.001, factor]]});
        let mut dem = build(&column(2, 0.002, heat(keys)));
        march(&mut dem, 0, 50);
        let found = dem.finish().expect("it ends").findings;
        let heat_steps = found.iter().any(|found| found.code == "heat_steps");
        assert_eq!(heat_steps, warns, "{found:?}");
    }
}

/// A coupler that gives the temperature of a glued disk finds no other one there.
#[test]
fn a_surface_has_its_temperature_from_one_side() {
    for (more, is_free) in [
        (json!({"held_k": {"base": 300.0}}), false),
        (
            json!({"half_spaces": {"base": half_space(1e4, 300.0)}}),
            false,
        ),
        (
            json!({"half_spaces": {"wheel": half_space(1e4, 300.0)}}),
            true,
        ),
    ] {
        let mut config = column(1, 1e-3, heat(more));
        config["time"] = json!({"pressure_pa": 1.0});
        let mut dem = build(&config);
        dem.couple("base").expect("it has this set");
        let given = dem.take_temperatures(&window(0, 1e-3), &[350.0]);
        let refused = given.err().map(|error| error.to_string());
        assert_eq!(refused.is_none(), is_free, "{refused:?}");
        assert!(
            refused
                .as_ref()
                .is_none_or(|why| why.contains("heat.half_spaces.base")),
            "{refused:?}"
        );
    }
}

/// The points of a bare surface are of the base as well.
#[test]
fn a_bare_surface_has_its_temperature_from_one_side() {
    let disks = json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]);
    let surface = json!({"half_width_m": 1e-3, "spacing_m": 5e-4});
    let sample = json!({"kind": "disks", "disks": disks, "walls": [], "surface": surface});
    let keys = heat(json!({"held_k": {"base": 300.0}}));
    let mut config = scene(json!({"kind": "signorini"}), 1e-3, sample, keys);
    config["time"] = json!({"pressure_pa": 1.0});
    let mut dem = build(&config);
    let points = dem.couple("base").expect("it has this set").x_m.len();
    let given = dem.take_temperatures(&window(0, 1e-3), &vec![350.0; points]);
    let why = given.expect_err("it is held").to_string();
    assert!(why.contains("heat.held_k.base"), "{why}");
}

/// Steps after the last conduction count at the end: one conduction over all of them.
#[test]
fn the_last_steps_conduct_at_the_end() {
    let ends = json!({"held_k": {"base": START + 10.0, "wheel": START + 10.0}, "every_steps": 100});
    let mut dem = build(&column(1, 1e-3, heat(ends)));
    march(&mut dem, 0, 7);
    let rate = 2.0 * CONDUCTANCE / (mass(R) * CAPACITY);
    let expected = START + 10.0 - 10.0 / (1.0 + 7e-3 * rate);
    close(
        "mean",
        result(&mut dem, "temperature_end_k"),
        expected,
        1e-9,
    );
}

/// Grains that never warm, under tables with 0.75 at their temperature, move as those with 0.75 of friction and w, bit by bit.
#[test]
fn what_is_warm_holds_less() {
    let table = json!([[START - 100.0, 1.0], [START + 100.0, 0.5]]);
    let moved = |law: Value, softening: Value| {
        let mut keys = heat(json!({"capacity_j_per_kg_k": 1e30, "softening": softening}));
        keys["solver"] = json!({"kind": "nsgs", "tolerance": 1e-8, "max_iterations": 20_000, "min_iterations": 1});
        let mut dem = on_floor(law, 1e-6, 9.81, pile(), &keys);
        let report = march(&mut dem, 0, 3000);
        let state = dem.state();
        (
            state.velocities.clone(),
            state.bonds.clone(),
            report.energy("cohesion"),
            report.energy("friction"),
        )
    };
    let constant = laws(0.4 * 0.75, 1e-6 * 0.75);
    for (index, (warm, cold)) in laws(0.4, 1e-6).into_iter().zip(constant).enumerate() {
        let mut softening = json!({ "friction": table });
        if index == 2 {
            softening["bonds"] = table.clone();
        }
        let found = moved(warm, softening);
        assert!(found.3 > 0.0 && (index < 2 || found.2 > 0.0), "{found:?}");
        assert_eq!(found, moved(cold, Value::Null));
    }
}

/// Contacts that a loose tolerance leaves unsolved gain energy in some steps: neither a grain nor the body below gets colder by it, and the heat is what
/// all contacts have lost.
#[test]
fn an_unsolved_contact_cools_nothing() {
    let mut disks = pile();
    let all = disks.as_array_mut().into_iter().flatten();
    for (index, disk) in all.enumerate() {
        disk["vy_m_per_s"] = json!(if index < 4 { 0.0 } else { -0.1 });
        disk["glued"] = json!(index < 4);
    }
    let law = json!({"kind": "coulomb", "friction": 0.9, "contact_stiffness_pa": 1e8, "tangential_stiffness_ratio": 0.5});
    let mut keys = heat(json!({"conductance_w_per_k": 1e-9}));
    keys["gravity_m_per_s2"] = json!([30.0, -9.81]);
    keys["solver"] =
        json!({"kind": "nsgs", "tolerance": 0.1, "max_iterations": 3, "min_iterations": 1});
    let sample = json!({"kind": "disks", "disks": disks, "walls": []});
    let mut config = scene(law, 1e-6, sample, keys);
    config["time"] = json!({"pressure_pa": 1.0});
    let mut dem = build(&config);
    dem.couple("base").expect("it has this set");
    dem.set_boundary(1e-6, &[0.0; 64]).expect("a rigid body");
    let mut entered = 0.0;
    for index in 0..60 {
        let temperatures = vec![START; 4];
        let given = dem.take_temperatures(&window(index, 1e-6), &temperatures);
        let given = given.expect("it has heat");
        assert!(given.iter().all(|number| *number >= 0.0), "{given:?}");
        entered += given[..4].iter().sum::<f64>();
        for index in 50 * index..50 * (index + 1) {
            let window = window(index, 1e-6);
            dem.solve(&window, &[0.0; 8]).expect("it can be solved");
            dem.commit(&window, &[0.0; 8]).expect("it is committed");
            let grains = dem.state().heat.contents.iter().copied();
            let lowest = grains.reduce(f64::min);
            assert!(lowest >= Some(0.0), "{lowest:?}");
        }
    }
    let given = dem.take_temperatures(&window(60, 1e-6), &[START; 4]);
    entered += given.expect("it has heat")[..4].iter().sum::<f64>();
    close(
        "base",
        entered / result(&mut dem, "heat_to_base_j"),
        1.0,
        1e-12,
    );
    let lost = result(&mut dem, "heat_friction_j") + dem.state().heat.owed;
    close(
        "heat",
        (result(&mut dem, "heat_stored_j") + entered) / lost,
        1.0,
        1e-12,
    );
}

/// A disk of 300 K slides over a floor of 600 K: its friction is 0.7 at the mean of 450 K. It cools a half-space of no effusivity to 300 K in its first
/// step, and all others have the whole friction.
#[test]
fn a_contact_has_the_mean_of_its_temperatures() {
    let softening = json!({"friction": [[400.0, 1.0], [500.0, 0.4]]});
    let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "vx_m_per_s": 0.1}]);
    let pairs = json!([{"between": ["grains", "floor"], "friction": 0.3}]);
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let paired = json!({"kind": "coulomb", "friction": 0.1, "pairs": pairs});
    let held = json!({"held_k": {"floor": 600.0}});
    let cooled = json!({"half_spaces": {"floor": half_space(1e-6, 600.0)}});
    for (law, floor, factor) in [
        (&law, &held, 0.7),
        (&paired, &held, 0.7),
        (&law, &cooled, 0.997),
    ] {
        let keys = json!({"capacity_j_per_kg_k": 1e30, "conductance_w_per_k": 1.0, "softening": softening});
        let keys = heat(with(keys, floor));
        let mut dem = on_floor(law.clone(), 1e-5, 9.81, disk.clone(), &keys);
        march(&mut dem, 0, 100);
        let speed = dem.state().velocities[0][0];
        close("speed", speed, 0.1 - 0.3 * factor * 9.81 * 1e-3, 1e-12);
    }
}

/// A disk of 300 K on a floor of 360 K heals in T exp(E/R (1/330 - 1/300)).
#[test]
fn healing_waits_for_less_where_it_is_warm() {
    let (time, activation) = (0.1, 4e4);
    let softening = json!({ "healing_j_per_mol": activation });
    let mut law = laws(0.3, 1e-3)[2].clone();
    law["healing"] = json!({"time_s": time, "pressure_pa": 0.0});
    law["alert_m"] = json!(1e-15);
    let keys = heat(
        json!({"capacity_j_per_kg_k": 1e30, "conductance_w_per_k": 0.0, "held_k": {"floor": 360.0}, "softening": softening}),
    );
    let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]);
    let mut dem = on_floor(law, 1e-5, 9.81, disk, &keys);
    let warm: f64 = time * (activation / 8.314_462_618 * (1.0 / 330.0 - 1.0_f64 / 300.0)).exp();
    // It comes to rest within three steps of this damper, and is bonded from T/100 on.
    let steps = (0.2 * warm / 1e-5) as u32;
    march(&mut dem, 0, steps);
    let adhesion = dem.state().bonds[0].adhesion;
    close("adhesion", adhesion, f64::from(steps) * 1e-5 / warm, 0.02);
    close("steps", adhesion * warm / 1e-5 % 1.0, 0.0, 1e-6);
}

/// A disk that cools as it slides has less friction at the start of each step than at its end: its contact slips all the same.
#[test]
fn a_contact_that_slips_as_it_cools_is_shown_to_slip() {
    let folder = harness::runs::Scratch::new("softening");
    let table = json!([[300.0, 1.0], [900.0, 0.5]]);
    let keys = heat(
        json!({"start_k": 800.0, "held_k": {"floor": 300.0}, "softening": {"friction": table}}),
    );
    let disks = json!([{"x_m": 0.0, "y_m": R, "radius_m": R, "vx_m_per_s": 1.0}]);
    let walls = json!([{"name": "floor", "x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}]);
    let sample = json!({"kind": "disks", "disks": disks, "walls": walls});
    let mut config = scene(
        json!({"kind": "coulomb", "friction": 0.3}),
        1e-5,
        sample,
        keys,
    );
    config["gravity_m_per_s2"] = json!([0.0, -9.81]);
    let setting = protocol::Setting {
        fields: Some(folder.path().to_path_buf()),
        ..setting(1)
    };
    let config = kit::read_config(&config).expect("the keys are valid");
    let mut dem = Dem::new(&config, &setting).expect("the scene is valid");
    march(&mut dem, 0, 100);
    dem.snapshot("end").expect("a file");
    let file = folder.path().join("third-body-end-contacts.vtp");
    let status = array(&std::fs::read(file).expect("a file"), "status");
    assert_eq!(status, [2.0]);
}

#[test]
fn softening_without_effect_is_refused() {
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let refused = |softening: Value, kind: &str| {
        let mut keys = column(1, 1e-3, heat(json!({ "softening": softening })));
        keys["law"] = law.clone();
        keys["solver"]["kind"] = json!(kind);
        refusal(&keys)
    };
    let words = [
        (json!({"friction": [[300.0, 1.0], [200.0, 0.5]]}), "entry 1"),
        (json!({"friction": [[300.0, -1.0]]}), "no less than 0"),
        (json!({"bonds": [[300.0, 1.0]]}), "without law.w_j_per_m2"),
        (json!({"healing_j_per_mol": 1.0}), "without law.healing"),
    ];
    for (softening, word) in words {
        let message = refused(softening, "nsgs");
        assert!(message.contains(word), "{message}");
    }
    let mut bare = column(
        1,
        1e-3,
        heat(json!({"softening": {"friction": [[300.0, 1.0]]}})),
    );
    bare["sample"]["surface"] = json!({"half_width_m": 1e-2, "spacing_m": 1e-3, "friction": 0.4});
    bare["law"] = json!({"kind": "coulomb", "friction": 0.0});
    // The surface rubs.
    build(&bare);
    let message = refused(json!({"friction": [[300.0, 1.0]]}), "pcg");
    assert!(message.contains("heat.softening.friction"), "{message}");
}
