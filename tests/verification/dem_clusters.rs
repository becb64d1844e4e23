//! Rigid clusters of disks.
//!
//! ```text
//!        O      n            l from the centre of mass to the contact point, A = l x n, B = l.n:
//!       /       |            W_nn = 1/M + A^2/I   W_nt = A B / I   W_tt = 1/M + B^2/I
//!      O  V     |            u_n = v_y + A w, u_t = -v_x + B w  on a floor, n = (0, 1)
//!   =======
//! ```
//!
//! Reference: the impact of a rigid body as a 2x2 problem, statics of a block on a slope, and conservation laws, each derived
//! in its test. Tolerance: the true residual 1e-12, or rounding where contacts do not couple.

use dem_node::{Dem, config};
use protocol::{Node, Setting};
use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, close, march, mass, refusal, scene, setting, with};

const R: f64 = 1e-3;
const STEP: f64 = 1e-5;
const G: f64 = 9.81;

fn member(x: f64, y: f64, cluster: &str) -> Value {
    json!({"x_m": x, "y_m": y, "radius_m": R, "cluster": cluster})
}

fn floor() -> Value {
    json!([{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}])
}

/// Two disks 2a apart at this angle to the floor, the lower one touching it, falling with a speed.
fn dumbbell(a: f64, angle: f64, speed: f64, law: Value, cluster: Value) -> Value {
    let (sin, cos) = angle.sin_cos();
    let mut entry = json!({"name": "bar", "vy_m_per_s": -speed});
    for (key, value) in cluster.as_object().into_iter().flatten() {
        entry[key] = value.clone();
    }
    let sample = json!({
        "kind": "disks",
        "disks": [member(0.0, R, "bar"), member(2.0 * a * cos, R + 2.0 * a * sin, "bar")],
        "clusters": [entry],
        "walls": floor(),
    });
    scene(law, STEP, sample, json!({}))
}

fn bar_inertia(a: f64) -> f64 {
    2.0 * mass(R) * (0.5 * R * R + a * a)
}

/// v_x, v_y and spin (rad/s) of the body of the first disk.
fn motion(dem: &Dem) -> [f64; 3] {
    let [vx, vy, _] = dem.state().velocities[0];
    [vx, vy, dem.state().velocity_of(dem.bodies(), 0)[2]]
}

#[test]
fn a_bar_that_lands_on_one_end_follows_the_two_by_two_problem() {
    for degrees in [10.0f64, 35.0, 70.0, 120.0] {
        for friction in [0.0, 0.1, 1.0] {
            let (a, speed) = (3.0 * R, 0.7);
            let angle = degrees.to_radians();
            let law = json!({"kind": "coulomb", "friction": friction});
            let mut dem = build(&dumbbell(a, angle, speed, law, json!({})));
            march(&mut dem, 0, 1);
            let (m, inertia) = (2.0 * mass(R), bar_inertia(a));
            let (lever_n, lever_t) = (-a * angle.cos(), -a * angle.sin() - R);
            let w_nn = 1.0 / m + lever_n * lever_n / inertia;
            let w_nt = lever_n * lever_t / inertia;
            let w_tt = 1.0 / m + lever_t * lever_t / inertia;
            // Without impulse u = (-V, 0). Stick: W r = (V, 0); else r_t = s mu r_n, r_n = V / (W_nn + s mu W_nt).
            let determinant = w_nn * w_tt - w_nt * w_nt;
            let stick = [speed * w_tt / determinant, -speed * w_nt / determinant];
            let r = if stick[1].abs() <= friction * stick[0] {
                stick
            } else {
                let slide = stick[1].signum() * friction;
                let r_n = speed / (w_nn + slide * w_nt);
                [r_n, slide * r_n]
            };
            let [vx, vy, spin] = motion(&dem);
            let name = |what: &str| format!("{what} at {degrees} degrees, friction {friction}");
            close(&name("v_x"), vx, -r[1] / m, 1e-11);
            close(&name("v_y"), vy, -speed + r[0] / m, 1e-11);
            let expected = (lever_n * r[0] + lever_t * r[1]) / inertia;
            close(&name("spin"), spin, expected, 1e-11 / R);
        }
    }
}

