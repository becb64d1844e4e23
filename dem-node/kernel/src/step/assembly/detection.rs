//! The data at which contacts are detected, and what only they decide: pairs that stay apart, and dampers of bonds.

use crate::bodies::geometry::between_points;
use crate::bodies::positions::Positions;
use crate::contact::bond::{Bond, BondContact};
use crate::contact::detect::Slot;
use crate::law::PairMobility;
use crate::solver::contact::{BodyRecord, Contact};
use crate::step::StepInput;
use crate::step::state::GrainState;

/// State, step and positions at which contacts are detected.
pub(super) struct Detection<'a> {
    pub state: &'a GrainState,
    pub input: &'a StepInput<'a>,
    pub positions: &'a Positions<'a>,
    /// Compliance of the law of most contacts (1/kg).
    pub compliance: [f64; 2],
    /// Gap beyond which two disks cannot touch in this step, at the largest velocity of any body (m).
    pub reach: f64,
}

impl Detection<'_> {
    /// True for two disks without memory that stay apart in this step, like most listed pairs. Computed without a square root, with a margin for
    /// rounding.
    #[inline(always)]
    pub fn stay_apart(&self, slot: &Slot) -> bool {
        let bodies = self.input.bodies;
        let pair = [slot.a as usize, slot.b as usize];
        if pair[1] >= bodies.disks() || self.state.feed.grows() || slot.remembers() {
            return false;
        }
        let [a, b] = pair.map(|disk| self.positions.centres[disk]);
        let [dx, dy] = between_points(a, b, bodies.period);
        let reach = bodies.radii[pair[0]] + bodies.radii[pair[1]] + self.reach;
        dx * dx + dy * dy > (1.0 + 1e-9) * reach * reach
    }

    /// A bond in the contact problem, with its index; its dampers change the contact.
    pub fn bonded(
        &self,
        contact: &mut Contact,
        bond: (usize, &Bond),
        records: &[BodyRecord],
    ) -> BondContact {
        let (bodies, h) = (self.input.bodies, self.input.step);
        let pair = [bond.1.a, bond.1.b];
        let [nx, ny] = contact.normal;
        let single = |disk: u32| {
            let disk = disk as usize;
            disk < bodies.free && bodies.clusters.of(disk).is_none()
        };
        let normal = self.mobility(pair, contact, [nx, ny], records);
        // A single grain is the lighter body, and yields alike in both directions.
        let tangential = if pair.into_iter().any(single) {
            normal
        } else {
            self.mobility(pair, contact, [-ny, nx], records)
        };
        let law = self.state.law_of(bodies, pair);
        let bond = BondContact::new(&law, bond, [normal, tangential], h);
        let share = 1.0 / bond.stiffening[0];
        contact.bias[0] *= share;
        contact.compliance[0] *= share;
        bond
    }

    /// Mobility of these disks along a direction, which sets the dampers of their contact.
    pub fn mobility(
        &self,
        pair: [u32; 2],
        contact: &Contact,
        along: [f64; 2],
        records: &[BodyRecord],
    ) -> PairMobility {
        let (state, bodies) = (self.state, self.input.bodies);
        let own = |disk: u32, pushed: u32| {
            let of_cluster = state.mobility(bodies, disk as usize, along);
            let alone = [records[pushed as usize].inverse_mass; 2];
            of_cluster.map_or(alone, |[own, _, free]| [own, free])
        };
        PairMobility::of([own(pair[0], contact.a), own(pair[1], contact.b)])
    }
}

/// Clears a contact that leaves the problem, for instance after a rebound: it must not keep its force.
pub(super) fn let_go(slot: &mut Slot) {
    (slot.force, slot.last_gap, slot.couple) = ([0.0; 2], 0.0, 0.0);
    (slot.attraction, slot.pressed) = (0.0, 0.0);
}
