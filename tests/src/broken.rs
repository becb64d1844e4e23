//! A continuum that is wrong in one way: fem-node with one of its answers spoilt.

use protocol::{
    ConfigError, Description, Node, NodeError, Outcome, Reaction, Session, Setting, Surface,
    Window, read_config,
};
use serde::Deserialize;
use serde_json::Value;

/// Keys: the harm, and those of fem-node.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    harm: Harm,
    rail: Value,
}

/// The ways of being wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Harm {
    /// None at all.
    Nothing,
    /// A tributary length that is no number.
    NanLength,
    /// A mass that is no number.
    NanMass,
    /// A mass below zero.
    NegativeMass,
    /// Places in millimetres.
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
    /// Repeats of a window with a substep less, although it is committed with all.
    ShortRepeats,
    /// Repeats of a window that answer 1 % more.
    LargeRepeats,
    /// Repeats of a window that begin where the one before ended.
    Forgets,
    /// A signal that is no number.
    NanSignal,
    /// An energy that is no number.
    NanEnergy,
    /// A ledger that is twice the right one.
    DoubleLedger,
    /// A ledger without its interface's work.
    NoInterfaceWork,
}

struct Broken {
    node: Box<dyn Node>,
    harm: Harm,
    /// Increments of the last answer, and their sum over what was committed.
    last: Vec<f64>,
    total: Vec<f64>,
}

/// Builds it.
pub fn build(session: &Session) -> Result<Box<dyn Node>, NodeError> {
    let config: Config = read_config(&session.config)?;
    let session = Session {
        config: config.rail,
        ..session.clone()
    };
    Ok(Box::new(Broken {
        node: fem_node::build(&session)?,
        harm: config.harm,
        last: Vec::new(),
        total: Vec::new(),
    }))
}

impl Node for Broken {
    fn describe(&self) -> Description {
        let mut told = self.node.describe();
        match self.harm {
            Harm::NegativeStep => told.step_s = told.step_s.map(|step| -step),
            Harm::ZeroStep => told.step_s = Some(0.0),
            _ => {}
        }
        told
    }

    fn couple(&mut self, set: &str) -> Result<Surface, NodeError> {
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
            Harm::FarAway => surface.y_m.iter_mut().for_each(|y| *y += 1.0),
            _ => {}
        }
        Ok(surface)
    }

    fn select(&mut self, points: &[usize]) -> Result<(), NodeError> {
        self.total = vec![0.0; 2 * points.len()];
        self.node.select(points)
    }

    fn columns(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        let mut columns = self.node.columns(substeps)?;
        let n = columns.len().isqrt();
        match self.harm {
            Harm::ZeroColumns => columns.fill(0.0),
            Harm::AsymmetricColumns => (0..n * n)
                .filter(|at| at % n < at / n)
                .for_each(|at| columns[at] *= 2.0),
            _ => {}
        }
        Ok(columns)
    }

    fn advance(&mut self, window: &Window, force: &[f64]) -> Result<Vec<f64>, NodeError> {
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
                let told = self.node.advance(&short, force)?;
                self.node.advance(window, force)?;
                increments = told;
            }
            Harm::LargeRepeats if repeat => increments.iter_mut().for_each(|du| *du *= 1.01),
            _ => {}
        }
        self.last.clone_from(&increments);
        if self.harm == Harm::Totals {
            let sums = increments.iter_mut().zip(&self.total);
            sums.for_each(|(du, total)| *du += total);
        }
        Ok(increments)
    }

    fn impedance(&mut self, substeps: u32) -> Result<Vec<f64>, NodeError> {
        self.node.impedance(substeps)
    }

    fn prescribe_velocity(
        &mut self,
        window: &Window,
        velocity: &[f64],
    ) -> Result<Reaction, NodeError> {
        self.node.prescribe_velocity(window, velocity)
    }

    fn commit(&mut self, window: &Window, displacement: &[f64]) -> Result<Vec<f64>, NodeError> {
        let mut report = self.node.commit(window, displacement)?;
        let sums = self.total.iter_mut().zip(&self.last);
        sums.for_each(|(total, du)| *total += du);
        let signals = self.node.describe().signals.len();
        match self.harm {
            Harm::NanSignal => report[0] = f64::NAN,
            Harm::NanEnergy => report[signals] = f64::NAN,
            Harm::DoubleLedger => report[signals..].iter_mut().for_each(|j| *j *= 2.0),
            Harm::NoInterfaceWork => report[signals] = 0.0,
            _ => {}
        }
        Ok(report)
    }

    fn finish(&mut self) -> Result<Outcome, NodeError> {
        self.node.finish()
    }
}

/// Checks a configuration.
pub fn check(config: &Value, setting: &Setting) -> Result<Vec<String>, ConfigError> {
    let config: Config = read_config(config)?;
    fem_node::check(&config.rail, setting)
}
