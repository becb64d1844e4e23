//! `profile.csv`: the traction of the interface on the continuum's surface.

use std::fmt::Write;

use kit::boxes::peak_of_means;
use protocol::Surface;
use serde::{Deserialize, Serialize};

use crate::run_dir::RunDir;
use scenario::error::{Error, Result};
use scheme::coupling::Coupling;
use scheme::group::Patch;

/// A node on the surface of the continuum.
pub(crate) struct Place {
    /// Its number in the group.
    pub node: usize,
    /// Unit vector along the undeformed surface, towards larger x.
    tangent: [f64; 2],
    /// 1 where the outward normal is on the left of the tangent, -1 where it is on the right.
    side: f64,
}

impl Place {
    /// The part of a force or traction that presses on the surface.
    pub fn pressing(&self, [x, y]: [f64; 2]) -> f64 {
        -self.side * (self.tangent[0] * y - self.tangent[1] * x)
    }

    /// The part along the surface.
    pub fn shearing(&self, [x, y]: [f64; 2]) -> f64 {
        self.tangent[0] * x + self.tangent[1] * y
    }
}

/// The nodes of an interface in their order along the surface, from smaller to larger x.
pub(crate) fn places(nodes: &Surface, patch: &Patch) -> Vec<Place> {
    let side = if patch.outward[1] < 0.0 { -1.0 } else { 1.0 };
    let mean = [side * patch.outward[1], -side * patch.outward[0]];
    let at = |node: usize| [nodes.x_m[node], nodes.y_m[node]];
    let along = |node: usize| mean[0] * at(node)[0] + mean[1] * at(node)[1];
    let mut order: Vec<usize> = patch.nodes.clone().collect();
    order.sort_by(|a, b| along(*a).total_cmp(&along(*b)));
    let last = order.len().saturating_sub(1);
    let tangent = |k: usize| {
        let [from, to] = [k.saturating_sub(1), (k + 1).min(last)].map(|k| at(order[k]));
        let along = [to[0] - from[0], to[1] - from[1]];
        match along[0].hypot(along[1]) {
            length if length > 0.0 => along.map(|part| part / length),
            _ => mean,
        }
    };
    let place = |k: usize| Place {
        node: order[k],
        tangent: tangent(k),
        side,
    };
    (0..order.len()).map(place).collect()
}

/// Traction at the exchanged nodes, sorted by position.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct InterfaceTraction {
    /// Positions (m).
    pub x_m: Vec<f64>,
    /// Force along the normal of the undeformed surface (N), compression positive.
    pub normal_n: Vec<f64>,
    /// Force along the surface (N), positive towards larger x.
    pub shear_n: Vec<f64>,
    /// Area of each node (m2).
    pub area_m2: Vec<f64>,
    thickness_m: f64,
    period_m: Option<f64>,
}

impl InterfaceTraction {
    /// The traction of an interface in the last accepted window of its group.
    pub fn of(coupling: &Coupling, patch: &Patch, thickness_m: f64) -> InterfaceTraction {
        let (nodes, force) = (&coupling.group().nodes, &coupling.state.lambda);
        let places = places(nodes, patch);
        let take = |value: &dyn Fn(&Place) -> f64| places.iter().map(value).collect();
        let force = |place: &Place| [0, 1].map(|k| force[2 * place.node + k]);
        InterfaceTraction {
            x_m: take(&|place| nodes.x_m[place.node]),
            normal_n: take(&|place| place.pressing(force(place))),
            shear_n: take(&|place| place.shearing(force(place))),
            area_m2: take(&|place| nodes.length_m[place.node] * thickness_m),
            thickness_m,
            period_m: patch.period_m,
        }
    }

    /// The text of `profile.csv`: x_m, pressure_pa, shear_pa, status.
    pub fn csv(&self) -> String {
        let mut text = String::from("x_m,pressure_pa,shear_pa,status\n");
        for i in 0..self.x_m.len() {
            let loaded = self.normal_n[i] != 0.0 || self.shear_n[i] != 0.0;
            let status = if loaded { "tied" } else { "open" };
            let (x, area) = (self.x_m[i], self.area_m2[i]);
            let (pressure, shear) = (self.normal_n[i] / area, self.shear_n[i] / area);
            let _ = writeln!(text, "{x:e},{pressure:e},{shear:e},{status}");
        }
        text
    }

    /// The largest mean pressure (Pa) over boxes of `width_m`, see [`peak_of_means`]; the force of a node acts on its
    /// own segment. `None` if the surface is too short for such a box.
    pub fn peak_of_means(&self, width_m: f64) -> Option<f64> {
        let nodes = self.x_m.iter().zip(&self.area_m2).zip(&self.normal_n);
        let pieces = nodes.map(|((x, area), force)| {
            let half = 0.5 * area / self.thickness_m;
            ([x - half, x + half], *force)
        });
        let peak = peak_of_means(pieces, width_m, self.period_m)?;
        Some(peak / self.thickness_m)
    }

