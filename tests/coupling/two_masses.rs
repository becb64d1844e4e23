//! Every coupling scheme on two degrees of freedom, without processes and without messages.
//!
//! Problem: a mass m on a spring k to the ground takes steps of velocity Verlet (h, `substeps` steps per window of length H). It is
//! glued to a mass M that takes one step of implicit Euler per window. M arrives with 1 m/s.
//!
//! ```text
//!   ground -/\/\/- (m) == (M) -> 1 m/s
//!              k
//! ```
//!
//! Exact answer: the equations of each scheme for two unknowns, written again with plain numbers ([`Two`]). The force
//! of every window must equal theirs to 1e-10 of the largest (rounding over 40 windows; fixed points are iterated to 1e-13 m). So must the
//! interface's ledger: the work and the force that m actually carried ([`Books`]). Growth: the
//! force of a staggered scheme grows, and the residual of a fixed point shrinks or grows, by the factor on paper.
//!
//! Sources: dual Schur on displacement and velocity coupling after Gravouil and Combescure 2001; added mass and relaxation,
//! |1 - omega (1 + C S)|: Causin, Gerbeau and Nobile 2005; IQN-ILS: Degroote, Bathe and Vierendeels 2009.

use lab::bench::stability::bar::UnitBar;
use nalgebra::DMatrix;
use protocol::{BoundaryAnswer, BoundaryInertia, Description, Reaction, Surface, Window};
use scheme::coupling::Coupling;
use scheme::error::SchemeError;
use scheme::keys::{Acceleration, CouplingScheme, Dirichlet, Policy, SchemeKeys, SchemeWord};
use scheme::ledger::InterfaceLedger;
use scheme::participants::{Participants, Request};
use scheme::predict::growth::growth;
use scheme::predict::linear_pair::{LinearModel, LinearPair};
use scheme::predict::sprung_mass::Masses;

mod on_paper;

use on_paper::{Books, CASES, Case, Two, work_along_line};

const WINDOWS: usize = 40;

/// The pair of the bench, which reports no work, with the work on paper.
struct Working<'a> {
    pair: LinearPair<'a>,
    case: Case,
}

