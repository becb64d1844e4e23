//! Every coupling scheme on two degrees of freedom, without processes and without messages.
//!
//! Problem: a mass m on a spring k to the ground, stepped by velocity Verlet (h, `substeps` steps a window of length H), glued to a
//! mass M that is stepped by implicit Euler once a window. M arrives with 1 m/s.
//!
//! ```text
//!   ground -/\/\/- (m) == (M) -> 1 m/s
//!              k
//! ```
//!
//! Exact answer: the equations of each scheme for two unknowns, written down once more below with plain numbers ([`Two`]); the force
//! of every window must be theirs to 1e-10 of the largest (rounding over 40 windows; fixed points are iterated to 1e-13 m). Growth: the
//! force of a staggered scheme grows, and the residual of a fixed point shrinks or grows, by the factor on paper.
//!
//! Sources: dual Schur on displacement and velocity coupling after Gravouil and Combescure 2001; added mass and relaxation,
//! |1 - omega (1 + C S)|: Causin, Gerbeau and Nobile 2005; IQN-ILS: Degroote, Bathe and Vierendeels 2009.

use coupler::bench::stability::bar::Bar;
use coupler::error::Error;
use coupler::scenario::{Acceleration, Dirichlet, Policy, Scheme, SchemeKeys, SchemeWord};
use coupler::scheme::coupling::Coupling;
use coupler::scheme::predict::growth::growth;
use coupler::scheme::predict::linear_pair::{LinearModel, LinearPair};
use coupler::scheme::predict::sprung_mass::Masses;
use protocol::BoundaryInertia;

/// m (kg) and k (N/m) of the one element of the bench's bar.
const MASS_KG: f64 = 0.5;
const STIFFNESS_N_PER_M: f64 = 1.0;
const WINDOWS: usize = 40;

/// A set-up.
#[derive(Clone, Copy)]
struct Case {
    step_s: f64,
    substeps: u32,
    /// M (kg).
    mass_kg: f64,
    /// Mass of the glued point (kg), which only schemes with `dirichlet = "continuum"` know.
    point_kg: f64,
}

const CASES: [Case; 3] = [
    Case {
        step_s: 0.3,
        substeps: 1,
        mass_kg: 0.2,
        point_kg: 0.01,
    },
    Case {
        step_s: 0.05,
        substeps: 9,
        mass_kg: 3.0,
        point_kg: 0.5,
    },
    Case {
        step_s: 0.6,
        substeps: 40,
        mass_kg: 20.0,
        point_kg: 2.0,
    },
];

/// The two masses on paper.
#[derive(Clone, Copy)]
struct Two {
    case: Case,
    u: f64,
    v: f64,
    /// Velocity of M at the end of the window before.
    v_m: f64,
    /// Force on m in the window before.
    lambda: f64,
    /// Motion of m in the window before.
    du: f64,
    /// Velocity of m's line, where the scheme prescribes it.
    line: f64,
}

impl Two {
    fn new(case: Case) -> Two {
        Two {
            case,
            u: 0.0,
            v: 0.0,
            v_m: 1.0,
            lambda: 0.0,
            du: 0.0,
            line: 0.0,
        }
    }

    fn h(&self) -> f64 {
        self.case.step_s * f64::from(self.case.substeps)
    }

    /// m under a constant force: (u, v) at the end of the window.
    fn verlet(&self, u: f64, v: f64, force: f64) -> (f64, f64) {
        let (h, a) = (self.case.step_s, |u: f64| {
            (force - STIFFNESS_N_PER_M * u) / MASS_KG
        });
        (0..self.case.substeps).fold((u, v), |(u, v), _| {
            let moved = u + h * v + 0.5 * h * h * a(u);
            (moved, v + 0.5 * h * (a(u) + a(moved)))
        })
    }

    /// C: displacement at the end of a window from rest under 1 N.
    fn compliance(&self) -> f64 {
        self.verlet(0.0, 0.0, 1.0).0
    }

    /// F = -M (v - v_0) / H.
    fn force_of(&self, v: f64) -> f64 {
        -self.case.mass_kg * (v - self.v_m) / self.h()
    }

