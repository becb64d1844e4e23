//! The pressure between wheel and body.

use std::fmt::Write;

use fem_kernel::mesh::Edge;
use fem_kernel::statics::contact::WheelContact;
use fem_kernel::wheel::node_contact::{ContactStatus, NodeContact};
use kit::rolling::nearest_image;
use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::model::Model;

/// Number of nodes in contact that give the half-width, counted inwards from the outermost node. That one is left out: its pressure acts on an
/// unknown part of its surface.
const FIT: usize = 5;

/// Tractions on the upper edge, node by node from left to right.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactProfile {
    /// Abscissa (m), undeformed.
    pub x: Vec<f64>,
    /// Normal force over the surface of the node (Pa).
    pub pressure: Vec<f64>,
    /// Tangential force over the same surface, positive where the wheel drags the body towards +x (Pa).
    pub shear: Vec<f64>,
    /// Open, sticking or slipping.
    pub status: Vec<ContactStatus>,
}

impl ContactProfile {
    /// The profile of a contact in equilibrium.
    pub fn new(model: &Model, contact: &WheelContact) -> ContactProfile {
        let (normal, tangential) = (&contact.normal, &contact.tangential);
        ContactProfile::of_forces(model, [normal, tangential], contact.status.clone())
    }

    /// The profile of a contact in motion.
    pub(crate) fn in_motion(model: &Model, contacts: &[NodeContact]) -> ContactProfile {
        let along =
            |force: fn(&NodeContact) -> f64| contacts.iter().map(force).collect::<Vec<f64>>();
        let (normal, dragging) = (along(NodeContact::pressing), along(NodeContact::dragging));
        let status = contacts.iter().map(|contact| contact.status);
        ContactProfile::of_forces(model, [&normal, &dragging], status.collect())
    }

    fn of_forces(
        model: &Model,
        [normal, dragging]: [&[f64]; 2],
        status: Vec<ContactStatus>,
    ) -> ContactProfile {
        let (nodes, lengths) = model.mesh.surface(Edge::Top);
        let areas = lengths.into_iter().map(|length| length * model.thickness);
        let areas: Vec<f64> = areas.collect();
        let over_area = |force: &[f64]| {
            let pairs = force.iter().zip(&areas);
            pairs.map(|(force, area)| force / area).collect()
        };
        let x = nodes.iter().map(|n| model.mesh.point(n[0], n[1])[0]);
        ContactProfile {
            x: x.collect(),
            pressure: over_area(normal),
            shear: over_area(dragging),
            status,
        }
    }

    /// Highest contact pressure p0 (Pa).
    pub fn peak(&self) -> f64 {
        self.pressure.iter().copied().fold(0.0, larger)
    }

    /// Half of the width of a contact around `centre` (m): the zero x = a of the straight line through p^2 over x^2 at the five nodes
    /// inside the outermost one, on the side of larger x. A Hertzian p^2 = p0^2 (1 - x^2/a^2) is such a line (Johnson 1985, eq.
    /// 4.44), so its half-width is exact. None where fewer than two nodes remain, or where the line does not fall,
    /// as under a uniform pressure. A body that repeats after the `period` (m) may have the contact at its seam.
    pub fn half_width(&self, centre: f64, period: Option<f64>) -> Option<f64> {
        let x = |k: usize| nearest_image(self.x[k] - centre, period);
        // A node under the centre counts on neither side.
        let width = self.x.last().map_or(0.0, |last| last - self.x[0]);
        let side = |k: usize| x(k) > 1e-9 * width;
        let closed = |k: &usize| self.status[*k] != ContactStatus::Open && side(*k);
        let mut closed: Vec<usize> = (0..self.x.len()).filter(closed).collect();
        closed.sort_by(|one, other| x(*one).total_cmp(&x(*other)));
        let inside = &closed[..closed.len().saturating_sub(1)];
        let fit = &inside[inside.len().saturating_sub(FIT)..];
        if fit.len() < 2 {
            return None;
        }
        let mean = |value: &dyn Fn(usize) -> f64| {
            fit.iter().map(|k| value(*k)).sum::<f64>() / fit.len() as f64
        };
        let x2 = |k: usize| x(k) * x(k);
        let p2 = |k: usize| self.pressure[k] * self.pressure[k];
        let (mean_x2, mean_p2) = (mean(&x2), mean(&p2));
        let covariance = mean(&|k| (x2(k) - mean_x2) * (p2(k) - mean_p2));
        let variance = mean(&|k| (x2(k) - mean_x2).powi(2));
        let zero = (mean_x2 - mean_p2 * variance / covariance).sqrt();
        let outermost = closed.last().map_or(0.0, |k| x(*k));
        (zero > 0.0 && zero <= 2.0 * outermost).then_some(zero)
    }

    /// A table with the columns x_m, pressure_pa, shear_pa and status.
    pub fn csv(&self) -> String {
        let mut text = String::from("x_m,pressure_pa,shear_pa,status\n");
        for (k, x) in self.x.iter().enumerate() {
            let (pressure, shear) = (self.pressure[k], self.shear[k]);
            writeln!(
                text,
                "{x:e},{pressure:e},{shear:e},{}",
                self.status[k].word()
            )
            .expect("a string takes what it is given");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_pressure_has_no_half_width() {
        let x: Vec<f64> = (-7..=7).map(f64::from).collect();
        let profile = ContactProfile {
            pressure: vec![3.0; x.len()],
            shear: vec![0.0; x.len()],
            status: vec![ContactStatus::Stick; x.len()],
            x,
        };
        assert_eq!(profile.half_width(0.0, None), None);
    }

    #[test]
    fn the_half_width_of_a_hertzian_pressure_is_exact() {
        // p^2 = 100 - x^2 vanishes at 10; a line through p^2 over x vanishes at 11.17.
        let x: Vec<f64> = (-9..=9).map(f64::from).collect();
        let profile = ContactProfile {
            pressure: x.iter().map(|x| (100.0 - x * x).sqrt()).collect(),
            shear: vec![0.0; x.len()],
            status: vec![ContactStatus::Stick; x.len()],
            x,
        };
        let half_width = profile
            .half_width(0.0, None)
            .expect("nine nodes on the right");
        assert!((half_width - 10.0).abs() < 1e-12, "{half_width}");
        assert_eq!(profile.peak(), 10.0);
        // The same around the seam of a body that repeats after 40.
        let apart = |x: &f64| if *x > 0.0 { x - 20.0 } else { x + 20.0 };
        let x = profile.x.iter().map(apart).collect();
        let seam = ContactProfile { x, ..profile };
        assert_eq!(seam.half_width(20.0, Some(40.0)), Some(half_width));
    }
}
