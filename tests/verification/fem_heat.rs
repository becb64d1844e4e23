//! Heat of a body.
//!
//! ```text
//!      q ->            a band of heat that moves over a half-space, a flux into one,
//!   ========---        a slab between two temperatures, a wheel that slides over a rail
//!   _________________
//! ```
//!
//! Exact, with b = sqrt(k rho c) and kappa = k/(rho c): 2 q sqrt(t/pi)/b under a flux; decay by kappa (pi/L)^2 in a slab; C q sqrt(a/(pi V))/b for a
//! fast band of the half-width a, C = 2 sqrt(2) if uniform, 2.188 with the flux of a semi-ellipse, 4 sqrt(6)/5 of a parabola; for a slow one
//! q/(pi k) int exp(-V (x - s)/(2 kappa)) K0(V |x - s|/(2 kappa)) ds.
//! Source: H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids, 1959, sections 2.9, 3.4 and 10.7.

use std::f64::consts::PI;

use fem_kernel::heat::{EdgeCondition, HeatBody, HeatField, HeatNumbers};
use fem_kernel::mesh::{Edge, Mesh};
use fem_node::{FemConfig, StaticNode};
use kit::read_config;
use protocol::Node;
use serde_json::{Value, json};

use crate::fem_bodies::{node, reported, setting, strip as strip_of, window, with};

/// Steel: k (W/(m K)), rho c (J/(m3 K)), and the thickness (m).
const K: f64 = 45.0;
const RHO_C: f64 = 7800.0 * 460.0;
const T: f64 = 1e-3;

fn numbers(finest: f64) -> HeatNumbers {
    HeatNumbers {
        conductivity: K,
        capacity: RHO_C,
        thickness: T,
        finest,
    }
}

/// A strip of elements of this size, its upper left corner at the origin.
fn strip([columns, rows]: [usize; 2], [dx, dy]: [f64; 2]) -> Mesh {
    Mesh::structured(columns, rows, |i, j| [dx * i as f64, -dy * j as f64])
}

fn march(body: &HeatBody, field: &mut HeatField, steps: u32, step: f64) {
    for _ in 0..steps {
        body.advance(field, step);
    }
}

/// Error of the rise under a flux for 1 ms, over the rise: in `steps` steps, with an uppermost layer of this thickness (m).
fn error_under_a_flux(steps: u32, finest: f64) -> f64 {
    let mesh = strip([2, 8], [1e-4, 2e-4]);
    let flux = [(Edge::Top, EdgeCondition::Flux(1e8))];
    let body = HeatBody::new(&mesh, numbers(finest), &flux);
    let mut field = body.at_start();
    march(&body, &mut field, steps, 1e-3 / f64::from(steps));
    let exact = 2e8 * (1e-3 / PI).sqrt() / (K * RHO_C).sqrt();
    body.rise(&field, [1, 0]) / exact - 1.0
}

#[test]
fn the_surface_of_a_half_space_warms_with_the_root_of_time() {
    let errors = [10, 100, 1000].map(|steps| error_under_a_flux(steps, 3e-6));
    assert!(errors[2].abs() < 2.5e-3, "{errors:?}");
    assert!(errors[0].abs() < 0.03, "{errors:?}");
    // Without layers within the row of elements, whose 0.2 mm heat has hardly crossed.
    let coarse = error_under_a_flux(1000, 2e-4);
    assert!(coarse < -0.1, "{coarse}");
}

/// The heat below an edge held 10 K above the rest, 2 b dT sqrt(t/pi) of its area, its own vertices included.
#[test]
fn a_held_edge_gives_the_heat_that_the_body_has() {
    for edge in [Edge::Top, Edge::Bottom, Edge::Left] {
        let (across, size) = (2, [5e-6, 5e-6]);
        let counts = if edge == Edge::Left {
            [200, across]
        } else {
            [across, 200]
        };
        let held = [(edge, EdgeCondition::Held(10.0))];
        let body = HeatBody::new(&strip(counts, size), numbers(5e-6), &held);
        let mut field = body.at_start();
        assert!((body.stored(&field) + field.conducted[0]).abs() < 1e-18);
        march(&body, &mut field, 2000, 5e-7);
        let exact = 20.0 * (K * RHO_C * 1e-3 / PI).sqrt() * 2.0 * 5e-6 * T;
        let stored = body.stored(&field);
        assert!(
            (stored / exact - 1.0).abs() < 0.01,
            "{edge:?}: {stored} of {exact}"
        );
        assert!((stored + field.conducted[0]).abs() < 1e-12 * exact);
    }
}