    fn end(&mut self, lambda: f64, acting: f64, v_m: f64) {
        let (u, v) = self.verlet(self.u, self.v, acting);
        (self.du, self.u, self.v) = (u - self.u, u, v);
        (self.lambda, self.v_m) = (lambda, v_m);
    }

    /// Both end in the same place: H v_M = du_free + C lambda, lambda = F(v_M). With a compliance that is `factor` times C the mass M
    /// goes by that one, from the increment under the force before.
    fn dual_schur(&mut self, factor: f64) {
        let (h, c) = (self.h(), factor * self.compliance());
        let before = self.verlet(self.u, self.v, self.lambda).0 - self.u;
        let free = (before - c * self.lambda) / h;
        let v_m = (free + c / (h * h) * self.case.mass_kg * self.v_m)
            / (1.0 + c / (h * h) * self.case.mass_kg);
        let lambda = self.force_of(v_m);
        self.end(lambda, lambda, v_m);
    }

    /// m follows a straight line of velocities to v: (u, force at the end), m a + k u.
    fn led(&self, v: f64) -> (f64, f64) {
        let (h, a) = (self.h(), (v - self.v) / self.h());
        let u = self.u + h * self.v + 0.5 * h * h * a;
        (u, MASS_KG * a + STIFFNESS_N_PER_M * u)
    }

    /// Equal velocities at the end, with M' = M + `added`: lambda(v) = -M' (v - v_0) / H, linear in v.
    fn velocity(&mut self, added: f64, v_0: f64) {
        let (h, mass) = (self.h(), self.case.mass_kg + added);
        let at = |v: f64| self.led(v).1 + mass * (v - v_0) / h;
        let v = -at(0.0) / (at(1.0) - at(0.0));
        let (u, lambda) = self.led(v);
        (self.u, self.v, self.v_m, self.line, self.lambda) = (u, v, v, v, lambda);
    }

    fn staggered(&mut self, parallel: bool) {
        let du = self.verlet(self.u, self.v, self.lambda).0 - self.u;
        let v_m = if parallel { self.du } else { du } / self.h();
        let lambda = self.force_of(v_m);
        self.end(lambda, self.lambda, v_m);
    }

    /// m follows the line of the window before; M with its point takes the force of that.
    fn staggered_continuum(&mut self, parallel: bool) {
        let (h, line) = (self.h(), self.line);
        let (u, lambda) = self.led(line);
        let borne = if parallel { self.lambda } else { lambda };
        // M and its point move as one, but at the start, when only M moves.
        let (mass, point) = (self.case.mass_kg, self.case.point_kg);
        let v = (mass * self.v_m + point * self.line - h * borne) / (mass + point);
        (self.u, self.v) = (u, line);
        (self.v_m, self.line, self.lambda) = (v, v, lambda);
    }
}

fn scheme(word: SchemeWord, keys: impl Fn(&mut SchemeKeys)) -> Scheme {
    let mut given = SchemeKeys::of(word);
    keys(&mut given);
    given.scheme()
}

/// Forces of the scheme in the first windows, and the repeats of the last of them.
fn forces(scheme: Scheme, case: Case, tolerance_m: f64) -> Result<(Vec<f64>, u64), Error> {
    let bar = Bar {
        elements: 1,
        step_s: case.step_s,
    };
    let response = bar.response(case.substeps);
    let model = model(&response, scheme, case);
    let mut coupling = Coupling::new("two", scheme, Policy::Stop, model.group(tolerance_m));
    let start = Masses {
        glued_velocity: 1.0,
        ..Masses::default()
    };
    let mut pair = LinearPair::new(model, start);
    let mut forces = Vec::new();
    let mut repeats = 0;
    for index in 0..WINDOWS as u64 {
        let window = coupling.group().clock.window(index, index, 1);
        let before = coupling.ledgers[0].repeats;
        coupling.window(&mut pair, window, |_| None)?;
        repeats = coupling.ledgers[0].repeats - before;
        forces.push(coupling.state.lambda[0]);
    }
    // A converged fixed point gives the nodes just the force that the mass and its point leave for them.
    if matches!(scheme, Scheme::FixedPoint { .. }) {
        let residual = coupling.ledgers[0].force_residual_rel();
        assert!(residual <= 1e-6, "{scheme:?}: {residual:e}");
    }
    Ok((forces, repeats))
}

