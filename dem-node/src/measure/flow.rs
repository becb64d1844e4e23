//! Flows of third body, from the graph of bonds: source, recirculation, wear and the flow through a section.
//!
//! A bond counts with more than 0.01 of adhesion. A grain is *first body* while bonds connect it with an anchor, else *third body*; grains that no
//! bond connects at the start are the initial stock, which is third body and no source. A grain is in the contact zone ([`zone::Zone`]) when its
//! centre is: where contacts carry the wheel, below a lid from end to end, or anywhere in a strip that repeats, which nothing enters or leaves. A
//! step is recorded in this order:
//!
//! 1. by their own motion, grains cross the ends of the old zone, and the section x = 0 with its images;
//! 2. the zone moves, over grains at their new positions;
//! 3. grains change from first to third body and back at their new positions;
//! 4. third body that has been outside for `wear_s` since it left is worn, once for each time that it left.
//!
//! Crossings count grains that were third body before the step: a grain that is detached in the step in which it leaves is detached outside. Then, at
//! each step and to rounding, third body in the zone = detached - re-attached + fed + entered - left. Fed grains are third body from then on, at the
//! position where they begin, before anything else of the step is recorded. So are grains off a bare surface, which are detached there. Grains in
//! store are nowhere.
//!
//! The ends of the zone move, and the mass that they take in and leave behind has no steady state. There is therefore also the mass per length in the
//! middle half of the zone at the start of the wheel's motion; in a strip, in the whole strip.

mod lateral;
pub mod ledger;
pub mod zone;

use dem_kernel::bodies::Bodies;
use dem_kernel::contact::bond::holding;
use dem_kernel::contact::graph::first_bodies;
use dem_kernel::step::state::GrainState;
use protocol::larger;
use serde::{Deserialize, Serialize};

use crate::config::flow::FlowConfig;
use crate::measure::loads::{ends, shown};
use crate::measure::report::given;
use ledger::MassLedger;
use zone::{Zone, ZoneLoads};

kit::results! {
    /// # Flows of third body
    /// - `third_body_zone_kg`: Third body in the contact zone at the end.
    /// - `flow_kinetic_rel`: Kinetic stress of the grains in the zone, ρ<v²>/2, over the wheel's pressure, mean over the run: far below 1 where
    ///   inertia does not matter.
    /// - `third_body_per_length_kg_per_m`: Third body per length at the end, in the middle half that the zone had when the motion began.
    /// # Quality of the solution
    /// - `flow_balance_rel`: Largest difference between the third body in the zone and the ledger of its flows, over all flows.
}

/// Part of a step by which rounding may miss the time of wear.
const ROUNDING: f64 = 1e-6;
/// Time of detachment of a grain that never was.
pub const NEVER: f64 = -1.0;

/// Constants of a scene.
#[derive(Clone, Debug)]
pub struct FlowScene {
    /// The keys.
    pub config: FlowConfig,
    /// Real masses of the free grains (kg).
    pub masses: Vec<f64>,
    /// Mean diameter of the grains (m).
    pub diameter: f64,
    /// `mass_scale`.
    pub mass_scale: f64,
    /// Mean height of the base (m).
    pub base: f64,
    /// Time at which the middle of the zone is fixed (s).
    pub middle_from: f64,
    /// Seed of the grains that leave sideways.
    pub seed: u64,
}

/// Membership of a grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FlowBody {
    /// Connected with an anchor.
    First = 0,
    /// Detached.
    Third = 1,
    /// Third body that no bond held at the start.
    Stock = 2,
    /// Third body that was or will be fed in.
    Fed = 3,
}

/// A grain in the ledger.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Grain {
    body: FlowBody,
    /// Time of its last detachment (s).
    detached: f64,
    /// True for a centre in the zone.
    inside: bool,
    /// True for a grain that has been in the zone as third body.
    has_entered: bool,
    /// Number of sections, x = 0 and its images, to the left of its centre; 0 just to the left of x = 0.
    section: i32,
    /// Time at which it left the zone (s), while it is outside.
    left_at: Option<f64>,
    /// True for a grain that has been outside for long enough to be worn.
    worn: bool,
}