/// A run that ends between two steps of heat has the heat up to its end.
#[test]
fn the_last_steps_count() {
    let keys = json!({"boundary": {}, "time": {"step_s": 1e-8},
        "heat": {"conductivity_w_per_m_k": K, "capacity_j_per_kg_k": 460.0, "start_k": 300.0, "every_steps": 100,
                 "edges": {"top": {"flux_w_per_m2": 1e8}}}});
    let mut body = node(&with(strip_of(1e-3, 1e-3, 5e-4), keys));
    body.advance_alone(&window(0, 50)).expect("it is stable");
    body.advance_alone(&window(1, 130)).expect("it is stable");
    let of = results(&mut body);
    let given = 1e8 * 1e-6 * 1.8e-6;
    assert!((of("heat_through_top_j") + given).abs() < 1e-12 * given);
    assert!((of("heat_stored_j") - given).abs() < 1e-9 * given);
}

/// A body turned over has the temperatures of the body, at its lower edge.
#[test]
fn layers_lie_at_the_lower_edge_as_well() {
    let mesh = Mesh::structured(3, 8, |i, j| [1e-4 * i as f64, -3e-5 * (j * j) as f64]);
    let conditions = [
        (Edge::Top, EdgeCondition::Flux(1e8)),
        (Edge::Bottom, EdgeCondition::Held(5.0)),
        (Edge::Left, EdgeCondition::Film([1e4, 20.0])),
    ];
    let turned = conditions.map(|(edge, of)| (edge.turned_over(), of));
    let bodies = [
        HeatBody::new(&mesh, numbers(3e-6), &conditions),
        HeatBody::above_bottom(&mesh.turned_over(), numbers(3e-6), &turned),
    ];
    let found = [0, 1].map(|k| {
        let (body, mut field) = (&bodies[k], bodies[k].at_start());
        field.inner = vec![0.0; 8 * 4];
        field.inner[4 * if k == 0 { 2 } else { 5 } + 1] = 1e-6;
        march(body, &mut field, 50, 1e-6);
        let row = |row: usize, count: usize| if k == 0 { row } else { count - 1 - row };
        let nodes = (0..9).map(|j| body.rise(&field, [1, row(j, 9)]));
        let means = (0..8).map(|j| body.mean_rise(&field, [1, row(j, 8)]));
        (nodes.chain(means).collect::<Vec<f64>>(), field.conducted)
    });
    assert!(found[0].0[0] > 10.0);
    assert_eq!(found[0], found[1]);
}

/// Rate of decay of a slab of this many elements between two held edges, over kappa (pi/L)^2, less 1.
fn error_of_decay(count: usize, edges: [Edge; 2]) -> f64 {
    let (long, size) = (1e-3, 1e-3 / count as f64);
    let along_x = edges[0] == Edge::Left;
    let counts = if along_x { [count, 2] } else { [2, count] };
    let body = HeatBody::new(
        &strip(counts, [size; 2]),
        numbers(long),
        &edges.map(|edge| (edge, EdgeCondition::Held(10.0))),
    );
    let rate = K / RHO_C * (PI / long).powi(2);
    let step = 5e-5 / rate;
    let mut field = body.at_start();
    let middle = if along_x {
        [count / 2, 1]
    } else {
        [1, count / 2]
    };
    // After 2/rate the third mode is gone.
    march(&body, &mut field, 40_000, step);
    let before = 10.0 - body.rise(&field, middle);
    march(&body, &mut field, 10_000, step);
    let after = 10.0 - body.rise(&field, middle);
    (before / after).ln() / 0.5 - 1.0
}

#[test]
fn a_slab_decays_by_its_first_mode_with_the_second_order_of_the_mesh() {
    for edges in [[Edge::Left, Edge::Right], [Edge::Bottom, Edge::Top]] {
        let errors = [8, 16, 32].map(|count| error_of_decay(count, edges).abs());
        assert!(errors[2] < 1e-3, "{edges:?}: {errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.1, "{edges:?}: {errors:?}");
        }
    }
}

/// Highest rise under a band of this flux (W/m2 over x/a) and half-width a (m) that moves at V (m/s) for 20 a, in elements of a/20.
fn under_a_band(flux: impl Fn(f64) -> f64, a: f64, speed: f64) -> f64 {
    // A twentieth of the depth to which a point warms below the band, or of the band.
    let finest = 0.05 * (K / RHO_C * 2.0 * a / speed).sqrt().min(a);
    let dx = a / 20.0;
    let mesh = strip([800, 8], [dx, a]);
    let body = HeatBody::new(&mesh, numbers(finest), &[]);
    let mut field = body.at_start();
    let step = 0.25 * dx / speed;
    for k in 0..1600 {
        let centre = 8.0 * a + (f64::from(k) + 0.5) * 0.25 * dx;
        for (i, joules) in field.upper.iter_mut().enumerate() {
            // The mean over the element around a node.
            let parts = (0..8).map(|part| {
                let x = dx * (i as f64 - 0.5 + (f64::from(part) + 0.5) / 8.0);
                let at = (x - centre) / a;
                if at.abs() < 1.0 { flux(at) } else { 0.0 }
            });
            *joules += parts.sum::<f64>() / 8.0 * dx * T * step;
        }
        body.advance(&mut field, step);
    }
    field.peak[0]
}

