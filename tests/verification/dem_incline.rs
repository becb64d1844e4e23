//! A disk on a slope sticks and rolls, or slides and turns.
//!
//! ```text
//!        O
//!      /        a = 2/3 g sin(theta), alpha R = a                      if mu >= tan(theta) / 3  (rolls)
//!    /          a = g (sin(theta) - mu cos(theta)), alpha R = 2 mu g cos(theta)      otherwise  (slides)
//!  / theta
//! ```
//!
//! Reference: incline_disk.csv of the project's own tables (closed form), regime, a/g and alpha R/g.
//! Implicit Euler is exact for a constant acceleration; the tolerance is rounding over 100 steps.

use serde_json::json;

use crate::dem_support::{build, close, march, scene};

// The table's sine of 45 degrees is no attempt at a constant.
#[allow(clippy::approx_constant)]
/// theta (degrees), mu, a/g, alpha R/g from incline_disk.csv.
const CASES: [(f64, f64, f64, f64); 35] = [
    (5.0, 0.0, 0.0871557427, 0.0000000000),
    (5.0, 0.05, 0.0581038285, 0.0581038285),
    (5.0, 0.1, 0.0581038285, 0.0581038285),
    (5.0, 0.19, 0.0581038285, 0.0581038285),
    (5.0, 0.2, 0.0581038285, 0.0581038285),
    (5.0, 0.3, 0.0581038285, 0.0581038285),
    (5.0, 0.6, 0.0581038285, 0.0581038285),
    (15.0, 0.0, 0.2588190451, 0.0000000000),
    (15.0, 0.05, 0.2105227538, 0.0965925826),
    (15.0, 0.1, 0.1725460301, 0.1725460301),
    (15.0, 0.19, 0.1725460301, 0.1725460301),
    (15.0, 0.2, 0.1725460301, 0.1725460301),
    (15.0, 0.3, 0.1725460301, 0.1725460301),
    (15.0, 0.6, 0.1725460301, 0.1725460301),
    (30.0, 0.0, 0.5000000000, 0.0000000000),
    (30.0, 0.05, 0.4566987298, 0.0866025404),
    (30.0, 0.1, 0.4133974596, 0.1732050808),
    (30.0, 0.19, 0.3354551733, 0.3290896534),
    (30.0, 0.2, 0.3333333333, 0.3333333333),
    (30.0, 0.3, 0.3333333333, 0.3333333333),
    (30.0, 0.6, 0.3333333333, 0.3333333333),
    (45.0, 0.0, 0.7071067812, 0.0000000000),
    (45.0, 0.05, 0.6717514421, 0.0707106781),
    (45.0, 0.1, 0.6363961031, 0.1414213562),
    (45.0, 0.19, 0.5727564928, 0.2687005769),
    (45.0, 0.2, 0.5656854249, 0.2828427125),
    (45.0, 0.3, 0.4949747468, 0.4242640687),
    (45.0, 0.6, 0.4714045208, 0.4714045208),
    (60.0, 0.0, 0.8660254038, 0.0000000000),
    (60.0, 0.05, 0.8410254038, 0.0500000000),
    (60.0, 0.1, 0.8160254038, 0.1000000000),
    (60.0, 0.19, 0.7710254038, 0.1900000000),
    (60.0, 0.2, 0.7660254038, 0.2000000000),
    (60.0, 0.3, 0.7160254038, 0.3000000000),
    (60.0, 0.6, 0.5773502692, 0.5773502692),
];
const G: f64 = 9.81;
const STEP: f64 = 1e-4;
const STEPS: u32 = 100;
const RADIUS: f64 = 1e-3;

#[test]
fn a_disk_on_a_slope_rolls_or_slides_as_the_table_says() {
    for (theta, mu, acceleration, turning) in CASES {
        let (sin, cos) = theta.to_radians().sin_cos();
        let sample = json!({
            "kind": "disks",
            "disks": [{"x_m": -sin * RADIUS, "y_m": cos * RADIUS, "radius_m": RADIUS}],
            "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": -sin, "ny": cos}],
        });
        let law = json!({"kind": "coulomb", "friction": mu});
        let overrides = json!({"gravity_m_per_s2": [0.0, -G]});
        let mut dem = build(&scene(law, STEP, sample, overrides));
        march(&mut dem, 0, STEPS);
        let [vx, vy, spin] = dem.state().velocities[0];
        let gained = G * STEP * f64::from(STEPS);
        let name = |what: &str| format!("{what} at {theta} degrees, friction {mu}");
        // Downhill is -(cos, sin); a disk that rolls that way, to the left, turns anticlockwise.
        close(
            &name("a/g"),
            -(vx * cos + vy * sin) / gained,
            acceleration,
            1e-9,
        );
        close(&name("alpha R/g"), spin / gained, turning, 1e-9);
    }
}
