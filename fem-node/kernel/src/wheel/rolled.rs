//! The contact of a rolling wheel, as its results see it.

use kit::rolled::{ContactExtent, RolledPiece};
use kit::rolling::Rolling;
use protocol::larger;

use super::node_contact::{ContactStatus, NodeContact};

/// Forces, ends, peak pressure and share of sticking surface of the contact of a wheel of this radius (m); `areas` are the surfaces of the nodes of
/// the upper edge (m2). Way, turn and dissipation are left 0.
pub fn rolled_piece(
    contacts: &[NodeContact],
    areas: &[f64],
    radius: f64,
    rolling: &Rolling,
) -> RolledPiece {
    let along = rolling.direction();
    let mut piece = RolledPiece::default();
    let mut extent = ContactExtent::default();
    let nodes = contacts.iter().zip(areas);
    for (contact, area) in nodes.filter(|(contact, _)| contact.pressing() > 0.0) {
        piece.creep_force += along * contact.dragging();
        piece.force_x += along * (contact.normal[0] + contact.friction[0]);
        piece.normal -= contact.normal[1] + contact.friction[1];
        let before = along * radius * contact.normal[0] / contact.pressing();
        extent.touch(before, *area, contact.status == ContactStatus::Stick);
        let pressure = contact.pressing() / area;
        piece.peak = Some(piece.peak.map_or(pressure, |peak| larger(peak, pressure)));
    }
    (piece.ends, piece.stick) = extent.ends_and_stick();
    piece
}