#[test]
fn a_fast_band_is_hottest_where_jaeger_says() {
    let (a, speed, q) = (1e-3, 20.0, 1e9);
    let unit = q * (a / (PI * speed)).sqrt() / (K * RHO_C).sqrt();
    let uniform = under_a_band(|_| q, a, speed) / unit;
    let ellipse = under_a_band(|x| q * (1.0 - x * x).sqrt(), a, speed) / unit;
    let parabola = under_a_band(|x| q * (1.0 - x * x), a, speed) / unit;
    let found = [uniform, ellipse, parabola];
    let exact = [2.0 * 2.0_f64.sqrt(), 2.188, 0.8 * 6.0_f64.sqrt()];
    for (found, exact) in found.iter().zip(exact) {
        assert!((found / exact - 1.0).abs() < 0.02, "{found} for {exact}");
    }
}

/// K0(z) as the integral of exp(-z cosh u) over u > 0.
fn bessel_k0(z: f64) -> f64 {
    let du = 1e-3;
    let terms = (0..12_000).map(|n| (-z * ((f64::from(n) + 0.5) * du).cosh()).exp());
    terms.sum::<f64>() * du
}

#[test]
fn a_slow_band_has_the_steady_temperature_of_jaeger() {
    let (a, q) = (1e-3, 1e7);
    let speed = 2.0 * K / RHO_C / a;
    let found = under_a_band(|_| q, a, speed);
    // V a/(2 kappa) = 1; lengths over a.
    let at = |x: f64| {
        let ds = 2.0 / 400.0;
        let parts = (0..400).map(|n| {
            let apart = x + 1.0 - (f64::from(n) + 0.5) * ds;
            (-apart).exp() * bessel_k0(apart.abs())
        });
        q * a / (PI * K) * parts.sum::<f64>() * ds
    };
    let exact = (0..20)
        .map(|n| at(-1.0 + 0.05 * f64::from(n)))
        .fold(0.0, f64::max);
    assert!((found / exact - 1.0).abs() < 0.02, "{found} for {exact}");
}

/// All kinds of conditions on a crowned body that is heated from above and within.
#[test]
fn heat_is_conserved_and_no_temperature_leaves_its_range() {
    let crowned = Mesh::structured(12, 6, |i, j| {
        let x = i as f64 - 6.0;
        [
            1e-4 * x,
            -1e-4 * (j as f64 + 0.02 * x * x * (1.0 - j as f64 / 6.0)),
        ]
    });
    let conditions = [
        (Edge::Bottom, EdgeCondition::Held(-5.0)),
        (Edge::Left, EdgeCondition::Film([1e4, 20.0])),
        (Edge::Right, EdgeCondition::Held(15.0)),
        (Edge::Top, EdgeCondition::Flux(1e5)),
    ];
    let body = HeatBody::new(&crowned, numbers(2e-6), &conditions);
    let mut field = body.at_start();
    let mut given = 0.0;
    for k in 0..50 {
        field.upper.iter_mut().for_each(|heat| *heat += 1e-6);
        field.inner = vec![1e-7; 6 * 16];
        given += 13.0 * 1e-6 + 72.0 * 1e-7;
        body.advance(&mut field, 1e-5 * f64::from(1 + k % 3));
        let kept = body.stored(&field) + field.conducted.iter().sum::<f64>();
        assert!((kept - given).abs() < 1e-12 * given, "{kept} of {given}");
    }
    let body = HeatBody::new(&crowned, numbers(2e-6), &conditions[..3]);
    let mut field = body.at_start();
    for _ in 0..200 {
        body.advance(&mut field, 1e-3);
        let inside = |rise: &f64| (-5.0..=20.0).contains(rise);
        assert!(field.rises.iter().all(inside), "{:?}", field.rises);
    }
}

/// A rail under a round wheel that slides half of its way.
fn rail() -> Value {
    json!({
        "element": "q4_2x2",
        "mesh": {"width_m": 40e-3, "height_m": 20e-3, "size_m": 4e-4, "fine_width_m": 24e-3, "fine_depth_m": 8e-4,
                 "side_columns": 6, "depth_rows": 10},
        "material": {"young_pa": 205e9, "poisson": 0.3, "density_kg_per_m3": 7800.0},
        "time": {"step_s": "auto", "damping": 0.7},
        "wheel": {"load_n": 3000.0, "mass_kg": 0.02, "radius_m": 0.46, "ramp_s": 0.0, "hold_s": 0.0,
                  "rolling": {"speed_m_per_s": 20.0, "creepage": 0.5, "distance_m": 12e-3, "start_m": -6e-3}},
        "contact": {"friction": 0.05},
        "heat": {"conductivity_w_per_m_k": K, "capacity_j_per_kg_k": 460.0, "start_k": 300.0},
    })
}