/// Ways in and out of the zone.
#[derive(Clone, Copy)]
enum Crossing {
    OwnMotion,
    ZoneMotion,
}

/// The flows since the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Flow {
    grains: Vec<Grain>,
    /// Number of grains that are not in store: they come first.
    present: usize,
    /// Bonds that held when the graph was last searched.
    bonds: Vec<(u32, u32)>,
    loads: ZoneLoads,
    zone: Option<Zone>,
    ledger: MassLedger,
    /// Third body in the zone, summed at each step (kg).
    held: f64,
    /// Largest difference between `held` and the ledger (kg).
    defect: f64,
    /// Twice the kinetic energy of the grains in the zone, of scaled masses, and the force on the wheel or the lid times its height above the base,
    /// summed over steps (J).
    kinetic: [f64; 2],
    /// The middle half of the zone, once the motion has begun, and third body in it (kg).
    middle: Option<Zone>,
    in_middle: f64,
    /// True where third body leaves sideways; mass that is due (kg), and number of grains that have left.
    lateral: bool,
    lateral_due: f64,
    lateral_grains: u64,
}

impl FlowScene {
    /// The constants of these bodies, whose masses are scaled by `mass_scale`, and whose wheel moves from this time on (s).
    pub fn new(
        config: FlowConfig,
        bodies: &Bodies,
        mass_scale: f64,
        (moves_from, seed): (f64, u64),
    ) -> FlowScene {
        FlowScene {
            seed,
            config,
            masses: bodies.masses.iter().map(|m| m / mass_scale).collect(),
            diameter: 2.0 * bodies.mean_radius(),
            mass_scale,
            base: mean_height(bodies),
            middle_from: moves_from,
        }
    }
}

/// Mean height of the glued disks of the base, or of the points of a bare base (m).
fn mean_height(bodies: &Bodies) -> f64 {
    let row = match &bodies.reference[..bodies.base] {
        [] => &bodies.surface.points[..bodies.surface.base],
        disks => disks,
    };
    row.iter().map(|point| point[1]).sum::<f64>() / row.len() as f64
}

impl Grain {
    fn at_start(body: FlowBody, section: i32) -> Grain {
        Grain {
            body,
            detached: NEVER,
            inside: false,
            has_entered: false,
            section,
            left_at: None,
            worn: false,
        }
    }

    fn is_third(&self) -> bool {
        self.body != FlowBody::First
    }

    /// The grain is fed in, or has come off a surface at a time (s), in the zone or outside.
    fn feed_in(
        &mut self,
        detached: Option<f64>,
        section: i32,
        inside: bool,
        mass: f64,
        ledger: &mut MassLedger,
    ) {
        let body = detached.map_or(FlowBody::Fed, |_| FlowBody::Third);
        *self = Grain {
            inside,
            has_entered: inside,
            detached: detached.unwrap_or(NEVER),
            ..Grain::at_start(body, section)
        };
        let (all, in_zone) = match detached {
            None => (&mut ledger.injected, &mut ledger.external),
            Some(_) => (&mut ledger.detached, &mut ledger.source),
        };
        *all += mass;
        *in_zone += if inside { mass } else { 0.0 };
    }

    fn cross_section(&mut self, section: i32, mass: f64, ledger: &mut MassLedger) {
        if self.is_third() {
            let passed = f64::from(section - self.section) * mass;
            ledger.internal_net += passed;
            ledger.internal_abs += passed.abs();
        }
        self.section = section;
    }

