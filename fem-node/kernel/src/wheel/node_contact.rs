//! Contact forces and statuses of the nodes of the upper edge.

use serde::{Deserialize, Serialize};

/// Contact of one node at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NodeContact {
    /// Normal force on the node (N).
    pub(crate) normal: [f64; 2],
    /// Friction on the node (N).
    pub(crate) friction: [f64; 2],
    /// Open, sticking or slipping.
    pub status: ContactStatus,
}

/// Status of a node of the contact surface, with the direction of its slip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactStatus {
    /// It does not touch.
    #[default]
    Open,
    /// It touches and moves with the wheel.
    Stick,
    /// It touches and slides, dragged towards +t by the wheel.
    SlipForward,
    /// It touches and slides, dragged towards -t by the wheel.
    SlipBackward,
}

impl ContactStatus {
    /// Direction of the drag, 0 when it does not slip.
    pub fn direction(self) -> f64 {
        match self {
            ContactStatus::SlipForward => 1.0,
            ContactStatus::SlipBackward => -1.0,
            ContactStatus::Open | ContactStatus::Stick => 0.0,
        }
    }

    /// The word in tables.
    pub fn word(self) -> &'static str {
        match self {
            ContactStatus::Open => "open",
            ContactStatus::Stick => "stick",
            ContactStatus::SlipForward | ContactStatus::SlipBackward => "slip",
        }
    }

    /// Slip under a drag in this direction.
    pub(crate) fn slipping(direction: f64) -> ContactStatus {
        if direction >= 0.0 {
            ContactStatus::SlipForward
        } else {
            ContactStatus::SlipBackward
        }
    }
}

impl NodeContact {
    pub(crate) fn closed(&self) -> bool {
        self.status != ContactStatus::Open
    }

    /// Magnitude of the normal force (N).
    pub fn pressing(&self) -> f64 {
        self.normal[0].hypot(self.normal[1])
    }

    /// Friction on the node along the surface, positive where the wheel drags it towards +x (N).
    pub fn dragging(&self) -> f64 {
        let [x, y] = self.friction;
        x.hypot(y).copysign(x)
    }
}

/// Force of all nodes on the wheel (N).
pub(super) fn force_on_wheel(contacts: &[NodeContact]) -> [f64; 2] {
    contacts.iter().fold([0.0, 0.0], |sum, contact| {
        [0, 1].map(|k| sum[k] - (contact.normal[k] + contact.friction[k]))
    })
}

/// Nodes in contact.
pub(super) struct ContactCount {
    pub(super) closed: usize,
    slip: usize,
}

/// Counts the nodes in contact.
pub(super) fn count(contacts: &[NodeContact]) -> ContactCount {
    let slips = |contact: &&NodeContact| contact.status.direction() != 0.0;
    ContactCount {
        closed: contacts.iter().filter(|contact| contact.closed()).count(),
        slip: contacts.iter().filter(slips).count(),
    }
}

impl ContactCount {
    /// Sn = slip / (slip + stick) in percent, 0 without contact.
    pub(super) fn sliding_pct(&self) -> f64 {
        100.0 * self.slip as f64 / self.closed.max(1) as f64
    }
}
