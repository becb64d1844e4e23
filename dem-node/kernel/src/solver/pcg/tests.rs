//! The solver against its four equations, and against itself with several threads.

mod textbook;

use crate::bodies::levers::Levers;
use crate::contact::bond::{Bond, BondContact};
use crate::contact::boundary::CompliantBoundary;
use crate::law::cohesion::{Cohesion, HPrime};
use crate::law::{Law, Penetration};
use crate::random::RandomNumbers;
use crate::solver::contact::{BodyRecord, Contact, NO_BOND, NO_LEVERS};
use crate::solver::criteria::{Algorithm, Criteria};
use crate::solver::partition::Partition;
use crate::solver::pcg::batch::Pass;
use crate::solver::pcg::group::PassSums;
use crate::solver::pcg::{Buffers, Form, solve_with};
use crate::solver::problem::Problem;
use textbook::Textbook;

const GLUED: usize = 6;

/// Parts of a problem in addition to grains.
#[derive(Clone, Copy, Debug)]
struct Scene {
    grains: usize,
    friction: f64,
    springs: bool,
    /// A wheel over some grains, a compliant boundary under others, and grains that represent clusters.
    constrained: bool,
    /// One in this many contacts of two grains has a bond, no contact where it is 0; friction needs springs.
    bonds: usize,
}

/// Grains in columns that touch at random angles.
fn problem(scene: Scene) -> Problem {
    let grains = scene.grains;
    let (column, wheel) = ((grains as f64).sqrt() as usize, grains + GLUED);
    let mut random = RandomNumbers::new(7);
    let mut problem = Problem {
        records: (0..=wheel).map(|i| record(i, grains)).collect(),
        first_glued: grains,
        wheel: Some(wheel),
        boundary: yielding(),
        friction: scene.friction,
        ..Problem::default()
    };
    for a in 0..grains {
        for b in [a + 1, a + column, a + column + 1] {
            if b < grains {
                let mut contact = touch(&mut random, [a, b], &scene);
                if scene.bonds > 0 && (a + b) % scene.bonds == 0 {
                    contact.bond = problem.bonds.len() as u32;
                    contact.bias = [random.between(-0.2, 0.2), 0.0];
                    contact.compliance[1] = 0.0;
                    problem.bonds.push(bond(&scene, problem.bonds.len()));
                }
                problem.contacts.push(contact);
            }
        }
        if scene.constrained && a % column == 0 {
            let disk = grains + a / column % GLUED;
            problem.contacts.push(touch(&mut random, [a, disk], &scene));
        }
        if scene.constrained && a % column == 3 {
            problem
                .contacts
                .push(touch(&mut random, [a, wheel], &scene));
        }
    }
    if scene.constrained {
        let pair = [grains + 1, wheel];
        problem.contacts.push(touch(&mut random, pair, &scene));
        if scene.bonds != 1 {
            turn_clusters(&mut random, &mut problem, grains);
        }
    }
    problem.prepare(1.0, false).expect("it is well posed");
    problem
}

/// Lets every eleventh grain represent a cluster, which all its contacts turn by levers of their own.
fn turn_clusters(random: &mut RandomNumbers, problem: &mut Problem, grains: usize) {
    let leads = |body: usize| body < grains && body % 11 == 5;
    for i in 0..problem.contacts.len() {
        let pair = [problem.contacts[i].a, problem.contacts[i].b].map(|body| body as usize);
        if !pair.into_iter().any(leads) {
            continue;
        }
        let mut levers = Levers::default();
        for (side, body) in pair.into_iter().enumerate() {
            levers.inverse[side] = problem.inverse_mass(body);
            levers.lever[side] = [0.0, [-1.0, 1.0][side] * problem.contacts[i].lever()];
            if leads(body) {
                levers.inverse[side][0] *= 0.5;
                levers.lever[side] = [random.between(-2.0, 2.0), random.between(-2.0, 2.0)];
            }
        }
        problem.contacts[i].levers = problem.levers.len() as u32;
        problem.levers.push(levers);
    }
}

fn touch(random: &mut RandomNumbers, [a, b]: [usize; 2], scene: &Scene) -> Contact {
    let angle = random.between(0.0, std::f64::consts::TAU);
    let glued = scene.grains..scene.grains + GLUED;
    Contact {
        a: a as u32,
        b: b as u32,
        glued: glued.contains(&a) || glued.contains(&b),
        normal: [angle.cos(), angle.sin()],
        relative_gap: random.between(-0.05, 0.05),
        bias: [random.between(-0.3, 0.1), random.between(-0.1, 0.1)],
        compliance: if scene.springs { [0.2, 0.4] } else { [0.0; 2] },
        impulse: [random.between(0.0, 0.1), 0.0],
        bond: NO_BOND,
        levers: NO_LEVERS,
        ..Contact::default()
    }
}