fn in_equilibrium(more: Value) -> StaticNode {
    let config = with(with(rail(), json!({"analysis": "static"})), more);
    let config: FemConfig = read_config(&config).expect("the keys are valid");
    StaticNode::new(&config, &setting(1)).expect("the body is valid")
}

fn results(node: &mut dyn Node) -> impl Fn(&str) -> f64 + use<> {
    let results = node.finish().expect("it ends").results;
    move |name: &str| *results.get(name).unwrap_or_else(|| panic!("no {name}"))
}

/// The semi-ellipse of Hertz slides: q = mu p0 zeta V, in increments of a sixtieth of the half-width.
#[test]
fn a_wheel_that_slides_over_a_rail_has_the_flash_temperature_of_jaeger() {
    let fine = json!({"statics": {"rolling_increment_m": 5e-5}, "mesh": {"size_m": 2e-4}});
    let mut node = in_equilibrium(fine);
    let end = node.describe().end_s.expect("it ends") as u32;
    node.advance_alone(&window(0, end)).expect("it converges");
    let of = results(&mut node);
    let modulus = 205e9 / (1.0 - 0.09);
    let a = (4.0 * 3000.0 / T * 0.46 / (PI * modulus)).sqrt();
    let q = 0.05 * modulus * a / (2.0 * 0.46) * 0.5 * 20.0;
    let exact = 2.188 * q * (a / (PI * 20.0)).sqrt() / (K * RHO_C).sqrt();
    let found = of("surface_temperature_peak_k") - 300.0;
    assert!((found / exact - 1.0).abs() < 0.02, "{found} for {exact}");
    assert!(of("heat_balance_rel") < 1e-12);
    assert!(of("surface_temperature_peak_x_m") > 0.0);
}

/// In motion and in equilibrium the heat is the friction of the ledger, and the wheel takes its share.
#[test]
fn the_slip_under_a_wheel_becomes_heat_of_both() {
    let keys = json!({"heat": {"wheel_share": 0.25, "sources": {"friction": 0.8},
                               "edges": {"bottom": {"held_k": 300.0}}}});
    // It expands all it can, so that the work of its thermal stresses shows in the balance.
    let expands = json!({"start": "static", "heat": {"alpha_per_k": 1e-4, "every_steps": 7}});
    let mut moving = node(&with(rail(), with(keys.clone(), expands)));
    let report = moving
        .advance_alone(&window(0, 3000))
        .expect("it is stable");
    let lost = reported(&moving, &report, "friction");
    assert!(crate::fem_wheel::balance(&moving, &report) < 1e-11);
    let mut still = in_equilibrium(with(keys, json!({"statics": {"increment_n": 300.0}})));
    still.advance_alone(&window(0, 40)).expect("it converges");
    let (moving, still) = (results(&mut moving), results(&mut still));
    assert!(lost > 0.0);
    assert!((moving("heat_friction_j") - 0.8 * lost).abs() < 1e-12 * lost);
    for of in [&moving as &dyn Fn(&str) -> f64, &still] {
        let (heat, kept) = (of("heat_friction_j"), of("heat_stored_j"));
        assert!(heat > 0.0);
        assert!((of("heat_to_own_wheel_j") - 0.25 * heat).abs() < 1e-12 * heat);
        let away = of("heat_through_bottom_j");
        assert!(
            kept + away <= 0.75 * heat * (1.0 + 1e-12),
            "{kept} of {heat}"
        );
        assert!(of("heat_balance_rel") < 1e-12);
    }
}

/// A block that yields under tension: 0.9 of the plastic work.
#[test]
fn plastic_flow_warms_the_body() {
    let keys = json!({
        "element": "q4_bbar", "material": {"yield_pa": 1e8},
        "boundary": {"top": {"displacement_m": ["free", 5e-6], "ramp_s": 1e-5}},
        "heat": {"conductivity_w_per_m_k": K, "capacity_j_per_kg_k": 460.0, "start_k": 300.0, "every_steps": 7},
    });
    let mut body = node(&with(strip_of(1e-3, 1e-3, 5e-4), keys));
    let mut lost = 0.0;
    for index in 0..20 {
        let report = body
            .advance_alone(&window(index, 10))
            .expect("it is stable");
        lost = reported(&body, &report, "plastic");
    }
    let of = results(&mut body);
    assert!(lost > 0.0);
    assert!((of("heat_plastic_j") - 0.9 * lost).abs() < 1e-12 * lost);
    assert!(of("heat_balance_rel") < 1e-12);
    assert!(of("surface_temperature_peak_k") > 300.0);
}

