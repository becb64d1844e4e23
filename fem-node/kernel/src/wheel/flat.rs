//! A horizontal face: normal and tangential parts decouple, both have closed forms.

use super::coulomb::admissible;
use super::node_contact::{ContactStatus, NodeContact};
use super::problem::{NodeMotion, WheelStep};

/// Contact forces at t_n, g_i the free gap, W_i and W_w the weights of node and wheel:
///
/// ```text
/// S   = sum r_i,  r_i = max(0, -(g_i + W_w S) / W_i)          a monotone equation in S alone
/// r_t = slip_free / W_i, clipped to +-mu r_i
/// ```
///
/// slip_free is the increment of D minus the increment of the node's free x; the clipping is [`admissible`]. Carpenter, Taylor and Katona (1991);
/// Renouf, Saulot and Berthier (2006), eqs 11-15, corrected.
pub(super) fn solve(nodes: &[NodeMotion], wheel: &WheelStep, contacts: &mut [NodeContact]) {
    let lifted = wheel.weight * total(nodes, wheel);
    for (node, contact) in nodes.iter().zip(contacts) {
        let gap = gap(node, wheel) + lifted;
        let closed = (gap < 0.0).then(|| close(node, wheel, -gap / node.weight[1]));
        *contact = closed.unwrap_or_default();
    }
}

fn gap(node: &NodeMotion, wheel: &WheelStep) -> f64 {
    wheel.free_height - (node.point[1] + node.free[1])
}

/// S by Newton's method from 0. S - sum max(0, -(g_i + W_w S)/W_i) is piecewise linear, increasing and concave, so
/// each iterate lies below the root and above its predecessor: nodes only leave the active set, and when no node leaves the iterate is the root.
pub(crate) fn total(nodes: &[NodeMotion], wheel: &WheelStep) -> f64 {
    let mut s = 0.0;
    let mut active = usize::MAX;
    loop {
        let (mut count, mut flexibility, mut pressed) = (0, 0.0, 0.0);
        for node in nodes {
            let gap = gap(node, wheel);
            if gap + wheel.weight * s < 0.0 {
                count += 1;
                flexibility += 1.0 / node.weight[1];
                pressed -= gap / node.weight[1];
            }
        }
        if count >= active || count == 0 {
            return s;
        }
        active = count;
        s = pressed / (1.0 + wheel.weight * flexibility);
    }
}

fn close(node: &NodeMotion, wheel: &WheelStep, pressing: f64) -> NodeContact {
    let slip = (wheel.lateral[1] - wheel.lateral[0]) - (node.free[0] - node.now[0]);
    // A node that is held in x cannot follow the wheel: it resists with full friction.
    let sticking = if node.weight[0] > 0.0 {
        slip / node.weight[0]
    } else if slip == 0.0 {
        0.0
    } else {
        f64::INFINITY.copysign(slip)
    };
    let [normal, tangential] = admissible([pressing, sticking], wheel.friction);
    let status = if sticking.abs() < wheel.friction * normal || slip == 0.0 {
        ContactStatus::Stick
    } else {
        ContactStatus::slipping(tangential)
    };
    NodeContact {
        normal: [0.0, -normal],
        friction: [tangential, 0.0],
        status,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes of weight 1 (m/N) that reach above a massive wheel by these distances, and slip by 3.
    fn pressed(reach: &[f64], weight: f64, friction: f64) -> Vec<NodeContact> {
        let node = |y: &f64| NodeMotion {
            free: [-3.0, *y],
            weight: [1.0, 1.0],
            ..NodeMotion::default()
        };
        let nodes: Vec<NodeMotion> = reach.iter().map(node).collect();
        let wheel = WheelStep {
            height: 0.0,
            free_height: 0.0,
            weight,
            lateral: [0.0, 0.0],
            turn: 0.0,
            turn_weight: 0.0,
            period: None,
            friction,
        };
        let mut contacts = vec![NodeContact::default(); nodes.len()];
        solve(&nodes, &wheel, &mut contacts);
        contacts
    }

    #[test]
    fn an_immovable_wheel_pushes_each_node_back_to_its_face() {
        let contacts = pressed(&[2.0, -1.0, 4.0], 0.0, 0.5);
        let normal: Vec<f64> = contacts.iter().map(|t| t.normal[1]).collect();
        assert_eq!(normal, [-2.0, 0.0, -4.0]);
    }

    #[test]
    fn a_light_wheel_is_lifted_off_the_lower_node() {
        // Both closed: S = (1 + 5)/(1 + 2 x 1) = 2, which lifts the wheel by 2 off the node at 1; so S = 5/2.
        let contacts = pressed(&[1.0, 5.0], 1.0, 0.5);
        assert_eq!(contacts[0], NodeContact::default());
        assert_eq!(contacts[1].normal[1], -2.5);
    }

    #[test]
    fn friction_holds_up_to_its_limit() {
        // The node would move by -3 under the resting wheel, the friction that stops it is 3.
        let contacts = pressed(&[4.0, 8.0], 0.0, 0.5);
        assert_eq!(contacts[0].friction[0], 2.0);
        assert_eq!(contacts[0].status, ContactStatus::SlipForward);
        assert_eq!(contacts[1].friction[0], 3.0);
        assert_eq!(contacts[1].status, ContactStatus::Stick);
    }

    #[test]
    fn a_smooth_wheel_slides() {
        let contacts = pressed(&[4.0], 0.0, 0.0);
        assert_eq!(contacts[0].friction, [0.0, 0.0]);
        assert_eq!(contacts[0].status, ContactStatus::SlipForward);
    }
}