/// Two bars and a disk that meet; the bars turn.
fn meeting(friction: f64, theta: f64, solver: &str) -> Dem {
    let sample = json!({
        "kind": "disks",
        "disks": [
            member(0.0, 0.0, "left"), member(1.8 * R, 0.9 * R, "left"),
            {"x_m": 3.0 * R, "y_m": 3.3 * R, "radius_m": 0.7 * R, "vx_m_per_s": -0.3, "vy_m_per_s": -1.0},
            member(5.0 * R, 0.3 * R, "right"), member(6.8 * R, -0.6 * R, "right"), member(6.9 * R, 1.3 * R, "right"),
        ],
        "clusters": [
            {"name": "left", "vx_m_per_s": 1.0, "spin_rad_per_s": 150.0},
            {"name": "right", "vx_m_per_s": -1.5, "vy_m_per_s": 0.1, "spin_rad_per_s": -80.0},
        ],
    });
    let law = json!({"kind": "coulomb", "friction": friction});
    let mut config = scene(law, STEP, sample, json!({}));
    config["time"]["theta"] = json!(theta);
    config["solver"]["kind"] = json!(solver);
    build(&config)
}

/// Linear momentum, and angular momentum about the origin.
fn momenta(dem: &Dem) -> [f64; 3] {
    let (state, bodies) = (dem.state(), dem.bodies());
    let mut sum = [0.0; 3];
    let mut add = |m: f64, x: [f64; 2], v: [f64; 3], radius: f64| {
        sum[0] += m * v[0];
        sum[1] += m * v[1];
        // I w = (m radius^2 / 2) (v_2 / radius).
        sum[2] += m * (x[0] * v[1] - x[1] * v[0] + 0.5 * radius * v[2]);
    };
    for (cluster, pose) in bodies.clusters.list.iter().zip(&state.clusters) {
        add(
            cluster.mass,
            pose.centre,
            state.velocities[cluster.leader()],
            cluster.radius,
        );
    }
    add(
        bodies.masses[2],
        state.centres[2],
        state.velocities[2],
        bodies.radii[2],
    );
    sum
}

#[test]
fn clusters_keep_linear_and_angular_momentum() {
    for (theta, solver) in [(0.5, "nsgs"), (1.0, "nsgs"), (1.0, "pcg")] {
        let mut dem = meeting(0.5, theta, solver);
        let before = momenta(&dem);
        let scale = mass(R) * 1.0;
        let report = march(&mut dem, 0, 800);
        assert!(report.energy("impact") > 0.05 * scale, "they must meet");
        let after = momenta(&dem);
        for (k, size) in [scale, scale, scale * 5.0 * R].into_iter().enumerate() {
            close(&format!("momentum {k}"), after[k], before[k], 1e-12 * size);
        }
    }
}

#[test]
fn the_ledger_of_clusters_closes_with_friction_for_every_theta() {
    for theta in [0.5, 0.8, 1.0] {
        let mut dem = meeting(0.5, theta, "nsgs");
        let before = dem.state().kinetic(dem.bodies());
        let linear = momenta(&dem);
        let report = march(&mut dem, 0, 800);
        assert!(
            report.energy("friction") > 1e-3 * before,
            "there must be slip"
        );
        assert!(
            report.imbalance(before) < 1e-10,
            "{:e}",
            report.imbalance(before)
        );
        for (now, then) in momenta(&dem).into_iter().zip(linear).take(2) {
            close("momentum", now, then, 1e-12 * mass(R));
        }
    }
}

#[test]
fn disks_of_a_cluster_keep_their_distances() {
    let mut dem = meeting(0.5, 1.0, "nsgs");
    let distances = |dem: &Dem| {
        let c = &dem.state().centres;
        [(0, 1), (3, 4), (3, 5), (4, 5)].map(|(i, j)| (c[i][0] - c[j][0]).hypot(c[i][1] - c[j][1]))
    };
    let before = distances(&dem);
    march(&mut dem, 0, 2000);
    for (now, then) in distances(&dem).into_iter().zip(before) {
        close("distance", now, then, 1e-15);
    }
}

