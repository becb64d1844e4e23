//! The prediction of stability: bounds, growth, and the verdict.

use protocol::{AccuracyLimit, BoundaryInertia};
use serde::Serialize;

use super::growth::{growth, growth_of_repeats};
use super::linear_pair::LinearModel;
use super::response::{EquivalentBar, Response};
use crate::clock::Clock;
use crate::error::{Result, SchemeError, Unfit};
use crate::keys::{CouplingScheme, Dirichlet, Interface, SchemeWord};

/// Growth per window beyond 1 that counts as rounding: undamped schemes keep a disturbance for ever.
pub const NEUTRAL: f64 = 1e-9;

/// The numbers from the handshake that determine stability.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityInputs {
    /// The continuum's steps in a window.
    pub clock: Clock,
    /// The longest stable step (s), and its name.
    pub step_limit: Option<(f64, String)>,
    /// The continuum's first period (s).
    pub first_period_s: Option<f64>,
    /// The longest window that the layer's solver accepts (s), and its name.
    pub window_limit: Option<(f64, String)>,
    /// Windows above which the layer's results lose accuracy.
    pub accuracy_limits: Vec<AccuracyLimit>,
    /// Compliance of the interface over a window (m/N): of its softest motion or, if the continuum takes the motion, H
    /// over the impedance of the stiffest motion.
    pub compliance: f64,
    /// True if no motion of the interface has a negative compliance.
    pub definite: bool,
    /// The masses behind a point of the layer.
    pub boundary_inertia: Option<BoundaryInertia>,
    /// The point's own mass (kg), if the continuum takes the motion; otherwise zero.
    pub point_mass_kg: f64,
}

/// Name of the bound on the continuum's own step; the participant's own name for it follows.
const OWN_STEP: &str = "CFL";

/// Name of the bound from the continuum's first period.
const FIRST_PERIOD: &str = "first period / 4";

/// A window whose margin is below this gets a warning.
pub const LEAST_MARGIN: f64 = 0.75;

/// A bound and the run's distance from it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Its name.
    pub name: String,
    /// Factor by which the bounded quantity could be larger; below 1 the bound is violated.
    pub margin: f64,
    /// True if violating it costs stability; otherwise it costs accuracy.
    pub stability: bool,
}

impl Bound {
    fn new(name: &str, margin: f64, stability: bool) -> Bound {
        let name = name.into();
        Bound {
            name,
            margin,
            stability,
        }
    }

    /// The bounds of a step or window (s) above which results lose accuracy.
    pub fn of_accuracy(limits: &[AccuracyLimit], step_s: f64) -> impl Iterator<Item = Bound> {
        let limits = limits.iter();
        limits.map(move |limit| Bound::new(&limit.name, limit.limit_s / step_s, false))
    }

    /// True for a window so long, compared with the continuum's first period, that results depend on it. Verification
    /// scenes with exact answers have windows up to a third longer than a quarter of the period.
    pub fn is_long_window(&self) -> bool {
        self.name == FIRST_PERIOD && self.margin < LEAST_MARGIN
    }

    /// The margin, the name and the kind, as text.
    pub fn line(&self) -> String {
        let kind = if self.stability {
            "stability"
        } else {
            "accuracy"
        };
        format!("  margin {:>9.3}  {} ({kind})", self.margin, self.name)
    }
}

/// A prediction.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StabilityPrediction {
    /// All bounds that apply.
    pub bounds: Vec<Bound>,
    /// Largest factor of a disturbance per window, or per repeat where the repeats of a window do not converge; absent
    /// if the layer does not describe its masses.
    pub growth: Option<f64>,
    /// C S, the layer's mass over the continuum's in a window.
    pub added_mass: Option<f64>,
}

/// Predicts the stability of a scheme, and the factor by which the mass on the boundary could grow.
pub fn explain(inputs: &StabilityInputs, scheme: &CouplingScheme) -> Result<StabilityPrediction> {
    let mut prediction = predict(inputs, scheme)?;
    if let Some(inertia) = inputs.boundary_inertia {
        let response = inputs.equivalent(scheme);
        let margin = added_mass_margin(scheme, inputs.model(&response, inertia))?;
        let bound = margin.map(|margin| Bound::new("added mass", margin, true));
        prediction.bounds.extend(bound);
    }
    Ok(prediction)
}

/// Predicts the stability of a scheme.
pub fn predict(inputs: &StabilityInputs, scheme: &CouplingScheme) -> Result<StabilityPrediction> {
    let window_s = inputs.clock.window_s();
    let mut prediction = StabilityPrediction::default();
    let mut add = |name: &str, margin: f64, stability: bool| {
        prediction.bounds.push(Bound::new(name, margin, stability));
    };
    if let Some((limit, name)) = &inputs.step_limit {
        let name = format!("{OWN_STEP} ({name})");
        add(&name, limit / inputs.clock.step_s, true);
    }
    if let Some(period) = inputs.first_period_s {
        add(FIRST_PERIOD, 0.25 * period / window_s, false);
    }
    if let Some((limit, name)) = &inputs.window_limit {
        add(name, limit / window_s, true);
    }
    if !inputs.definite {
        add("compliance that is nowhere negative", 0.0, true);
    }
    let accuracy = Bound::of_accuracy(&inputs.accuracy_limits, window_s);
    prediction.bounds.extend(accuracy);
    if let Some(inertia) = inputs.boundary_inertia {
        let response = inputs.equivalent(scheme);
        let model = inputs.model(&response, inertia);
        let yields = compliance(scheme, &response, window_s);
        prediction.growth = Some(growth(scheme, model)?);
        prediction.added_mass = Some(yields * model.whole().stiffness());
    }
    Ok(prediction)
}