    /// The grain is inside or outside from this time on (s).
    fn cross_end(
        &mut self,
        inside: bool,
        by: Crossing,
        time: f64,
        mass: f64,
        ledger: &mut MassLedger,
    ) {
        if inside == self.inside {
            return;
        }
        self.inside = inside;
        if !self.is_third() {
            return;
        }
        let account = match (inside, by) {
            (false, Crossing::OwnMotion) => &mut ledger.ejected,
            (false, Crossing::ZoneMotion) => &mut ledger.uncovered,
            (true, Crossing::ZoneMotion) => &mut ledger.covered,
            (true, Crossing::OwnMotion) if self.has_entered => &mut ledger.recirculated,
            (true, Crossing::OwnMotion) => &mut ledger.entered,
        };
        *account += mass;
        if inside && self.worn {
            ledger.wear_returned += mass;
        }
        self.has_entered = true;
        self.worn = false;
        self.left_at = (!inside).then_some(time);
    }

    fn change_body(&mut self, first: bool, time: f64, mass: f64, ledger: &mut MassLedger) {
        if first != self.is_third() {
            return;
        }
        if first {
            ledger.reattached += if self.inside { mass } else { 0.0 };
            self.body = FlowBody::First;
        } else {
            ledger.source += if self.inside { mass } else { 0.0 };
            ledger.detached += mass;
            self.body = FlowBody::Third;
            self.detached = time;
        }
        self.has_entered = self.inside && !first;
        self.worn = false;
        self.left_at = None;
    }

    fn wear(&mut self, until: f64, mass: f64, ledger: &mut MassLedger) {
        if !self.worn && self.left_at.is_some_and(|left| left <= until) {
            ledger.wear += mass;
            self.worn = true;
        }
    }
}

/// True for each free disk that these bonds or its cluster connect with an anchor. A cluster counts as a whole, whichever of its disks is bonded; a
/// driven cluster is first body.
fn first_grains(bodies: &Bodies, bonds: &[(u32, u32)]) -> Vec<bool> {
    let held = bodies.clusters.held(bodies.free as u32);
    let pairs: Vec<(u32, u32)> = bonds.iter().copied().chain(held).collect();
    first_bodies(bodies.free, &pairs)
}

impl Flow {
    /// The flows at the start, without a zone; third body is initial stock.
    pub fn new(config: &FlowConfig, bodies: &Bodies, state: &GrainState) -> Flow {
        let bonds: Vec<(u32, u32)> = holding(&state.bonds).collect();
        let first = first_grains(bodies, &bonds);
        let present = state.present(bodies);
        let body = |grain: usize| {
            if first[grain] {
                FlowBody::First
            } else if grain < present {
                FlowBody::Stock
            } else {
                FlowBody::Fed
            }
        };
        let grains = state.centres[..bodies.free].iter().enumerate();
        let grains = grains.map(|(grain, at)| Grain::at_start(body(grain), section(bodies, at[0])));
        Flow {
            grains: grains.collect(),
            present,
            bonds,
            lateral: config.lateral.is_some(),
            ..Flow::default()
        }
    }

