//! Surfaces of bodies that another solver moves: a polyline of points whose segments carry grains.
//!
//! ```text
//!          ( O )           the two points of a segment take a grain's force in the shares 1 - s and s;
//!   .____.___|____.        at the grain the segment moves with (1 - s) v_i + s v_j
//!        i   s    j
//! ```
//!
//! With S = (1 - s, s), a grain on two points of the compliance W_g sees W = 1/m + S W_g S^T. So its impulse under its weight is
//! r = (h g + S a_g)/W. The forces on the points are then r S/h, and their moment is the moment of a force at the foot.
//! A straight line gives the motion on a half-plane, a crown the motion on a circle; both are exact. Tolerance: rounding.

use dem_node::Dem;
use protocol::{Node, Window};
use serde_json::{Value, json};

use crate::dem_support::{build, close, march, mass, refusal, scene};

const R: f64 = 1e-3;
const G: f64 = 9.81;
const H: f64 = 1e-5;

fn on_surface(law: Value, disks: Value, surface: Value, overrides: Value) -> Dem {
    let sample = json!({"kind": "disks", "disks": disks, "surface": surface});
    build(&scene(law, H, sample, overrides))
}

fn window(step_s: f64) -> Window {
    Window {
        substeps: 1,
        t1_s: step_s,
        ..Window::default()
    }
}

/// A compliance of n points: symmetric, positive definite, not diagonal, and of the order of 1/m.
fn compliance(points: usize) -> Vec<f64> {
    let n = 2 * points;
    let row = |i: usize| -> Vec<f64> {
        (0..n)
            .map(|k| ((3 * i + 5 * k) as f64).sin() + if i == k { 2.0 } else { 0.0 })
            .collect()
    };
    let m = mass(R);
    let product = |i: usize, j: usize| row(i).iter().zip(row(j)).map(|(a, b)| a * b).sum::<f64>();
    let entries = (0..n * n).map(|entry| 0.1 * product(entry / n, entry % n) / m);
    entries.collect()
}

#[test]
fn the_points_of_a_segment_share_force_and_motion() {
    let points = [
        [-2.0 * R, 0.0],
        [-0.5 * R, 0.0],
        [1.5 * R, 0.0],
        [3.0 * R, 0.0],
    ];
    let (n, share) = (8, 0.25);
    let w = compliance(4);
    let a: Vec<f64> = (0..n).map(|i| 1e-4 * (i as f64).cos()).collect();
    for solver in ["nsgs", "pcg"] {
        let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]);
        let over = json!({"gravity_m_per_s2": [0.0, -G],
            "time": {"pressure_pa": 1.0},
            "solver": {"kind": solver, "tolerance": 1e-12, "max_iterations": 2000, "min_iterations": 1}});
        let law = json!({"kind": "signorini"});
        let mut dem = on_surface(law, disk, json!({"points_m": points}), over);
        let surface = dem.couple("base").expect("the surface is a set");
        assert_eq!(surface.x_m, points.map(|p| p[0]));
        assert_eq!(surface.radius_m, [0.0; 4]);
        dem.set_boundary(H, &w).expect("8 x 8 numbers");
        let answer = dem.solve(&window(H), &a).expect("it can be solved");
        assert!(answer.converged);
        // Points 1 and 2, component y.
        let shares = [(3, 1.0 - share), (5, share)];
        let of =
            |vector: &dyn Fn(usize) -> f64| shares.map(|(i, s)| s * vector(i)).iter().sum::<f64>();
        let own: f64 = of(&|i| of(&|j| w[j * n + i]));
        let r = (H * G + of(&|i| a[i])) / (1.0 / mass(R) + own);
        for (i, force) in answer.force.iter().enumerate() {
            let part = shares
                .iter()
                .find(|(k, _)| *k == i)
                .map_or(0.0, |(_, s)| *s);
            close("force", *force, -part * r / H, 1e-12 * r / H);
            let moved: f64 = of(&|j| w[j * n + i]);
            close("v_g", answer.velocity[i], a[i] - r * moved, 1e-12 * a[0]);
        }
        let moment: f64 = (0..4).map(|k| points[k][0] * answer.force[2 * k + 1]).sum();
        close("moment about the foot", moment, 0.0, 1e-12 * R * r / H);
    }
}