impl StabilityInputs {
    /// A window of the bar that matches the handshake. Its undamped step keeps energy that a damped one would lose: it
    /// errs to the unstable side.
    fn equivalent(&self, scheme: &CouplingScheme) -> Response {
        let (limit, Clock { step_s, substeps }) = (self.step_limit.as_ref(), self.clock);
        let bar = EquivalentBar::equivalent(
            step_s,
            substeps,
            limit.map_or(step_s, |(limit, _)| *limit),
            self.first_period_s,
            self.compliance,
            |response| compliance(scheme, response, self.clock.window_s()),
        );
        bar.response(step_s, substeps)
    }

    fn model<'a>(&self, response: &'a Response, inertia: BoundaryInertia) -> LinearModel<'a> {
        LinearModel {
            response,
            inertia,
            point_mass_kg: self.point_mass_kg,
            window_s: self.clock.window_s(),
        }
    }
}

impl StabilityPrediction {
    /// Stability of the scheme; `None` if the layer's description is not sufficient for the scheme.
    pub fn stable(&self) -> Option<bool> {
        let kept = self.bounds.iter().all(|b| b.margin >= 1.0 || !b.stability);
        let bounded = self.growth.map(|growth| growth <= 1.0 + NEUTRAL);
        if kept { bounded } else { Some(false) }
    }

    /// The bound of stability with the smallest margin.
    pub fn decides(&self) -> Option<&Bound> {
        let bounds = self.bounds.iter().filter(|bound| bound.stability);
        bounds.min_by(|a, b| a.margin.total_cmp(&b.margin))
    }

    /// True where the continuum is unstable by itself.
    fn step_is_too_long(&self) -> bool {
        let mut bounds = self.bounds.iter();
        bounds.any(|bound| bound.name.starts_with(OWN_STEP) && bound.margin < 1.0)
    }

    /// Refuses an unstable choice, unless the scenario asks for it.
    pub fn refuse(&self, interface: &Interface) -> Result<()> {
        if self.stable() != Some(false) || interface.unsafe_window {
            return Ok(());
        }
        let (name, bound) = (&interface.name, self.decides());
        let bound = bound.map_or(String::new(), |bound| {
            format!(" ({}, margin {:.3})", bound.name, bound.margin)
        });
        let growth = self.growth.unwrap_or(1.0);
        let cure = match interface.scheme().dirichlet() {
            _ if self.step_is_too_long() => "shorten the continuum's own step",
            _ if interface.scheme == SchemeWord::DualSchur => "take fewer substeps",
            Dirichlet::MotionDriven => "take scheme = \"dual-schur\" or fewer substeps",
            Dirichlet::ForceDriven => {
                "take scheme = \"dual-schur\", dirichlet = \"wall\" or fewer substeps"
            }
        };
        Err(SchemeError::from(Unfit::Unstable {
            interface: name.clone(),
            scheme: interface.scheme.to_string(),
            substeps: interface.substeps(),
            bound,
            growth,
            cure,
        }))
    }

    /// For the log of a run and for `check`: the verdict, then one line for each bound.
    pub fn lines(&self) -> Vec<String> {
        let verdict = match self.stable() {
            Some(true) => "stable",
            Some(false) => "UNSTABLE",
            None => "unknown: the solver on the wall does not describe its masses",
        };
        let mut first = format!("predicted: {verdict}");
        if let Some(growth) = self.growth {
            first += &format!(", growth at most {growth:.6} a window");
        }
        if let Some(bound) = self.decides() {
            first += &format!(", {} decides", bound.name);
        }
        let mut lines = vec![first];
        lines.extend(self.bounds.iter().map(Bound::line));
        if let Some(ratio) = self.added_mass {
            lines.push(format!(
                "  the wall resists a window's motion {ratio:.3} times as much as the continuum"
            ));
        }
        lines
    }
}

/// Factor by which the mass on the boundary could grow, or shrink if the continuum takes the motion; `None` if
/// stability does not depend on it.
fn added_mass_margin(scheme: &CouplingScheme, model: LinearModel) -> Result<Option<f64>> {
    let late = matches!(scheme, CouplingScheme::Staggered { .. });
    if growth_of_repeats(scheme, model)?.is_none() && !late {
        return Ok(None);
    }
    let more = match scheme.dirichlet() {
        Dirichlet::MotionDriven => 1.0,
        Dirichlet::ForceDriven => -1.0,
    };
    let stable = |exponent: f64| -> Result<bool> {
        let times = model.times(10f64.powf(more * exponent));
        Ok(growth(scheme, times)? <= 1.0 + NEUTRAL)
    };
    let (mut low, mut high) = (-9.0, 9.0);
    if !stable(low)? {
        return Ok(Some(0.0));
    }
    if stable(high)? {
        return Ok(Some(f64::INFINITY));
    }
    while high - low > 1e-3 {
        let middle = 0.5 * (low + high);
        let end = if stable(middle)? { &mut low } else { &mut high };
        *end = middle;
    }
    Ok(Some(10f64.powf(low)))
}

/// C (m/N) of the motion that the scheme sends: the compliance under a constant force, or H over the impedance.
pub fn compliance(scheme: &CouplingScheme, response: &Response, window_s: f64) -> f64 {
    match scheme.dirichlet() {
        Dirichlet::MotionDriven => response.compliance(),
        Dirichlet::ForceDriven => response.prescribed_compliance(window_s),
    }
}