/// A rod of five disks that only spins: the outer ones move by 4 r omega.
#[test]
fn the_fastest_disk_of_a_rod_that_spins_is_at_its_end() {
    let disks: Vec<Value> = (0..5)
        .map(|i| member(2.0 * R * f64::from(i), 0.0, "rod"))
        .collect();
    let clusters = json!([{"name": "rod", "spin_rad_per_s": 500.0}]);
    let sample = json!({"kind": "disks", "disks": disks, "clusters": clusters});
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let report = march(&mut build(&scene(law, 1e-6, sample, json!({}))), 0, 1);
    close(
        "speed",
        report.signal("speed_max_m_per_s"),
        4.0 * R * 500.0,
        1e-9,
    );
}

/// A disk that falls on a slope and rolls, alone or as a cluster of one.
fn on_slope(disk: Value) -> Dem {
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let sample = json!({
        "kind": "disks", "disks": [disk],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": -sin, "ny": cos}],
    });
    let law = json!({"kind": "coulomb", "friction": 0.3});
    build(&scene(
        law,
        1e-4,
        sample,
        json!({"gravity_m_per_s2": [0.0, -G]}),
    ))
}

#[test]
fn a_cluster_of_one_disk_is_that_disk() {
    let mut single = on_slope(json!({"x_m": 0.3e-3, "y_m": 1.5 * R, "radius_m": R}));
    let mut cluster = on_slope(member(0.3e-3, 1.5 * R, "one"));
    for step in 0..300 {
        march(&mut single, step, 1);
        march(&mut cluster, step, 1);
        let (a, b) = (motion(&single), motion(&cluster));
        for (k, scale) in [1.0, 1.0, 1.0 / R].into_iter().enumerate() {
            close(&format!("step {step}, {k}"), b[k], a[k], 1e-14 * scale);
        }
    }
    assert!(motion(&single)[2] > 10.0, "it must have rolled");
}

#[test]
fn locked_rotation_is_infinite_inertia() {
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let angle = 35f64.to_radians();
    let run = |cluster: Value| {
        let mut dem = build(&dumbbell(3.0 * R, angle, 0.7, law.clone(), cluster));
        march(&mut dem, 0, 20);
        motion(&dem)
    };
    let locked = run(json!({"locked": ["rotation"]}));
    let heavy = run(json!({"inertia_kg_m2": 1e6}));
    assert_eq!(locked[2], 0.0);
    for k in 0..2 {
        close("velocity", locked[k], heavy[k], 1e-12);
    }
    // It stops dead on the floor: no spin, no slip.
    close("v_y", locked[1], 0.0, 1e-12);
}

#[test]
fn a_locked_direction_holds_and_the_ledger_still_closes() {
    let law = json!({"kind": "coulomb", "friction": 0.3});
    for (locked, axis) in [("x", 0), ("y", 1)] {
        let mut config = dumbbell(3.0 * R, 0.6, 0.0, law.clone(), json!({"locked": [locked]}));
        config["gravity_m_per_s2"] = json!([3.0, -G]);
        // Momentum and energy balance at any residual.
        config["solver"]["tolerance"] = json!(1e-8);
        config["sample"]["disks"]
            .as_array_mut()
            .expect("a list")
            .push(json!({
                "x_m": 3.0 * R, "y_m": 12.0 * R, "radius_m": R, "vy_m_per_s": -2.0,
            }));
        let mut dem = build(&config);
        let start = dem.state().clusters[0].centre[axis];
        let mut report = march(&mut dem, 0, 1);
        let mut worst = 0.0f64;
        for step in 1..1000 {
            report = march(&mut dem, step, 1);
            worst = worst.max(report.signal("momentum_defect_n"));
        }
        assert_eq!(dem.state().clusters[0].centre[axis], start, "{locked}");
        assert!(dem.state().clusters[0].angle.abs() > 0.01, "it turns");
        let weight = 3.0 * mass(R) * G;
        assert!(worst < 1e-9 * weight, "{locked}: {worst:e}");
        let energy = 2.0 * mass(R);
        assert!(
            report.imbalance(energy) < 1e-10,
            "{:e}",
            report.imbalance(energy)
        );
    }
}