    /// Records a step of the length `step` that ended at a time `end` (s) in this state.
    pub fn record(
        &mut self,
        scene: &FlowScene,
        (bodies, state): (&Bodies, &GrainState),
        end: f64,
        step: f64,
    ) {
        let before = self.zone;
        self.follow_contact(scene, (bodies, state), step);
        if self.middle.is_none() && end + ROUNDING * step >= scene.middle_from {
            let middle = match bodies.period {
                None => self.zone.map(Zone::middle_half),
                Some(_) => self.zone,
            };
            self.middle = middle.filter(|middle| middle.ends[0] < middle.ends[1]);
        }
        let first = self.changed_bodies(bodies, state);
        let worn = end - scene.config.wear_s + ROUNDING * step;
        let ledger = &mut self.ledger;
        let (mut held, mut kinetic) = (0.0, 0.0);
        self.in_middle = 0.0;
        let come = self.present..state.present(bodies);
        let detached = state.worn.detaches().then_some(end);
        self.present = come.end;
        let positions = state.positions(bodies);
        for (i, grain) in self.grains[..come.end].iter_mut().enumerate() {
            if positions.is_taken(i) {
                continue;
            }
            let (centre, mass) = (state.centres[i], scene.masses[i]);
            let ([x, _], section) = (shown(bodies, centre), section(bodies, centre[0]));
            let [was_inside, inside] =
                [before, self.zone].map(|zone| zone.is_some_and(|zone| zone.holds(x)));
            if come.contains(&i) {
                grain.feed_in(detached, section, was_inside, mass, ledger);
            }
            grain.cross_section(section, mass, ledger);
            grain.cross_end(was_inside, Crossing::OwnMotion, end, mass, ledger);
            grain.cross_end(inside, Crossing::ZoneMotion, end, mass, ledger);
            if let Some(first) = &first {
                grain.change_body(first[i], end, mass, ledger);
            }
            grain.wear(worn, mass, ledger);
            // From the positions, not from the grain's record: the ledger is checked against this sum.
            if grain.is_third() && inside {
                held += mass;
            }
            if inside {
                let [vx, vy, _] = state.velocities[i];
                kinetic += mass * (vx * vx + vy * vy);
            }
            if grain.is_third() && self.middle.is_some_and(|middle| middle.holds(x)) {
                self.in_middle += mass;
            }
        }
        self.held = held;
        self.kinetic[0] += scene.mass_scale * kinetic;
        self.kinetic[1] += match bodies.wheel() {
            Some(_) => self.loads.force() * (state.wheel.position[1] - scene.base),
            None => pressed_by_lid(bodies, state, scene.base),
        };
        self.defect = larger(self.defect, (self.held - ledger.zone()).abs());
    }

    /// Moves the zone: to the ends of the strip or of the lid, or with the contacts that carry the wheel. It stays while these bear nothing.
    fn follow_contact(
        &mut self,
        scene: &FlowScene,
        (bodies, state): (&Bodies, &GrainState),
        step: f64,
    ) {
        let (config, diameter) = (&scene.config, scene.diameter);
        let share = -(-step / config.mean_s()).exp_m1();
        self.loads.update(bodies, state, diameter, share);
        if bodies.period.is_some() || bodies.wheel().is_none() {
            let ends = ends(bodies, state, 0, bodies.lid());
            self.zone = Some(Zone { ends });
            return;
        }
        let Some(found) = Zone::find(config, &self.loads, diameter) else {
            return;
        };
        let slack = scene.config.hysteresis_diameters * scene.diameter;
        self.zone = Some(self.zone.map_or(found, |zone| zone.moved_to(found, slack)));
    }

    /// True for each grain that is now first body; `None` while the same bonds hold.
    fn changed_bodies(&mut self, bodies: &Bodies, state: &GrainState) -> Option<Vec<bool>> {
        if holding(&state.bonds).eq(self.bonds.iter().copied()) {
            return None;
        }
        self.bonds.clear();
        self.bonds.extend(holding(&state.bonds));
        Some(first_grains(bodies, &self.bonds))
    }

    /// Number of grains.
    pub fn count(&self) -> usize {
        self.grains.len()
    }

    /// Membership of each grain.
    pub fn bodies(&self) -> impl Iterator<Item = FlowBody> {
        self.grains.iter().map(|grain| grain.body)
    }

    /// Time at which each grain was last detached (s); -1 for a grain that never was.
    pub fn detached(&self) -> impl Iterator<Item = f64> {
        self.grains.iter().map(|grain| grain.detached)
    }

    /// The masses since the start.
    pub fn ledger(&self) -> &MassLedger {
        &self.ledger
    }

    /// Third body per length in the middle half that the zone had when the motion began (kg/m); 0 before.
    pub fn per_length(&self) -> f64 {
        let [left, right] = self.middle.map_or([0.0, 1.0], |middle| middle.ends);
        self.in_middle / (right - left)
    }

