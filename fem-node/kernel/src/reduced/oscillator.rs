//! A mode over a window: the n-fold step of the body's own scheme.
//!
//! A mode of frequency omega under the modal force f is an oscillator of unit mass, and the scheme of the body moves it like the body,
//!
//! ```text
//! a  = f - omega^2 u - c v                       at the start of a window
//! u' = u + h v + h^2/2 a                         then n times
//! a' = p - c (v + h [(1-b) a + b p]) / (1 + b h c),   p = f' - omega^2 u'
//! v' = v + h [(1-b) a + b a']
//! ```
//!
//! Since a follows from the present u and v, (u, v) is the whole state, for any b and c. Under a constant force n steps are one product,
//! (u, v)+ = P (u, v) + q f, and the energies that the scheme and the mass damping take are quadratic forms in (u, v, f); their formulas are derived in
//! [`crate::integrate`].

use serde::{Deserialize, Serialize};

use crate::scheme::NewmarkScheme;

/// A number that depends linearly on (u, v, f).
type Form = [f64; 3];

/// A quadratic form in (u, v, f): the products uu, vv, ff, uv, uf, vf.
type Quadratic = [f64; 6];

/// Displacement (m sqrt(kg)) and velocity of a mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModeState {
    /// u.
    pub u: f64,
    /// v.
    pub v: f64,
}

/// Energies that a mode has lost in a window (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModeLoss {
    /// To the time scheme: (b-1/2) (du dF - b h^2/2 da da) - (b h^2/4) d(a a).
    pub numerical: f64,
    /// To the mass damping: [(1-b) c v + b c v'] du.
    pub mass_damping: f64,
}

/// The map of a mode over a window of n steps under a constant force.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct WindowMap {
    u: Form,
    v: Form,
    numerical: Quadratic,
    mass_damping: Quadratic,
}

impl WindowMap {
    pub(crate) fn new(scheme: &NewmarkScheme, omega: f64, substeps: u32) -> WindowMap {
        let mut step = Step::begin(scheme, omega, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], UNIT);
        let start = step.a;
        let (mut numerical, mut mass_damping) = ([0.0; 6], [0.0; 6]);
        let (b, h) = (scheme.damping, scheme.step);
        for _ in 0..substeps {
            let before = step;
            step.advance(UNIT);
            let [du, da] =
                [(step.u, before.u), (step.a, before.a)].map(|(new, old)| minus(new, old));
            add_product(&mut numerical, (b - 0.5) * omega * omega, du, du);
            add_product(&mut numerical, -0.5 * (b - 0.5) * b * h * h, da, da);
            let mean = plus(scaled(1.0 - b, before.v), scaled(b, step.v));
            add_product(&mut mass_damping, scheme.mass_damping, mean, du);
        }
        add_product(&mut numerical, -0.25 * b * h * h, step.a, step.a);
        add_product(&mut numerical, 0.25 * b * h * h, start, start);
        WindowMap {
            u: step.u,
            v: step.v,
            numerical,
            mass_damping,
        }
    }

    /// Displacement at the end by a unit force.
    pub(crate) fn compliance(&self) -> f64 {
        self.u[2]
    }

    /// The state at the end of the window.
    pub(crate) fn end(&self, start: ModeState, force: f64) -> ModeState {
        let of = |form: &Form| form[0] * start.u + form[1] * start.v + form[2] * force;
        ModeState {
            u: of(&self.u),
            v: of(&self.v),
        }
    }

    /// The energies that it loses in the window.
    pub(crate) fn loss(&self, ModeState { u, v }: ModeState, f: f64) -> ModeLoss {
        let products = [u * u, v * v, f * f, u * v, u * f, v * f];
        let of = |form: &Quadratic| products.iter().zip(form).map(|(p, q)| p * q).sum();
        ModeLoss {
            numerical: of(&self.numerical),
            mass_damping: of(&self.mass_damping),
        }
    }
}

const UNIT: Form = [0.0, 0.0, 1.0];

/// A state within a window, its numbers as they depend on the start.
#[derive(Clone, Copy)]
struct Step<'a> {
    scheme: &'a NewmarkScheme,
    omega: f64,
    u: Form,
    v: Form,
    a: Form,
}

impl<'a> Step<'a> {
    fn begin(scheme: &'a NewmarkScheme, omega: f64, u: Form, v: Form, force: Form) -> Step<'a> {
        let elastic = plus(force, scaled(-omega * omega, u));
        let a = plus(elastic, scaled(-scheme.mass_damping, v));
        Step {
            scheme,
            omega,
            u,
            v,
            a,
        }
    }

    fn advance(&mut self, force: Form) {
        let NewmarkScheme {
            step: h,
            damping: b,
            mass_damping: c,
            ..
        } = *self.scheme;
        let Step { u, v, a, .. } = *self;
        self.u = plus(u, plus(scaled(h, v), scaled(0.5 * h * h, a)));
        let p = plus(force, scaled(-self.omega * self.omega, self.u));
        let mean = |end: Form| plus(scaled(h * (1.0 - b), a), scaled(h * b, end));
        let damped = plus(v, mean(p));
        self.a = plus(p, scaled(-c / (1.0 + b * h * c), damped));
        self.v = plus(v, mean(self.a));
    }
}

/// A mode over a window under a force that changes from step to step; `forces` holds it at the start and after each step. Returns the state at the end,
/// the losses, and for each step the increment du.
pub(crate) fn stepped(
    scheme: &NewmarkScheme,
    omega: f64,
    start: ModeState,
    forces: &[f64],
) -> (ModeState, ModeLoss, Vec<f64>) {
    // Constant parts of the forms: this start, and a force of one.
    let number = |value: f64| [value, 0.0, 0.0];
    let (u, v) = (number(start.u), number(start.v));
    let mut step = Step::begin(scheme, omega, u, v, number(forces[0]));
    let first = step.a[0];
    let (b, h) = (scheme.damping, scheme.step);
    let mut loss = ModeLoss::default();
    let mut increments = Vec::with_capacity(forces.len() - 1);
    for force in &forces[1..] {
        let before = step;
        step.advance(number(*force));
        let (du, da) = (step.u[0] - before.u[0], step.a[0] - before.a[0]);
        loss.numerical += (b - 0.5) * (omega * omega * du * du - 0.5 * b * h * h * da * da);
        loss.mass_damping += scheme.mass_damping * ((1.0 - b) * before.v[0] + b * step.v[0]) * du;
        increments.push(du);
    }
    loss.numerical -= 0.25 * b * h * h * (step.a[0] * step.a[0] - first * first);
    let end = ModeState {
        u: step.u[0],
        v: step.v[0],
    };
    (end, loss, increments)
}

fn plus(a: Form, b: Form) -> Form {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn minus(a: Form, b: Form) -> Form {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn scaled(factor: f64, a: Form) -> Form {
    a.map(|value| factor * value)
}

/// Adds factor times the product of two forms.
fn add_product(sum: &mut Quadratic, factor: f64, [a, b, c]: Form, [x, y, z]: Form) {
    let products = [
        a * x,
        b * y,
        c * z,
        a * y + b * x,
        a * z + c * x,
        b * z + c * y,
    ];
    for (sum, product) in sum.iter_mut().zip(products) {
        *sum += factor * product;
    }
}