/// Four disks around a centre at (0, R + h), on a slope made by the direction of gravity.
fn block(b: f64, h: f64, tangent: f64) -> Dem {
    let theta = tangent.atan();
    let sample = json!({
        "kind": "disks",
        "disks": [
            member(-b, R, "block"), member(b, R, "block"),
            member(-b, R + 2.0 * h, "block"), member(b, R + 2.0 * h, "block"),
        ],
        "walls": floor(),
    });
    let law = json!({"kind": "coulomb", "friction": 0.9});
    let gravity = json!({"gravity_m_per_s2": [G * theta.sin(), -G * theta.cos()]});
    build(&scene(law, STEP, sample, gravity))
}

#[test]
fn a_block_tips_when_its_weight_leaves_its_feet() {
    for (b, h) in [(R, R), (2.0 * R, 3.0 * R)] {
        // The feet touch at x = +-b, the centre of mass is R + h above: it tips above tan = b / (R + h).
        let threshold = b / (R + h);
        let mut stays = block(b, h, 0.99 * threshold);
        march(&mut stays, 0, 200);
        let motion_of = |dem: &Dem| motion(dem).map(f64::abs);
        assert!(
            motion_of(&stays).into_iter().all(|v| v < 1e-9),
            "{:?}",
            motion_of(&stays)
        );
        let mut tips = block(b, h, 1.01 * threshold);
        march(&mut tips, 0, 1);
        // About the lower foot: I' alpha = M g (H sin - b cos) with I' = I + M (b^2 + H^2), clockwise.
        let (high, m, theta) = (R + h, 4.0 * mass(R), (1.01 * threshold).atan());
        let inertia = m * (0.5 * R * R + b * b + h * h) + m * (b * b + high * high);
        let alpha = m * G * (high * theta.sin() - b * theta.cos()) / inertia;
        close(
            "angular acceleration",
            motion(&tips)[2] / STEP,
            -alpha,
            1e-8 * alpha,
        );
    }
}

#[test]
fn a_bar_that_jams_is_an_error_by_name() {
    // W_nn - mu |W_nt| changes sign at mu = (I/M + A^2) / |A B|: sliding has no unique impulse above (Painleve 1895).
    let (a, angle) = (5.0 * R, 50f64.to_radians());
    let (lever_n, lever_t) = (a * angle.cos(), a * angle.sin() + R);
    let limit = (bar_inertia(a) / (2.0 * mass(R)) + lever_n * lever_n) / (lever_n * lever_t);
    let run = |friction: f64| {
        let law = json!({"kind": "coulomb", "friction": friction});
        let mut dem = build(&dumbbell(a, angle, 0.1, law, json!({})));
        dem.advance_alone(&protocol::Window {
            substeps: 1,
            ..Default::default()
        })
    };
    run(0.999 * limit).expect("sliding is unique");
    let error = run(1.001 * limit).expect_err("it jams");
    assert!(
        error.message.contains("W_nn - friction |W_nt|") && error.message.contains("Painleve"),
        "{error}"
    );
}

#[test]
fn any_number_of_threads_leaves_the_same_bits() {
    let mut disks = Vec::new();
    for column in 0..60 {
        for row in 0..90 {
            let shift = 0.9 * R * f64::from(row % 2);
            let mut disk = json!({
                "x_m": R * f64::from(2 * column + 1) + shift, "y_m": R * (1.0 + 1.9 * f64::from(row)),
                "radius_m": 0.9 * R * [0.99, 0.93, 0.85][(column * 90 + row) as usize % 3],
            });
            if row % 10 < 2 && column % 3 == 0 {
                disk["cluster"] = json!(format!("{column} {}", row / 10));
            }
            disks.push(disk);
        }
    }
    let sample = json!({"kind": "disks", "disks": disks, "walls": floor()});
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let solver =
        json!({"kind": "nsgs", "tolerance": 1e-2, "max_iterations": 20_000, "min_iterations": 1});
    let overrides = json!({"gravity_m_per_s2": [2.0, -G], "solver": solver});
    let config: config::DemConfig =
        kit::read_config(scene(law, 5e-3, sample, overrides)).expect("it is valid");
    let mut by_pcg = config.clone();
    by_pcg.solver.algorithm = config::solver::Algorithm::Pcg;
    let run = |config: &config::DemConfig, threads: usize| {
        let setting = Setting {
            threads,
            ..setting(1)
        };
        let mut dem = Dem::new(config, &setting).expect("it can be prepared");
        march(&mut dem, 0, 3);
        assert!(dem.state().list.slots.len() > 2 * 4096, "one block only");
        dem.finish().expect("it finishes").state_hash
    };
    for config in [&config, &by_pcg] {
        let one = run(config, 1);
        for threads in [2, 4] {
            assert_eq!(run(config, threads), one, "{threads} threads");
        }
    }
}

