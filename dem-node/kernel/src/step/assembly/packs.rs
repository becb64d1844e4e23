//! Contacts side by side: pairs of single grains on springs, with the bits of [`super::Stepper::candidate`] and what follows it.

use super::detection::{Detection, let_go};
use crate::bodies::geometry::between_points;
use crate::contact::bond::{Bond, BondContact};
use crate::contact::detect::Slot;
use crate::law::cohesion::Cohesion;
use crate::law::lanes::{Lanes, Real, widest};
use crate::law::local::{BondLaw, DelassusBlock, LocalLaw, PRESCRIBED};
use crate::law::{Law, Springs};
use crate::solver::contact::{BodyRecord, Contact, NO_BOND, NO_LEVERS};
use crate::step::Stepper;

/// Pairs of a pack.
const LANES: usize = 4;

/// A number of each pair of a pack.
type Doubles = Lanes<LANES>;

/// A slot whose contact waits for a full pack, in the order of the slots.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    slot: usize,
    /// Its bond, or [`NO_BOND`].
    bond: u32,
    /// Its lane; `None` for a pair that goes alone.
    lane: Option<usize>,
}

/// Pairs of single grains that become contacts together.
#[derive(Clone, Debug, Default)]
pub(super) struct Pack {
    waiting: Vec<Waiting>,
    count: usize,
    /// Vector from b to a (m), sum of the radii (m), and inverse masses (1/kg).
    from_b: [Doubles; 2],
    reach: Doubles,
    inverse: [Doubles; 2],
    /// Free velocity of a against b (m/s), of pairs without a bond.
    velocity: [Doubles; 2],
    /// The memory of the pair; of a bond its reference, area, adhesion and slip.
    force: [Doubles; 2],
    spring: Doubles,
    reference: Doubles,
    area: Doubles,
    adhesion: Doubles,
    slip: Doubles,
    /// 1 for a bond, else 0.
    bonded: Doubles,
}

/// The contacts of a pack.
struct Made {
    normal: [Doubles; 2],
    gap: Doubles,
    relative_gap: Doubles,
    /// Reference of pairs without a bond.
    reference: Doubles,
    bias: [Doubles; 2],
    compliance: [Doubles; 2],
    impulse: [Doubles; 2],
    block: [Doubles; 2],
    inverse: [Doubles; 2],
    /// 1 for pairs that may touch in this step, else 0.
    touches: Doubles,
    relaxation: Doubles,
    stiffening: Doubles,
    kappa: [Doubles; 2],
    /// delta_t/h (m/s).
    slip: Doubles,
    shear: Doubles,
    tension: Doubles,
}

