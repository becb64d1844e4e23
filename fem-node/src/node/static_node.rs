//! A static analysis as a participant.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use fem_kernel::integrate::state::NodalState;
use fem_kernel::statics::contact::WheelContact;
use fem_kernel::statics::history::{IncrementState, StaticLoads, StaticState, Statics};
use fem_kernel::wheel::node_contact::ContactStatus;
use fem_kernel::wheel::rolled::rolled_piece;
use kit::rolled::{RolledPiece, RollingRecord};
use kit::rolling::{Rolling, nearest_image};
use kit::wheel::{HOLD, moments, phases};
use protocol::checkpoint::{pack, unpack};
use protocol::{
    Capabilities, Description, Finding, Node, NodeError, Outcome, Setting, Surface, Window,
};

use serde::{Deserialize, Serialize};

use super::checkpoint::foreign;
use super::report::hash_of;
use crate::config::keys::FemConfig;
use crate::error::FemError;
use crate::interface::coupling_sets;
use crate::model::Model;
use crate::model::heat::{BodyHeat, HeatState};
use crate::model::rolling::Roll;
use crate::output::plausible;
use crate::output::probe;
use crate::output::profile::ContactProfile;
use crate::output::snapshot::Snapshots;

/// Increments between two reports. A report costs a solve of the whole body, an increment several; 5 take less than a second on 28 080 elements, far
/// below the coupler's timeout.
const INCREMENTS_AT_ONCE: u32 = 5;

/// Increments in which a force on a wheel that does not roll yet grows to its value.
const IN_PLACE: u64 = 50;

/// A body whose loads grow so slowly that it is always in equilibrium. Its time counts increments, 1 s each: first of the load, then of the sideways
/// cycles D = A sin(2 pi c), or of the distance that the wheel rolls.
///
/// With the fields of a snapshot NAME it writes `<participant>-NAME-profile.csv`: x_m, pressure_pa, shear_pa, status.
pub struct StaticNode {
    /// Mesh, body and loads.
    pub model: Model,
    snapshots: Snapshots,
    statics: Statics,
    loads: Option<StaticLoads>,
    cycling: Cycling,
    rolling: Option<RollingIncrements>,
    /// The equilibrium under the full load, `None` until it is reached.
    pub held: Option<StaticState>,
    cycles: CycleRecord,
    rolled: RollingRecord,
    heat: HeatState,
    /// Time of an increment of the motion (s).
    increment_s: f64,
}

/// The part of a static analysis that a checkpoint keeps.
#[derive(Debug, Serialize, Deserialize)]
struct StaticRecord {
    progress: IncrementState,
    held: Option<StaticState>,
    cycles: CycleRecord,
    rolled: RollingRecord,
    heat: HeatState,
}

/// The rolling after the loading: increments in place, in which a given force grows to its value at the start, then equal distances.
#[derive(Clone, Debug)]
struct RollingIncrements {
    rolling: Rolling,
    in_place: u64,
    rolled: u64,
}

/// The sideways motion after the loading.
#[derive(Clone, Copy, Debug)]
struct Cycling {
    amplitude: f64,
    increments: u64,
    per_cycle: u32,
}

/// Record of the sideways cycles.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct CycleRecord {
    /// (D, force of the wheel on the body in x) after each increment, the loaded state first.
    path: Vec<[f64; 2]>,
    /// Sn at each zero of D after the first reversal (%).
    slipping_at_zero: Vec<f64>,
}

impl StaticNode {
    /// Builds and factorises the body; nothing is loaded yet.
    pub fn new(config: &FemConfig, setting: &Setting) -> Result<StaticNode, FemError> {
        let model = Model::new(config, setting)?;
        let loads = config.static_loads();
        let rolling = RollingIncrements::new(config, &model)?;
        let wheel = config.wheel.iter().find(|wheel| wheel.amplitude_m > 0.0);
        let (amplitude, cycles) =
            wheel.map_or((0.0, 0.0), |wheel| (wheel.amplitude_m, wheel.cycles));
        let frequency = wheel.map_or(0.0, |wheel| wheel.frequency_hz);
        let rolled_in = rolling.as_ref().map(RollingIncrements::increment_s);
        let increment_s =
            rolled_in.unwrap_or(1.0 / (frequency * f64::from(config.statics.per_cycle())));
        let of_body = model.heat.as_ref();
        of_body.map_or(Ok(()), |heat| heat.check_step(increment_s))?;
        Ok(StaticNode {
            heat: of_body.map(BodyHeat::at_start).unwrap_or_default(),
            increment_s,
            statics: Statics::new(&model.static_problem(), loads)?,
            snapshots: Snapshots::new(setting),
            loads,
            cycling: Cycling {
                amplitude,
                increments: config.statics.cycle_increments(cycles) as u64,
                per_cycle: config.statics.per_cycle(),
            },
            rolling,
            held: None,
            cycles: CycleRecord::default(),
            rolled: RollingRecord::default(),
            model,
        })
    }