#[test]
fn keys_that_exclude_clusters_are_refused() {
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let bar = |changes: Value| dumbbell(3.0 * R, 0.5, 0.0, law.clone(), changes);
    let mut glued = bar(json!({}));
    glued["sample"]["disks"][0]["glued"] = json!(true);
    let mut moving = bar(json!({}));
    moving["sample"]["disks"][1]["vx_m_per_s"] = json!(1.0);
    let mut projected = bar(json!({}));
    projected["law"]["penetration"] = json!("projection");
    let cases = [
        (glued, "sample.disks[0].cluster"),
        (moving, "sample.disks[1].cluster"),
        (projected, "law.penetration"),
        (
            bar(json!({"name": "rod"})),
            "sample.clusters[0].name: \"rod\" has no disks",
        ),
        (bar(json!({"mass_kg": 0.0})), "sample.clusters[0].mass_kg"),
        (bar(json!({"locked": ["z"]})), "sample"),
        (
            bar(json!({"locked": ["rotation"], "spin_rad_per_s": 1.0})),
            "sample.clusters[0].spin_rad_per_s: belongs to a motion that is locked",
        ),
        (
            bar(json!({"locked": ["rotation"], "inertia_kg_m2": 1e-9})),
            "sample.clusters[0].inertia_kg_m2: has no effect",
        ),
        (
            bar(json!({"locked": ["x", "y"], "mass_kg": 1.0, "vy_m_per_s": 0.0})),
            "sample.clusters[0].mass_kg: has no effect",
        ),
        (
            bar(
                json!({"drive": {"velocity_m_per_s": [0.0, 0.0]}, "mass_kg": 1.0, "vy_m_per_s": 0.0}),
            ),
            "sample.clusters[0].mass_kg: has no effect",
        ),
    ];
    for (config, expected) in cases {
        let message = refusal(&config);
        assert!(message.contains(expected), "{expected}: {message}");
    }
}

/// Exact: a disk m with the velocity v hits a resting body of mass M plastically in its centre; both continue with m v/(m + M).
#[test]
fn a_given_mass_also_counts_for_a_cluster_without_a_drive() {
    let bar = |x: f64| json!({"x_m": x, "y_m": 0.0, "radius_m": R, "cluster": "bar"});
    let ball = json!({"x_m": -3.0 * R, "y_m": 0.0, "radius_m": R, "vx_m_per_s": 1.0});
    for times in [0.5, 3.0] {
        let sample = json!({
            "kind": "disks", "disks": [bar(0.0), bar(1.5 * R), ball],
            "clusters": [{"name": "bar", "mass_kg": times * mass(R)}],
        });
        let mut dem = build(&scene(
            json!({"kind": "signorini"}),
            1e-5,
            sample,
            json!({}),
        ));
        march(&mut dem, 0, 200);
        let [vx, ..] = dem.state().velocities[0];
        close("speed", vx, 1.0 / (1.0 + times), 1e-12);
    }
}

fn bonded_law(more: Value) -> Value {
    let mut law = json!({"kind": "cohesion", "friction": 0.3, "cn_pa_per_m": 1e9, "ct_pa_per_m": 1e9, "w_j_per_m2": 1.0, "b_pa_m_s": 0.0,
        "p": 1.0, "h_prime": "one", "alert_m": 1e-6});
    for (key, value) in more.as_object().into_iter().flatten() {
        law[key] = value.clone();
    }
    law
}

