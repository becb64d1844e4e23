//! Contact forces and statuses of the nodes under a wheel in equilibrium.

use serde::{Deserialize, Serialize};

use crate::wheel::node_contact::{ContactStatus, NodeContact};

/// Contact of the wheel with the upper edge, node by node from left to right.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WheelContact {
    /// Unit normals from the body into the wheel.
    pub normals: Vec<[f64; 2]>,
    /// Contact forces along the normals (N), >= 0; the body is pushed against its normal.
    pub normal: Vec<f64>,
    /// Forces of the wheel on the body along (n_y, -n_x), the normals turned clockwise (N).
    pub tangential: Vec<f64>,
    /// Open, sticking or slipping.
    pub status: Vec<ContactStatus>,
    /// Approach of the wheel since it first touched (m).
    pub approach: f64,
    /// Sideways displacement of the wheel, or the abscissa of the centre of a rolling one (m).
    pub lateral: f64,
    /// Length of the face that has rolled off, towards +x (m).
    pub turned: f64,
    /// Energy that friction has dissipated at each node since the start (J).
    pub dissipated: Vec<f64>,
}

impl WheelContact {
    /// Energy that friction has dissipated since the start (J).
    pub fn lost(&self) -> f64 {
        self.dissipated.iter().sum()
    }

    /// Energy that friction has dissipated at each node (J), and the nodes that it touches.
    pub fn rubbed(&self) -> (&[f64], impl Iterator<Item = bool>) {
        let touches = self.status.iter().map(|s| *s != ContactStatus::Open);
        (&self.dissipated, touches)
    }

    /// Share of the touching nodes that slip; 0 when none touches.
    pub fn slipping_share(&self) -> f64 {
        let count =
            |wanted: fn(&ContactStatus) -> bool| self.status.iter().filter(|s| wanted(s)).count();
        let touching = count(|s| *s != ContactStatus::Open);
        count(|s| s.direction() != 0.0) as f64 / touching.max(1) as f64
    }

    /// Force of the wheel on the node (N).
    pub fn force(&self, node: usize) -> [f64; 2] {
        let contact = self.node_contact(node);
        [0, 1].map(|k| contact.friction[k] + contact.normal[k])
    }

    /// Contact of a node in the form used for a wheel in motion.
    fn node_contact(&self, node: usize) -> NodeContact {
        let [nx, ny] = self.normals[node];
        let (normal, tangential) = (self.normal[node], self.tangential[node]);
        NodeContact {
            normal: [-normal * nx, -normal * ny],
            friction: [tangential * ny, -tangential * nx],
            status: self.status[node],
        }
    }

    /// Contacts in the form used for a wheel in motion.
    pub fn node_contacts(&self) -> Vec<NodeContact> {
        let nodes = 0..self.normals.len();
        nodes.map(|node| self.node_contact(node)).collect()
    }

    /// Force of the wheel on the body (N).
    pub fn resultant(&self) -> [f64; 2] {
        (0..self.normals.len())
            .map(|node| self.force(node))
            .fold([0.0, 0.0], |sum, f| [sum[0] + f[0], sum[1] + f[1]])
    }
}
