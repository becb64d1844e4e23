//! Three disks as a pyramid: it stands on friction alone.
//!
//! ```text
//!      O        the contacts between disks lie 60 degrees above the horizontal; a lower disk that may roll balances
//!     O O       moments only if the friction at both of its contacts is equal: mu >= tan(15 degrees) = 0.2679
//!    =====
//! ```
//!
//! Reference: pyramid.csv of the project's own tables, min_mu_disk_disk = 0.267949192431 (the lower disks touch each
//! other without force). Tested 1 % above and below: the step cannot resolve less, since both motions start from rest.

use serde_json::json;

use crate::dem_support::{build, march, scene};

const MIN_FRICTION: f64 = 0.267949192431;
const R: f64 = 1e-3;

/// Sinking of the top disk in 5 ms (m).
fn sinking(friction: f64) -> f64 {
    let top = R + 3f64.sqrt() * R;
    let sample = json!({
        "kind": "disks",
        "disks": [
            {"x_m": -R, "y_m": R, "radius_m": R},
            {"x_m": R, "y_m": R, "radius_m": R},
            {"x_m": 0.0, "y_m": top, "radius_m": R},
        ],
        "walls": [{"x_m": 0.0, "y_m": 0.0, "nx": 0.0, "ny": 1.0}],
    });
    let law = json!({"kind": "coulomb", "friction": friction});
    let overrides = json!({"gravity_m_per_s2": [0.0, -9.81]});
    let mut dem = build(&scene(law, 1e-4, sample, overrides));
    march(&mut dem, 0, 50);
    top - dem.state().centres[2][1]
}

#[test]
fn a_pyramid_stands_above_the_least_friction_and_falls_below_it() {
    let (held, fallen) = (sinking(1.01 * MIN_FRICTION), sinking(0.99 * MIN_FRICTION));
    assert!(held < 1e-9, "it should stand, and sinks {held:e} m");
    assert!(fallen > 1e-7, "it should fall, and sinks {fallen:e} m only");
}