/// A rod of three disks below two glued ones, bonded at its ends: each bond carries half the weight, opened by m g / (2 l Cn).
#[test]
fn a_rod_hangs_on_the_bonds_at_its_ends() {
    let glued = |x: f64| json!({"x_m": x, "y_m": 2.0 * R, "radius_m": R, "glued": true});
    let rod = [-2.0 * R, 0.0, 2.0 * R].map(|x| member(x, 0.0, "rod"));
    let disks: Vec<Value> = rod
        .into_iter()
        .chain([glued(-2.0 * R), glued(2.0 * R)])
        .collect();
    let sample = json!({"kind": "disks", "disks": disks});
    let law = bonded_law(json!({"bond_damping_ratio": 1.0}));
    let over = json!({"gravity_m_per_s2": [0.0, -G]});
    let mut dem = build(&scene(law, STEP, sample, over));
    let report = march(&mut dem, 0, 5000);
    let area = 0.5 * R * 1e-3;
    let opening = 3.0 * mass(R) * G / (2.0 * area * 1e9);
    let bonds = &dem.state().bonds;
    assert_eq!(bonds.len(), 2);
    for bond in bonds {
        close("opening", bond.opening, opening, 1e-9 * opening);
        close("slip", bond.slip, 0.0, 1e-9 * opening);
    }
    assert!(report.imbalance(mass(R) * G * opening) < 1e-9);
}

/// A square of four disks and a triangle of three, bonded at one pair, with different velocities: together they keep momentum and
/// angular momentum, and the ledger accounts for the energy.
#[test]
fn bonded_clumps_keep_momentum_and_angular_momentum() {
    let square = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0]]
        .map(|[x, y]| member(x * R, y * R, "square"));
    let height = 3.0f64.sqrt();
    let triangle = [[4.0, 2.0], [6.0, 2.0], [5.0, 2.0 + height]]
        .map(|[x, y]| member(x * R, y * R, "triangle"));
    let disks: Vec<Value> = square.into_iter().chain(triangle).collect();
    let clusters = json!([{"name": "square", "vx_m_per_s": 0.01, "spin_rad_per_s": 3.0}, {"name": "triangle", "vy_m_per_s": 0.02}]);
    let sample = json!({"kind": "disks", "disks": disks, "clusters": clusters});
    // Conjugate gradients take no friction beside a rigid bond.
    for (solver, friction) in [("nsgs", 0.3), ("pcg", 0.0)] {
        let law = bonded_law(json!({"friction": friction}));
        let mut config = scene(law, 1e-6, sample.clone(), json!({}));
        config["solver"]["kind"] = json!(solver);
        keeps_momentum(build(&config));
    }
}

fn keeps_momentum(mut dem: Dem) {
    assert_eq!(dem.state().bonds.len(), 1);
    let about_origin = |dem: &Dem| {
        let (bodies, state) = (dem.bodies(), dem.state());
        let mut sums = [0.0; 3];
        for (cluster, pose) in bodies.clusters.list.iter().zip(&state.clusters) {
            let (m, [vx, vy, spin]) = (cluster.mass, state.velocities[cluster.leader()]);
            let [x, y] = pose.centre;
            sums[0] += m * vx;
            sums[1] += m * vy;
            sums[2] += m * (x * vy - y * vx + 0.5 * cluster.radius * spin);
        }
        sums
    };
    let start = about_origin(&dem);
    let (energy, mut from) = (dem.state().kinetic(dem.bodies()), 0);
    for _ in 0..20 {
        let report = march(&mut dem, from, 500);
        from += 500;
        assert!(
            report.imbalance(energy) < 1e-9,
            "{:e}",
            report.imbalance(energy)
        );
    }
    let end = about_origin(&dem);
    let scale = mass(R) * 0.02;
    close("momentum x", end[0], start[0], 1e-12 * scale);
    close("momentum y", end[1], start[1], 1e-12 * scale);
    // A step uses the levers of its start, from which the bodies turn away.
    close("angular momentum", end[2], start[2], 1e-5 * start[2].abs());
    assert_eq!(dem.state().bonds.len(), 1);
}