/// k and rho c grow alike, kappa stays: the Kirchhoff transform int f dT, f = 1 + dT/200, is the linear field under the same flux.
#[test]
fn a_half_space_whose_properties_grow_has_the_transform_of_the_linear_one() {
    let mesh = strip([2, 8], [1e-4, 2e-4]);
    let flux = [(Edge::Top, EdgeCondition::Flux(1e8))];
    let table = vec![[300.0, 1.0], [700.0, 3.0]];
    let body = HeatBody::new(&mesh, numbers(3e-6), &flux).over_temperature(300.0, [&table[..]; 2]);
    let mut field = body.at_start();
    march(&body, &mut field, 1000, 1e-6);
    let transform = 2e8 * (1e-3 / PI).sqrt() / (K * RHO_C).sqrt();
    let exact = 200.0 * ((1.0 + transform / 100.0).sqrt() - 1.0);
    let found = body.rise(&field, [1, 0]);
    assert!((found / exact - 1.0).abs() < 3e-3, "{found} for {exact}");
    let given = 1e8 * 1e-3 * 2e-4 * T;
    assert!((body.stored(&field) - given).abs() < 1e-12 * given);
    assert!((field.conducted[0] + given).abs() < 1e-12 * given);
    // All heat at once, without a flux: the temperature of the heat.
    let body = HeatBody::new(&mesh, numbers(2e-4), &[]).over_temperature(300.0, [&[], &table]);
    let mut field = body.at_start();
    field.inner = vec![RHO_C * 1e-4 * 2e-4 * T * 125.0; 8 * 2];
    march(&body, &mut field, 1, 1e-3);
    let exact = 200.0 * (2.25_f64.sqrt() - 1.0);
    let found = body.rise(&field, [1, 3]);
    assert!((found - exact).abs() < 1e-9, "{found} for {exact}");
}

/// Between two held edges k = k0 (1 + dT/100): the transform is linear, dT (1 + dT/200) = 22 K at 20 K, and falls evenly. Heat through the edges is conserved.
#[test]
fn a_slab_whose_conductivity_grows_is_steady_with_the_transform() {
    let held = [
        (Edge::Top, EdgeCondition::Held(20.0)),
        (Edge::Bottom, EdgeCondition::Held(0.0)),
    ];
    let tables = [vec![[300.0, 1.0], [500.0, 3.0]], Vec::new()];
    let body = HeatBody::new(&strip([2, 16], [1e-4, 1e-4]), numbers(1e-4), &held)
        .over_temperature(300.0, [&tables[0], &tables[1]]);
    let mut field = body.at_start();
    march(&body, &mut field, 8000, 1e-4);
    for row in 0..=16 {
        let transform = 22.0 * (1.0 - f64::from(row) / 16.0);
        let exact = 100.0 * ((1.0 + transform / 50.0).sqrt() - 1.0);
        let found = body.rise(&field, [1, row as usize]);
        assert!((found - exact).abs() < 1e-9, "{row}: {found} for {exact}");
    }
    let all: f64 = field.conducted.iter().sum();
    assert!((body.stored(&field) + all).abs() < 1e-9 * all.abs());
}

/// A wheel of half of the body's b touches it: warmer by 90 K without a source, the common surface is 30 K above the body (b1 T1 + b2 T2)/(b1 + b2);
/// as warm, with a source between the two, it takes a third of the heat.
#[test]
fn a_body_and_a_wheel_meet_at_the_temperature_of_their_effusivities() {
    let mesh = strip([2, 10], [1e-4, 2e-4]);
    let b = (K * RHO_C).sqrt();
    for (rise, source) in [(90.0, 0.0), (0.0, 1e8)] {
        let body =
            HeatBody::new(&mesh, numbers(1e-6), &[]).under_wheel((&mesh, T), [0.5 * b, rise]);
        let mut field = body.at_start();
        body.meet(&mut field, [true, false, true].into_iter());
        body.meet(&mut field, [true; 3].into_iter());
        let areas = [0.5e-4, 1e-4, 0.5e-4].map(|length| length * T);
        for _ in 0..2000 {
            for (heat, area) in field.upper.iter_mut().zip(areas) {
                *heat += source * area * 5e-7;
            }
            body.advance(&mut field, 5e-7);
        }
        let given = source * 2e-4 * T * 1e-3;
        let into_wheel = field.conducted[0];
        let left = body.stored(&field) + into_wheel - given;
        assert!(left.abs() < 1e-12 * into_wheel.abs(), "{left}");
        if source == 0.0 {
            let surface = body.rise(&field, [1, 0]);
            assert!((surface / 30.0 - 1.0).abs() < 0.01, "{surface}");
        } else {
            let share = into_wheel / given;
            assert!((3.0 * share - 1.0).abs() < 0.01, "{share}");
        }
        // They part, and the wheel gets no more.
        body.meet(&mut field, [false; 3].into_iter());
        body.advance(&mut field, 5e-7);
        assert_eq!(field.conducted[0], into_wheel);
    }
}

fn half_space(effusivity: f64) -> Value {
    json!({"effusivity_w_s05_per_m2_k": effusivity, "start_k": 300.0})
}