    /// The masses of the ledger, with the lateral mass where `flow.lateral` is given.
    fn named(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let lateral = self.lateral.then_some(self.ledger.lateral);
        let named = self.ledger.named().into_iter();
        named.chain(given([("q_lateral_kg", lateral)]))
    }

    /// The masses of the ledger, the third body in the zone and in its middle, and the ends of the zone, 0 before the wheel bears a load.
    pub fn signals(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let [left, right] = self.zone.map_or([0.0; 2], |zone| zone.ends);
        self.named().chain([
            ("third_body_zone_kg", self.held),
            ("third_body_per_length_kg_per_m", self.per_length()),
            ("zone_left_m", left),
            ("zone_right_m", right),
        ])
    }

    /// The masses of the ledger, the third body in the zone, its largest difference from the ledger over the turnover, and the third body in the
    /// middle of the zone once the motion has begun.
    pub fn results(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let turnover = self.ledger.turnover();
        let defect = self.defect / if turnover > 0.0 { turnover } else { 1.0 };
        let middle = self.middle.map(|_| self.per_length());
        let results = self.named().chain([
            ("third_body_zone_kg", self.held),
            ("flow_balance_rel", defect),
            ("flow_kinetic_rel", self.kinetic_share()),
        ]);
        results.chain(given([("third_body_per_length_kg_per_m", middle)]))
    }

    /// Kinetic stress of the grains in the zone over the pressure of the wheel or the lid: sum m v^2 / (2 V) over F / A, V = A H.
    pub fn kinetic_share(&self) -> f64 {
        let [twice, borne] = self.kinetic;
        if borne > 0.0 {
            0.5 * twice / borne
        } else {
            0.0
        }
    }

    /// blake3 over another hash and every number, in hexadecimal.
    pub fn hash(&self, before: &str) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(before.as_bytes());
        self.for_each_number(|x| {
            hasher.update(&x.to_bits().to_le_bytes());
        });
        hasher.finalize().to_hex().to_string()
    }

    /// All numbers that can change a later bit, except the bonds, which the state has.
    fn for_each_number(&self, mut visit: impl FnMut(f64)) {
        for grain in &self.grains {
            visit(f64::from(grain.body as u8));
            visit(f64::from(grain.inside));
            visit(f64::from(grain.has_entered));
            visit(f64::from(grain.section));
            visit(f64::from(grain.worn));
            visit(grain.detached);
            visit(grain.left_at.unwrap_or(NEVER));
        }
        self.loads.numbers().for_each(&mut visit);
        for zone in [self.zone, self.middle].into_iter().flatten() {
            zone.ends.into_iter().for_each(&mut visit);
        }
        self.ledger.named().iter().for_each(|(_, x)| visit(*x));
        visit(self.held);
        visit(self.defect);
        self.kinetic.iter().for_each(|x| visit(*x));
        visit(self.in_middle);
        if self.lateral {
            visit(self.ledger.lateral);
            visit(self.lateral_due);
        }
    }
}

/// See [`Grain::section`].
fn section(bodies: &Bodies, x: f64) -> i32 {
    match bodies.period {
        None => i32::from(x >= 0.0),
        Some(period) => 1 + (x / period.length).floor() as i32,
    }
}

/// Force of the grains on the lid, upwards, times its mean height above a base (J).
fn pressed_by_lid(bodies: &Bodies, state: &GrainState, base: f64) -> f64 {
    let (lid, positions) = (bodies.lid(), state.positions(bodies));
    let slots = state.list.slots.iter();
    let forces = slots
        .filter(|slot| lid.contains(&(slot.b as usize)))
        .map(|slot| {
            let at = positions.proximity(slot.a as usize, slot.b as usize);
            -(slot.force[0] * at.normal[1] + slot.force[1] * at.normal[0])
        });
    let heights = state.centres[lid.clone()].iter().map(|centre| centre[1]);
    forces.sum::<f64>() * (heights.sum::<f64>() / lid.len().max(1) as f64 - base)
}

#[cfg(test)]
mod tests;
