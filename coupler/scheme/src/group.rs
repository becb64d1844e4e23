//! Interfaces that are solved together because participants connect them.
//!
//! A participant on several interfaces exchanges the points of all of them at once, set after set in the order of the
//! scenario. The compliance of the group is block-diagonal, with one block for each force-driven participant. A
//! motion-driven participant with several glued rows stands on all of its continua, so that one contact solve a window
//! covers every row. A set of a continuum may carry several layers, each on its own nodes, which are exchanged as parts
//! of the set.

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
    /// Windows in integer steps. With several force-driven participants the step is the longest that is a whole number
    /// of steps of each.
    pub clock: Clock,
    /// Windows from one exchange of heat to the next, where heat passes.
    pub heat_every: Option<u32>,
}

/// Difference between two joined surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Offset {
    /// Difference in shape: a parabola is fitted to the points' distances from the line through the nodes; this is its
    /// largest departure from their mean, over the spacing of the points. The part that the roughness of the row may
    /// explain is subtracted. Surfaces of the same shape have zero, at any distance.
    pub shape_rel: f64,
    /// Their mean distance over the length of the joined part. Each side may have its own origin.
    pub distance_rel: f64,
    /// Distance of neighbouring points over the distance of the nodes that carry them: the median along the row. It
    /// counts twice where the mapping gives a point two nodes, and four times where it gives a point one node.
    pub spacing_rel: f64,
    /// Largest distance of neighbouring points over their median; 0 where the mapping gives a point no width.
    pub hole_rel: f64,
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
    /// Mean outward unit normal of the continuum, as it describes it; else along y.
    pub outward: [f64; 2],
    /// Difference between its points and its surface line.
    pub offset: Offset,
    /// Period of both sides along x (m), if they repeat.
    pub period_m: Option<f64>,
    /// Mean spacing of its exchanged nodes (m).
    pub spacing_m: f64,
    /// Largest gap that counts as closed, over the spacing.
    pub tolerance_rel: f64,
    /// Bound on the energy defect over the energy, if it is judged.
    pub energy_defect_max_rel: Option<f64>,
}

/// A participant of the group.
#[derive(Clone, Debug)]
pub struct Side {
    /// Index of the participant.
    pub peer: usize,
    /// Its nodes or points among the group's.
    pub range: Range<usize>,
    /// Its steps in one step of the group's clock; 1 for a motion-driven participant, which steps by windows.
    pub steps: u32,
}

impl Group {
    /// Length of a window (s).
    pub fn window_s(&self, window: &Window) -> f64 {
        self.clock.step_s * f64::from(window.substeps)
    }

    /// The first interface of a motion-driven participant, which reports for it.
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

    /// The window in its own steps.
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

/// The range of components: two for each position.
pub fn components(range: &Range<usize>) -> Range<usize> {
    2 * range.start..2 * range.end
}
