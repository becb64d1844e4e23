use super::*;
use crate::bodies::levers::Levers;
use crate::contact::boundary::CompliantBoundary;
use crate::random::RandomNumbers;
use crate::solver::Solver;
use crate::solver::contact::{BodyRecord, NO_LEVERS};
use crate::solver::criteria::{Algorithm, Criteria};

/// A disk of 1/m = `inverse` on a fixed wall, at this velocity.
fn on_wall(inverse: f64, velocity: [f64; 3], friction: f64) -> Problem {
    let contact = Contact {
        a: 0,
        b: 1,
        normal: [0.0, 1.0],
        bond: NO_BOND,
        levers: NO_LEVERS,
        ..Contact::default()
    };
    let disk = BodyRecord {
        velocity,
        inverse_mass: inverse,
    };
    let mut problem = Problem {
        contacts: vec![contact],
        records: vec![disk, BodyRecord::default()],
        first_glued: 2,
        friction,
        ..Problem::default()
    };
    problem.prepare(1e-10, false).expect("it is well posed");
    problem
}

/// A disk that lands: by hand r_n = -m v_y; it rolls with r_t = -m (v_x - w) / 3 if that is within mu r_n, else it slides.
#[test]
fn a_disk_that_lands_rolls_or_slides() {
    for (velocity, friction, expected) in [
        ([3.0, -2.0, 0.0], 0.6, [1.0, -0.5]),
        ([3.0, -2.0, 0.0], 0.3, [1.0, -0.3]),
        ([-3.0, -2.0, 0.6], 0.3, [1.0, 0.3]),
        ([0.0, -2.0, 0.0], 0.3, [1.0, 0.0]),
        ([1.0, 2.0, 0.0], 0.3, [0.0, 0.0]),
    ] {
        let mut problem = on_wall(2.0, velocity, friction);
        // On the wall the tangent is (-1, 0): r_t pushes the disk to the left.
        let solved = solve(&problem, 1e-14).expect("it is solved");
        let [r_n, r_t] = solved.contacts[0].impulse;
        assert!((r_n - expected[0]).abs() < 1e-12, "{r_n} {expected:?}");
        assert!((r_t + expected[1]).abs() < 1e-12, "{r_t} {expected:?}");
        let residual_of = residual(&solved);
        assert!(residual_of <= 1e-12, "{residual_of:e}");
        // The first guess does not matter.
        problem = with_impulses(&problem, &[[0.7, -0.2]]);
        let again = solve(&problem, 1e-14).expect("it is solved");
        assert!((again.contacts[0].impulse[0] - r_n).abs() < 1e-12);
    }
}

#[test]
fn more_contacts_than_a_path_can_take_are_left_to_the_sweeps() {
    let mut problem = on_wall(2.0, [0.0, -1.0, 0.0], 0.3);
    let mut contact = problem.contacts[0];
    contact.impulse = [0.5, 0.0];
    problem.contacts = vec![contact; 3];
    assert!(solve(&problem, 1e-4).is_some());
    problem.contacts = vec![contact; MOST_PRESSING + 1];
    assert!(solve(&problem, 1e-4).is_none());
}

#[test]
fn bonds_are_left_to_the_sweeps() {
    let mut problem = on_wall(2.0, [0.0, -1.0, 0.0], 0.3);
    problem.contacts[0].bond = 0;
    assert!(solve(&problem, 1e-4).is_none());
}

const ROWS: usize = 5;
const COLUMNS: usize = 6;

/// Rigid grains that fall in a heap on glued disks, whose boundary yields; every row is heavier than the row below.
fn heap(seed: u64, friction: f64) -> Problem {
    let mut random = RandomNumbers::new(seed);
    let mut centres = Vec::new();
    for row in (0..=ROWS).rev() {
        for column in 0..COLUMNS {
            let x = column as f64 + 0.5 * (row % 2) as f64 + random.between(-0.1, 0.1);
            centres.push([x, 0.85 * row as f64 + random.between(-0.1, 0.1)]);
        }
    }
    let grains = ROWS * COLUMNS;
    let mut records = vec![BodyRecord::default(); centres.len()];
    for (body, record) in records.iter_mut().enumerate().take(grains) {
        record.inverse_mass = 1.0 / (1.0 + (grains - body) as f64);
        record.velocity = [0, 1, 2].map(|_| random.between(-0.3, 0.3));
        record.velocity[1] -= 1.0;
    }
    let mut contacts = Vec::new();
    for a in 0..grains {
        for b in a + 1..centres.len() {
            let [dx, dy] = [0, 1].map(|axis| centres[a][axis] - centres[b][axis]);
            let distance = f64::hypot(dx, dy);
            if distance < 1.15 {
                contacts.push(Contact {
                    a: a as u32,
                    b: b as u32,
                    glued: b >= grains,
                    normal: [dx / distance, dy / distance],
                    bias: [random.between(-0.01, 0.1), 0.0],
                    bond: NO_BOND,
                    levers: NO_LEVERS,
                    ..Contact::default()
                });
            }
        }
    }
    let size = 2 * COLUMNS;
    let compliance = (0..size * size).map(|i| {
        let apart = (i / size).abs_diff(i % size) as f64;
        if apart % 2.0 == 0.0 {
            0.1 * (-0.3 * apart).exp()
        } else {
            0.0
        }
    });
    let mut boundary = CompliantBoundary::compliant(COLUMNS, compliance.collect());
    boundary.start(&vec![0.0; size]);
    let mut problem = Problem {
        contacts,
        records,
        first_glued: grains,
        boundary,
        friction,
        ..Problem::default()
    };
    problem.prepare(1e-10, false).expect("it is well posed");
    problem
}

