//! A solver with one fault: another solver with one spoilt answer.

use std::sync::atomic::{AtomicU64, Ordering};

use kit::{ConfigError, read_table};
use protocol::{
    BoundaryAnswer, Description, Node, NodeError, Outcome, Reaction, Role, Session, Setting,
    Surface, Term, Window,
};
use serde::Deserialize;
use serde_json::Value;

/// Keys: the harm, the kind of the solver, and its keys.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    harm: Harm,
    kind: String,
    config: Value,
}

/// The faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Harm {
    /// No fault.
    Nothing,
    /// A tributary length of NaN.
    NanLength,
    /// A mass of NaN.
    NanMass,
    /// A mass below zero.
    NegativeMass,
    /// Coordinates in millimetres.
    Millimetres,
    /// A surface 1 m above.
    FarAway,
    /// A step below zero.
    NegativeStep,
    /// A step of zero.
    ZeroStep,
    /// Columns of zeros.
    ZeroColumns,
    /// Columns whose upper triangle is doubled.
    AsymmetricColumns,
    /// Displacements since the start instead of increments.
    Totals,
    /// Repeats of a window with one substep less, although it is committed with all substeps.
    ShortRepeats,
    /// Repeats of a window with answers 1 % too large.
    LargeRepeats,
    /// Repeats of a window that start from the end of the previous try.
    Forgets,
    /// A signal of NaN.
    NanSignal,
    /// An energy of NaN.
    NanEnergy,
    /// A ledger of twice the right values.
    DoubleLedger,
    /// A ledger without its interface's work.
    NoInterfaceWork,
    /// Columns of half the size.
    HalfColumns,
    /// A report that lacks its last energy.
    ShortReport,
    /// Windows of a few substeps at most, for any request.
    OneLength,
    /// Motions and forces of the wrong sign.
    Against,
    /// Stored energies of half the size.
    HalfStored,
    /// Fields written after an additional window.
    FieldsMove,
    /// A checkpoint that is restored without effect.
    LazyRestore,
    /// A hash that is the same for every state.
    OneHash,
    /// A farewell that counts no steps.
    NoSteps,
    /// The points of another set for a set that does not exist.
    AnySet,
    /// Answers that differ from one instance to the next.
    OddLives,
    /// Prescribed velocities that are halved.
    HalfVelocity,
    /// A boundary that is rigid for any compliance.
    AlwaysRigid,
    /// Solves that never converge.
    NeverConverges,
    /// The first points instead of the selected ones.
    WrongPoints,
    /// A capability that is only claimed: running alone.
    ClaimsAlone,
    /// Masses a hundred times too large.
    Heavy,
    /// Masses a hundred times too small.
    Light,
    /// Motions and forces with 1e-3 of noise.
    Noise,
    /// A tenth of the stored energies, with the rest reported as dissipated.
    TenthStored,
    /// A kinetic energy of zero.
    NoKinetic,
    /// Three times the dissipated energies.
    TripleDissipated,
    /// A layer that answers with zero force, has no ledger and reports no load.
    Silent,
    /// A layer that answers with half the force from window 60 on.
    Halves,
    /// A layer that answers with the same force from window 60 on.
    Freezes,
    /// A layer that adds three tenths of each normal force to the tangential one.
    Tangential,
    /// Sound, but without columns.
    NoColumns,
    /// Sound, but each window can be requested only once.
    NoRollback,
    /// Sound, but only on rigid boundaries.
    RigidOnly,
    /// Sound, but without a declared step; its internal step is half a second.
    NoStep,
    /// Sound, but with points without mass.
    Weightless,
}

/// Longest window (substeps) with [`Harm::OneLength`].
const LENGTH: u32 = 5;

/// Internal step with [`Harm::NoStep`] (s).
const INSIDE_S: f64 = 0.5;

static LIVES: AtomicU64 = AtomicU64::new(0);

