//! Limits at which each scheme begins to grow: predicted from the handshake, and measured with the real coupler.

use super::bar::UnitBar;
use super::map::{bar, boundary_inertia, inputs};
use super::setup::{StabilitySetup, keys, largest, word};
use scenario::error::Error;
use scheme::keys::SchemeWord::{DualSchur, DualSchurSecant, Velocity};
use scheme::keys::SchemeWord::{FixedPointSerial, StaggeredParallel, StaggeredSerial};
use scheme::keys::{CouplingScheme, Dirichlet, SchemeKeys};
use scheme::predict::prediction::{NEUTRAL, explain};

/// A limit, predicted and measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The scheme.
    pub keys: SchemeKeys,
    /// The bisected quantity: `mass_ratio`, mass behind the boundary over the bar's mass, or `cfl`, step over its limit.
    pub axis: &'static str,
    /// Steps in a window.
    pub substeps: u32,
    /// Step over its limit; for a limit of the step, the start of the search.
    pub cfl: f64,
    /// Prediction from the handshake.
    pub predicted: f64,
    /// Measurement from runs.
    pub measured: f64,
}

impl Limit {
    /// |measured - predicted| / predicted.
    pub fn difference_rel(&self) -> f64 {
        (self.measured - self.predicted).abs() / self.predicted
    }
}

/// Growth of a window that counts as a limit here. With an undamped bar, schemes that lag by a window grow for any mass, more slowly for
/// smaller masses; a run of a thousand windows can show 2 %.
const GROWTH: f64 = 1.02;
/// Number of windows of a run.
const WINDOWS: u64 = 1200;
/// Gap (m) at which a window is accepted; motions are of the order of 1 m.
const GAP_M: f64 = 1e-10;
/// Number of bisections: eight decades down to half a per cent.
const HALVINGS: usize = 12;

/// All limits, for theta = 1 and a glued mass.
pub fn limits(substeps: &[u32], cfls: &[f64]) -> Result<Vec<Limit>, Error> {
    let mut limits = Vec::new();
    for m in substeps {
        for cfl in cfls {
            for word in [StaggeredSerial, StaggeredParallel, FixedPointSerial] {
                for dirichlet in [Dirichlet::MotionDriven, Dirichlet::ForceDriven] {
                    limits.push(mass_limit(keys(word, dirichlet), *m, *cfl)?);
                }
            }
        }
        for word in [DualSchur, DualSchurSecant, Velocity] {
            limits.push(step_limit(keys(word, Dirichlet::MotionDriven), *m)?);
        }
    }
    Ok(limits)
}

fn setup(keys: SchemeKeys, substeps: u32, cfl: f64, mass_ratio: f64) -> StabilitySetup {
    StabilitySetup {
        bar: bar(cfl),
        substeps,
        keys,
        boundary_inertia: boundary_inertia(mass_ratio, f64::INFINITY, 1.0),
    }
}

/// Schemes in which the boundary follows grow with heavy masses; schemes in which the continuum follows grow with light masses.
fn mass_limit(keys: SchemeKeys, substeps: u32, cfl: f64) -> Result<Limit, Error> {
    let scheme = keys.scheme();
    let at_low_end = keys.dirichlet() == Dirichlet::MotionDriven;
    let response = bar(cfl).response(substeps);
    let predicted = |mass_ratio: f64| -> Result<bool, Error> {
        let setup = setup(keys, substeps, cfl, mass_ratio);
        let growth = explain(&inputs(&setup, &response), &scheme)?.growth;
        Ok(growth.is_some_and(|growth| growth <= level(&scheme)) == at_low_end)
    };
    let measured = |mass_ratio: f64| -> Result<bool, Error> {
        Ok(is_stable(&setup(keys, substeps, cfl, mass_ratio)) == at_low_end)
    };
    Ok(Limit {
        keys,
        axis: "mass_ratio",
        substeps,
        cfl,
        predicted: bisect(1e-4, 1e4, predicted)?,
        measured: bisect(1e-4, 1e4, measured)?,
    })
}

fn step_limit(keys: SchemeKeys, substeps: u32) -> Result<Limit, Error> {
    let measured = |cfl: f64| Ok(is_stable(&setup(keys, substeps, cfl, 1.0)));
    Ok(Limit {
        keys,
        axis: "cfl",
        substeps,
        cfl: 0.5,
        predicted: UnitBar::LIMIT_S,
        measured: bisect(0.5, 2.0, measured)?,
    })
}

/// Growth that counts as unstable: repeats must contract, windows may grow by the smallest growth that a run can show.
fn level(scheme: &CouplingScheme) -> f64 {
    match scheme {
        CouplingScheme::FixedPoint { .. } => 1.0 + NEUTRAL,
        _ => GROWTH,
    }
}

/// True if a real run grows by less than the limit per window, from its third quarter to its last.
fn is_stable(setup: &StabilitySetup) -> bool {
    let fixed_point = level(&setup.keys.scheme()) < GROWTH;
    let windows = if fixed_point { 3 } else { WINDOWS };
    let run = setup.run(&setup.response(), windows, GAP_M);
    if run.error.is_some() || fixed_point {
        return run.error.is_none();
    }
    let quarter = run.forces.len() / 4;
    let early = largest(&run.forces[2 * quarter..3 * quarter]);
    let late = largest(&run.forces[3 * quarter..]);
    (late / early).powf(1.0 / quarter as f64) < GROWTH
}

/// The largest value, by bisection of logarithms, at which a property that holds at the low end still holds.
fn bisect(low: f64, high: f64, holds: impl Fn(f64) -> Result<bool, Error>) -> Result<f64, Error> {
    let (mut low, mut high) = (low.ln(), high.ln());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle.exp())? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok((0.5 * (low + high)).exp())
}

/// The limits as CSV.
pub fn csv(limits: &[Limit]) -> String {
    let mut text = String::from(
        "scheme,axis,substeps,cfl,theta,stiffness_ratio,predicted,measured,difference_rel,dirichlet\n",
    );
    for limit in limits {
        text.push_str(&format!(
            "{},{},{},{},1,inf,{:.6e},{:.6e},{:.3e},{}\n",
            word(limit.keys.scheme),
            limit.axis,
            limit.substeps,
            limit.cfl,
            limit.predicted,
            limit.measured,
            limit.difference_rel(),
            word(limit.keys.dirichlet())
        ));
    }
    text
}