/// A wheel of the rail's own material rolls over it with slip: each of its points gets what the rail's gets, as long as it stays in the contact.
#[test]
fn a_wheel_of_half_spaces_takes_its_share_of_the_slip() {
    for (of_b, share, creepage) in [(1.0, 0.5, 0.5), (3.0, 0.75, 0.05)] {
        let wheel = half_space(of_b * (K * RHO_C).sqrt());
        let keys = json!({"heat": {"wheel_half_space": wheel, "finest_m": 1e-6}, "wheel": {"rolling": {"creepage": creepage}}});
        let mut node = in_equilibrium(keys);
        let end = node.describe().end_s.expect("it ends") as u32;
        node.advance_alone(&window(0, end)).expect("it converges");
        let outcome = node.finish().expect("it ends");
        let of = |name: &str| outcome.results[name];
        let found = of("heat_to_own_wheel_j") / of("heat_friction_j");
        assert!((found / share - 1.0).abs() < 0.02, "{found} for {share}");
        assert!(of("heat_balance_rel") < 1e-12);
        let mut warnings = outcome.findings.iter();
        let left = warnings.find(|found| found.code == "wheel_points");
        assert_eq!(
            left.map(|found| found.value),
            (creepage > 0.1).then_some(creepage)
        );
    }
}

/// A block that yields under tension at 600 K, where its table has 0.75, has the bits of one with 0.75 of the yield stress.
#[test]
fn a_warm_block_yields_as_one_of_its_warm_yield_stress() {
    for element in ["q4_1point", "q4_2x2", "q4_bbar"] {
        let moved = |yield_pa: f64, heat: Value| {
            let keys = json!({
                "element": element, "material": {"yield_pa": yield_pa, "hardening_pa": 1e9},
                "boundary": {"top": {"displacement_m": ["free", 5e-6], "ramp_s": 1e-5}}, "heat": heat,
            });
            let mut body = node(&with(strip_of(1e-3, 1e-3, 1e-4), keys));
            let mut lost = 0.0;
            for index in 0..20 {
                let report = body
                    .advance_alone(&window(index, 10))
                    .expect("it is stable");
                lost = reported(&body, &report, "plastic");
            }
            (lost, body.state().u.to_vec())
        };
        let warm = json!({"conductivity_w_per_m_k": K, "capacity_j_per_kg_k": 1e30, "start_k": 600.0, "every_steps": 7,
                          "softening": {"yield_stress": [[500.0, 1.0], [700.0, 0.5]]}});
        let found = moved(1e8, warm);
        assert!(found.0 > 0.0);
        assert_eq!(found, moved(0.75e8, Value::Null));
    }
}

/// A strip held along x warms by 100 K: exx = 0 and syy = 0 give eyy = (1 + nu)/(1 - nu) alpha dT and sxx = szz = -E alpha dT/(1 - nu) in plane
/// strain, eyy = (1 + nu) alpha dT in plane stress. All energy is the work of the thermal stresses.
#[test]
fn a_strip_that_warms_expands_where_it_can() {
    for (element, plane, strain) in [
        ("q4_1point", "strain", 1.3 / 0.7),
        ("q4_2x2", "strain", 1.3 / 0.7),
        ("q4_bbar", "strain", 1.3 / 0.7),
        ("q4_2x2", "stress", 1.3),
    ] {
        let keys = json!({
            "element": element, "plane": plane, "time": {"mass_damping_per_s": 6e6, "damping": 0.6},
            "heat": {"conductivity_w_per_m_k": K, "capacity_j_per_kg_k": 0.01, "start_k": 300.0, "every_steps": 7,
                     "alpha_per_k": 1.2e-5, "edges": {"top": {"held_k": 400.0}}},
        });
        let mut body = node(&with(strip_of(1e-3, 1e-3, 2.5e-4), keys));
        let mut report = Vec::new();
        for index in 0..60 {
            report = body
                .advance_alone(&window(index, 11))
                .expect("it is stable");
            let balance = crate::fem_wheel::balance(&body, &report);
            assert!(balance < 1e-12, "{balance}");
        }
        assert!(reported(&body, &report, "applied_work") > 0.0);
        let moved = body.state().u.iter().fold(0.0, |a: f64, u| a.max(*u));
        let exact = strain * 1.2e-5 * 100.0 * 1e-3;
        assert!((moved / exact - 1.0).abs() < 1e-6, "{moved} for {exact}");
        if plane == "strain" {
            let pressure = results(&mut body)("p_max_centroid_pa");
            let exact = 2.0 / 3.0 * 102.5e9 * 1.2e-5 * 100.0 / 0.7;
            assert!(
                (pressure / exact - 1.0).abs() < 1e-6,
                "{element}: {pressure} for {exact}"
            );
        }
    }
}