/// A scenario with one of its participants behind a harm.
pub fn harmed(text: &str, [participant, harm]: [&str; 2]) -> String {
    let mut table: toml::Table = text.parse().expect("it is TOML");
    let participants = table["participant"].as_array_mut().expect("a list");
    let named = |value: &&mut toml::Value| value["name"].as_str() == Some(participant);
    let one = participants.iter_mut().find(named).expect("it takes part");
    let one = one.as_table_mut().expect("a table");
    let kind = one.insert("kind".into(), "broken".into()).expect("a kind");
    let config = one.remove("config").expect("keys");
    let harmed = [("harm", harm.into()), ("kind", kind), ("config", config)];
    let harmed = harmed.map(|(key, value)| (key.to_string(), value));
    one.insert("config".into(), toml::Table::from_iter(harmed).into());
    toml::to_string(&table).expect("it was TOML")
}

struct Broken {
    /// Requests so far.
    requests: u64,
    /// The frozen force.
    frozen: Vec<f64>,
    node: Box<dyn Node>,
    harm: Harm,
    /// Increments of the last answer, and their sum over the committed windows.
    last: Vec<f64>,
    total: Vec<f64>,
    set: String,
    life: u64,
    /// A window was requested and not accepted yet.
    asked: bool,
}

/// Builds it.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: Config = read_table(&session.config)?;
    let session = Session {
        config: config.config,
        ..session.clone()
    };
    let registry = crate::registry();
    let solver = registry
        .get(&config.kind)
        .ok_or_else(|| NodeError::configuration(format!("no solver of kind `{}`", config.kind)))?;
    Ok(Box::new(Broken {
        requests: 0,
        frozen: Vec::new(),
        node: (solver.build)(&session)?,
        harm: config.harm,
        last: Vec::new(),
        total: Vec::new(),
        set: String::new(),
        asked: false,
        life: LIVES.fetch_add(1, Ordering::Relaxed),
    }))
}

impl Broken {
    /// The window, perhaps shorter than requested.
    fn window(&self, window: &Window) -> Window {
        let steps = (window.t1_s - window.t0_s) / INSIDE_S;
        let substeps = match self.harm {
            Harm::OneLength => window.substeps.min(LENGTH),
            Harm::NoStep => steps.round() as u32,
            _ => window.substeps,
        };
        Window {
            substeps,
            ..*window
        }
    }

    /// Changes numbers by up to 1e-3, each time differently.
    fn disturb(&mut self, numbers: &mut [f64]) {
        self.requests += 1;
        let factor = 1.0 + 1e-3 * (self.requests as f64).sin();
        numbers.iter_mut().for_each(|number| *number *= factor);
    }

    /// Refuses a second window before the first is accepted, if windows cannot be repeated.
    fn ask_once(&mut self) -> Result<(), NodeError> {
        if self.asked && self.harm == Harm::NoRollback {
            return Err(NodeError::configuration("a window twice"));
        }
        self.asked = true;
        Ok(())
    }
}

impl Node for Broken {
    fn describe(&self) -> Description {
        let mut description = self.node.describe();
        match self.harm {
            Harm::NegativeStep => description.step_s = description.step_s.map(|step| -step),
            Harm::ZeroStep => description.step_s = Some(0.0),
            Harm::ClaimsAlone => description.capabilities.alone = true,
            Harm::NoColumns => description.capabilities.columns = false,
            Harm::NoRollback => {
                description.capabilities.rollback = false;
                description.capabilities.resume = false;
            }
            Harm::RigidOnly => {
                description.capabilities.compliant_boundary = false;
                description.capabilities.rigid_boundary = true;
            }
            Harm::NoStep => description.step_s = None,
            Harm::Silent => description.ledger.clear(),
            Harm::TenthStored => description.ledger.push(Term {
                name: "lost_j".into(),
                role: Role::Dissipated,
            }),
            _ => {}
        }
        description
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
        let known = self.describe().sets.iter().any(|known| known == set);
        if self.harm == Harm::AnySet && !known {
            return self.node.couple(&self.set);
        }
        self.set = set.to_string();
        let mut surface = self.node.couple(set)?;
        let middle = surface.len() / 2;
        match self.harm {
            Harm::NanLength => surface.length_m[middle] = f64::NAN,
            Harm::NanMass => surface.mass_kg[middle] = f64::NAN,
            Harm::NegativeMass => surface.mass_kg[middle] *= -1.0,
            Harm::Millimetres => {
                let places = surface.x_m.iter_mut().chain(&mut surface.y_m);
                places.for_each(|place| *place *= 1e3);
            }
            Harm::Weightless => surface.mass_kg.fill(0.0),
            Harm::Heavy => surface.mass_kg.iter_mut().for_each(|m| *m *= 100.0),
            Harm::Light => surface.mass_kg.iter_mut().for_each(|m| *m /= 100.0),
            Harm::FarAway => surface.y_m.iter_mut().for_each(|y| *y += 1.0),
            _ => {}
        }
        Ok(surface)
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        self.total = vec![0.0; 2 * points.len()];
        if self.harm == Harm::WrongPoints {
            let first: Vec<usize> = (0..points.len()).collect();
            return self.node.select(&first);
        }
        self.node.select(points)
    }

