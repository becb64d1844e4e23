//! Layers below a lid, a rigid plate of mass M under a load P that moves sideways: flows, feeds and stress.
//!
//! ```text
//!     # # # # # # # #  ->  V     lid:  v_x = V,  M v_y' = -P + (forces of the grains)
//!      o o o o o o o o
//!     o o o o o o o o           free grains, bonded or not; the strip is periodic along x or has ends
//!      o o o o o o o o
//!     # # # # # # # #           base, held
//! ```
//!
//! The plate is a compliant boundary, v_g = a_g + W_g p, all of whose vertical components share 1/M. Reference: statics, balance
//! of momentum, masses counted grain by grain. Tolerance: rounding, and the true residual for forces.

use dem_node::Dem;
use protocol::{Node, Window};
use serde_json::{Value, json};

use crate::dem_flow::third_body;
use crate::dem_support::{DENSITY, Report, THICKNESS, build, close, mass, refusal, scene};

const R: f64 = 0.07e-3;
const STEP: f64 = 1e-6;
const STIFFNESS: f64 = 1.4e10;
/// Grains of a row, and length of the strip (m).
const ROW: usize = 12;
const LENGTH: f64 = 2.0 * R * ROW as f64;

/// A node whose lid is a plate.
struct Pressed {
    dem: Dem,
    /// Glued disks of the base and of the lid.
    rows: [usize; 2],
    mass: f64,
    speed: f64,
    /// Vertical velocity of the lid, and displacement (m/s, m).
    sinking: f64,
    moved: [f64; 2],
    windows: u64,
    /// Forces of the grains on base and lid in the last window (N).
    forces: [[f64; 2]; 2],
}

impl Pressed {
    fn new(config: &Value, mass: f64, speed: f64) -> Pressed {
        let mut dem = build(config);
        let rows = ["base", "lid"].map(|set| dem.couple(set).expect("it is a row").len());
        let n = 2 * (rows[0] + rows[1]);
        let vertical = |k: usize| k % 2 == 1 && k >= 2 * rows[0];
        let plate = |i: usize| {
            if vertical(i / n) && vertical(i % n) {
                1.0 / mass
            } else {
                0.0
            }
        };
        let compliance: Vec<f64> = (0..n * n).map(plate).collect();
        dem.set_boundary(STEP, &compliance).expect("it is square");
        Pressed {
            dem,
            rows,
            mass,
            speed,
            sinking: 0.0,
            moved: [0.0; 2],
            windows: 0,
            forces: [[0.0; 2]; 2],
        }
    }

    /// A window under a load (N).
    fn step(&mut self, load: f64) -> Report {
        let window = Window {
            index: self.windows,
            substeps: 1,
            t0_s: self.windows as f64 * STEP,
            t1_s: (self.windows + 1) as f64 * STEP,
            ..Window::default()
        };
        let [base, lid] = self.rows;
        let on_rows = |of_lid: [f64; 2]| [[0.0; 2].repeat(base), of_lid.repeat(lid)].concat();
        let free = on_rows([self.speed, self.sinking - STEP * load / self.mass]);
        let answer = self.dem.solve(&window, &free).expect("it is solved");
        assert!(answer.converged);
        self.sinking = answer.velocity[2 * base + 1];
        self.moved = [
            self.moved[0] + STEP * self.speed,
            self.moved[1] + STEP * self.sinking,
        ];
        let sum = |part: &[f64]| [0, 1].map(|k| part.iter().skip(k).step_by(2).sum());
        let (below, above) = answer.force.split_at(2 * base);
        self.forces = [sum(below), sum(above)];
        let values = self
            .dem
            .commit(&window, &on_rows(self.moved))
            .expect("it was solved");
        self.windows += 1;
        Report::new(self.dem.describe(), values)
    }

    fn result(&mut self, name: &str) -> Option<f64> {
        let results = self.dem.finish().expect("it ends").results;
        results.get(name).copied()
    }
}

/// Hexagonal rows: the lowest is the base, the uppermost the lid.
fn hexagonal(rows: usize, periodic: bool) -> Value {
    let disk = |i: usize| {
        let (row, column) = (i / ROW, (i % ROW) as f64);
        let x = R * (2.0 * column + (row % 2) as f64 + 0.5) - 0.5 * LENGTH;
        let glued = row == 0 || row == rows - 1;
        json!({"x_m": x, "y_m": 3f64.sqrt() * R * row as f64, "radius_m": R, "glued": glued, "lid": glued && row > 0})
    };
    let mut sample =
        json!({"kind": "disks", "disks": (0..ROW * rows).map(disk).collect::<Vec<_>>()});
    if periodic {
        sample["periodic_x_m"] = json!([-0.5 * LENGTH, 0.5 * LENGTH]);
    }
    sample
}

