//! What can be said of a coupled run before its first window: whether its scheme is stable, with what margin, and which
//! bound decides.
//!
//! The handshake tells the continuum's step, step limit, first period and compliance, and what stands behind a point of
//! the wall. In the softest motion of the interface the continuum is taken for the elastic bar that agrees with all of
//! this ([`response`]), the wall for a mass behind a spring ([`wall`]); one window of the scheme is then a matrix
//! ([`operator`]), and the scheme is stable if no disturbance grows under it (spectral radius at most one).
//!
//! Schemes that send force one way and motion the other fail by *added mass*: the light continuum is pushed by the
//! inertia of a heavy wall. With C the continuum's compliance in the window and S the wall's resistance -dF/du, the
//! number that counts is C S, the wall's mass over the mass that the continuum moves in a window. A fixed point with
//! relaxation omega contracts by |1 - omega (1 + C S)| a repeat, so it converges for omega < 2 / (1 + C S) (Causin,
//! Gerbeau and Nobile 2005, relaxed Dirichlet-Neumann iterations); without repeats the force comes back C S times as
//! large one window later, and the limit is that of the window's matrix. With `dirichlet = "continuum"` it is the
//! motion that comes back, 1 / (C S) times as large: omega < 2 / (1 + 1 / (C S)), where C is H over the impedance of
//! the *stiffest* motion and S holds the masses of the points.

use protocol::BoundaryInertia;

use crate::error::Error;
use crate::scenario::{Acceleration, Dirichlet, Interface, Scheme};
use operator::{Operator, Tie};
use response::{Bar, Response, Step};
use wall::Wall;

pub mod operator;
pub mod response;
pub mod wall;

/// Growth of a window beyond one that is not rounding: undamped schemes keep a disturbance for ever.
pub const NEUTRAL: f64 = 1e-9;

/// What the handshake told.
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// The continuum's step (s).
    pub step_s: f64,
    /// Steps in a window.
    pub substeps: u32,
    /// The longest stable step (s), and its name.
    pub step_limit: Option<(f64, String)>,
    /// The continuum's first period (s).
    pub first_period_s: Option<f64>,
    /// The longest window that the wall's solver accepts (s), and its name.
    pub window_limit: Option<(f64, String)>,
    /// Compliance of the interface over a window (m/N): that of its softest motion or, where the continuum takes the motion,
    /// H over the impedance of its stiffest one.
    pub compliance: f64,
    /// Whether no motion of the interface has a negative compliance.
    pub definite: bool,
    /// What stands behind a point of the wall; where the continuum takes the motion, with the point's own mass.
    pub boundary_inertia: Option<BoundaryInertia>,
}

/// How a scheme uses what comes back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The scheme.
    pub scheme: Scheme,
    /// Which side takes the motion.
    pub dirichlet: Dirichlet,
    /// How a fixed point is accelerated.
    pub acceleration: Acceleration,
    /// Its relaxation.
    pub relaxation: f64,
}

impl From<&Interface> for Choice {
    fn from(interface: &Interface) -> Choice {
        Choice {
            scheme: interface.scheme,
            dirichlet: interface.dirichlet,
            acceleration: interface.acceleration,
            relaxation: interface.relaxation,
        }
    }
}

/// A bound and how far from it the run is.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Which one.
    pub name: String,
    /// How many times larger the bounded quantity could be; below one it is broken.
    pub margin: f64,
    /// Whether breaking it costs stability; otherwise it costs accuracy.
    pub stability: bool,
}

/// What is foreseen.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// All bounds that apply.
    pub bounds: Vec<Bound>,
    /// Largest factor of a disturbance a window, or a repeat where the repeats of a window do not converge; absent
    /// where the wall tells nothing of itself.
    pub growth: Option<f64>,
    /// C S, the wall's mass over the continuum's in a window.
    pub added_mass: Option<f64>,
}

/// Foresees how a scheme will do, and how much more could stand on the wall.
pub fn explain(facts: &Facts, choice: Choice) -> Prediction {
    let mut prediction = predict(facts, choice);
    let joined = facts
        .boundary_inertia
        .map(|b| Foreseen::new(facts, choice, b));
    if let Some(margin) = joined.and_then(|joined| joined.added_mass_margin()) {
        prediction.bounds.push(Bound {
            name: "added mass".into(),
            margin,
            stability: true,
        });
    }
    prediction
}