    fn columns(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        if self.harm == Harm::NoColumns {
            return Err(NodeError::configuration("columns"));
        }
        let mut columns = self.node.columns(&self.window(window))?;
        let n = columns.len().isqrt();
        match self.harm {
            Harm::ZeroColumns => columns.fill(0.0),
            Harm::HalfColumns => columns.iter_mut().for_each(|c| *c *= 0.5),
            Harm::AsymmetricColumns => (0..n * n)
                .filter(|at| at % n < at / n)
                .for_each(|at| columns[at] *= 2.0),
            _ => {}
        }
        Ok(columns)
    }

    fn set_boundary(&mut self, window_s: f64, compliance: &[f64]) -> Result<(), NodeError> {
        if self.harm == Harm::RigidOnly && compliance.iter().any(|w| *w != 0.0) {
            return Err(NodeError::configuration("a boundary that yields"));
        }
        let rigid = vec![0.0; compliance.len()];
        let given = if self.harm == Harm::AlwaysRigid {
            &rigid
        } else {
            compliance
        };
        self.node.set_boundary(window_s, given)
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.ask_once()?;
        let window = &self.window(window);
        let repeat = window.iteration > 0;
        if repeat && self.harm == Harm::Forgets {
            self.node.commit(window, &[])?;
        }
        let mut increments = self.node.advance(window, force)?;
        match self.harm {
            Harm::ShortRepeats if repeat && window.substeps > 1 => {
                let short = Window {
                    substeps: window.substeps - 1,
                    ..*window
                };
                let short_answer = self.node.advance(&short, force)?;
                self.node.advance(window, force)?;
                increments = short_answer;
            }
            Harm::LargeRepeats if repeat => increments.iter_mut().for_each(|du| *du *= 1.01),
            Harm::Against => increments.iter_mut().for_each(|du| *du *= -1.0),
            Harm::OddLives => {
                let factor = 1.0 + 1e-15 * self.life as f64;
                increments.iter_mut().for_each(|du| *du *= factor);
            }
            Harm::Noise => self.disturb(&mut increments),
            _ => {}
        }
        self.last.clone_from(&increments);
        if self.harm == Harm::Totals {
            let sums = increments.iter_mut().zip(&self.total);
            sums.for_each(|(du, total)| *du += total);
        }
        Ok(increments)
    }

    fn impedance(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        self.node.impedance(window)
    }

