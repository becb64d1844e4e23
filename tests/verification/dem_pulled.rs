//! Pulling a random bonded layer apart, compared with the strength in its results.
//!
//! `layer_tension_pa` is the mean-field strength of a bonded bed (Rumpf 1958, in the plane): all bonds of a section carry their strength at
//! once. In a random layer the weakest section tears first, bond by bond. Layers of 8 mm x 1 mm, seeds 1 to 3, tear at 0.65 to 0.71 of the
//! strength of the bonds between the held ends, which is 0.55 to 0.62 of the whole layer's strength; pulling three times as slowly changes
//! this by 0.5 %. The band allows three times the scatter of these seeds.
//!
//! Rows of grains at the bottom and at the top are rigid clusters that loads pull apart; they do not move sideways.

use dem_node::config::layer::LayerConfig;
use dem_node::config::radii::RadiusLaw;
use dem_node::config::surface::SurfaceConfig;
use dem_node::measure::structure::bonded_strength;
use dem_node::sample::layer;
use dem_node::sample::types::Sample;
use serde_json::{Value, json};

use crate::dem_support::{THICKNESS, build, march, scene, with};

const STIFFNESS: f64 = 2.255e11;
/// Half-width of the layer, and its height (m).
const SIZE: [f64; 2] = [4e-3, 1e-3];
/// Height of the held ends (m): the lower one includes the glued row, which has few bonds to the next row.
const END: f64 = 0.12e-3;
/// Rise of the stress that pulls (Pa/s).
const RATE: f64 = 1.7e13;
const STEP: f64 = 5e-9;
/// Opening at which the layer is torn (m); its load is largest at about 0.6 um.
const TORN: f64 = 4e-6;

fn random_layer(seed: u64) -> Sample {
    let recipe = LayerConfig {
        glued: true,
        surface: SurfaceConfig::default(),
        thickness_m: SIZE[1],
        x_m: 0.0,
        half_width_m: SIZE[0],
        half_width_load_n: None,
        crown_radius_m: 1e3,
        radius_min_m: 0.05e-3,
        radius_max_m: 0.1e-3,
        law: RadiusLaw::SurfaceUniform,
        power: None,
        seed: None,
        lid: false,
        lid_crown_radius_m: 0.0,
        bed_extra_m: 0.7e-3,
        press_pa: vec![300e6, 50e6],
        periodic_x_m: None,
    };
    layer::prepare(&recipe, Some(STIFFNESS), false, seed).expect("the recipe works")
}

/// The layer as listed disks: the disks near its lower and its upper end form a cluster each.
fn listed(sample: &Sample) -> Vec<Value> {
    let disks = || sample.glued.iter().chain(&sample.free);
    let top = disks()
        .map(|disk| disk.centre[1] + disk.radius)
        .fold(0.0, f64::max);
    let place = |disk: &dem_kernel::bodies::disk::Disk| {
        let [x, y] = disk.centre;
        let plain = json!({"x_m": x, "y_m": y, "radius_m": disk.radius});
        let cluster = match (y < END, y > top - END) {
            (true, _) => json!({"cluster": "lower"}),
            (_, true) => json!({"cluster": "upper"}),
            _ => json!({}),
        };
        with(plain, &cluster)
    };
    disks().map(place).collect()
}

/// Stress at which a layer tears, over the strength computed from its bonds.
fn torn_share(seed: u64) -> f64 {
    let sample = random_layer(seed);
    let area = 2.0 * SIZE[0] * THICKNESS;
    let drive = |sign: f64| {
        json!({
            "velocity_m_per_s": [0.0, "free"], "damping_n_s_per_m": 1000.0,
            "load_table": [[0.0, 0.0], [1e-3, sign * RATE * area * 1e-3]],
        })
    };
    let law = json!({
        "kind": "cohesion", "friction": 0.3, "damping": 0.4, "contact_stiffness_pa": STIFFNESS,
        "tangential_stiffness_ratio": 0.5, "cn_pa_per_m": 6.4e15, "ct_pa_per_m": 2.56e15, "w_j_per_m2": 1406.25,
        "b_pa_m_s": 0.0, "p": 1.0, "h_prime": "one", "alert_m": 8e-6, "bonds_min": 2,
    });
    let clusters = json!([
        {"name": "lower", "drive": drive(-1.0)},
        {"name": "upper", "drive": drive(1.0)},
    ]);
    let disks = json!({"kind": "disks", "disks": listed(&sample), "clusters": clusters});
    let solver =
        json!({"kind": "nsgs", "tolerance": 1e-4, "max_iterations": 5000, "min_iterations": 2});
    let mut dem = build(&scene(law, STEP, disks, json!({"solver": solver})));
    let strength = bonded_strength(
        dem.bodies(),
        &dem.state().bonds,
        sample.solid_fraction,
        THICKNESS,
    );
    let [tension, _] = strength.expect("it is bonded");
    let (mut start, mut steps) = (None, 0);
    loop {
        let report = march(&mut dem, steps, 100);
        steps += 100;
        let apart = report.signal("upper_y_m") - report.signal("lower_y_m");
        if apart - *start.get_or_insert(apart) > TORN {
            return RATE * steps as f64 * STEP / tension;
        }
        assert!(steps < 40_000, "it bears more than 3 GPa");
    }
}

#[test]
fn a_random_layer_tears_below_its_mean_field_strength() {
    for seed in [1, 2, 3] {
        let share = torn_share(seed);
        println!("seed {seed}: torn at {share:.3} of layer_tension_pa");
        assert!((0.55..0.8).contains(&share), "seed {seed}: {share}");
    }
}