/// Weakly bonded rows with flows of third body.
fn followed(periodic: bool) -> Value {
    let law = json!({
        "kind": "cohesion", "friction": 0.6, "contact_stiffness_pa": STIFFNESS, "tangential_stiffness_ratio": 0.5,
        "cn_pa_per_m": 4e14, "ct_pa_per_m": 2e14, "w_j_per_m2": 0.06, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one",
        "alert_m": 2e-6,
    });
    let mut config = scene(
        law,
        STEP,
        hexagonal(6, periodic),
        json!({"mass_scale": 100.0}),
    );
    config["time"] = json!({"pressure_pa": 1e6});
    config["solver"] =
        json!({"kind": "nsgs", "tolerance": 1e-9, "max_iterations": 50_000, "min_iterations": 1});
    config["flow"] = json!({"wear_s": 1e-4});
    config
}

/// A lid of 0.01 kg under 20 N, with a velocity of 2 m/s.
fn sheared(config: &Value) -> Pressed {
    Pressed::new(config, 0.01, 2.0)
}

const LOAD: f64 = 20.0;

#[test]
fn nothing_leaves_a_sheared_strip_and_its_masses_balance() {
    let mut pressed = sheared(&followed(true));
    let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
    for window in 0..600 {
        let report = pressed.step(LOAD);
        let found = report.signal("third_body_zone_kg");
        let expected = third_body(&pressed.dem, everywhere);
        close("third body", found, expected, 1e-12 * mass(R));
        let per_length = report.signal("third_body_per_length_kg_per_m");
        close(
            "per length",
            per_length,
            expected / LENGTH,
            1e-12 * mass(R) / LENGTH,
        );
        close("left", report.signal("zone_left_m"), -0.5 * LENGTH, 0.0);
        close("right", report.signal("zone_right_m"), 0.5 * LENGTH, 1e-18);
        for name in [
            "q_ejected_kg",
            "q_left_by_zone_kg",
            "q_entered_kg",
            "q_recirculated_kg",
            "q_wear_kg",
        ] {
            assert_eq!(report.signal(name), 0.0, "{name} in window {window}");
        }
    }
    let centres = &pressed.dem.state().centres[..pressed.dem.bodies().free];
    let beyond = centres
        .iter()
        .filter(|centre| centre[0] > 0.5 * LENGTH)
        .count();
    assert!(
        beyond > 2,
        "{beyond} grains have left by the right side and entered by the left"
    );
    let detached = third_body(&pressed.dem, everywhere);
    assert!(detached > 9.5 * mass(R), "{detached:e}");
    let source = pressed.result("q_source_kg");
    let anew = pressed.result("q_reattached_kg");
    close(
        "source",
        source.expect("it is reported"),
        detached,
        1e-12 * detached,
    );
    assert_eq!(anew, Some(0.0));
    close(
        "balance",
        pressed.result("flow_balance_rel").expect("it is reported"),
        0.0,
        1e-15,
    );
    let kinetic = pressed.result("flow_kinetic_rel").expect("it is reported");
    assert!(kinetic > 0.0, "{kinetic}");
}

/// The flow through x = 0 and its images follows from the moves of the grains; the seam has no effect.
#[test]
fn the_flow_through_a_section_of_a_strip_is_counted_at_all_its_images() {
    let mut pressed = sheared(&followed(true));
    let mut report = pressed.step(LOAD);
    let image = |x: f64| (x / LENGTH).floor();
    let positions = |dem: &Dem| -> Vec<f64> {
        let centres = dem.state().centres[..dem.bodies().free].iter();
        centres.map(|centre| centre[0]).collect()
    };
    let third = |dem: &Dem| -> Vec<f64> {
        let alone = |i: usize| third_body_of(dem, i);
        (0..dem.bodies().free).map(alone).collect()
    };
    let (mut net, mut both) = (0.0, 0.0);
    for _ in 0..1500 {
        let (before, was) = (positions(&pressed.dem), third(&pressed.dem));
        report = pressed.step(LOAD);
        for ((now, then), mass) in positions(&pressed.dem).iter().zip(before).zip(was) {
            let passed = (image(*now) - image(then)) * mass;
            net += passed;
            both += passed.abs();
        }
    }
    assert!(net > 3.5 * mass(R), "{net:e}");
    close("net", report.signal("q_internal_net_kg"), net, 1e-12 * net);
    close(
        "both",
        report.signal("q_internal_abs_kg"),
        both,
        1e-12 * both,
    );
}