/// Foresees how a scheme will do.
pub fn predict(facts: &Facts, choice: Choice) -> Prediction {
    let window_s = facts.step_s * f64::from(facts.substeps);
    let mut bounds = Vec::new();
    let mut add = |name: &str, margin: f64, stability: bool| {
        bounds.push(Bound {
            name: name.into(),
            margin,
            stability,
        });
    };
    if let Some((limit, name)) = &facts.step_limit {
        add(&format!("CFL ({name})"), limit / facts.step_s, true);
    }
    if let Some(period) = facts.first_period_s {
        add("first period / 4", 0.25 * period / window_s, false);
    }
    if let Some((limit, name)) = &facts.window_limit {
        add(name, limit / window_s, true);
    }
    if !facts.definite {
        add("compliance that is nowhere negative", 0.0, true);
    }
    let joined = facts
        .boundary_inertia
        .map(|boundary_inertia| Foreseen::new(facts, choice, boundary_inertia));
    Prediction {
        bounds,
        growth: joined.as_ref().map(|joined| joined.growth(1.0)),
        added_mass: joined.as_ref().map(|joined| joined.added_mass(1.0)),
    }
}

impl Prediction {
    /// Whether the scheme is stable; `None` where the wall tells too little for its scheme.
    pub fn stable(&self) -> Option<bool> {
        let kept = self.bounds.iter().all(|b| b.margin >= 1.0 || !b.stability);
        let bounded = self.growth.map(|growth| growth <= 1.0 + NEUTRAL);
        match kept {
            true => bounded,
            false => Some(false),
        }
    }

    /// The bound with the smallest margin.
    pub fn decides(&self) -> Option<&Bound> {
        self.bounds
            .iter()
            .min_by(|a, b| a.margin.total_cmp(&b.margin))
    }

    /// Refuses a choice that will not work, unless the scenario wants to see it.
    pub fn refuse(&self, interface: &Interface) -> Result<(), Error> {
        if self.stable() != Some(false) || interface.unsafe_window {
            return Ok(());
        }
        let (name, bound) = (&interface.name, self.decides());
        let bound = bound.map_or(String::new(), |bound| {
            format!(" ({}, margin {:.3})", bound.name, bound.margin)
        });
        let growth = self.growth.unwrap_or(1.0);
        let other_way = match interface.dirichlet {
            Dirichlet::Wall => "",
            Dirichlet::Continuum => ", dirichlet = \"wall\"",
        };
        Err(Error::Refused(format!(
            "interface `{name}`: scheme {:?} with {} substeps is predicted to be unstable{bound}: a disturbance grows {growth:.3}-fold a window; take scheme = \"dual-schur\"{other_way} or fewer substeps, or set interface.{name}.unsafe_window = true to see it fail",
            interface.scheme, interface.substeps
        )))
    }

    /// For the log of a run and for `check`: the verdict, then a line a bound.
    pub fn lines(&self) -> Vec<String> {
        let verdict = match self.stable() {
            Some(true) => "stable",
            Some(false) => "UNSTABLE",
            None => "unknown: the solver on the wall tells nothing of its masses",
        };
        let decides = self
            .decides()
            .map(|bound| format!(", {} decides", bound.name))
            .unwrap_or_default();
        let growth = match self.growth {
            Some(growth) => format!(", growth at most {growth:.6} a window"),
            None => String::new(),
        };
        let mut lines = vec![format!("predicted: {verdict}{growth}{decides}")];
        lines.extend(self.bounds.iter().map(|bound| {
            let kind = match bound.stability {
                true => "stability",
                false => "accuracy",
            };
            format!("  margin {:>9.3}  {} ({kind})", bound.margin, bound.name)
        }));
        if let Some(ratio) = self.added_mass {
            lines.push(format!(
                "  the wall resists a window's motion {ratio:.3} times as much as the continuum"
            ));
        }
        lines
    }
}

/// Both sides in the softest motion of the interface.
struct Foreseen {
    choice: Choice,
    response: Response,
    boundary_inertia: BoundaryInertia,
    window_s: f64,
}

impl Foreseen {
    fn new(facts: &Facts, choice: Choice, boundary_inertia: BoundaryInertia) -> Foreseen {
        // An undamped step keeps what a damped one would lose: it errs to the unstable side.
        let step = Step {
            step_s: facts.step_s,
            damping: 0.5,
        };
        let limit_s = facts
            .step_limit
            .as_ref()
            .map_or(facts.step_s, |(limit, _)| *limit);
        let window_s = facts.step_s * f64::from(facts.substeps);
        let compliance = |response: &Response| match choice.dirichlet {
            Dirichlet::Wall => response.compliance(),
            Dirichlet::Continuum => response.led_compliance(window_s),
        };
        let bar = Bar::equivalent(
            step,
            facts.substeps,
            limit_s,
            facts.first_period_s,
            (facts.compliance, compliance),
        );
        Foreseen {
            choice,
            response: bar.response(step, facts.substeps),
            boundary_inertia,
            window_s,
        }
    }