fn record(i: usize, grains: usize) -> BodyRecord {
    let glued = (grains..grains + GLUED).contains(&i);
    BodyRecord {
        velocity: [0.01 * (i % 13) as f64, -0.02, 0.03],
        inverse_mass: if glued {
            0.0
        } else {
            1.0 + 0.1 * (i % 7) as f64
        },
    }
}

fn yielding() -> CompliantBoundary {
    let diagonal = 2 * GLUED + 1;
    let at = |k: usize| if k.is_multiple_of(diagonal) { 2.0 } else { 0.1 };
    let mut wall = CompliantBoundary::compliant(GLUED, (0..4 * GLUED * GLUED).map(at).collect());
    wall.start(&[0.05; 2 * GLUED]);
    wall
}

fn bond(scene: &Scene, index: usize) -> BondContact {
    let law = Law {
        friction: scene.friction,
        rolling: 0.0,
        adhesion: None,
        healing: None,
        springs: None,
        cohesion: Some(Cohesion {
            normal: 4.0,
            tangential: if index.is_multiple_of(20) { 0.0 } else { 2.0 },
            energy: 1.0,
            viscosity: 0.0,
            power: 1.0,
            h_prime: HPrime::Adhesion,
            thickness: 1.0,
            alert: 0.1,
            bonds_min: 0,
            damping: 0.0,
        }),
        restitution: None,
        penetration: Penetration::Gap,
    };
    let bond = Bond {
        area: 1.0,
        adhesion: 0.9,
        slip: 0.1,
        ..Bond::default()
    };
    BondContact::new(&law, (index, &bond), Default::default(), 0.5)
}

fn scenes(grains: usize) -> Vec<Scene> {
    let mut scenes = Vec::new();
    for (friction, springs, bonds) in [
        (0.0, false, 0),
        (0.0, true, 0),
        (0.3, false, 0),
        (0.3, true, 0),
        (0.0, false, 3),
        (0.3, true, 3),
        (0.0, true, 1),
    ] {
        for constrained in [false, true] {
            scenes.push(Scene {
                grains,
                friction,
                springs,
                constrained,
                bonds,
            });
        }
    }
    scenes
}

fn exactly(iterations: usize, parallel: bool) -> Criteria {
    Criteria {
        algorithm: Algorithm::Pcg,
        tolerance: 0.0,
        min_iterations: iterations,
        max_iterations: iterations,
        parallel,
    }
}

/// Iterations of the equations and of the fast form differ by rounding only, until rounding has grown to a contact that slides in one and sticks in
/// the other.
#[test]
fn every_iteration_agrees_with_the_equations() {
    let plain = scenes(3200).into_iter().filter(|scene| scene.bonds != 1);
    for scene in scenes(400).into_iter().chain(plain) {
        let start = problem(scene);
        let mut textbook = Textbook::new(&start, |_| false);
        for iterations in 1..=12 {
            textbook.step();
            let mut fast = start.clone();
            super::solve(
                &mut fast,
                &mut Buffers::default(),
                &exactly(iterations, false),
            );
            let near = |what: &str, value: f64, expected: f64| {
                assert!(
                    (value - expected).abs() < 1e-10,
                    "{scene:?}, iteration {iterations}, {what}: {value} instead of {expected}"
                );
            };
            for (contact, expected) in fast.contacts.iter().zip(&textbook.impulses) {
                near("r_n", contact.impulse[0], expected[0]);
                near("r_t", contact.impulse[1], expected[1]);
            }
            let (bodies, wall) = textbook.speeds();
            for (record, expected) in fast.records[..scene.grains].iter().zip(&bodies) {
                (0..3).for_each(|axis| near("v", record.velocity[axis], expected[axis]));
            }
            let wheel = scene.grains + GLUED;
            near("wheel", fast.records[wheel].velocity[1], bodies[wheel][1]);
            for (v, expected) in fast.boundary.velocity.iter().zip(&wall) {
                near("wall", *v, *expected);
            }
        }
    }
}

/// Bonded grains without friction, enough for subdomains.
fn bonded(springs: bool, constrained: bool) -> Scene {
    let scene = Scene {
        grains: 4800,
        friction: 0.0,
        springs,
        constrained,
        bonds: 1,
    };
    let mut made = problem(scene);
    assert!(super::correction::suits(&made), "{scene:?}");
    assert!(Buffers::default().correction.load(&mut made, false));
    scene
}