impl Pack {
    /// Adds a pair of free grains, with its bond; true when the pack is full.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        at: &Detection,
        records: &[BodyRecord],
        (index, slot): (usize, &Slot),
        bond: Option<(usize, &Bond)>,
    ) -> bool {
        let (k, bodies) = (self.count, at.input.bodies);
        let pair = [slot.a as usize, slot.b as usize];
        let [a, b] = pair.map(|disk| at.positions.centres[disk]);
        let [dx, dy] = between_points(a, b, bodies.period);
        (self.from_b[0].0[k], self.from_b[1].0[k]) = (dx, dy);
        self.reach.0[k] = bodies.radii[pair[0]] + bodies.radii[pair[1]];
        let [a, b] = pair.map(|disk| &records[disk]);
        (self.inverse[0].0[k], self.inverse[1].0[k]) = (a.inverse_mass, b.inverse_mass);
        (self.force[0].0[k], self.force[1].0[k]) = (slot.force[0], slot.force[1]);
        self.bonded.0[k] = match bond {
            Some((_, bond)) => {
                (self.reference.0[k], self.area.0[k]) = (bond.reference, bond.area);
                (self.adhesion.0[k], self.slip.0[k]) = (bond.adhesion, bond.slip);
                1.0
            }
            None => {
                for axis in 0..2 {
                    self.velocity[axis].0[k] = a.velocity[axis] - b.velocity[axis];
                }
                (self.reference.0[k], self.spring.0[k]) = (slot.reference, slot.spring);
                0.0
            }
        };
        self.wait(index, bond, Some(k));
        self.count += 1;
        self.count == LANES
    }

    /// Adds a pair that goes alone.
    pub(super) fn wait(&mut self, slot: usize, bond: Option<(usize, &Bond)>, lane: Option<usize>) {
        let bond = bond.map_or(NO_BOND, |(index, _)| index as u32);
        self.waiting.push(Waiting { slot, bond, lane });
    }

    /// The contacts of all lanes, in a step h (s), under this law. Pairs whose gap is below `alert` (m) at the end of the step may touch.
    #[inline(always)]
    fn make(&self, law: &Law, springs: &Springs, h: f64, alert: f64) -> Made {
        let (one, zero, is_bond) = (Doubles::of(1.0), Doubles::of(0.0), |bonded| bonded > 0.0);
        let either = |bond, loose| self.bonded.choose(is_bond, bond, loose);
        let of_bonds = law.cohesion.as_ref();
        let of_bond = |of: fn(&Cohesion) -> f64| Doubles::of(of_bonds.map_or(0.0, of));
        let step = Doubles::of(h);
        // Geometry.
        let ([dx, dy], reach) = (self.from_b, self.reach);
        let distance = (dx * dx + dy * dy).map(f64::sqrt);
        let one_over = one / distance;
        let apart = |distance| distance > 0.0;
        let normal = [
            distance.choose(apart, one_over * dx, zero),
            distance.choose(apart, one_over * dy, one),
        ];
        let surfaces = distance - reach;
        let relative_gap = surfaces / reach;
        let lever = one + relative_gap;
        let loose = self.reference.zip(surfaces, |reference, gap| {
            if gap > reference.max(0.0) {
                0.0
            } else {
                reference
            }
        });
        let reference = either(self.reference, loose);
        let gap = surfaces - reference;
        // Springs and dampers.
        let along = self.inverse[0] + self.inverse[1];
        let stiffness = either(
            self.area * of_bond(|c| c.normal),
            Doubles::of(springs.normal),
        );
        let damping = either(of_bond(|c| c.damping), Doubles::of(springs.damping));
        let relaxation = Doubles::of(2.0) * damping / (stiffness * along).map(f64::sqrt);
        let stiffening = one + relaxation / step;
        let share = one / stiffening;
        let pressed = gap.choose(|gap| gap < 0.0, share, one);
        let share = either(share, pressed);
        let [c_n, c_t] = law.compliance(h).map(Doubles::of);
        let compliance = [c_n * share, either(zero, c_t)];
        let impulse = [step * (self.force[0] + zero), step * self.force[1]];
        // Delassus block.
        let [nx, ny] = normal;
        let squared = [nx * nx, ny * ny, lever * lever];
        let [a, b] = self.inverse.map(|inverse| {
            let [x, y] = [squared[0] * inverse, squared[1] * inverse];
            [x + y, y + x + Doubles::of(2.0) * inverse * squared[2]]
        });
        let block = [a[0] + b[0], a[1] + b[1]];
        // Laws.
        let bonds = of_bonds.map_or([zero; 2], |c| c.stiffness(self.area, self.adhesion));
        let kappa = bonds.map(|stiffness| Doubles::of(h * h) * (stiffening * stiffness));
        let freed = one / (one + kappa[1] * block[1]);
        let tension = kappa[0] / (one + kappa[0] * block[0]);
        let tangential = either(freed * block[1], block[1] + c_t);
        let diagonal = block[0] + compliance[0];
        let least = Doubles::of(PRESCRIBED) * diagonal;
        let inverse = [one / diagonal, one / tangential.zip(least, f64::max)];
        // Contacts of this step.
        let approach = nx * self.velocity[0] + ny * self.velocity[1];
        let way = step * approach.map(|approach| approach.min(0.0));
        let near = (gap + way).map(|gap| f64::from(u8::from(gap < alert)));
        let held = impulse[0].zip(gap, |r_n, gap| {
            f64::from(u8::from((r_n > 0.0) & gap.is_finite()))
        });
        Made {
            normal,
            gap,
            relative_gap,
            reference,
            bias: [gap / step * share, either(zero, self.spring / step)],
            compliance,
            impulse,
            block,
            inverse,
            touches: self.bonded + near + held,
            relaxation,
            stiffening,
            kappa,
            slip: self.slip / (step * stiffening),
            shear: kappa[1] * freed,
            tension,
        }
    }
}

