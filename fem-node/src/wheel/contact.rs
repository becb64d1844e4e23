//! The contact problem of one step.

use serde::{Deserialize, Serialize};

use super::{flat, round};

/// Contact of one node at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Touch {
    /// Normal force on the node (N).
    pub(crate) normal: [f64; 2],
    /// Friction on the node (N).
    pub(crate) friction: [f64; 2],
    /// Whether the node moves along with the wheel.
    pub(crate) status: Status,
}

/// Whether a node moves along with the wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Status {
    /// No contact.
    #[default]
    Open,
    /// Contact, and no slip.
    Stick,
    /// Contact, and slip under the full friction.
    Slip,
}

impl Touch {
    pub(crate) fn closed(&self) -> bool {
        self.status != Status::Open
    }

    /// Magnitude of the normal force (N).
    pub(crate) fn pressing(&self) -> f64 {
        self.normal[0].hypot(self.normal[1])
    }

    /// Friction on the node along the surface, positive where the wheel drags it towards +x (N).
    pub(crate) fn dragging(&self) -> f64 {
        self.friction[0]
            .hypot(self.friction[1])
            .copysign(self.friction[0])
    }
}

/// Force of all nodes on the wheel (N).
pub(super) fn on_wheel(touches: &[Touch]) -> [f64; 2] {
    touches.iter().fold([0.0, 0.0], |sum, touch| {
        [0, 1].map(|k| sum[k] - (touch.normal[k] + touch.friction[k]))
    })
}

/// Nodes in contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Count {
    stick: usize,
    slip: usize,
}

/// Counts the nodes in contact.
pub(super) fn count(touches: &[Touch]) -> Count {
    let mut count = Count::default();
    for touch in touches {
        match touch.status {
            Status::Open => {}
            Status::Stick => count.stick += 1,
            Status::Slip => count.slip += 1,
        }
    }
    count
}

impl Count {
    pub(super) fn closed(self) -> usize {
        self.stick + self.slip
    }

    /// Sn = slip / (slip + stick) in percent, 0 without contact.
    pub(super) fn sliding_pct(self) -> f64 {
        100.0 * self.slip as f64 / self.closed().max(1) as f64
    }
}

/// A node of the upper edge between t_n and t_n+1.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NodeMotion {
    /// Position without displacement (m).
    pub(super) point: [f64; 2],
    /// Displacement at t_n (m).
    pub(super) now: [f64; 2],
    /// Displacement at t_n+1 without contact forces at t_n (m).
    pub(super) free: [f64; 2],
    /// Displacement at t_n+1 for each unit of force at t_n (m/N), zero where supported.
    pub(super) weight: [f64; 2],
}

/// The wheel between t_n and t_n+1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Increment {
    /// Lowest point of the face at t_n (m).
    pub(super) height: f64,
    /// The same at t_n+1 without contact forces at t_n (m).
    pub(super) free_height: f64,
    /// Vertical displacement at t_n+1 for each unit of force at t_n (m/N).
    pub(super) weight: f64,
    /// Sideways displacement at t_n and t_n+1 (m).
    pub(super) drive: [f64; 2],
    /// Coefficient of friction.
    pub(super) friction: f64,
}

/// A problem whose residual stayed too large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unsolved {
    pub(super) sweeps: usize,
    pub(super) residual: f64,
}

/// The upper edge, and room for solving.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) nodes: Vec<NodeMotion>,
    room: round::Room,
}

impl Problem {
    pub(super) fn new(points: &[[f64; 2]]) -> Problem {
        let at = |point: &[f64; 2]| NodeMotion {
            point: *point,
            ..NodeMotion::default()
        };
        Problem {
            nodes: points.iter().map(at).collect(),
            room: round::Room::default(),
        }
    }

    /// The contact forces at t_n. `touches` holds those of the step before, a good guess.
    pub(super) fn solve(
        &mut self,
        radius: f64,
        wheel: &Increment,
        touches: &mut [Touch],
    ) -> Result<(), Unsolved> {
        if radius == 0.0 {
            flat::solve(&self.nodes, wheel, touches);
            return Ok(());
        }
        self.room.solve(&self.nodes, (radius, wheel), touches)
    }
}

/// Lowest point of the face when it just touches the points (m), the wheel standing over x = 0.
pub(super) fn first_height(radius: f64, points: &[[f64; 2]]) -> f64 {
    let below = points
        .iter()
        .filter(|p| radius == 0.0 || p[0].abs() < radius);
    let touching = below.map(|[x, y]| match radius == 0.0 {
        true => *y,
        // R - sqrt(R^2 - x^2) without the cancellation at small x.
        false => y - x * x / (radius + (radius * radius - x * x).sqrt()),
    });
    touching.fold(f64::NEG_INFINITY, f64::max)
}