/// The attraction of the surface holds a disk against gravity: r = -(h g - S a_g)/W as under a load, down to -N_c h. A disk within the
/// range that does not touch pulls the two points with N_c, and they pull the disk.
#[test]
fn attraction_acts_on_the_points_of_a_segment_as_a_contact_does() {
    let points = [
        [-2.0 * R, 0.0],
        [-0.5 * R, 0.0],
        [1.5 * R, 0.0],
        [3.0 * R, 0.0],
    ];
    let (n, shares) = (8, [(3, 0.75), (5, 0.25)]);
    let w = compliance(4);
    let a: Vec<f64> = (0..n).map(|i| 1e-6 * (i as f64).cos()).collect();
    let of = |vector: &dyn Fn(usize) -> f64| shares.map(|(i, s)| s * vector(i)).iter().sum::<f64>();
    let own: f64 = of(&|i| of(&|j| w[j * n + i]));
    let pull_off = 3.0 * mass(R) * G;
    for solver in ["nsgs", "pcg"] {
        for gap in [0.0, 0.1 * R] {
            let disk = json!([{"x_m": 0.0, "y_m": R + gap, "radius_m": R}]);
            let over = json!({"gravity_m_per_s2": [0.0, G],
                "time": {"pressure_pa": 1.0},
                "solver": {"kind": solver, "tolerance": 1e-12, "max_iterations": 2000, "min_iterations": 1}});
            let law = json!({"kind": "signorini", "adhesion": {"pull_off_n": pull_off, "range_m": 0.2 * R}});
            let mut dem = on_surface(law, disk, json!({"points_m": points}), over);
            dem.couple("base").expect("the surface is a set");
            dem.set_boundary(H, &w).expect("8 x 8 numbers");
            let answer = dem.solve(&window(H), &a).expect("it can be solved");
            let r = if gap > 0.0 {
                -H * pull_off
            } else {
                (of(&|i| a[i]) - H * G) / (1.0 / mass(R) + own)
            };
            assert!(answer.converged && r < 0.0 && r >= -H * pull_off);
            for (i, force) in answer.force.iter().enumerate() {
                let part = shares
                    .iter()
                    .find(|(k, _)| *k == i)
                    .map_or(0.0, |(_, s)| *s);
                close("force", *force, -part * r / H, 1e-11 * pull_off);
                let moved: f64 = of(&|j| w[j * n + i]);
                close("v_g", answer.velocity[i], a[i] - r * moved, 1e-11 * a[0]);
            }
            let speed = H * G + r / mass(R);
            dem.commit(&window(H), &[0.0; 8]).expect("it is committed");
            close("speed", dem.state().velocities[0][1], speed, 1e-11 * H * G);
        }
    }
}

/// A pile of grains presses on a surface of compliant points and lies on six segments at once.
#[test]
fn solvers_agree_on_a_pile_of_grains_on_a_surface_that_yields() {
    let place = |k: usize| {
        let row = k / 6;
        let x = (k % 6) as f64 * 2.0 * R + row as f64 * R - 5.5 * R;
        json!({"x_m": x, "y_m": R + row as f64 * 3f64.sqrt() * R, "radius_m": R, "vy_m_per_s": -1e-2 * (1 + k % 4) as f64})
    };
    let disks: Vec<Value> = (0..12).map(place).collect();
    let w = compliance(11);
    let solve = |solver: &str| {
        let over = json!({"gravity_m_per_s2": [0.0, -G],
            "time": {"pressure_pa": 1.0},
            "solver": {"kind": solver, "tolerance": 1e-11, "max_iterations": 20_000, "min_iterations": 1}});
        let surface = json!({"half_width_m": 10.0 * R, "spacing_m": 2.0 * R});
        let law = json!({"kind": "signorini", "contact_stiffness_pa": 1e9});
        let mut dem = on_surface(law, json!(disks), surface, over);
        dem.couple("base").expect("the surface is a set");
        dem.set_boundary(H, &w).expect("22 x 22 numbers");
        let answer = dem.solve(&window(H), &[0.0; 22]).expect("it can be solved");
        assert!(answer.converged);
        answer.force
    };
    let (nsgs, pcg) = (solve("nsgs"), solve("pcg"));
    let largest = nsgs.iter().fold(0.0f64, |most, f| most.max(f.abs()));
    let loaded = nsgs.iter().filter(|f| f.abs() > 0.01 * largest).count();
    assert!(loaded >= 6, "{loaded} of {nsgs:?}");
    for (a, b) in nsgs.iter().zip(&pcg) {
        close("force", *a, *b, 1e-8 * largest);
    }
}

