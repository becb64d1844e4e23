//! The contact law: Signorini's condition and Coulomb's friction, neither regularised.

/// Projection of a trial force onto the admissible forces (N):
///
/// ```text
/// r_n = max(0, r_n*),  r_t = r_t* clipped to +-mu r_n
/// ```
///
/// With W the weights of a node, a force r obeys
///
/// ```text
/// gap >= 0,  r_n >= 0,  gap r_n = 0                                     Signorini
/// |r_t| <= mu r_n,  r_t = mu r_n sign(slip) where the node slips        Coulomb
/// ```
///
/// exactly if r is the projection of (r_n - gap/W_nn, r_t + slip/W_tt).
pub(crate) fn admissible([normal, tangential]: [f64; 2], friction: f64) -> [f64; 2] {
    let normal = normal.max(0.0);
    let limit = friction * normal;
    [normal, tangential.clamp(-limit, limit)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wheel::node_contact::{ContactStatus, NodeContact};
    use crate::wheel::problem::{NodeMotion, WheelStep};
    use crate::wheel::{flat, round::RoundFace};

    const FRICTION: f64 = 0.4;

    /// A node with this reach above the face of the wheel and this slip, and the wheel.
    fn node(reach: f64, slip: f64) -> (NodeMotion, WheelStep) {
        let node = NodeMotion {
            free: [-slip, reach],
            weight: [0.7, 0.9],
            ..NodeMotion::default()
        };
        let wheel = WheelStep {
            height: 0.0,
            free_height: 0.0,
            weight: 0.3,
            lateral: [0.0, 0.0],
            turn: 0.0,
            turn_weight: 0.0,
            period: None,
            friction: FRICTION,
        };
        (node, wheel)
    }

    /// The closed form of a flat face and the sweeps of a round one against the law itself: nodes that stay open, stick, and
    /// slip either way.
    #[test]
    fn both_forms_of_the_contact_obey_the_law() {
        let cases = [
            (-0.2, 0.3),
            (0.5, 0.01),
            (0.5, 2.0),
            (0.5, -2.0),
            (0.5, 0.0),
        ];
        let mut seen = Vec::new();
        for (reach, slip) in cases {
            let (node, wheel) = node(reach, slip);
            let mut contacts = [NodeContact::default(); 2];
            let [flat, round] = &mut contacts;
            flat::solve(&[node], &wheel, std::slice::from_mut(flat));
            RoundFace::default()
                .solve(&[node], 1e9, &wheel, std::slice::from_mut(round))
                .expect("one node needs one sweep");
            for contact in contacts {
                let (normal, tangential) = (-contact.normal[1], contact.friction[0]);
                let gap = -reach + (node.weight[1] + wheel.weight) * normal;
                let left = slip - node.weight[0] * tangential;
                let trial = [normal - gap, tangential + left];
                let [n, t] = admissible(trial, FRICTION);
                assert!(
                    (n - normal).abs() < 1e-7 && (t - tangential).abs() < 1e-7,
                    "{contact:?}"
                );
            }
            assert_eq!(contacts[0].status, contacts[1].status);
            seen.push(contacts[0].status);
        }
        use ContactStatus::{Open, SlipBackward, SlipForward, Stick};
        assert_eq!(seen, [Open, Stick, SlipForward, SlipBackward, Stick]);
    }
}