impl Participants for Working<'_> {
    fn count(&self) -> usize {
        self.pair.count()
    }

    fn name(&self, peer: usize) -> &str {
        self.pair.name(peer)
    }

    fn description(&self, peer: usize) -> &Description {
        self.pair.description(peer)
    }

    fn couple(&mut self, peer: usize, set: &str) -> Result<Surface, SchemeError> {
        self.pair.couple(peer, set)
    }

    fn select(&mut self, peer: usize, points: &[usize]) -> Result<(), SchemeError> {
        self.pair.select(peer, points)
    }

    fn compliance(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<DMatrix<f64>, SchemeError> {
        self.pair.compliance(peer, window, n)
    }

    fn impedance(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<DMatrix<f64>, SchemeError> {
        self.pair.impedance(peer, window, n)
    }

    fn set_boundary(
        &mut self,
        peer: usize,
        window: &Window,
        window_s: f64,
        compliance: &DMatrix<f64>,
    ) -> Result<(), SchemeError> {
        self.pair.set_boundary(peer, window, window_s, compliance)
    }

    fn begin(&mut self, peer: usize, window: &Window, request: Request) -> Result<(), SchemeError> {
        self.pair.begin(peer, window, request)
    }

    fn finish_advance(
        &mut self,
        peer: usize,
        at: &Window,
        n: usize,
    ) -> Result<Vec<f64>, SchemeError> {
        self.pair.finish_advance(peer, at, n)
    }

    fn finish_prescribed_velocity(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<Reaction, SchemeError> {
        let reaction = self.pair.finish_prescribed_velocity(peer, window, n)?;
        let (start, line) = (&self.pair.state.continuum, &self.pair.prescribed_velocities);
        let end = *line.last().expect("a line was begun");
        let work = work_along_line(self.case, [start[0], start[1]], end);
        Ok(Reaction {
            work: vec![work, 0.0],
            ..reaction
        })
    }

    fn finish_solve(
        &mut self,
        peer: usize,
        window: &Window,
        n: usize,
    ) -> Result<BoundaryAnswer, SchemeError> {
        self.pair.finish_solve(peer, window, n)
    }

    fn accept(&mut self, peer: usize, window: &Window, place: &[f64]) -> Result<(), SchemeError> {
        self.pair.accept(peer, window, place)
    }

    fn report(&mut self, peer: usize) -> Result<Vec<f64>, SchemeError> {
        self.pair.report(peer)
    }
}

fn scheme(word: SchemeWord, keys: impl Fn(&mut SchemeKeys)) -> CouplingScheme {
    let mut given = SchemeKeys::of(word);
    keys(&mut given);
    given.scheme()
}

/// The first windows of a scheme.
struct Ran {
    /// Force of each window (N).
    forces: Vec<f64>,
    /// Repeats of the last window.
    repeats: u64,
    ledger: InterfaceLedger,
}

fn run(scheme: CouplingScheme, case: Case, tolerance_m: f64) -> Result<Ran, SchemeError> {
    let bar = UnitBar {
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
    let pair = LinearPair::new(model, start);
    let mut pair = Working { pair, case };
    let mut forces = Vec::new();
    let mut repeats = 0;
    for index in 0..WINDOWS as u64 {
        let window = coupling.group().clock.window(index, index, 1);
        let before = coupling.ledgers[0].repeats;
        coupling.window(&mut pair, window, |_| None)?;
        repeats = coupling.ledgers[0].repeats - before;
        forces.push(coupling.state.lambda[0]);
    }
    // A converged fixed point gives the nodes exactly the force that the mass and its point leave for them.
    if matches!(scheme, CouplingScheme::FixedPoint { .. }) {
        let residual = coupling.ledgers[0].force_residual_rel();
        assert!(residual <= 1e-6, "{scheme:?}: {residual:e}");
    }
    Ok(Ran {
        forces,
        repeats,
        ledger: coupling.ledgers[0].clone(),
    })
}

fn model(
    response: &scheme::predict::response::Response,
    scheme: CouplingScheme,
    case: Case,
) -> LinearModel<'_> {
    let continuum = scheme.dirichlet() == Dirichlet::ForceDriven;
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

/// Compares the forces and the ledger of a scheme with the paper's; `window` receives the index of the window.
fn follows(scheme: CouplingScheme, case: Case, window: impl Fn(&mut Two, usize)) {
    let ran = run(scheme, case, 1e-13).expect("it converges");
    let (ours, ledger) = (ran.forces, ran.ledger);
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
    let Books {
        defect_j,
        energy_j,
        residual_n,
        force_n,
    } = paper.books;
    for (what, ours, theirs, scale) in [
        ("defect", ledger.energy_defect_j, defect_j, energy_j),
        ("energy", ledger.energy_j, energy_j, energy_j),
        ("residual", ledger.force_residual_n, residual_n, force_n),
        ("force", ledger.force_max_n, force_n, force_n),
    ] {
        let apart = (ours - theirs).abs();
        assert!(
            apart <= 1e-9 * scale,
            "{scheme:?}, {what}: {ours:e}, on paper {theirs:e}"
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
            let continuum = scheme(word, |keys| keys.dirichlet = Some(Dirichlet::ForceDriven));
            follows(continuum, case, |two, _| two.staggered_continuum(parallel));
        }
    }
}

#[test]
fn fixed_points_converge_to_the_direct_solution() {
    use Acceleration::{Aitken, Constant, IqnIls};
    let (serial, parallel) = (SchemeWord::FixedPointSerial, SchemeWord::FixedPointParallel);
    for case in CASES {
        // Without rounding, this relaxation would reach the fixed point at once.
        let relaxation = 1.0 / (1.0 + added_mass(case));
        // Quasi-Newton may stall in parallel order, where the first answer belongs to another request.
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
fn a_continuum_that_follows_converges_to_equal_velocities() {
    for case in CASES {
        for word in [SchemeWord::FixedPointSerial, SchemeWord::FixedPointParallel] {
            let keys = |keys: &mut SchemeKeys| {
                keys.dirichlet = Some(Dirichlet::ForceDriven);
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

fn constant(relaxation: f64, dirichlet: Dirichlet) -> CouplingScheme {
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
            let scheme = constant(relaxation, Dirichlet::MotionDriven);
            let bar = UnitBar {
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
                let error = run(scheme, case, 1e-9).err().expect("it diverges");
                assert!(
                    matches!(
                        error,
                        SchemeError::NotConverged(_) | SchemeError::NotFinite(_)
                    ),
                    "{error}"
                );
            } else if factor.abs() < 0.97 {
                assert!(found <= 1.0 + 1e-9, "{found}");
                // From about 1 m to 1e-9 m, with a margin of some decades.
                let repeats = run(scheme, case, 1e-9).expect("it converges").repeats;
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
            let bar = UnitBar {
                elements: 1,
                step_s: case.step_s,
            };
            let response = bar.response(case.substeps);
            let found = growth(&scheme, model(&response, scheme, case)).expect("it is linear");
            assert!((found / paper - 1.0).abs() <= 2e-3, "{found} {paper}");
        }
    }
}