/// Friction 0.3 on a slope of 50 degrees: as 3 mu < tan, the disk does not roll. It slides with a = g (sin - mu cos) and turns with
/// 2 mu g cos / r.
#[test]
fn a_disk_slides_along_a_straight_surface_as_along_a_plane() {
    let (sin, cos) = 50f64.to_radians().sin_cos();
    let places = [-9.0, -3.1, -1.3, -0.2, 0.017, 0.9, 1.7, 2.9, 4.0, 30.0];
    // The grains are on the left of the line, and down the slope is towards -x.
    let points: Vec<[f64; 2]> = places.iter().map(|s| [s * R * cos, s * R * sin]).collect();
    let disk =
        json!([{"x_m": 3.7 * R * cos - R * sin, "y_m": 3.7 * R * sin + R * cos, "radius_m": R}]);
    let law = json!({"kind": "coulomb", "friction": 0.3});
    let gravity = json!({"gravity_m_per_s2": [0.0, -G]});
    let mut dem = on_surface(law, disk, json!({"points_m": points}), gravity);
    for step in 1..=4000u32 {
        let report = march(&mut dem, u64::from(step) - 1, 1);
        let [vx, vy, spin] = dem.state().velocities[0];
        let time = f64::from(step) * H;
        let scale = G * time;
        close(
            "along",
            -(vx * cos + vy * sin),
            G * (sin - 0.3 * cos) * time,
            1e-9 * scale,
        );
        close("across", vy * cos - vx * sin, 0.0, 1e-9 * scale);
        close("spin", spin, 2.0 * 0.3 * G * cos * time, 1e-9 * scale);
        let [fx, fy] = ["glued_fx_n", "glued_fy_n"].map(|name| report.signal(name));
        let (normal, along) = (fx * sin - fy * cos, fx * cos + fy * sin);
        close("friction over the normal force", -along / normal, 0.3, 1e-9);
        close(
            "weight across",
            normal,
            mass(R) * G * cos,
            1e-9 * mass(R) * G,
        );
    }
    let [x, y] = dem.state().centres[0];
    assert!(x * cos + y * sin < -0.5 * R, "it has passed joints");
}

/// A disk slides under its weight over the joints of a crown. On a segment the force is m g cos. Over a joint the centre moves on a circle
/// of the disk's radius, which lowers the force by m v^2/r and no more, as the fan of normals closes without a jump.
#[test]
fn a_disk_slides_over_the_joints_of_a_crown_without_jumps() {
    let (crown, speed) = (50.0 * R, 0.02);
    let x0 = -2.0 * R;
    let top = |x: f64| (crown * crown - x * x).sqrt();
    let disk = json!([{"x_m": x0 * (1.0 + R / crown), "y_m": top(x0) * (1.0 + R / crown) - crown, "radius_m": R, "vx_m_per_s": speed}]);
    let surface = json!({"half_width_m": 20.0 * R, "spacing_m": 0.3 * R, "crown_radius_m": crown});
    let law = json!({"kind": "coulomb", "friction": 0.2});
    let gravity = json!({"gravity_m_per_s2": [0.0, -G]});
    let mut dem = on_surface(law, disk, surface, gravity);
    let weight = mass(R) * G;
    let fan = mass(R) * speed * speed / R;
    for step in 0..10_000 {
        let report = march(&mut dem, step, 1);
        let [fx, fy] = ["glued_fx_n", "glued_fy_n"].map(|name| report.signal(name));
        // The tolerances allow for the landing on the first segment and for a segment's sagitta, s^2/8R.
        if step > 500 {
            close("normal force", -fy / weight, 1.0, 3.0 * fan / weight + 5e-3);
            assert!(fx.hypot(fy) <= 1.3 * weight);
            assert_eq!(report.signal("contacts"), 1.0, "step {step}");
        }
        let [x, y] = dem.state().centres[0];
        let height = x.hypot(y + crown) - crown - R;
        assert!(
            height.abs() < 0.3f64.powi(2) * R * R / (8.0 * crown) + 1e-8,
            "{height:e} at {x:e}"
        );
    }
}