fn model(
    response: &coupler::scheme::predict::response::Response,
    scheme: Scheme,
    case: Case,
) -> LinearModel<'_> {
    let continuum = scheme.dirichlet() == Dirichlet::Continuum;
    LinearModel {
        response,
        inertia: BoundaryInertia {
            glued_mass_kg: case.mass_kg,
            mass_kg: 0.0,
            stiffness_n_per_m: None,
            theta: 1.0,
            may_part: false,
        },
        point_mass_kg: if continuum { case.point_kg } else { 0.0 },
        window_s: case.step_s * f64::from(case.substeps),
    }
}

/// Compares the forces of a scheme with those on paper, `window` being told its index.
fn follows(scheme: Scheme, case: Case, window: impl Fn(&mut Two, usize)) {
    let (ours, _) = forces(scheme, case, 1e-13).expect("it converges");
    let mut paper = Two::new(case);
    let mut largest = 0.0f64;
    for (index, force) in ours.iter().enumerate() {
        window(&mut paper, index);
        largest = largest.max(paper.lambda.abs());
        let apart = (force - paper.lambda).abs();
        assert!(
            apart <= 1e-10 * largest,
            "{scheme:?}, window {index}: {apart:e} of {largest:e}"
        );
    }
}

#[test]
fn dual_schur_ends_both_in_the_same_place() {
    for case in CASES {
        let exact = scheme(SchemeWord::DualSchur, |_| ());
        follows(exact, case, |two, _| two.dual_schur(1.0));
        let secant = scheme(SchemeWord::DualSchurSecant, |_| ());
        follows(secant, case, |two, _| two.dual_schur(1.0));
    }
}

#[test]
fn the_cheap_scheme_learns_the_compliance_in_its_first_window() {
    for case in CASES {
        let cheap = scheme(SchemeWord::DualSchurCheap, |_| ());
        follows(cheap, case, |two, index| {
            two.dual_schur(if index == 0 { 1.2 } else { 1.0 });
        });
    }
}

#[test]
fn velocity_ends_both_with_the_same_velocity() {
    for case in CASES {
        let velocity = scheme(SchemeWord::Velocity, |_| ());
        follows(velocity, case, |two, _| two.velocity(0.0, two.v_m));
    }
}

#[test]
fn staggered_schemes_use_the_answers_of_the_window_before() {
    for case in CASES {
        for (word, parallel) in [
            (SchemeWord::StaggeredSerial, false),
            (SchemeWord::StaggeredParallel, true),
        ] {
            let wall = scheme(word, |_| ());
            follows(wall, case, |two, _| two.staggered(parallel));
            let continuum = scheme(word, |keys| keys.dirichlet = Some(Dirichlet::Continuum));
            follows(continuum, case, |two, _| two.staggered_continuum(parallel));
        }
    }
}

#[test]
fn fixed_points_come_to_what_is_solved_at_once() {
    use Acceleration::{Aitken, Constant, IqnIls};
    let (serial, parallel) = (SchemeWord::FixedPointSerial, SchemeWord::FixedPointParallel);
    for case in CASES {
        // The relaxation that meets the fixed point at once, were it not for rounding.
        let relaxation = 1.0 / (1.0 + added_mass(case));
        // Quasi-Newton may stall in parallel order, whose first answer is not to its own question.
        for (word, acceleration) in [
            (serial, Constant),
            (serial, Aitken),
            (serial, IqnIls),
            (parallel, Constant),
            (parallel, Aitken),
        ] {
            let fixed_point = scheme(word, |keys| {
                keys.acceleration = Some(acceleration);
                keys.relaxation = Some(relaxation);
                keys.repeats_max = Some(400);
            });
            follows(fixed_point, case, |two, _| two.dual_schur(1.0));
        }
    }
}