/// The forces in rigid heaps are not unique. The true residual judges, independent of paths.
#[test]
fn heaps_with_friction_from_weak_to_strong_are_solved() {
    for seed in 0..20 {
        for friction in [0.1, 0.5, 1.0, 3.0] {
            let problem = heap(seed, friction);
            for tolerance in [1e-4, 1e-10] {
                let solved = solve(&problem, tolerance).expect("the path is followed");
                let left = residual(&solved);
                assert!(left <= tolerance, "{left:e} at {friction}, heap {seed}");
            }
        }
    }
}

#[test]
fn contacts_with_a_friction_of_their_own_are_solved() {
    for seed in 0..20 {
        let mut problem = heap(seed, 0.0);
        problem.frictions = vec![0.2, 1.5];
        for (index, contact) in problem.contacts.iter_mut().enumerate() {
            contact.pair_law = index as u32 % 3;
        }
        problem.prepare(1e-10, false).expect("it is well posed");
        let solved = solve(&problem, 1e-10).expect("the path is followed");
        let left = residual(&solved);
        assert!(left <= 1e-10, "{left:e}, heap {seed}");
    }
}

/// Plain, extrapolated and averaged sweeps fail in some of these heaps.
#[test]
fn heaps_on_which_sweeps_do_not_converge_are_solved_by_the_solver() {
    let mut beyond = 0;
    for seed in 0..20 {
        let ended = [1399, 1400].map(|max_iterations| {
            let criteria = Criteria {
                algorithm: Algorithm::Nsgs,
                tolerance: 1e-8,
                max_iterations,
                min_iterations: 1,
                parallel: false,
            };
            let mut problem = heap(seed, 1.5);
            let ended = Solver::default().solve(&mut problem, &criteria);
            ended.expect("it is finite").converged
        });
        assert!(ended[1], "heap {seed}");
        beyond += usize::from(!ended[0]);
    }
    assert!(beyond > 0);
}

#[test]
fn w_has_the_local_blocks_of_all_kinds_of_contacts_and_is_symmetric() {
    let mut problem = heap(1, 0.3);
    problem.levers.push(Levers {
        lever: [[0.3, 1.1], [-0.2, 0.9]],
        inverse: [[0.5, 0.5, 0.7], [0.4, 0.4, 0.6]],
    });
    problem.contacts[0].levers = 0;
    let w = Delassus::new(&problem, 0.0).expect("it is small");
    let near = |value: f64, expected: f64| {
        assert!((value - expected).abs() < 1e-14, "{value} {expected}");
    };
    for (i, contact) in problem.contacts.iter().enumerate() {
        let (block, expected) = (w.block(i, i), problem.block(contact));
        near(block[0][0], expected.nn);
        near(block[0][1], expected.nt);
        near(block[1][1], expected.tt);
        for (j, block) in &w.rows[i] {
            let mirrored = w.block(*j, i);
            // W is symmetric only if all contacts of a cluster have the same inertia.
            if i.min(*j) > 0 {
                near(block[0][1], mirrored[1][0]);
            }
        }
    }
}

/// A = [[4, 1, 0], [1, 3, 2], [0, -1, 5]], y = (1, 2, 3): unknowns come, go and are exchanged.
#[test]
fn equations_that_gain_and_lose_unknowns_keep_their_solution() {
    let a = [[4.0, 1.0, 0.0], [1.0, 3.0, 2.0], [0.0, -1.0, 5.0]];
    let right = [6.0, 13.0, 13.0];
    let mut system = System::default();
    for k in 0..3 {
        let column: Vec<_> = (0..k).map(|i| (i, a[i][k])).collect();
        let row: Vec<_> = (0..k).map(|i| (i, a[k][i])).collect();
        assert!(system.border(&column, &row, a[k][k], [right[k], -2.0 * right[k]]));
    }
    let near = |system: &System, expected: &[f64]| {
        assert_eq!(system.len(), expected.len());
        for (y, expected) in system.solution.iter().zip(expected) {
            assert!((y[0] - expected).abs() < 1e-14, "{y:?} {expected}");
            assert!((y[1] + 2.0 * expected).abs() < 1e-14, "{y:?} {expected}");
        }
    };
    near(&system, &[1.0, 2.0, 3.0]);
    // Without the first, the third takes its place: [[5, -1], [2, 3]] y = (13, 13).
    assert!(system.remove(0));
    near(&system, &[52.0 / 17.0, 39.0 / 17.0]);
    // w' = 2 v - w.
    system.mirror(0, 1, 2.0);
    near(&system, &[26.0 / 17.0, 39.0 / 17.0]);
    // The errors of -w' + 2 v = w: the columns are (-5, -2) and (9, 7).
    system.correct(&[[-5.0 * 0.5, 10.0 * 0.5], [-2.0 * 0.5, 4.0 * 0.5]]);
    let moved = system.solution[0];
    assert!((moved[0] - (26.0 / 17.0 - 0.5)).abs() < 1e-14, "{moved:?}");
}
