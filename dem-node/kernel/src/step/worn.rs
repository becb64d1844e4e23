//! The wear of bare surfaces: work of friction on each segment, and depth of each point, see [`super::detachment`].

use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;

kit::results! {
    /// # Flows of third body
    /// - `detached_kg`: Steel that has come off bare surfaces, as grains or not yet.
    /// - `detached_waiting_kg`: Part of `detached_kg` that is not yet a whole grain, or has no gap to begin in.
    /// - `detached_depth_max_m`: Largest depth that has come off.
    /// - `surface_friction_j`: Work of friction on bare surfaces.
}

/// The wear of the bare surfaces.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Worn {
    /// Work of friction on each segment since its last layer (J).
    pub(super) work: Vec<f64>,
    /// Displacement of each point by the steel that has come off (m).
    pub(super) offsets: Vec<[f64; 2]>,
    /// Scaled mass that has come off (kg).
    pub mass: f64,
    /// Work of all friction on segments, and the part of it that would have taken layers beyond the limit (J).
    pub done: [f64; 2],
    /// The segment that lost the last layer.
    pub(super) last: u32,
}

impl Worn {
    /// A new surface.
    pub fn new(bodies: &Bodies) -> Worn {
        Worn {
            work: vec![0.0; bodies.surface.bare()],
            offsets: vec![[0.0; 2]; bodies.surface.points.len()],
            ..Worn::default()
        }
    }

    /// Adds the work of friction (J) on a segment.
    pub fn rub(&mut self, segment: usize, work: f64) {
        if let Some(sum) = self.work.get_mut(segment) {
            *sum += work;
            self.done[0] += work;
        }
    }

    /// True for a surface that may lose steel.
    pub fn detaches(&self) -> bool {
        !self.work.is_empty()
    }

    /// Moves points from their positions on the body by the worn depth (m).
    pub fn lower(&self, points: &mut [[f64; 2]]) {
        for (point, [x, y]) in points.iter_mut().zip(&self.offsets) {
            *point = [point[0] + x, point[1] + y];
        }
    }

    /// Depth at a point (m), 0 at points that glued disks carry.
    pub fn depth(&self, point: usize) -> f64 {
        self.offsets.get(point).map_or(0.0, |[x, y]| x.hypot(*y))
    }

    /// Results, `real` being the unscaled mass over the scaled mass: the mass that has come off and its part that is no grain yet (kg), the largest
    /// depth (m), and the work of friction on bare surfaces (J).
    pub fn results(&self, delivered: f64, real: f64) -> Vec<(&'static str, f64)> {
        let depths = (0..self.offsets.len()).map(|point| self.depth(point));
        vec![
            ("detached_kg", real * self.mass),
            ("detached_waiting_kg", real * (self.mass - delivered)),
            ("detached_depth_max_m", depths.fold(0.0, f64::max)),
            ("surface_friction_j", self.done[0]),
        ]
    }

    /// All numbers that can change a later bit.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let rest = [self.mass, self.done[0], self.done[1], f64::from(self.last)];
        let offsets = self.offsets.as_flattened();
        self.work.iter().chain(offsets).copied().chain(rest)
    }
}