/// Flow warms a block and lowers its yield stress, Y (1 - s dT): in uniaxial strain e, far beyond yielding, the flow is 2/3 de, and all its work
/// becomes heat, so that dT = (1 - exp(-2 Y s e/(3 rho c)))/s.
#[test]
fn flow_that_warms_softens_by_an_exponential() {
    let (stress, slope) = (1e8_f64, 1e-3);
    let keys = json!({
        "element": "q4_bbar", "material": {"yield_pa": stress, "young_pa": 1e13}, "time": {"step_s": 5e-9},
        "boundary": {"top": {"displacement_m": ["free", 5e-5], "ramp_s": 1e-5}},
        "heat": {"conductivity_w_per_m_k": 1e-3, "capacity_j_per_kg_k": 4.0, "start_k": 300.0, "every_steps": 1,
                 "sources": {"plastic": 1.0}, "softening": {"yield_stress": [[300.0, 1.0], [1200.0, 0.1]]}},
    });
    let mut body = node(&with(strip_of(1e-3, 1e-3, 5e-4), keys));
    for index in 0..20 {
        let window = window(index, 100);
        body.advance_alone(&window).expect("it is stable");
    }
    let of = results(&mut body);
    let exact = (1.0 - (-2.0 * stress * slope * 0.05 / (3.0 * 7800.0 * 4.0)).exp()) / slope;
    let found = of("surface_temperature_peak_k") - 300.0;
    assert!((found / exact - 1.0).abs() < 0.02, "{found} for {exact}");
}

#[test]
fn a_resume_between_two_steps_of_heat_changes_no_bit() {
    let wheel = half_space(1e4);
    let heat = json!({"every_steps": 7, "alpha_per_k": 1e-5, "wheel_half_space": wheel,
                      "capacity_factor": [[300.0, 1.0], [400.0, 2.0]], "softening": {"yield_stress": [[300.0, 1.0], [310.0, 0.5]]}});
    let config = with(
        rail(),
        json!({"wheel": {"ramp_s": 1e-6}, "heat": heat, "material": {"yield_pa": 3e7}}),
    );
    let (mut whole, mut cut) = (node(&config), node(&config));
    for node in [&mut whole, &mut cut] {
        node.advance_alone(&window(0, 25)).expect("it is stable");
    }
    let long = whole.advance_alone(&window(1, 35)).expect("it is stable");
    let state = cut.checkpoint().expect("it is a state");
    let mut resumed = node(&config);
    resumed.restore(&state).expect("of the same body");
    let parts = resumed.advance_alone(&window(1, 35)).expect("it is stable");
    assert_eq!(long, parts);
    let [whole, resumed] = [whole, resumed].map(|mut node| node.finish().expect("it ends"));
    assert_eq!(whole.state_hash, resumed.state_hash);
}

/// Warmth acts in each step of heat, however long the windows are; only accelerations are computed anew at the start of a window.
#[test]
fn expansion_hardly_depends_on_the_window() {
    let keys = json!({"heat": {"conductivity_w_per_m_k": K, "capacity_j_per_kg_k": 460.0, "start_k": 300.0, "every_steps": 7,
                               "alpha_per_k": 1.2e-5, "edges": {"top": {"held_k": 400.0}}}});
    let moved = |count: u32| {
        let mut body = node(&with(strip_of(1e-3, 1e-3, 2.5e-4), keys.clone()));
        for index in 0..660 / count {
            body.advance_alone(&window(u64::from(index), count))
                .expect("it is stable");
        }
        body.state().u.iter().fold(0.0, |a: f64, u| a.max(*u))
    };
    let [short, long] = [moved(11), moved(660)];
    assert!((long / short - 1.0).abs() < 0.01, "{long} for {short}");
}

/// The elements are 0.25 mm, and heat enters by 0.035 mm: 22 % off beside a film on the lower edge.
#[test]
fn heat_that_the_mesh_or_its_steps_do_not_resolve_is_warned_of() {
    for (more, code) in [
        (
            json!({"edges": {"bottom": {"film_w_per_m2_k": 1e9, "ambient_k": 400.0}}}),
            Some("thermal_depth"),
        ),
        (
            json!({"edges": {"bottom": {"flux_w_per_m2": 1e8}}}),
            Some("thermal_depth"),
        ),
        (
            json!({"edges": {"top": {"flux_w_per_m2": -1e8}}, "finest_m": 2.5e-4}),
            Some("thermal_depth"),
        ),
        (
            json!({"edges": {"top": {"flux_w_per_m2": -5e8}}}),
            Some("below_zero"),
        ),
        (json!({"edges": {"top": {"flux_w_per_m2": 1e8}}}), None),
        (
            json!({"edges": {"top": {"film_w_per_m2_k": 1e7, "ambient_k": 400.0}}, "capacity_factor": [[340.0, 1.0], [340.1, 0.01]]}),
            Some("heat_steps"),
        ),
        (
            json!({"edges": {"top": {"film_w_per_m2_k": 1e7, "ambient_k": 400.0}}, "capacity_factor": [[340.0, 1.0], [380.0, 2.0]]}),
            None,
        ),
    ] {
        let keys = json!({"boundary": {}, "time": {"step_s": 1e-8}, "heat": {
            "conductivity_w_per_m_k": K, "capacity_j_per_kg_k": 460.0, "start_k": 300.0, "every_steps": 100}});
        let keys = with(keys, json!({"heat": more}));
        let mut body = node(&with(strip_of(1e-3, 1e-3, 2.5e-4), keys.clone()));
        body.advance_alone(&window(0, 10_000))
            .expect("it is stable");
        let found = body.finish().expect("it ends").findings;
        let codes: Vec<&str> = found.iter().map(|found| found.code.as_str()).collect();
        let found = code.map_or(codes.is_empty(), |code| codes.contains(&code));
        assert!(found, "{codes:?}: {keys}");
    }
}

