//! Interfaces that are solved together: all that are connected through a participant.
//!
//! A participant on several interfaces exchanges the points of all of them at once, one set after the other in the
//! order of the scenario. The compliance of the group is block-diagonal, one block a continuum; a wall with
//! several glued rows stands on all of its continua, so that one contact solve a window sees every row.

use std::ops::Range;

use protocol::{Surface, Window};

use super::clock::Clock;
use super::mapping::Mapping;

/// Connected interfaces, ready for their first window.
#[derive(Clone, Debug)]
pub struct Group {
    /// The interfaces, in the order of the scenario.
    pub patches: Vec<Patch>,
    /// Participants that take forces, in the order in which the interfaces name them.
    pub continua: Vec<Side>,
    /// Participants on a wall, in the same order.
    pub walls: Vec<Side>,
    /// Exchanged surface nodes, continuum after continuum.
    pub nodes: Surface,
    /// Glued points, wall after wall.
    pub points: Surface,
    /// From exchanged nodes to glued points.
    pub mapping: Mapping,
    /// Windows in integer steps. With several continua its step is the longest that is a whole number of steps of each.
    pub clock: Clock,
}

/// One interface inside its group.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Its index in the scenario.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// Its continuum, as a place in [`Group::continua`].
    pub continuum: usize,
    /// Its wall, as a place in [`Group::walls`].
    pub wall: usize,
    /// Its nodes among the group's.
    pub nodes: Range<usize>,
    /// Its points among the group's.
    pub points: Range<usize>,
    /// 1 where the wall lies above the continuum, -1 where it hangs below: the side of the continuum's outward normal.
    pub outward_y: f64,
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
    pub places: Range<usize>,
    /// Own steps in a step of the group's clock; 1 for a wall, which steps by windows.
    pub steps: u32,
}

impl Group {
    /// Length of a window (s).
    pub fn window_s(&self, window: &Window) -> f64 {
        self.clock.step_s * f64::from(window.substeps)
    }

    /// Nodal forces (N) that the points of one wall exert; zero on the nodes of other walls.
    pub fn borne_by(&self, wall: usize, force: &[f64]) -> Vec<f64> {
        let mut own = vec![0.0; force.len()];
        for patch in self.patches.iter().filter(|patch| patch.wall == wall) {
            let range = components(&patch.nodes);
            own[range.clone()].copy_from_slice(&force[range]);
        }
        own
    }

    /// The interface that speaks for a wall: its first.
    pub fn first_of(&self, wall: usize) -> usize {
        let found = self.patches.iter().position(|patch| patch.wall == wall);
        found.expect("a wall is in the group because of an interface")
    }
}

impl Side {
    /// The components of its nodes or points in a vector of the group.
    pub fn of<'a>(&self, vector: &'a [f64]) -> &'a [f64] {
        &vector[components(&self.places)]
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

/// Two components a place.
pub fn components(places: &Range<usize>) -> Range<usize> {
    2 * places.start..2 * places.end
}