    /// The wall with all that stands on it this many times as large.
    fn wall(&self, factor: f64) -> Wall {
        let boundary_inertia = BoundaryInertia {
            glued_mass_kg: factor * self.boundary_inertia.glued_mass_kg,
            mass_kg: factor * self.boundary_inertia.mass_kg,
            stiffness_n_per_m: self.boundary_inertia.stiffness_n_per_m.map(|k| factor * k),
            theta: self.boundary_inertia.theta,
            may_part: self.boundary_inertia.may_part,
        };
        Wall::new(&boundary_inertia, self.window_s)
    }

    /// C S.
    fn added_mass(&self, factor: f64) -> f64 {
        added_mass(
            self.choice.dirichlet,
            &self.response,
            &self.wall(factor),
            self.window_s,
        )
    }

    fn growth(&self, factor: f64) -> f64 {
        growth(
            self.choice,
            &self.response,
            &self.wall(factor),
            self.window_s,
        )
    }

    /// How many times as much could stand on the wall, or how many times less where the continuum takes the motion;
    /// nothing where that does not matter.
    fn added_mass_margin(&self) -> Option<f64> {
        let late = !matches!(tie(self.choice), Tie::Exact | Tie::Velocity);
        if contraction(self.choice, self.added_mass(1.0)).is_none() && !late {
            return None;
        }
        let more = match self.choice.dirichlet {
            Dirichlet::Wall => 1.0,
            Dirichlet::Continuum => -1.0,
        };
        let stable = |exponent: f64| self.growth(10f64.powf(more * exponent)) <= 1.0 + NEUTRAL;
        let (mut low, mut high) = (-9.0, 9.0);
        match (stable(low), stable(high)) {
            (false, _) => return Some(0.0),
            (_, true) => return Some(f64::INFINITY),
            _ => {}
        }
        while high - low > 1e-3 {
            let middle = 0.5 * (low + high);
            match stable(middle) {
                true => low = middle,
                false => high = middle,
            }
        }
        Some(10f64.powf(low))
    }
}

/// Growth of a disturbance a window, or a repeat where the repeats of a window do not converge.
pub fn growth(choice: Choice, response: &Response, wall: &Wall, window_s: f64) -> f64 {
    let added_mass = added_mass(choice.dirichlet, response, wall, window_s);
    match contraction(choice, added_mass) {
        Some(repeats) if repeats >= 1.0 => repeats,
        _ => Operator {
            response,
            wall: *wall,
            window_s,
            tie: tie(choice),
        }
        .growth(),
    }
}

/// C S.
fn added_mass(dirichlet: Dirichlet, response: &Response, wall: &Wall, window_s: f64) -> f64 {
    let compliance = match dirichlet {
        Dirichlet::Wall => response.compliance(),
        Dirichlet::Continuum => response.led_compliance(window_s),
    };
    compliance * wall.stiffness()
}

/// |1 - omega (1 + C S)| of a fixed point with constant relaxation, |1 - omega (1 + 1 / (C S))| where the continuum takes
/// the motion. The others find their own: one unknown takes them two answers.
fn contraction(choice: Choice, added_mass: f64) -> Option<f64> {
    let constant = choice.acceleration == Acceleration::Constant;
    let comes_back = match choice.dirichlet {
        Dirichlet::Wall => added_mass,
        Dirichlet::Continuum => 1.0 / added_mass,
    };
    match choice.scheme {
        Scheme::FixedPointSerial | Scheme::FixedPointParallel if constant => {
            Some((1.0 - choice.relaxation * (1.0 + comes_back)).abs())
        }
        _ => None,
    }
}

/// What a scheme comes to for two linear sides. `dual-schur-cheap` starts on a compliance that is too soft and has learnt the
/// true one of a single motion after its first window. Where the continuum takes the motion its velocity goes in a straight
/// line.
pub fn tie(choice: Choice) -> Tie {
    match (choice.scheme, choice.dirichlet) {
        (Scheme::DualSchur | Scheme::DualSchurSecant | Scheme::DualSchurCheap, _) => Tie::Exact,
        (Scheme::Velocity, _) => Tie::Velocity,
        (Scheme::FixedPointSerial | Scheme::FixedPointParallel, Dirichlet::Wall) => Tie::Exact,
        (Scheme::FixedPointSerial | Scheme::FixedPointParallel, Dirichlet::Continuum) => {
            Tie::Velocity
        }
        (Scheme::StaggeredSerial, Dirichlet::Wall) => Tie::LateForce,
        (Scheme::StaggeredParallel, Dirichlet::Wall) => Tie::LateBoth,
        (Scheme::StaggeredSerial, Dirichlet::Continuum) => Tie::LateVelocity,
        (Scheme::StaggeredParallel, Dirichlet::Continuum) => Tie::LateVelocityAndForce,
    }
}