/// Without projection inside the subdomains, with seven digits: the first iterations agree with the equations, until rounding shows.
#[test]
fn iterations_in_single_precision_agree_with_the_equations() {
    for scene in [bonded(true, false), bonded(false, true)] {
        let start = problem(scene);
        let free = |body: u32| (body as usize) < scene.grains;
        let mut textbook = Textbook::new(&start, |contact| {
            let bond = start.bonds.get(contact.bond as usize);
            bond.is_some_and(|bond| super::bonded::suits_bond(contact, bond))
                && free(contact.a)
                && free(contact.b)
        });
        for iterations in 1..=8 {
            textbook.step();
            let mut fast = start.clone();
            let criteria = exactly(iterations, false);
            super::solve(&mut fast, &mut Buffers::default(), &criteria);
            for (contact, expected) in fast.contacts.iter().zip(&textbook.impulses) {
                for (r, expected) in contact.impulse.iter().zip(expected) {
                    assert!(
                        (r - expected).abs() < 1e-5,
                        "{scene:?}, iteration {iterations}: {r} instead of {expected}"
                    );
                }
            }
        }
    }
}

/// With restarts before rounding shows, it reaches any tolerance, and the velocities of double precision.
#[test]
fn single_precision_finds_the_solution_of_double_precision() {
    let criteria = Criteria {
        tolerance: 1e-10,
        max_iterations: 3000,
        ..exactly(1, false)
    };
    for scene in [bonded(true, false), bonded(true, true)] {
        let (mut single, mut double) = (problem(scene), problem(scene));
        let mut buffers = Buffers::default();
        assert!(buffers.correction.load(&mut single, false));
        let form = super::Single {
            correction: &mut buffers.correction,
            parallel: false,
        };
        let found = super::solve_with(&mut single, form, &criteria);
        let expected =
            super::compiled(&double)(&mut double, &mut buffers.workspace, &criteria, None);
        assert!(
            found.converged && expected.converged,
            "{found:?} {expected:?}"
        );
        let moving = (0..scene.grains).chain([scene.grains + GLUED]);
        for body in moving {
            let [one, other] = [&single, &double].map(|problem| problem.records[body]);
            for (v, expected) in one.velocity.iter().zip(other.velocity) {
                assert!((v - expected).abs() < 1e-8, "{scene:?}: {v} {expected}");
            }
        }
        for (v, expected) in single
            .boundary
            .velocity
            .iter()
            .zip(&double.boundary.velocity)
        {
            assert!(
                (v - expected).abs() < 1e-8,
                "{scene:?}, wall: {v} {expected}"
            );
        }
    }
}

/// A rigid pack does not reach this residual: after iterations in vain, double precision continues with the remaining iterations.
#[test]
fn where_single_precision_is_stuck_double_precision_goes_on() {
    let criteria = Criteria {
        tolerance: 1e-12,
        max_iterations: 3000,
        ..exactly(1, false)
    };
    let (mut rigid, mut buffers) = (problem(bonded(false, false)), Buffers::default());
    let found = super::solve(&mut rigid, &mut buffers, &criteria);
    assert_eq!(
        (found.converged, found.iterations),
        (false, 3000),
        "{found:?}"
    );
    assert_eq!(buffers.holds, super::Holder::Double);
}

/// In subdomains, with contacts across them last, they give the same velocities as one after the other.
#[test]
fn first_guesses_move_the_bodies_in_any_subdomain() {
    for scene in scenes(12_000) {
        let prepared = problem(scene);
        let mut plain = prepared.clone();
        let bodies = 0..plain.records.len();
        plain.records = bodies.map(|body| record(body, scene.grains)).collect();
        for contact in &prepared.contacts {
            plain.apply(contact, contact.impulse);
        }
        for (record, expected) in prepared.records.iter().zip(&plain.records) {
            for (v, expected) in record.velocity.iter().zip(expected.velocity) {
                assert!((v - expected).abs() < 1e-14, "{scene:?}: {v} {expected}");
            }
        }
    }
}