/// M and the point move as one from the second window on; before, the point is at rest.
#[test]
fn a_continuum_that_follows_comes_to_velocities_that_are_equal() {
    for case in CASES {
        for word in [SchemeWord::FixedPointSerial, SchemeWord::FixedPointParallel] {
            let keys = |keys: &mut SchemeKeys| {
                keys.dirichlet = Some(Dirichlet::Continuum);
                keys.acceleration = Some(Acceleration::IqnIls);
                keys.repeats_max = Some(400);
            };
            let (mass, point) = (case.mass_kg, case.point_kg);
            follows(scheme(word, keys), case, |two, _| {
                let v_0 = (mass * two.v_m + point * two.line) / (mass + point);
                two.velocity(point, v_0);
            });
        }
    }
}

/// C S = C M / H^2.
fn added_mass(case: Case) -> f64 {
    let two = Two::new(case);
    two.compliance() * case.mass_kg / (two.h() * two.h())
}

fn constant(relaxation: f64, dirichlet: Dirichlet) -> Scheme {
    scheme(SchemeWord::FixedPointSerial, |keys| {
        keys.acceleration = Some(Acceleration::Constant);
        keys.relaxation = Some(relaxation);
        keys.repeats_max = Some(4000);
        keys.dirichlet = Some(dirichlet);
    })
}

#[test]
fn constant_relaxation_contracts_by_the_factor_on_paper() {
    for case in CASES {
        for relaxation in [0.05, 0.3, 1.0] {
            let factor = 1.0 - relaxation * (1.0 + added_mass(case));
            let scheme = constant(relaxation, Dirichlet::Wall);
            let bar = Bar {
                elements: 1,
                step_s: case.step_s,
            };
            let response = bar.response(case.substeps);
            let found = growth(&scheme, model(&response, scheme, case)).expect("it is linear");
            if factor.abs() > 1.0 {
                assert!(
                    (found - factor.abs()).abs() < 1e-9 * found,
                    "{found}, {factor}"
                );
                let error = forces(scheme, case, 1e-9).expect_err("it diverges");
                assert!(
                    matches!(error, Error::NotConverged(_) | Error::NotFinite(_)),
                    "{error}"
                );
            } else if factor.abs() < 0.97 {
                assert!(found <= 1.0 + 1e-9, "{found}");
                // From about 1 m to 1e-9 m, give or take the first decades.
                let (_, repeats) = forces(scheme, case, 1e-9).expect("it converges");
                let most = 2.0 + (1e-12f64).ln() / factor.abs().ln();
                assert!((repeats as f64) <= most, "{repeats} of {most}, {factor}");
            }
        }
    }
}

#[test]
fn a_staggered_scheme_grows_by_the_factor_on_paper() {
    for case in CASES {
        for parallel in [false, true] {
            // Growth of the paper's own numbers, over the second half of many windows.
            let mut two = Two::new(case);
            let mut log = Vec::new();
            for _ in 0..2000 {
                two.staggered(parallel);
                let size = [two.u, two.v, two.v_m, two.lambda, two.du]
                    .iter()
                    .fold(0.0f64, |most, value| most.max(value.abs()));
                log.push(size.ln() + log.last().copied().unwrap_or(0.0));
                for value in [
                    &mut two.u,
                    &mut two.v,
                    &mut two.v_m,
                    &mut two.lambda,
                    &mut two.du,
                ] {
                    *value /= size;
                }
            }
            let paper = ((log[1999] - log[999]) / 1000.0).exp();
            let word = if parallel {
                SchemeWord::StaggeredParallel
            } else {
                SchemeWord::StaggeredSerial
            };
            let scheme = scheme(word, |_| ());
            let bar = Bar {
                elements: 1,
                step_s: case.step_s,
            };
            let response = bar.response(case.substeps);
            let found = growth(&scheme, model(&response, scheme, case)).expect("it is linear");
            assert!((found / paper - 1.0).abs() <= 2e-3, "{found} {paper}");
        }
    }
}