/// The real mass (kg) of a grain that no chain of bonds holds, 0 for any other grain.
fn third_body_of(dem: &Dem, grain: usize) -> f64 {
    let free = dem.bodies().free;
    let bonds = dem.state().bonds.iter().filter(|bond| bond.adhesion > 0.01);
    let pairs: Vec<_> = bonds.map(|bond| (bond.a, bond.b)).collect();
    let first = dem_kernel::contact::graph::first_bodies(free, &pairs);
    if first[grain] { 0.0 } else { mass(R) }
}

/// The zone of a lid with ends is its row from end to end, which moves with the lid. A loose grain that flies out below leaves when it
/// passes the right end; the left end leaves a second one behind, which counts as wear T_w later. The lid hangs above the layer.
#[test]
fn the_zone_of_a_lid_is_its_row_and_grains_that_leave_it_are_worn() {
    let mut config = followed(false);
    let low = -4.0 * R;
    let (fast, start) = (6.0, 0.5 * LENGTH - 20.3 * R);
    let disks = config["sample"]["disks"].as_array_mut().expect("a list");
    for disk in disks.iter_mut().filter(|disk| disk["lid"] == json!(true)) {
        disk["y_m"] = json!(30.0 * R);
    }
    disks.push(json!({"x_m": start, "y_m": low, "radius_m": R, "vx_m_per_s": fast}));
    disks.push(json!({"x_m": -0.5 * LENGTH + 0.6 * R, "y_m": low, "radius_m": R}));
    let mut pressed = sheared(&config);
    let row = [-0.5 * LENGTH + 0.5 * R, 0.5 * LENGTH + 0.5 * R];
    let mut events = [None; 3];
    for window in 0..600_u32 {
        let report = pressed.step(0.0);
        let moved = pressed.moved[0];
        let ends = [report.signal("zone_left_m"), report.signal("zone_right_m")];
        for (end, own) in ends.into_iter().zip(row) {
            close("end", end, own + moved, 1e-15);
        }
        let expected = third_body(&pressed.dem, ends);
        close(
            "third body",
            report.signal("third_body_zone_kg"),
            expected,
            1e-12 * mass(R),
        );
        let names = ["q_ejected_kg", "q_left_by_zone_kg", "q_wear_kg"];
        for (event, name) in events.iter_mut().zip(names) {
            if report.signal(name) > 0.0 {
                event.get_or_insert(window);
            }
        }
    }
    // Grains move before the zone does: the first window i at whose end start + fast (i + 1) h > row + V i h.
    let chase =
        |speed: f64, way: f64, ahead: f64| ((way - ahead) / (speed * STEP)).ceil() as u32 - 1;
    let out = chase(fast - 2.0, row[1] - start, 2.0 * STEP);
    let behind = chase(2.0, -0.5 * LENGTH + 0.6 * R - row[0], 0.0);
    // The grain left behind is worn first, 100 windows later.
    assert_eq!(events, [Some(out), Some(behind), Some(behind + 100)]);
    let results = pressed.dem.finish().expect("it ends").results;
    close("balance", results["flow_balance_rel"], 0.0, 1e-15);
}

/// The forces on lid and base are opposite, except for the momentum of the grains: F_lid + F_base = -dP/dt.
#[test]
fn forces_on_lid_and_base_differ_by_the_momentum_of_the_grains() {
    let mut pressed = sheared(&followed(true));
    let mut momentum = [0.0; 2];
    let (mut drag, mut weight): (f64, f64) = (0.0, 0.0);
    for window in 0..600 {
        let report = pressed.step(LOAD);
        let now =
            ["momentum_x_kg_m_per_s", "momentum_y_kg_m_per_s"].map(|name| report.signal(name));
        let [base, lid] = pressed.forces;
        for k in 0..2 {
            let taken = (now[k] - momentum[k]) / STEP;
            close(
                &format!("{k} in window {window}"),
                base[k] + lid[k],
                -taken,
                1e-9 * LOAD,
            );
        }
        momentum = now;
        drag = drag.max(lid[0].abs());
        weight = weight.max(lid[1]);
    }
    assert!(drag > 0.1 * LOAD && weight > 0.5 * LOAD, "{drag} {weight}");
}