    fn done(&self) -> u64 {
        self.statics.increments_done as u64
    }

    fn loading(&self) -> u64 {
        self.statics.loading_increments() as u64
    }

    /// Increments of the whole history.
    fn end(&self) -> u64 {
        let rolling = self.rolling.as_ref();
        let rolling = rolling.map_or(0, |rolling| rolling.in_place + rolling.rolled);
        self.loading() + self.cycling.increments + rolling
    }

    fn increment(&mut self) -> Result<(), FemError> {
        if self.done() >= self.end() {
            return Ok(());
        }
        if self.done() < self.loading() {
            self.statics.load_increment(&self.model.static_problem())?;
            if self.done() == self.loading() {
                self.held = Some(self.statics.state(&self.model.static_problem()));
                self.note();
            }
            return Ok(());
        }
        let step = self.done() + 1 - self.loading();
        if self.rolling.is_some() {
            return self.roll(step);
        }
        self.statics
            .move_to(&self.model.static_problem(), self.cycling.lateral(step))?;
        self.note();
        self.warm();
        if let (true, Some(contact)) = (self.cycling.passes_zero(step), self.statics.contact()) {
            let slipping = 100.0 * contact.slipping_share();
            self.cycles.slipping_at_zero.push(slipping);
        }
        Ok(())
    }

    /// The increment of this number after the loading.
    fn roll(&mut self, step: u64) -> Result<(), FemError> {
        let problem = self.model.static_problem();
        let before = self.statics.contact();
        let (Some(increments), Some(before), Some(wheel)) =
            (&self.rolling, before, &self.model.wheel)
        else {
            return Ok(());
        };
        let rolling = &increments.rolling;
        let (rolled, share) = (increments.at(step), increments.share(step));
        self.statics.roll_to(&problem, rolling, rolled, share)?;
        let way = rolled - increments.at(step - 1);
        if let Some(after) = self.statics.contact().filter(|_| way > 0.0) {
            let contacts = after.node_contacts();
            let piece = rolled_piece(&contacts, &wheel.areas, self.model.wheel_radius, rolling);
            let piece = RolledPiece {
                way,
                turned: rolling.direction() * (after.turned - before.turned),
                dissipated: after.lost() - before.lost(),
                ..piece
            };
            self.rolled.add(rolling, &piece);
            self.warm();
        }
        Ok(())
    }

    /// Takes the slip of the increment as heat, and lets it pass in the time of the increment.
    fn warm(&mut self) {
        let contact = self.statics.contact();
        if let Some((heat, contact)) = self.model.heat.as_ref().zip(contact) {
            self.heat.advance(heat, contact.rubbed(), self.increment_s);
        }
    }

    fn note(&mut self) {
        if let Some(contact) = self.statics.contact() {
            let point = [contact.lateral, contact.resultant()[0]];
            self.cycles.path.push(point);
        }
    }

    /// Signals by name; the wheel's signals have the same names as in dynamics. `wheel_fn_n` and `wheel_ft_n` are the force of the body on the wheel,
    /// upwards and towards +x.
    fn signals(&self, at: &StaticState) -> Vec<(String, f64)> {
        let (model, state) = (&self.model, &at.state);
        let mut signals = probe::surface_signals(model, state);
        if let Some(contact) = &at.contact {
            let [fx, fy] = contact.resultant();
            let statuses = contact.status.iter();
            let touching = statuses.filter(|s| **s != ContactStatus::Open).count();
            let named = [
                (
                    "wheel_x_m",
                    nearest_image(contact.lateral, model.mesh.period()),
                ),
                ("approach_m", contact.approach),
                ("wheel_fn_n", -fy),
                ("wheel_ft_n", -fx),
                ("sn_pct", 100.0 * contact.slipping_share()),
                ("contact_nodes", touching as f64),
            ];
            signals.extend(named.map(|(name, value)| (name.into(), value)));
            if self.rolling.is_some() {
                let rolled = self.rolled.signals();
                signals.extend(rolled.map(|(name, value)| (name.into(), value)));
            }
        }
        let heat = model.heat.iter();
        signals.extend(heat.flat_map(|heat| heat.signals(&self.heat)));
        let probes = model.probes.iter();
        signals.extend(probes.flat_map(|probe| probe.signals(model.body.layout, state, false)));
        signals
    }

    fn try_snapshot(&mut self, name: &str) -> Result<(), FemError> {
        if !self.snapshots.wanted() {
            return Ok(());
        }
        let state = match &self.held {
            Some(held) if name == HOLD => held.clone(),
            _ => self.statics.state(&self.model.static_problem()),
        };
        let contact = state.contact.as_ref();
        let contacts = contact.map_or(Vec::new(), |contact| contact.node_contacts());
        let profile = contact.map(|contact| ContactProfile::new(&self.model, contact));
        let surface = (&*contacts, profile.as_ref(), &self.heat);
        self.snapshots
            .write(name, &self.model, &state.state, surface)
    }