/// A wheel of half-spaces gets nothing from the end of the edge that is held.
#[test]
fn a_wheel_beside_a_held_end_loses_no_heat() {
    let ends = [(Edge::Left, EdgeCondition::Held(50.0))];
    let mesh = strip([3, 20], [1e-4, 1e-4]);
    let body = HeatBody::new(&mesh, numbers(1e-6), &ends).under_wheel((&mesh, T), [1e4, 20.0]);
    let mut field = body.at_start();
    body.meet(&mut field, [true; 4].into_iter());
    march(&body, &mut field, 100, 1e-6);
    let left = body.stored(&field) + field.conducted.iter().sum::<f64>();
    assert!(left.abs() < 1e-12 * field.conducted[1].abs(), "{left}");
}

#[test]
fn heat_without_a_mesh_a_time_or_a_way_is_refused() {
    let wheelless = json!({"wheel": null, "contact": null});
    for (change, key) in [
        (
            json!({"heat": {"edges": {"middle": {"held_k": 300.0}}}}),
            "heat.edges.middle",
        ),
        (
            json!({"heat": {"edges": {"top": {"held_k": 300.0, "flux_w_per_m2": 1.0}}}}),
            "heat.edges.top",
        ),
        (
            json!({"heat": {"edges": {"top": {"film_w_per_m2_k": 1.0}}}}),
            "heat.edges.top",
        ),
        (json!({"heat": {"finest_m": 1e-3}}), "heat.finest_m"),
        (json!({"mesh": {"contact_edge": "bottom"}}), "heat"),
        (
            with(json!({"heat": {"wheel_share": 0.5}}), wheelless.clone()),
            "heat.wheel_share",
        ),
        (
            json!({"mesh": {"periodic_x": true}, "heat": {"edges": {"left": {"held_k": 1.0}}}}),
            "heat.edges",
        ),
        (
            json!({"analysis": "static", "wheel": {"rolling": null}}),
            "heat",
        ),
        (
            json!({"heat": {"softening": {"yield_stress": [[300.0, 1.0]]}}}),
            "heat.softening.yield_stress",
        ),
        (
            json!({"heat": {"alpha_per_k": 1e-5}, "analysis": "static"}),
            "heat.alpha_per_k",
        ),
        (
            json!({"heat": {"capacity_factor": [[300.0, 0.0]]}}),
            "heat.capacity_factor",
        ),
        (
            json!({"heat": {"conductivity_factor": [[300.0, 1.0], [200.0, 1.0]]}}),
            "heat.conductivity_factor",
        ),
        (
            with(
                json!({"heat": {"wheel_half_space": half_space(1e4)}}),
                wheelless.clone(),
            ),
            "heat.wheel_half_space",
        ),
        (
            json!({"heat": {"wheel_half_space": half_space(1e4), "wheel_share": 0.5}}),
            "heat.wheel_share",
        ),
        (
            json!({"heat": {"wheel_half_space": half_space(1e4), "edges": {"top": {"held_k": 400.0}}}}),
            "heat.edges.top.held_k",
        ),
        (
            json!({"heat": {"wheel_half_space": half_space(1e30)}}),
            "heat",
        ),
        (json!({"heat": {"conductivity_w_per_m_k": 1e30}}), "heat"),
        (
            json!({"heat": {"capacity_factor": [[300.0, 1e-30]]}}),
            "heat",
        ),
        (json!({"heat": {"finest_m": 1e-15}}), "heat"),
        (
            json!({"heat": {"edges": {"bottom": {"film_w_per_m2_k": 1e18, "ambient_k": 400.0}}}}),
            "heat",
        ),
    ] {
        let config = with(rail(), change.clone());
        let error = fem_node::check(&config, &setting(1)).expect_err("it is impossible");
        assert_eq!(error.key, key, "{change}");
    }
    let mut body = node(&with(
        strip_of(1e-3, 1e-3, 5e-4),
        json!({"heat": rail()["heat"]}),
    ));
    let error = body
        .couple("left")
        .expect_err("its layers lie below the top");
    assert!(
        error.to_string().contains("participant.config.heat"),
        "{error}"
    );
}