/// All grains have one radius R: the n-th comes in the first window that ends n m / rate after the start. The feed point lies at the seam.
#[test]
fn a_feed_at_the_seam_of_a_strip_counts_its_rate_times_its_time() {
    let (every, start, fed) = (80.0, 50.0, 4_u32);
    let mut config = followed(true);
    config["law"]["bonds_min"] = json!(2);
    config["injection"] = json!({
        "x_m": 0.5 * LENGTH, "y_m": 2.6 * R, "rate_kg_per_s": mass(R) / (every * STEP),
        "start_s": start * STEP, "end_s": (start + every * (f64::from(fed) + 0.5)) * STEP,
    });
    let mut pressed = sheared(&config);
    let free = pressed.dem.bodies().free;
    for window in 0..500 {
        let report = pressed.step(LOAD);
        let due = |window: f64| {
            ((window - start) / every)
                .clamp(0.0, f64::from(fed))
                .floor()
        };
        let came = report.signal("q_external_kg") / mass(R);
        let [late, soon] = [due(f64::from(window)), due(f64::from(window) + 1.0)];
        assert!(
            came > late - 1e-9 && came < soon + 1e-9,
            "{came} in window {window}"
        );
        assert_eq!(
            report.signal("q_injected_total_kg"),
            report.signal("q_external_kg")
        );
        assert_eq!(report.signal("q_entered_kg"), 0.0);
    }
    // The strip closes at the point: fed grains lie on either side of the seam, over the depth of the layer.
    let centres = &pressed.dem.state().centres[free - fed as usize - 1..free - 1];
    for [x, y] in centres {
        let off = x.rem_euclid(LENGTH) - 0.5 * LENGTH;
        assert!(
            off.abs() < 20.0 * R && *y > 0.0 && *y < 12.0 * R,
            "{x:e} {y:e}"
        );
    }
    close(
        "balance",
        pressed.result("flow_balance_rel").expect("it is reported"),
        0.0,
        1e-15,
    );
}

/// A feed starts in a gap between base and lid: a place that touches images of disks across the seam is no gap, and neither is the space
/// above the lid.
#[test]
fn a_grain_at_the_seam_starts_clear_of_all_images() {
    for height in [2.6 * R, 8.6 * R] {
        let mut config = followed(true);
        config["law"]["bonds_min"] = json!(2);
        config["injection"] = json!({
            "x_m": 0.5 * LENGTH, "y_m": height, "rate_kg_per_s": 1.5 * mass(R) / STEP, "start_s": 0.0,
            "end_s": STEP, "growth_s": 1.0,
        });
        let mut pressed = Pressed::new(&config, 0.01, 0.0);
        pressed.step(0.0);
        pressed.step(0.0);
        let (bodies, state) = (pressed.dem.bodies(), pressed.dem.state());
        // One and a half are due: the last one stays in store.
        let fed = bodies.free - 2;
        assert!(!state.waits(bodies, fed) && state.waits(bodies, fed + 1));
        let [x, y] = state.centres[fed];
        assert!(y > 0.0 && y < 5.0 * 3f64.sqrt() * R, "{y:e}");
        let others = (0..bodies.disks()).filter(|other| *other < fed || *other > fed + 1);
        for centre in others.map(|other| state.centres[other]) {
            for turn in [-LENGTH, 0.0, LENGTH] {
                let distance = (centre[0] + turn - x).hypot(centre[1] - y);
                let gap = distance - R - state.radius(bodies, fed);
                assert!(gap > -0.01 * R, "{centre:?}: {gap:e}");
            }
        }
    }
}