    /// Values beyond their bounds, in the equilibrium under the full load and in the last one.
    fn findings(&self, states: [&StaticState; 2]) -> Vec<Finding> {
        let model = &self.model;
        let strain = states.iter().fold(0.0, |largest, state| {
            plausible::strain_so_far(largest, model, &state.state)
        });
        let contacts = states.iter().filter_map(|state| state.contact.as_ref());
        let profiles: Vec<ContactProfile> =
            contacts.map(|c| ContactProfile::new(model, c)).collect();
        let found = [
            plausible::strain(model, strain),
            plausible::locking(model, &states[1].state, 0.0),
            plausible::contact_reach(model, profiles.iter()),
            profiles
                .first()
                .and_then(|held| plausible::contact_resolution(model, held)),
            profiles.last().and_then(|last| {
                let creepage = self.rolling.as_ref().map(|_| self.rolled.creepage());
                plausible::wheel_points(model, last, (creepage, self.cycling.amplitude))
            }),
        ];
        let lost = states[1].contact.as_ref().map_or(0.0, WheelContact::lost);
        let heat = plausible::heat(model, &self.heat, [lost, 0.0]);
        found.into_iter().flatten().chain(heat).collect()
    }

    fn results(&self, [held, last]: [&StaticState; 2]) -> BTreeMap<String, f64> {
        let maxima = probe::pressure_maxima(&self.model, &held.state);
        let mut results = BTreeMap::from(maxima.results());
        let mut add = |name: &str, value: f64| results.insert(name.to_string(), value);
        if let Some((loads, contact)) = self.loads.zip(held.contact.as_ref()) {
            let profile = ContactProfile::new(&self.model, contact);
            add("load_n", loads.load);
            add("approach_m", contact.approach);
            add("p0_pa", profile.peak());
            if let Some(width) = profile.half_width(loads.start, self.model.mesh.period()) {
                add("contact_half_width_m", width);
            }
        }
        let rolling = self.rolling.iter();
        let radius = self.model.wheel_radius;
        let rolled = rolling.flat_map(|all| self.rolled.results(&all.rolling, radius));
        let shift = self.model.roll.as_ref().map(Roll::box_shift);
        let rolled = rolled.chain(shift.map(|shift| ("creepage_box_shift", shift)));
        for (name, value) in rolled.chain(self.cycles.results(self.cycling.per_cycle as usize)) {
            add(name, value);
        }
        results.extend(probe::outward_displacements(&self.model, &held.state));
        let lost = last.contact.as_ref().map_or(0.0, WheelContact::lost);
        let heat = self.model.heat.iter();
        results.extend(heat.flat_map(|heat| heat.results(&self.heat, [lost, 0.0])));
        results
    }
}

impl RollingIncrements {
    fn new(config: &FemConfig, model: &Model) -> Result<Option<RollingIncrements>, FemError> {
        let Some(roll) = &model.roll else {
            return Ok(None);
        };
        let rolling = &roll.rolling;
        let at_start = rolling.force(0.0).unwrap_or(0.0) != 0.0;
        Ok(Some(RollingIncrements {
            in_place: if at_start { IN_PLACE } else { 0 },
            rolled: config
                .statics
                .rolling_increments(rolling, roll.spacing[0])?,
            rolling: rolling.clone(),
        }))
    }

    /// Distance rolled after this many increments (m).
    fn at(&self, step: u64) -> f64 {
        let rolled = step.saturating_sub(self.in_place) as f64;
        self.rolling.distance * rolled / self.rolled as f64
    }

    /// Time of an increment of rolling (s).
    fn increment_s(&self) -> f64 {
        self.rolling.distance / self.rolling.speed.abs() / self.rolled as f64
    }

    /// Share of the force that acts after this many increments.
    fn share(&self, step: u64) -> f64 {
        (step as f64 / self.in_place.max(1) as f64).min(1.0)
    }
}

impl Cycling {
    /// D after this many increments (m).
    fn lateral(&self, step: u64) -> f64 {
        let within = step % u64::from(self.per_cycle);
        self.amplitude * (TAU * within as f64 / f64::from(self.per_cycle)).sin()
    }

    /// True where D = 0 after this many increments, after a reversal.
    fn passes_zero(&self, step: u64) -> bool {
        (2 * step).is_multiple_of(u64::from(self.per_cycle))
    }
}