#[test]
fn a_surface_closes_at_the_seam_of_a_strip() {
    let strip = |overrides: Value| {
        let disk = json!([{"x_m": 1.5 * R, "y_m": R, "radius_m": R, "vx_m_per_s": 1.0}]);
        let surface = json!({"half_width_m": 5.0 * R, "spacing_m": 1.1 * R});
        let sample = json!({"kind": "disks", "disks": disk, "surface": surface,
            "periodic_x_m": [-5.0 * R, 5.0 * R]});
        build(&scene(json!({"kind": "signorini"}), H, sample, overrides))
    };
    let mut dem = strip(json!({"time": {"pressure_pa": 1.0}}));
    let points = dem.couple("base").expect("the surface is a set");
    close("length", points.length_m.iter().sum(), 10.0 * R, 1e-15);
    assert_eq!(points.x_m.len(), 10, "the end is the image of the start");
    let mut dem = strip(json!({"gravity_m_per_s2": [0.0, -G]}));
    for step in 0..2500 {
        let report = march(&mut dem, step, 1);
        close("force", report.signal("glued_fy_n"), -mass(R) * G, 1e-12);
        assert_eq!(report.signal("contacts"), 1.0, "step {step}");
    }
    close("distance", dem.state().centres[0][0], 26.5 * R, 1e-12);
}

/// A disk that overlaps by delta rolls through a valley of two slopes. Where the corner lies inside the disk, phi^2 r / 8 < delta, its two
/// contacts share the spring; otherwise the valley would be up to twice as stiff as its slopes. With a whole spring each, detection ends
/// with 0.24 or 0.2 of the spring's energy, and has up to 1.0 on the way. With shares it ends with 0.02. In a valley as shallow as
/// a pressed surface's it never exceeds that.
#[test]
fn a_valley_keeps_the_energy_of_a_disk_that_rolls_through() {
    for (slope, overlap) in [(1e-3, 1e-3), (0.02, 1e-3), (0.05, 1e-3), (0.05, 1e-2)] {
        let (sin, cos) = f64::atan(slope).sin_cos();
        let rise = 9.0 * slope * R;
        let points = [[-9.0 * R, rise], [0.0, 0.0], [9.0 * R, rise]];
        let lift = R - overlap * R;
        let disk = json!([{"x_m": -R + lift * sin, "y_m": slope * R + lift * cos, "radius_m": R,
            "vx_m_per_s": 0.1 * cos, "vy_m_per_s": -0.1 * sin}]);
        let weight = mass(R) * G;
        let law = json!({"kind": "signorini", "contact_stiffness_pa": weight * cos / (overlap * R * 1e-3)});
        let over = json!({"gravity_m_per_s2": [0.0, -G],
            "time": {"step_s": 2e-6, "pressure_pa": 1.0, "theta": 0.5}});
        let mut dem = on_surface(law, disk, json!({"points_m": points}), over);
        let (mut found, mut worst, mut in_both) = (0.0, 0.0f64, false);
        for step in 0..10_500 {
            let report = march(&mut dem, step, 1);
            found = report.energy("detection") / (0.5 * weight * overlap * R);
            worst = worst.max(found.abs());
            in_both |= report.signal("contacts") == 2.0;
        }
        assert!(
            dem.state().centres[0][0] > 0.9 * R && in_both,
            "{slope}: it rolls through"
        );
        close("detection after the valley", found, 0.0, 0.03);
        assert!(slope > 1e-3 || worst < 5e-3, "{worst} on the way");
    }
}

#[test]
fn grains_behind_a_surface_are_counted() {
    let disk = |y: f64| json!([{"x_m": 0.0, "y_m": y, "radius_m": R}]);
    let surface = json!({"half_width_m": 5.0 * R, "spacing_m": R});
    for (y, inside) in [(R, 0.0), (-1.5 * R, 1.0)] {
        let law = json!({"kind": "signorini"});
        let mut dem = on_surface(law, disk(y), surface.clone(), json!({}));
        march(&mut dem, 0, 1);
        let outcome = dem.finish().expect("it ends");
        assert_eq!(outcome.results["inside_grains"], inside);
        let suspect = outcome
            .findings
            .iter()
            .any(|finding| finding.code == "inside");
        assert_eq!(suspect, inside > 0.0);
    }
}