#[test]
fn a_resumed_lid_has_the_flows_of_an_unbroken_one() {
    let config = followed(true);
    let mut whole = sheared(&config);
    (0..250).for_each(|_| drop(whole.step(LOAD)));
    let checkpoint = whole.dem.checkpoint().expect("it can be packed");
    let mut resumed = sheared(&config);
    resumed
        .dem
        .restore(&checkpoint)
        .expect("it is of these grains");
    resumed.windows = whole.windows;
    resumed.sinking = whole.sinking;
    resumed.moved = whole.moved;
    for pressed in [&mut whole, &mut resumed] {
        (0..250).for_each(|_| drop(pressed.step(LOAD)));
    }
    let [whole, resumed] =
        [whole, resumed].map(|mut pressed| pressed.dem.finish().expect("it ends"));
    assert_eq!(whole.state_hash, resumed.state_hash);
    assert_eq!(whole.results, resumed.results);
    assert!(whole.results["q_source_kg"] > 0.0);
}

/// Columns of unbonded disks between base and lid, at rest under p: each contact carries p 2R t, and overlaps by this force over its
/// stiffness.
fn columns(pressure: f64, stress: Value) -> Pressed {
    let sunk = pressure * 2.0 * R / STIFFNESS;
    let disk = |i: usize| {
        let (row, column) = (i / ROW, (i % ROW) as f64);
        let glued = row == 0 || row == 7;
        json!({
            "x_m": R * (2.0 * column + 1.0) - 0.5 * LENGTH, "y_m": (2.0 * R - sunk) * row as f64, "radius_m": R,
            "glued": glued, "lid": row == 7,
        })
    };
    let sample = json!({
        "kind": "disks", "disks": (0..8 * ROW).map(disk).collect::<Vec<_>>(),
        "periodic_x_m": [-0.5 * LENGTH, 0.5 * LENGTH],
    });
    let law = json!({"kind": "signorini", "contact_stiffness_pa": STIFFNESS});
    let mut config = scene(law, STEP, sample, json!({"stress": stress}));
    config["time"] = json!({"pressure_pa": 1e6});
    Pressed::new(&config, 0.01, 0.0)
}

/// Any region inside a lattice in balance has the pressure of its lid, and no lateral stress, because it is not confined. The six rows of
/// grains are higher by s from edge to edge than from contact to contact, 6 (2R - s) with overlaps s.
#[test]
fn the_stress_of_a_strip_is_the_pressure_on_its_lid() {
    let pressure = 1e6;
    let sunk = pressure * 2.0 * R / STIFFNESS;
    let between = 6.0 * (2.0 * R - sunk);
    let whole = pressure * between / (between + sunk);
    for (y, of_region) in [(json!(null), whole), (json!([3.0 * R, 10.4 * R]), pressure)] {
        let mut stress = json!({"cell_m": 7.2 * R});
        if !y.is_null() {
            stress["y_m"] = y;
        }
        let mut pressed = columns(pressure, stress);
        for _ in 0..20 {
            pressed.step(pressure * LENGTH * THICKNESS);
        }
        close(
            "lid",
            pressed.forces[1][1],
            pressure * LENGTH * THICKNESS,
            1e-9 * LOAD,
        );
        for (name, expected) in [
            ("stress_yy_pa", of_region),
            ("stress_xx_pa", 0.0),
            ("stress_xy_pa", 0.0),
        ] {
            let found = pressed.result(name).expect("it is reported");
            close(name, found, expected, 1e-9 * pressure);
        }
        let mean = pressed
            .result("dem_p_max_mean_pa")
            .expect("there are cells");
        close("a cell", mean, 0.5 * pressure, 1e-9 * pressure);
    }
}

/// The load doubles after 20 windows. At their end the stress belongs to one load; without a moment it belongs to the end of the run.
#[test]
fn the_stress_belongs_to_its_moment_and_is_absent_before() {
    let pressure = 1e6;
    let load = pressure * LENGTH * THICKNESS;
    let stress = |at: Value| json!({"cell_m": 7.2 * R, "y_m": [3.0 * R, 10.4 * R], "at_s": at});
    let mut held = columns(pressure, stress(json!(20.0 * STEP)));
    let mut last = columns(pressure, json!({"cell_m": 7.2 * R}));
    assert_eq!(held.dem.describe().moments["stress.at_s"], 20.0 * STEP);
    for window in 0..60 {
        let there = held.result("stress_yy_pa").is_some();
        assert_eq!(there, window >= 20, "after {window} windows");
        let load = if window < 20 { load } else { 2.0 * load };
        held.step(load);
        last.step(load);
    }
    close(
        "held",
        held.result("stress_yy_pa").expect("it is there"),
        pressure,
        1e-9 * pressure,
    );
    let end = last.result("stress_yy_pa").expect("it is there");
    assert!(end > 1.1 * pressure, "{end:e}");
    // The checkpoint holds the stress of the moment.
    let checkpoint = held.dem.checkpoint().expect("it can be packed");
    let mut resumed = columns(pressure, stress(json!(20.0 * STEP)));
    resumed
        .dem
        .restore(&checkpoint)
        .expect("it is of these grains");
    assert_eq!(resumed.result("stress_yy_pa"), held.result("stress_yy_pa"));
}

