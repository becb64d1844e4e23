//! Results that describe the arrangement of contacts.
//!
//! ```text
//!      (2)          a pyramid of three disks on a floor, between side walls, under gravity
//!   |(0) (1)|
//!   +-------+
//! ```
//!
//! Exact: the upper disk pushes each lower one with N = m g / sqrt(3) at 60 degrees to the floor; a floor contact carries
//! 3/2 m g, a side wall N / 2. Contacts per disk: 2, 3, 3. The fabric of contacts at 60, 120 (once each), 90 (twice) and 0
//! degrees (twice) is the mean of cos^2, sin cos and sin^2. A rattler is in the air above. Tolerance: the true residual.

use protocol::Node;
use serde_json::json;

use crate::dem_support::{build, close, march, mass, scene};

const R: f64 = 1e-3;
const G: f64 = 9.81;

#[test]
fn the_structure_of_a_pyramid_with_a_rattler_is_exact() {
    // A gap of 1e-5 keeps the lower disks from touching each other.
    let s = R * (1.0 + 1e-5);
    let height = (4.0 * R * R - s * s).sqrt();
    let disk = |x: f64, y: f64| json!({"x_m": x, "y_m": y, "radius_m": R});
    let sample = json!({
        "kind": "disks",
        "disks": [disk(-s, R), disk(s, R), disk(0.0, R + height), disk(0.0, 40.0 * R)],
        "walls": [
            {"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0},
            {"x_m": -s - R, "y_m": 0.0, "nx": 1.0, "ny": 0.0},
            {"x_m": s + R, "y_m": 0.0, "nx": -1.0, "ny": 0.0},
        ],
    });
    let gravity = json!({"gravity_m_per_s2": [0.0, -G]});
    let mut dem = build(&scene(json!({"kind": "signorini"}), 1e-5, sample, gravity));
    march(&mut dem, 0, 50);
    let results = dem.finish().expect("it finishes").results;
    let result = |name: &str, expected: f64, tolerance: f64| {
        close(name, results[name], expected, tolerance);
    };
    result("contacts", 6.0, 0.0);
    result("coordination", 8.0 / 3.0, 1e-15);
    result("coordination_with_rattlers", 2.0, 1e-15);
    result("rattlers_share", 0.25, 1e-15);
    // xx: (1/4 + 1/4 + 0 + 0 + 1 + 1) / 6, yy: (3/4 + 3/4 + 1 + 1) / 6; the gap changes them by 1e-5.
    result("fabric_anisotropy", 3.5 / 6.0 - 2.5 / 6.0, 1e-4);
    close(
        "direction",
        results["fabric_direction_deg"].abs(),
        90.0,
        1e-6,
    );
    let weight = mass(R) * G;
    let (slanted, side) = (1.0 / 3f64.sqrt(), 0.5 / 3f64.sqrt());
    let mean = (2.0 * slanted + 2.0 * side + 2.0 * 1.5) / 6.0;
    result("contact_force_mean_n", mean * weight, 1e-4 * weight);
    result("contact_force_max_over_mean", 1.5 / mean, 1e-4);
    let squares = [slanted, side, 1.5].map(|f| (f - mean).powi(2));
    let deviation = (squares.iter().sum::<f64>() / 3.0).sqrt();
    result("contact_force_deviation_over_mean", deviation / mean, 1e-4);
    result("contact_force_above_mean_share", 1.0 / 3.0, 1e-15);
}

#[test]
fn a_scene_without_contacts_has_no_structure() {
    let sample = json!({"kind": "disks", "disks": [{"x_m": 0.0, "y_m": 0.0, "radius_m": R}]});
    let mut dem = build(&scene(
        json!({"kind": "signorini"}),
        1e-5,
        sample,
        json!({}),
    ));
    march(&mut dem, 0, 1);
    let results = dem.finish().expect("it finishes").results;
    assert_eq!(results["coordination"], 0.0);
    assert_eq!(results["rattlers_share"], 1.0);
    assert!(results.values().all(|x| x.is_finite()), "{results:?}");
}