impl CycleRecord {
    fn results(&self, per_cycle: usize) -> Vec<(&'static str, f64)> {
        let mut results = Vec::new();
        let mut ends = (0..self.path.len()).step_by(per_cycle);
        if let Some(end) = ends.next_back().filter(|end| *end > 0) {
            let last = &self.path[end - per_cycle..=end];
            results.push(("loop_area_j", loop_area(last)));
        }
        let zeros = &self.slipping_at_zero;
        if !zeros.is_empty() {
            let mean = zeros.iter().sum::<f64>() / zeros.len() as f64;
            results.push(("sn_max_velocity_pct", mean));
        }
        results
    }
}

/// Work of the wheel along a path, the integral of the force over D (J).
fn loop_area(path: &[[f64; 2]]) -> f64 {
    let trapezium = |pair: &[[f64; 2]]| 0.5 * (pair[0][1] + pair[1][1]) * (pair[1][0] - pair[0][0]);
    path.windows(2).map(trapezium).sum()
}

impl Node for StaticNode {
    fn describe(&self) -> Description {
        let unloaded = StaticState {
            state: NodalState::at_rest(&self.model.body),
            contact: self.statics.contact(),
        };
        let signals = self.signals(&unloaded).into_iter();
        let [loaded, end] = [self.loading(), self.end()].map(|increments| increments as f64);
        let [motion, moved_by] = match &self.rolling {
            Some(_) => ["rolling", "wheel.rolling"],
            None => ["cycling", "wheel.cycles"],
        };
        Description {
            kind: "fem".into(),
            software: format!("fem-node {}", env!("CARGO_PKG_VERSION")),
            capabilities: Capabilities {
                alone: true,
                resume: true,
                ..Capabilities::default()
            },
            step_s: Some(1.0),
            steps_at_once: Some(INCREMENTS_AT_ONCE),
            step_limit_s: None,
            step_limit_name: "none: the time of a static analysis counts increments".into(),
            end_s: Some(end),
            phases: phases([(HOLD, 0.0, loaded), (motion, loaded, end)]),
            moments: moments([
                ("wheel.load_n", self.loads.map(|_| loaded)),
                (moved_by, self.loads.map(|_| end)),
            ]),
            // No set can be coupled; `couple` gives the reason where an interface names one.
            sets: coupling_sets(&self.model),
            signals: signals.map(|(name, _)| name).collect(),
            ledger: Vec::new(),
            warnings: self.model.warnings.clone(),
            ..Description::default()
        }
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        Err(FemError::CoupledStatics { set: set.into() }.into())
    }

    fn select(&mut self, _points: &[usize]) -> Result<(), NodeError> {
        Ok(())
    }

    fn commit(&mut self, window: &Window, _displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        let (window, advanced) = (window.index, None);
        Err(FemError::NotAdvanced { window, advanced }.into())
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        for _ in 0..window.substeps {
            self.increment()?;
        }
        let signals = self.signals(&self.statics.state(&self.model.static_problem()));
        Ok(signals.into_iter().map(|(_, value)| value).collect())
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        let history = StaticRecord {
            progress: self.statics.progress(),
            held: self.held.clone(),
            cycles: self.cycles.clone(),
            rolled: self.rolled.clone(),
            heat: self.heat.clone(),
        };
        let bytes = pack(&history)?;
        let hash = blake3::hash(&bytes).to_hex().to_string();
        pack(&(hash, bytes))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        let (hash, bytes): (String, Vec<u8>) = unpack(state)?;
        if blake3::hash(&bytes).to_hex().as_str() != hash {
            return foreign("its numbers have another hash");
        }
        let history: StaticRecord = unpack(&bytes)?;
        let length = self.model.body.layout.len();
        if history.held.iter().any(|held| held.state.u.len() != length) {
            return foreign("its fields have other lengths");
        }
        if !self.statics.take_up(history.progress) {
            return foreign("the nodes of its upper edge differ");
        }
        (self.held, self.cycles) = (history.held, history.cycles);
        (self.rolled, self.heat) = (history.rolled, history.heat);
        Ok(())
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        Ok(self.try_snapshot(name)?)
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        let last = self.statics.state(&self.model.static_problem());
        let contact = last.contact.iter();
        let forces = contact.flat_map(|c| c.normal.iter().chain(&c.tangential));
        let heat = self.heat.numbers();
        let numbers = last.state.u.iter().chain(forces).chain(heat).copied();
        let state_hash = hash_of(&[], numbers);
        let held = self.held.as_ref().unwrap_or(&last);
        let results = self.results([held, &last]);
        if let Some(increments) = &self.rolling {
            let table = self
                .rolled
                .csv(&increments.rolling, self.model.wheel_radius);
            self.snapshots.table("passages", &table)?;
        }
        let findings = self.findings([held, &last]);
        Ok(Outcome {
            steps: self.done(),
            work: BTreeMap::from([("load_increments".into(), self.done() as f64)]),
            results,
            state_hash,
            findings,
            ..Outcome::default()
        })
    }
}
