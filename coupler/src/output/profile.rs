//! `profile.csv`: the traction of the interface on the continuum's surface.

use std::fmt::Write;

use crate::couple::scheme::Coupling;

/// Traction at the exchanged nodes, sorted by place.
pub struct Traction {
    /// Places (m).
    pub x_m: Vec<f64>,
    /// Normal force (N), compression positive.
    pub normal_n: Vec<f64>,
    /// Tangential force (N).
    pub shear_n: Vec<f64>,
    /// Area that each node stands for (m2).
    pub area_m2: Vec<f64>,
    thickness_m: f64,
}

impl Traction {
    /// The traction of the last window that stands.
    pub fn of(coupling: &Coupling, thickness_m: f64) -> Traction {
        let nodes = &coupling.joined().nodes;
        let mut order: Vec<usize> = (0..nodes.len()).collect();
        order.sort_by(|a, b| nodes.x_m[*a].total_cmp(&nodes.x_m[*b]));
        let take = |value: &dyn Fn(usize) -> f64| order.iter().map(|i| value(*i)).collect();
        Traction {
            x_m: take(&|i| nodes.x_m[i]),
            normal_n: take(&|i| -coupling.lambda[2 * i + 1]),
            shear_n: take(&|i| coupling.lambda[2 * i]),
            area_m2: take(&|i| nodes.length_m[i] * thickness_m),
            thickness_m,
        }
    }

    /// The largest mean pressure (Pa) over boxes of `width_m` centred at multiples of it. Single nodes carry
    /// single grains, whose pressures say little.
    pub fn peak_of_means(&self, width_m: f64) -> f64 {
        let mut boxes = std::collections::BTreeMap::new();
        for (x, force) in self.x_m.iter().zip(&self.normal_n) {
            *boxes.entry((x / width_m).round() as i64).or_insert(0.0) += force;
        }
        boxes.values().fold(0.0, |peak: f64, force| {
            peak.max(force / (width_m * self.thickness_m))
        })
    }

    /// Half of the shortest distance that is symmetric about x = 0 and carries `share` of the normal force (m).
    pub fn half_width(&self, share: f64) -> f64 {
        let mut order: Vec<usize> = (0..self.x_m.len()).collect();
        order.sort_by(|a, b| self.x_m[*a].abs().total_cmp(&self.x_m[*b].abs()));
        let total: f64 = self.normal_n.iter().sum();
        let mut carried = 0.0;
        for index in order {
            carried += self.normal_n[index];
            if carried >= share * total {
                return self.x_m[index].abs();
            }
        }
        0.0
    }
}

/// The file's text: x_m, pressure_pa, shear_pa, status.
pub fn csv(coupling: &Coupling, thickness_m: f64) -> String {
    let traction = Traction::of(coupling, thickness_m);
    let mut text = String::from("x_m,pressure_pa,shear_pa,status\n");
    for i in 0..traction.x_m.len() {
        let loaded = traction.normal_n[i] != 0.0 || traction.shear_n[i] != 0.0;
        let _ = writeln!(
            text,
            "{:e},{:e},{:e},{}",
            traction.x_m[i],
            traction.normal_n[i] / traction.area_m2[i],
            traction.shear_n[i] / traction.area_m2[i],
            if loaded { "tied" } else { "open" }
        );
    }
    text
}