impl Made {
    /// A contact of these bodies, with the number of its bond.
    #[inline(always)]
    fn contact(&self, k: usize, [a, b]: [u32; 2], bond: u32, friction: f64) -> Contact {
        let at = |lanes: &[Doubles; 2]| [lanes[0].0[k], lanes[1].0[k]];
        let ([nn, tt], [inverse_n, inverse_t]) = (at(&self.block), at(&self.inverse));
        let inverse = DelassusBlock {
            nn: inverse_n,
            nt: 0.0,
            tt: inverse_t,
        };
        Contact {
            a,
            b,
            glued: false,
            normal: at(&self.normal),
            gap: self.gap.0[k],
            relative_gap: self.relative_gap.0[k],
            bias: at(&self.bias),
            pair_law: 0,
            compliance: at(&self.compliance),
            impulse: at(&self.impulse),
            bond,
            levers: NO_LEVERS,
            block: DelassusBlock { nn, nt: 0.0, tt },
            law: LocalLaw::single(inverse, friction),
            // What the law refuses is prepared again, which gives the reason.
            prepared: inverse_n > 0.0 && inverse_n.is_finite() && inverse_t > 0.0,
        }
    }

    #[inline(always)]
    fn bond(&self, k: usize, index: u32, adhesion: f64) -> BondContact {
        BondContact {
            index,
            adhesion: [adhesion; 2],
            relaxation: [self.relaxation.0[k]; 2],
            stiffening: [self.stiffening.0[k]; 2],
            law: BondLaw::prepared(
                [self.kappa[0].0[k], self.kappa[1].0[k]],
                self.slip.0[k],
                [self.shear.0[k], self.tension.0[k]],
            ),
        }
    }
}

impl Stepper {
    /// Makes the contacts of a pack and of those that wait for it, in the order of their slots.
    pub(super) fn make_contacts(&mut self, at: &Detection, pack: &mut Pack, slots: &mut [Slot]) {
        let (law, h) = (&at.input.bodies.law, at.input.step);
        let (alert, bonds) = (at.input.bodies.alert, &at.state.bonds);
        let springs = law.springs.filter(|_| pack.count > 0);
        let made = springs.map(|springs| widest!(pack.make(law, &springs, h, alert)));
        for waiting in &pack.waiting {
            let slot = &mut slots[waiting.slot];
            let bond = bonds.get(waiting.bond as usize);
            let (Some(k), Some(made)) = (waiting.lane, &made) else {
                let bond = bond.map(|bond| (waiting.bond as usize, bond));
                self.take(at, (waiting.slot, slot), bond);
                continue;
            };
            let mut number = NO_BOND;
            let mut friction = law.friction;
            if let Some(bond) = bond {
                number = self.problem.bonds.len() as u32;
                friction = 0.0;
                let bond = made.bond(k, waiting.bond, bond.adhesion);
                self.problem.bonds.push(bond);
            } else {
                slot.reference = made.reference.0[k];
                if made.touches.0[k] == 0.0 {
                    let_go(slot);
                    continue;
                }
            }
            let bodies = [slot.a, slot.b];
            self.problem
                .contacts
                .push(made.contact(k, bodies, number, friction));
            self.slots.push(waiting.slot as u32);
        }
        pack.waiting.clear();
        pack.count = 0;
    }
}