/// At rest the moments of all grains add up to the moments of the forces on base and lid at their contacts. The stress of a random layer is
/// therefore p (Y - y) / H with the mean heights Y and y of these contacts, weighted by their vertical forces.
#[test]
fn the_stress_of_a_random_layer_follows_from_the_forces_on_its_rows() {
    let (half, thickness) = (2e-3, 0.5e-3);
    let config = json!({
        "law": {"kind": "coulomb", "friction": 0.3, "damping": 0.5, "contact_stiffness_pa": 2.255e11,
                "tangential_stiffness_ratio": 0.5},
        "solver": {"kind": "nsgs", "tolerance": 1e-7, "max_iterations": 20_000, "min_iterations": 2},
        "time": {"pressure_pa": 1e9}, "density_kg_per_m3": DENSITY, "mass_scale": 1000.0,
        "sample": {
            "kind": "layer", "thickness_m": thickness, "half_width_m": half, "crown_radius_m": 0.0,
            "radius_min_m": 0.05e-3, "radius_max_m": 0.1e-3, "law": "surface_uniform", "lid": true,
            "periodic_x_m": [-half, half],
        },
        "stress": {"cell_m": 0.6e-3, "y_m": [-0.2e-3, 0.7e-3]},
    });
    let pressure = 3e8;
    let load = pressure * 2.0 * half * THICKNESS;
    let mut pressed = Pressed::new(&config, 0.01, 0.0);
    for window in 0..1200 {
        pressed.step(load * (f64::from(window) / 300.0).min(1.0));
    }
    let [base, lid] = pressed.forces;
    close("lid", lid[1], load, 1e-4 * load);
    close("base", base[1], -load, 1e-4 * load);
    let (bodies, state) = (pressed.dem.bodies(), pressed.dem.state());
    let positions = state.positions(bodies);
    let mut moment = 0.0;
    for slot in state
        .list
        .slots
        .iter()
        .filter(|slot| slot.b as usize >= bodies.free)
    {
        let (a, b) = (slot.a as usize, slot.b as usize);
        let at = positions.proximity(a, b);
        let [n, t] = slot.force;
        let force = n * at.normal[1] + t * at.normal[0];
        // The contact point lies in the middle of the overlap.
        let height = state.centres[a][1] - (bodies.radii[a] + 0.5 * at.gap) * at.normal[1];
        moment -= force * height;
    }
    let volume = 2.0 * half * 0.9e-3 * THICKNESS;
    let found = pressed.result("stress_yy_pa").expect("it is reported");
    close("stress", found, moment / volume, 1e-4 * pressure);
    // The contacts lie within a largest radius of the lines along which the layer was cut.
    let height = found * 0.9e-3 / pressure;
    assert!((height - thickness).abs() < 2.0 * 0.1e-3, "{height:e}");
}

#[test]
fn keys_without_meaning_below_a_lid_are_refused() {
    let refused = |change: &dyn Fn(&mut Value), parts: &[&str]| {
        let mut config = followed(true);
        change(&mut config);
        let message = refusal(&config);
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?}");
        }
    };
    for (key, value) in [
        ("zone_share", 0.9),
        ("margin_diameters", 2.0),
        ("hysteresis_diameters", 0.5),
        ("zone_mean_s", 1e-4),
    ] {
        let name = format!("flow.{key}");
        refused(
            &|config| config["flow"][key] = json!(value),
            &[&name, "whole lid or strip"],
        );
    }
    refused(
        &|config| config["stress"] = json!({"cell_m": 1e-3, "at_s": 0.0}),
        &["stress.at_s", "above 0"],
    );
    let bare = |config: &mut Value| {
        let sample = config["sample"].as_object_mut().expect("a table");
        sample.remove("periodic_x_m");
        let disks = sample["disks"].as_array_mut().expect("a list");
        disks.retain(|disk| disk["lid"] == json!(false));
    };
    refused(&bare, &["flow", "wheel", "lid", "periodic_x_m"]);
}