/// One disk moves alike alone and as a cluster, also with couples that resist its rolling.
#[test]
fn a_cluster_of_one_disk_rolls_like_the_disk() {
    let run = |disk: Value| {
        let (sin, cos) = 20.0f64.to_radians().sin_cos();
        let law = json!({"kind": "coulomb", "friction": 0.9, "rolling": {"coefficient": 0.1}});
        let sample = json!({"kind": "disks", "disks": [disk], "walls": floor()});
        let over = json!({"gravity_m_per_s2": [G * sin, -G * cos]});
        let mut dem = build(&scene(law, STEP, sample, over));
        march(&mut dem, 0, 500);
        motion(&dem)
    };
    let alone = run(json!({"x_m": 0.0, "y_m": R, "radius_m": R}));
    let cluster = run(member(0.0, R, "one"));
    for (alone, cluster) in alone.into_iter().zip(cluster) {
        close("motion", cluster, alone, 1e-12 * alone.abs().max(1e-3));
    }
    assert!(alone[0] > 0.0);
}

/// A bar and a triangle that fall on each other, two disks and a floor, with the disks and the clusters in this order.
fn heap(law: &Value, order: [usize; 7], clusters: [usize; 2]) -> Dem {
    let disks = [
        member(0.0, 2.0 * R, "bar"),
        json!({"x_m": 1.7 * R, "y_m": 2.0 * R, "radius_m": 0.8 * R, "cluster": "bar"}),
        json!({"x_m": 1.8 * R, "y_m": 0.6 * R, "radius_m": 0.6 * R, "cluster": "three"}),
        json!({"x_m": 1.9 * R, "y_m": -0.4 * R, "radius_m": 0.6 * R, "cluster": "three"}),
        json!({"x_m": 2.7 * R, "y_m": -0.3 * R, "radius_m": 0.5 * R, "cluster": "three"}),
        json!({"x_m": 3.5 * R, "y_m": 2.0 * R, "radius_m": R, "vx_m_per_s": 0.1, "vy_m_per_s": -0.3, "spin_rad_per_s": 30.0}),
        json!({"x_m": -1.5 * R, "y_m": 2.0 * R, "radius_m": 0.5 * R, "vx_m_per_s": 0.2}),
    ];
    let entries = [
        json!({"name": "bar", "vx_m_per_s": 0.2, "spin_rad_per_s": 20.0}),
        json!({"name": "three", "vy_m_per_s": 0.4}),
    ];
    let sample = json!({
        "kind": "disks",
        "disks": order.map(|i| disks[i].clone()),
        "clusters": clusters.map(|i| entries[i].clone()),
        "walls": [{"x_m": 0.0, "y_m": -R, "nx": 0.0, "ny": 1.0}],
    });
    let over = json!({"gravity_m_per_s2": [0.0, -G]});
    build(&scene(law.clone(), 1e-6, sample, over))
}