/// Some bonds soften after a solve and some break: continuing from there finds the velocities of a solve from the start.
#[test]
fn softer_bonds_are_solved_from_the_last_solution() {
    let criteria = Criteria {
        tolerance: 1e-10,
        max_iterations: 1000,
        ..exactly(1, false)
    };
    let third = |constrained| Scene {
        grains: 3200,
        friction: 0.0,
        springs: true,
        constrained,
        bonds: 3,
    };
    let scenes = [
        third(false),
        third(true),
        bonded(true, false),
        bonded(true, true),
    ];
    for scene in scenes {
        let (mut solved, mut buffers) = (problem(scene), Buffers::default());
        let first = super::solve(&mut solved, &mut buffers, &criteria);
        assert!(first.converged, "{scene:?}: {first:?}");
        let mut fresh = problem(scene);
        let bonded = solved.contacts.iter().enumerate();
        let softened: Vec<u32> = bonded
            .filter(|(index, contact)| contact.bond != NO_BOND && index % 5 == 0)
            .map(|(index, _)| index as u32)
            .collect();
        for (place, index) in softened.iter().enumerate() {
            // Without breaking bonds, single precision continues too.
            let breaks = place % 4 == 0 && !(scene.bonds == 1 && scene.constrained);
            let stiffness = if breaks { [0.0; 2] } else { [0.7, 0.3] };
            let bond = solved.contacts[*index as usize].bond as usize;
            for problem in [&mut solved, &mut fresh] {
                problem.bonds[bond].law.set_stiffness(stiffness, 0.5);
                problem.prepare_bonds(&[*index]).expect("it is well posed");
            }
        }
        let gone_on = buffers.solve(&mut solved, &criteria, Some(&softened));
        let anew = super::solve(&mut fresh, &mut Buffers::default(), &criteria);
        if scene.bonds == 1 && scene.constrained {
            assert_eq!(buffers.holds, super::Holder::Single, "{scene:?}");
        }
        assert!(gone_on.converged && anew.converged, "{gone_on:?} {anew:?}");
        let grains = solved.records[..scene.grains].iter();
        for (one, other) in grains.zip(&fresh.records) {
            for (v, expected) in one.velocity.iter().zip(other.velocity) {
                assert!((v - expected).abs() < 1e-8, "{scene:?}: {v} {expected}");
            }
        }
    }
}

#[test]
fn any_number_of_threads_leaves_the_same_bits() {
    for scene in scenes(12_000) {
        let start = problem(scene);
        let partition = Partition::new(start.contacts.len(), start.records.len());
        assert!(
            partition.common(0, scene.grains as u32 / 2).is_none(),
            "one block"
        );
        let bits = |threads: usize| {
            let mut problem = start.clone();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.expect("threads can be started");
            pool.install(|| {
                super::solve(
                    &mut problem,
                    &mut Buffers::default(),
                    &exactly(40, threads > 1),
                )
            });
            let impulses = problem.contacts.iter().flat_map(|c| c.impulse);
            let velocities = problem.records.iter().flat_map(|m| m.velocity);
            let all = impulses.chain(velocities).chain(problem.boundary.velocity);
            all.map(f64::to_bits).collect::<Vec<u64>>()
        };
        let one = bits(1);
        for threads in [2, 4] {
            assert!(bits(threads) == one, "{scene:?}, {threads} threads");
        }
    }
}

/// The passes compute the residual with seven digits of D and on one branch of each bond: a tolerance just below the residual of an iteration must
/// not count as reached.
#[test]
fn an_accepted_solution_is_within_the_tolerance() {
    for scene in scenes(400) {
        let start = problem(scene);
        for iterations in 1..=20 {
            let reached = super::solve(
                &mut start.clone(),
                &mut Buffers::default(),
                &exactly(iterations, false),
            );
            let criteria = Criteria {
                tolerance: reached.residual * (1.0 - 1e-9),
                max_iterations: 20_000,
                ..exactly(1, false)
            };
            let convergence = super::solve(&mut start.clone(), &mut Buffers::default(), &criteria);
            assert!(
                convergence.converged,
                "{scene:?}: {convergence:?} for {:e}",
                criteria.tolerance
            );
        }
    }
}

/// A form that always reports a residual of 0.
struct Blind;

impl Form for Blind {
    const THRESHOLDS: bool = false;
    const CANCELLED: f64 = 0.0;
    const REDUCED: f64 = 0.0;
    const PATIENCE: usize = usize::MAX;

    fn run(&mut self, _problem: &Problem, _pass: Pass) -> PassSums<f64> {
        PassSums::default()
    }

    fn store(&mut self, _problem: &mut Problem) {}

    fn restart(&mut self, _problem: &mut Problem) {}
}

#[test]
fn a_form_without_a_residual_ends() {
    let mut problem = problem(scenes(40)[0]);
    let criteria = Criteria {
        tolerance: 1e-8,
        ..exactly(10, false)
    };
    assert!(!solve_with(&mut problem, Blind, &criteria).converged);
}