#[test]
fn a_rough_surface_has_its_height_and_correlation_length() {
    let line = |spacing: f64, seed: u64| {
        let surface = json!({"half_width_m": 1000.0 * R, "spacing_m": spacing,
            "roughness": {"rms_m": 0.1 * R, "correlation_m": 2.0 * R, "seed": seed}});
        let disk = json!([{"x_m": 0.0, "y_m": 3.0 * R, "radius_m": R}]);
        let dem = on_surface(json!({"kind": "signorini"}), disk, surface, json!({}));
        dem.state().surface.clone()
    };
    let (coarse, fine) = (line(R, 4), line(0.5 * R, 4));
    for (k, point) in coarse.iter().enumerate() {
        close(
            "the same place on a finer line",
            point[1],
            fine[2 * k][1],
            1e-12,
        );
    }
    // 500 correlation lengths per seed: the means are known to 1/sqrt(500), and the 256 waves add a little.
    let of = |lag: usize| {
        let seeds = 1..=8u64;
        let means = seeds.clone().map(|seed| {
            let line = line(R, seed);
            let products = line.windows(lag + 1).map(|pair| pair[0][1] * pair[lag][1]);
            products.sum::<f64>() / (line.len() - lag) as f64
        });
        means.sum::<f64>() / 8.0
    };
    let square = (0.1 * R).powi(2);
    close("mean square", of(0), square, 0.05 * square);
    close(
        "at the correlation length",
        of(2),
        square * (-1f64).exp(),
        0.05 * square,
    );
    close(
        "at twice the correlation length",
        of(4),
        square * (-4f64).exp(),
        0.05 * square,
    );
}

#[test]
fn impossible_surfaces_are_refused_by_name() {
    let refused = |surface: Value| {
        let disk = json!([{"x_m": 0.0, "y_m": R, "radius_m": R}]);
        let sample = json!({"kind": "disks", "disks": disk, "surface": surface});
        refusal(&scene(json!({"kind": "signorini"}), H, sample, json!({})))
    };
    for (surface, key) in [
        (json!({}), "sample.surface.half_width_m"),
        (json!({"half_width_m": -1.0}), "sample.surface.half_width_m"),
        (
            json!({"half_width_m": 1.0, "spacing_m": 0.0}),
            "sample.surface.spacing_m",
        ),
        (
            json!({"half_width_m": 1.0, "spacing_m": 1e-9}),
            "sample.surface.spacing_m",
        ),
        (
            json!({"half_width_m": 1.0, "friction": -0.1}),
            "sample.surface.friction",
        ),
        (
            json!({"half_width_m": 0.1, "crown_radius_m": 0.05}),
            "sample.surface.crown_radius_m",
        ),
        (json!({"points_m": [[0.0, 0.0]]}), "sample.surface.points_m"),
        (
            json!({"points_m": [[0.0, 0.0], [0.0, 1.0]]}),
            "sample.surface.points_m",
        ),
        (
            json!({"points_m": [[0.0, 0.0], [1.0, 0.0]], "spacing_m": 0.1}),
            "sample.surface.points_m",
        ),
        (
            json!({"half_width_m": 0.1, "roughness": {"rms_m": 1e-6, "correlation_m": 1e-4}}),
            "sample.surface.roughness.correlation_m",
        ),
    ] {
        let message = refused(surface.clone());
        assert!(message.contains(key), "{surface}: {message}");
    }
}

/// Two grains of 0.1 mm, 4 mm apart, below a wheel of 5 mm: between them it sinks through the surface.
#[test]
fn a_wheel_that_goes_into_the_surface_gives_a_finding() {
    let disk = |x: f64| json!({"x_m": x, "y_m": 1e-4, "radius_m": 1e-4});
    let sink = |x: f64| {
        let sample = json!({"kind": "disks", "disks": [disk(-x), disk(x)], "surface": {"half_width_m": 8e-3, "spacing_m": 5e-4}});
        let law = json!({"kind": "coulomb", "friction": 0.3, "contact_stiffness_pa": 1e9, "tangential_stiffness_ratio": 0.5, "damping": 0.3});
        let wheel = json!({"load_n": 1.0, "mass_kg": 1e-3, "ramp_s": 0.01, "hold_s": 0.002, "radius_m": 5e-3});
        let mut config = scene(law, 1e-6, sample, json!({"wheel": wheel}));
        config["solver"]["tolerance"] = json!(1e-8);
        let mut dem = build(&config);
        march(&mut dem, 0, 12_000);
        let findings = dem.finish().expect("it ends").findings;
        let found = findings.into_iter().find(|f| f.code == "wheel_inside");
        found.map(|f| (f.value, f.suspect))
    };
    let (value, suspect) = sink(2e-3).expect("it goes in");
    assert!(suspect && (1.9..2.3).contains(&value), "{value}");
    assert_eq!(sink(2e-4), None);
}
