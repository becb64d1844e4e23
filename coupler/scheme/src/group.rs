//! Interfaces that are solved together: all that are connected through a participant.
//!
//! A participant on several interfaces exchanges the points of all of them at once, one set after the other in the
//! order of the scenario. The compliance of the group is block-diagonal, one block a force-driven participant; a motion-driven
//! one with several glued rows stands on all of its continua, so that one contact solve a window sees every row. A set of a
//! continuum may carry several layers, each on nodes of its own, which are exchanged as parts of it.

use std::ops::Range;

use protocol::{Surface, Window};

use super::clock::Clock;
use super::mapping::Mapping;

/// Connected interfaces, ready for their first window.
#[derive(Clone, Debug)]
pub struct Group {
    /// The interfaces, in the order of the scenario.
    pub patches: Vec<Patch>,
    /// Participants that take forces and answer motion, in the order in which the interfaces name them: the continua.
    pub force_driven: Vec<Side>,
    /// Participants that take the motion of their boundary and answer force, in the same order: the layers.
    pub motion_driven: Vec<Side>,
    /// Exchanged surface nodes, one force-driven participant after the other.
    pub nodes: Surface,
    /// Glued points, one motion-driven participant after the other.
    pub points: Surface,
    /// From exchanged nodes to glued points.
    pub mapping: Mapping,
    /// Windows in integer steps. With several force-driven participants its step is the longest that is a whole number of steps of each.
    pub clock: Clock,
}

/// Difference between two surfaces that are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Offset {
    /// That in shape: tilt and curvature of the parabola through the points' distances from the line through the nodes, as its
    /// largest departure from their mean over the spacing of the points. What the roughness of the row may explain is taken off;
    /// surfaces of the same shape have none, however far apart they lie.
    pub shape_rel: f64,
    /// Their mean distance over the length of the joined part. Each side may have an origin of its own.
    pub distance_rel: f64,
    /// Distance of neighbouring points over the distance of the nodes that carry them, the median along the row.
    pub spacing_rel: f64,
}

/// One interface inside its group.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Its index in the scenario.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// Its continuum, as an index into [`Group::force_driven`].
    pub force_driven: usize,
    /// Its layer, as an index into [`Group::motion_driven`].
    pub motion_driven: usize,
    /// Its nodes among the group's.
    pub nodes: Range<usize>,
    /// Its points among the group's.
    pub points: Range<usize>,
    /// 1 where the layer lies above the continuum, -1 where it hangs below: the side of the continuum's outward normal.
    pub outward_y: f64,
    /// Difference between its points and its surface line.
    pub offset: Offset,
    /// Length after which both of its sides repeat along x (m), where they do.
    pub period_m: Option<f64>,
    /// Mean spacing of its exchanged nodes (m).
    pub spacing_m: f64,
    /// Largest gap that counts as closed, over the spacing.
    pub tolerance_rel: f64,
    /// Largest energy defect over the energy, if it is judged.
    pub energy_defect_max_rel: Option<f64>,
}

/// A participant of the group.
#[derive(Clone, Debug)]
pub struct Side {
    /// Index of the participant.
    pub peer: usize,
    /// Its nodes or points among the group's.
    pub range: Range<usize>,
    /// Own steps in a step of the group's clock; 1 for a motion-driven one, which steps by windows.
    pub steps: u32,
}

impl Group {
    /// Length of a window (s).
    pub fn window_s(&self, window: &Window) -> f64 {
        self.clock.step_s * f64::from(window.substeps)
    }

    /// The interface that speaks for a motion-driven participant: its first.
    pub fn first_of(&self, motion_driven: usize) -> usize {
        let mut patches = self.patches.iter();
        let found = patches.position(|patch| patch.motion_driven == motion_driven);
        found.expect("it is in the group because of an interface")
    }
}

impl Side {
    /// The components of its nodes or points in a vector of the group.
    pub fn of<'a>(&self, vector: &'a [f64]) -> &'a [f64] {
        &vector[components(&self.range)]
    }

    /// The window, counted in its own steps.
    pub fn window(&self, window: &Window) -> Window {
        Window {
            step: window.step * u64::from(self.steps),
            substeps: window.substeps * self.steps,
            ..*window
        }
    }
}

impl Patch {
    /// The components of its points in a vector of the group.
    pub fn of_points<'a>(&self, vector: &'a [f64]) -> &'a [f64] {
        &vector[components(&self.points)]
    }

    /// The components of its nodes in a vector of the group.
    pub fn of_nodes<'a>(&self, vector: &'a [f64]) -> &'a [f64] {
        &vector[components(&self.nodes)]
    }
}

/// Two components a position.
pub fn components(range: &Range<usize>) -> Range<usize> {
    2 * range.start..2 * range.end
}