/// Any disk may carry the mass of its cluster: with bonds at any disk, healing, adhesion, dampers, couples and rebounds.
#[test]
fn the_order_of_disks_and_clusters_changes_nothing() {
    let springs =
        json!({"contact_stiffness_pa": 1e7, "tangential_stiffness_ratio": 1.0, "damping": 0.5});
    let bonds = json!({"kind": "cohesion", "friction": 0.3, "cn_pa_per_m": 1e9, "ct_pa_per_m": 1e9, "w_j_per_m2": 1e-3,
        "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 3e-5, "bond_damping_ratio": 0.1,
        "rolling": {"coefficient": 0.1}, "healing": {"time_s": 1e-3, "pressure_pa": 0.0}});
    let adhesive = json!({"kind": "coulomb", "friction": 0.3, "adhesion": {"pull_off_pa": 1e3, "range_m": 1e-4}});
    let rigid = json!({"kind": "coulomb", "friction": 0.3, "restitution": 0.4, "rolling": {"coefficient": 0.1}});
    let laws = [
        with(bonds.clone(), &springs),
        bonds,
        with(adhesive, &springs),
        rigid,
    ];
    for law in laws {
        let mut first = None;
        for (order, clusters) in [
            ([0, 1, 2, 3, 4, 5, 6], [0, 1]),
            ([6, 5, 4, 3, 2, 1, 0], [1, 0]),
            ([1, 4, 0, 6, 3, 5, 2], [1, 0]),
            ([5, 3, 6, 1, 2, 0, 4], [0, 1]),
        ] {
            let mut dem = heap(&law, order, clusters);
            march(&mut dem, 0, 4000);
            let place = |i: usize| order.iter().position(|n| *n == i).expect("each is there");
            let centres = [0, 1, 2, 3, 4, 5, 6].map(|i| dem.state().centres[place(i)]);
            let end = dem.finish().expect("it ends");
            let named = ["bond_step_limit_s", "spring_restitution"];
            let numbers = named.map(|name| end.results.get(name).copied().unwrap_or(0.0));
            let codes: Vec<String> = end.findings.into_iter().map(|found| found.code).collect();
            let Some((expected, limits, found)) = &first else {
                first = Some((centres, numbers, codes));
                continue;
            };
            assert_eq!(&codes, found, "{order:?}");
            for (a, b) in centres.iter().flatten().zip(expected.iter().flatten()) {
                close("centre", *a, *b, 1e-7 * R);
            }
            for (a, b) in numbers.iter().zip(limits) {
                close("bound", *a, *b, 1e-12 * b);
            }
        }
    }
}

/// A bar bonded at its end yields by turning: 1/m = 1/M + a^2/I, against a disk of infinite mass.
#[test]
fn the_step_limit_of_a_bond_depends_on_its_lever_on_a_cluster() {
    for (at, lever, locked) in [
        (0.0, 2.0 * R, json!([])),
        (4.0 * R, 2.0 * R, json!([])),
        (2.0 * R, 0.0, json!([])),
        (0.0, 0.0, json!(["rotation"])),
    ] {
        let sample = json!({
            "kind": "disks",
            "disks": [member(0.0, 0.0, "bar"), member(2.0 * R, 0.0, "bar"), member(4.0 * R, 0.0, "bar"),
                {"x_m": at, "y_m": 2.0 * R, "radius_m": R, "glued": true}],
            "clusters": [{"name": "bar", "locked": locked}],
        });
        let law = json!({"kind": "cohesion", "friction": 0.0, "contact_stiffness_pa": 1e7, "tangential_stiffness_ratio": 1.0,
            "cn_pa_per_m": 1e9, "ct_pa_per_m": 1e9, "w_j_per_m2": 1.0, "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 1e-6});
        let mut dem = build(&scene(law, 1e-6, sample, json!({})));
        assert_eq!(dem.state().bonds.len(), 1);
        let (m, area) = (3.0 * mass(R), 0.5 * R * THICKNESS);
        let inertia = m * 0.5 * R * R + 2.0 * mass(R) * 4.0 * R * R;
        let mobility = 1.0 / m + lever * lever / inertia;
        let limit = 1.0 / (3.0 * area * 1e9 * mobility).sqrt();
        let found = dem.finish().expect("it ends").results["bond_step_limit_s"];
        close("limit", found, limit, 1e-12 * limit);
    }
}

/// `bonds_min` bonds disks of clusters to their neighbours, but never to their own cluster.
#[test]
fn no_bond_is_made_within_a_cluster() {
    let law = json!({"kind": "cohesion", "friction": 0.3, "cn_pa_per_m": 1e9, "ct_pa_per_m": 1e9, "w_j_per_m2": 1e-3,
        "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 1e-6, "bonds_min": 2});
    let single = |x: f64, y: f64| json!({"x_m": x, "y_m": y, "radius_m": R});
    let sample = json!({"kind": "disks", "disks": [member(0.0, R, "pair"), member(1.5 * R, R, "pair"),
        single(3.5 * R, R), single(5.5 * R, R), single(3.5 * R, 3.0 * R)]});
    let dem = build(&scene(law, STEP, sample, json!({})));
    let pairs: Vec<_> = dem.state().bonds.iter().map(|bond| bond.pair()).collect();
    assert!(
        !pairs.contains(&(0, 1)) && pairs.contains(&(1, 2)),
        "{pairs:?}"
    );
}