    fn prescribe_velocity(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, NodeError> {
        if self.harm != Harm::HalfVelocity {
            return self.node.prescribe_velocity(window, velocity);
        }
        let half: Vec<f64> = velocity.iter().map(|v| 0.5 * v).collect();
        self.node.prescribe_velocity(window, &half)
    }

    fn solve(
        &mut self,
        window: &Window,
        free_velocity: &[f64],
    ) -> Result<BoundaryAnswer, NodeError> {
        self.ask_once()?;
        if window.iteration > 0 && self.harm == Harm::Forgets {
            self.node.commit(window, &self.total)?;
        }
        let mut answer = self.node.solve(window, free_velocity)?;
        match self.harm {
            Harm::Against => answer.force.iter_mut().for_each(|f| *f *= -1.0),
            Harm::NeverConverges => answer.converged = false,
            Harm::Noise => self.disturb(&mut answer.force),
            Harm::Silent => {
                answer.force.fill(0.0);
                answer.velocity = free_velocity.to_vec();
            }
            Harm::Halves if window.index >= 60 => answer.force.iter_mut().for_each(|f| *f *= 0.5),
            Harm::Freezes if window.index >= 60 => answer.force.clone_from(&self.frozen),
            Harm::Freezes => self.frozen.clone_from(&answer.force),
            Harm::Tangential => {
                let pairs = answer.force.chunks_exact_mut(2);
                pairs.for_each(|force| force[0] += 0.3 * force[1].abs());
            }
            _ => {}
        }
        Ok(answer)
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        self.asked = false;
        let window = &self.window(window);
        let mut report = self.node.commit(window, displacement)?;
        let sums = self.total.iter_mut().zip(&self.last);
        sums.for_each(|(total, du)| *total += du);
        let description = self.node.describe();
        let signals = description.signals.len();
        match self.harm {
            Harm::NanSignal => report[0] = f64::NAN,
            Harm::NanEnergy => report[signals] = f64::NAN,
            Harm::DoubleLedger => report[signals..].iter_mut().for_each(|j| *j *= 2.0),
            Harm::NoInterfaceWork => report[signals] = 0.0,
            Harm::ShortReport => drop(report.pop()),
            Harm::Silent => report.truncate(signals),
            Harm::TenthStored => {
                let mut lost = 0.0;
                let energies = report[signals..].iter_mut().zip(&description.ledger);
                for (joules, _) in energies.filter(|(_, term)| term.role == Role::Stored) {
                    lost += 0.9 * *joules;
                    *joules *= 0.1;
                }
                report.push(lost);
            }
            Harm::HalfStored => {
                let energies = report[signals..].iter_mut().zip(&description.ledger);
                let stored = energies.filter(|(_, term)| term.role == Role::Stored);
                stored.for_each(|(joules, _)| *joules *= 0.5);
            }
            Harm::NoKinetic => {
                let energies = report[signals..].iter_mut().zip(&description.ledger);
                let moved = energies.filter(|(_, term)| term.name.contains("kinetic"));
                moved.for_each(|(joules, _)| *joules = 0.0);
            }
            Harm::TripleDissipated => {
                let energies = report[signals..].iter_mut().zip(&description.ledger);
                let lost = energies.filter(|(_, term)| term.role == Role::Dissipated);
                lost.for_each(|(joules, _)| *joules *= 3.0);
            }
            _ => {}
        }
        Ok(report)
    }

    fn advance_alone(&mut self, window: &Window) -> Result<Vec<f64>, NodeError> {
        self.node.advance_alone(window)
    }

    fn checkpoint(&mut self) -> Result<Vec<u8>, NodeError> {
        self.node.checkpoint()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), NodeError> {
        if self.harm == Harm::LazyRestore {
            return Ok(());
        }
        self.node.restore(state)
    }

    fn snapshot(&mut self, name: &str) -> Result<(), NodeError> {
        if self.harm == Harm::FieldsMove {
            let window = Window {
                substeps: 1,
                ..Window::default()
            };
            self.node.advance(&window, &vec![0.0; self.total.len()])?;
            self.node.commit(&window, &[])?;
        }
        self.node.snapshot(name)
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        let mut outcome = self.node.finish()?;
        match self.harm {
            Harm::OneHash => outcome.state_hash = "0".repeat(64),
            Harm::NoSteps => outcome.steps = 0,
            Harm::Silent => outcome.held_load = None,
            _ => {}
        }
        Ok(outcome)
    }
}

/// Checks a configuration.
pub fn check(config: &Value, setting: &Setting) -> Result<Vec<String>, ConfigError> {
    let config: Config = read_table(config)?;
    let registry = crate::registry();
    let solver = registry.get(&config.kind);
    let solver = solver.ok_or_else(|| ConfigError::new("kind", "no such solver"))?;
    (solver.check)(&config.config, setting)
}