    /// Distance (m) from the middle of the node with which the nodes nearest to the middle carry `share` of the normal
    /// force; the segment of this node reaches half a spacing further. The middle is x = 0, the centre of wheels and crowns, or the middle of the nodes if all of them are on one side of
    /// it.
    pub fn half_width(&self, share: f64) -> f64 {
        let middle = match (self.x_m.first(), self.x_m.last()) {
            (Some(first), Some(last)) if *first > 0.0 || *last < 0.0 => 0.5 * (first + last),
            _ => 0.0,
        };
        let distance = |node: usize| (self.x_m[node] - middle).abs();
        let mut order: Vec<usize> = (0..self.x_m.len()).collect();
        order.sort_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        let total: f64 = self.normal_n.iter().sum();
        let mut carried = 0.0;
        for index in order {
            carried += self.normal_n[index];
            if carried >= share * total {
                return distance(index);
            }
        }
        0.0
    }
}

/// Copies the traction that a solver running alone wrote at the end of this phase, if any, to the run's `profile.csv`.
pub fn adopt(rundir: &RunDir, phase: &str) -> Result<()> {
    let fields = rundir.fields();
    let entries = std::fs::read_dir(&fields).map_err(Error::input(fields.display()))?;
    let ending = format!("-{phase}-profile.csv");
    let mut paths = entries.flatten().map(|entry| entry.path());
    let written = paths.find(|path| path.to_string_lossy().ends_with(&ending));
    let Some(path) = written else { return Ok(()) };
    let text = std::fs::read_to_string(&path).map_err(Error::input(path.display()))?;
    rundir.write("profile.csv", &text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_share_nodes_that_lie_across_their_edges() {
        let uniform = InterfaceTraction {
            x_m: vec![-0.8e-3, -0.4e-3, 0.0, 0.4e-3, 0.8e-3],
            normal_n: vec![40.0; 5],
            shear_n: vec![0.0; 5],
            area_m2: vec![0.4e-6; 5],
            thickness_m: 1e-3,
            period_m: None,
        };
        // 40 N on 0.4 mm2 is 100 MPa, for any boxes.
        let peak = uniform.peak_of_means(1e-3).expect("a box in the middle");
        assert!((peak / 1e8 - 1.0).abs() < 1e-12);
        // The surface is 2 mm long; over 3 mm the mean would be two thirds of this.
        assert_eq!(uniform.peak_of_means(3e-3), None);
        assert_eq!(uniform.half_width(0.98), 0.8e-3);
        let beside = InterfaceTraction {
            x_m: uniform.x_m.iter().map(|x| x - 4e-3).collect(),
            ..uniform
        };
        assert!((beside.half_width(0.98) - 0.8e-3).abs() < 1e-15);
    }

    /// 200 MPa over the 0.4 mm at both ends of 2 mm give 80 N + 80 N in the box of 1 mm across the seam, in addition to
    /// 20 N.
    #[test]
    fn a_box_across_the_seam_of_a_periodic_line_counts_as_a_whole() {
        let at = |period_m| InterfaceTraction {
            x_m: vec![-0.8e-3, -0.4e-3, 0.0, 0.4e-3, 0.8e-3],
            normal_n: vec![80.0, 40.0, 40.0, 40.0, 80.0],
            shear_n: vec![0.0; 5],
            area_m2: vec![0.4e-6; 5],
            thickness_m: 1e-3,
            period_m,
        };
        let peaks = [None, Some(2e-3)].map(|period_m| at(period_m).peak_of_means(1e-3));
        let peaks = peaks.map(|peak| peak.expect("a whole box"));
        assert!((peaks[0] / 1e8 - 1.0).abs() < 1e-12, "{peaks:?}");
        assert!((peaks[1] / 1.8e8 - 1.0).abs() < 1e-12, "{peaks:?}");
    }

    /// 5 N press on each node of a face under any angle, and 2 N shear it towards larger x; an upright face is sheared downwards.
    #[test]
    fn pressure_and_shear_follow_the_normal_of_the_surface() {
        for (degrees, side) in [
            (0.0, 1.0),
            (45.0, 1.0),
            (-60.0, 1.0),
            (30.0, -1.0),
            (-90.0, 1.0),
        ] {
            let [c, s] = [f64::cos, f64::sin].map(|of| of(f64::to_radians(degrees)));
            let nodes = Surface {
                x_m: (0..4).map(|k| c * f64::from(k)).collect(),
                y_m: (0..4).map(|k| s * f64::from(k)).collect(),
                ..Surface::default()
            };
            let patch = Patch {
                index: 0,
                name: "face".into(),
                force_driven: 0,
                motion_driven: 0,
                nodes: 0..4,
                points: 0..0,
                outward_y: side,
                outward: [-side * s, side * c],
                offset: Default::default(),
                period_m: None,
                spacing_m: 1.0,
                tolerance_rel: 1.0,
                energy_defect_max_rel: None,
            };
            let force = [0, 1].map(|k| -5.0 * patch.outward[k] + 2.0 * [c, s][k]);
            let places = places(&nodes, &patch);
            assert!(places.iter().map(|place| place.node).eq(0..4), "{degrees}");
            for place in places {
                assert!((place.pressing(force) - 5.0).abs() < 1e-14, "{degrees}");
                assert!((place.shearing(force) - 2.0).abs() < 1e-14, "{degrees}");
            }
        }
    }
}
