//! Sweeps in groups against sweeps one by one.

use super::*;
use crate::contact::bond::BondContact;
use crate::contact::boundary::CompliantBoundary;
use crate::law::local::BondLaw;
use crate::random::RandomNumbers;
use crate::solver::contact::NO_BOND;
use crate::solver::residual::measured;

const GRAINS: usize = 60;
const GLUED: usize = 6;

/// Grains that touch at random, a wheel over some, a compliant boundary under others; the law is friction 0.3 and
/// springs, and every fourth contact has a bond. Grain 0 touches all others: more neighbours than there are open groups.
fn problem() -> Problem {
    let mut random = RandomNumbers::new(7);
    let wheel = GRAINS + GLUED;
    let mut contact = |a: usize, b: usize| {
        let angle = random.between(0.0, std::f64::consts::TAU);
        Contact {
            a: a as u32,
            b: b as u32,
            glued: (GRAINS..wheel).contains(&b) || a >= GRAINS,
            normal: [angle.cos(), angle.sin()],
            relative_gap: random.between(-0.05, 0.05),
            bias: [random.between(-0.3, 0.1), random.between(-0.1, 0.1)],
            compliance: [0.2, 0.4],
            impulse: [random.between(0.0, 0.1), 0.0],
            ..Contact::default()
        }
    };
    let mut contacts = Vec::new();
    for a in 0..GRAINS {
        let neighbours = if a == 0 { 1..GRAINS } else { a + 1..a + 4 };
        contacts.extend(neighbours.filter(|b| *b < GRAINS).map(|b| contact(a, b)));
        if a % 3 == 0 {
            contacts.push(contact(a, GRAINS + a % GLUED));
        }
        if a % 5 == 0 {
            contacts.push(contact(a, wheel));
        }
    }
    contacts.push(contact(GRAINS + 1, wheel));
    bond_every(4, &mut contacts);
    let record = |i: usize| BodyRecord {
        velocity: [0.01 * i as f64, -0.02, 0.03],
        inverse_mass: if (GRAINS..wheel).contains(&i) {
            0.0
        } else {
            1.0 + 0.1 * (i % 7) as f64
        },
    };
    let at = |i: usize, j: usize| if i == j { 2.0 } else { 0.1 };
    let components = 0..4 * GLUED * GLUED;
    let compliance: Vec<f64> = components
        .map(|k| at(k / (2 * GLUED), k % (2 * GLUED)))
        .collect();
    let mut boundary = CompliantBoundary::compliant(GLUED, compliance);
    boundary.start(&[0.05; 2 * GLUED]);
    let mut law = BondLaw::new(0.02, 0.0);
    law.set_stiffness([3.0, 2.0], 1.0);
    let bond = BondContact {
        law,
        ..BondContact::default()
    };
    let mut problem = Problem {
        bonds: vec![bond; contacts.len()],
        contacts,
        records: (0..=wheel).map(record).collect(),
        first_glued: GRAINS,
        wheel: Some(wheel),
        boundary,
        friction: 0.3,
        ..Problem::default()
    };
    problem.prepare(1.0, false).expect("it is well posed");
    problem
}

fn bond_every(step: usize, contacts: &mut [Contact]) {
    for (index, contact) in contacts.iter_mut().enumerate() {
        let bonded = index % step == 0 && (contact.b as usize) < GRAINS + GLUED;
        contact.bond = if bonded { index as u32 } else { NO_BOND };
    }
}

/// The contacts in the order in which a sweep treats them.
fn order(sweeper: &Sweeper) -> Vec<u32> {
    let grouped = sweeper
        .lists()
        .flat_map(|list| list.members.iter().flatten());
    let all = sweeper
        .glued
        .iter()
        .map(|(_, index)| index)
        .chain(grouped)
        .chain(&sweeper.wheel)
        .chain(&sweeper.clustered);
    all.copied().filter(|index| *index != EMPTY).collect()
}

#[test]
fn every_contact_is_swept_once_and_groups_share_no_body() {
    let problem = problem();
    let mut sweeper = Sweeper::default();
    sweeper.load(&problem);
    let mut all = order(&sweeper);
    all.sort_unstable();
    assert!(all.iter().copied().eq(0..problem.contacts.len() as u32));
    for members in &sweeper.subdomains[0].work.members {
        let mut bodies: Vec<u32> = members
            .iter()
            .filter(|index| **index != EMPTY)
            .map(|index| &problem.contacts[*index as usize])
            .flat_map(|contact| [contact.a, contact.b])
            .collect();
        let count = bodies.len();
        bodies.sort_unstable();
        bodies.dedup();
        assert_eq!(bodies.len(), count);
    }
    assert!(sweeper.grouping.taken.iter().all(|taken| *taken == 0));
}

#[test]
fn pairs_are_sorted_by_their_first_numbers_and_else_keep_their_order() {
    let pairs = [(7, 0), (5, 1), (7, 2), (9, 3), (5, 4), (5, 5)];
    let mut sorting = CountingSort::default();
    for _ in 0..2 {
        let mut sorted = pairs;
        sorting.sort(&mut sorted);
        assert_eq!(sorted, [(5, 1), (5, 4), (5, 5), (7, 0), (7, 2), (9, 3)]);
        sorting.sort(&mut []);
    }
}

#[test]
fn a_sweep_in_groups_is_the_sweep_one_by_one() {
    for friction in [0.0, 0.3] {
        let mut fast = problem();
        fast.friction = friction;
        fast.contacts.iter_mut().for_each(|c| c.impulse[1] = 0.0);
        let mut plain = fast.clone();
        for contact in &mut plain.contacts {
            let softened = crate::law::local::DelassusBlock {
                nn: contact.block.nn + contact.compliance[0],
                nt: contact.block.nt,
                tt: contact.block.tt + contact.compliance[1],
            };
            contact.law =
                crate::law::local::LocalLaw::new(softened, friction, (0, 0)).expect("well posed");
        }
        fast.contacts.clone_from(&plain.contacts);
        let mut sweeper = Sweeper::default();
        sweeper.load(&fast);
        let order = order(&sweeper);
        for _ in 0..5 {
            let squares = sweeper.sweep(&mut fast, false);
            let mut expected = [0.0; 2];
            let mut contacts = std::mem::take(&mut plain.contacts);
            for index in &order {
                solve_contact(&mut plain, &mut contacts[*index as usize], &mut expected);
            }
            plain.contacts = contacts;
            for (square, expected) in squares.into_iter().zip(expected) {
                assert!((square - expected).abs() <= 1e-12 * expected);
            }
            // The measurement by groups agrees with the measurement one by one after each sweep.
            let (defect, quad) = sweeper.measured(&mut fast, false);
            let (expected, expected_quad) = measured(&plain, false);
            let seen = [defect.residual(&fast), defect.size()].into_iter();
            let known = [expected.residual(&plain), expected.size()].into_iter();
            let pairs = seen
                .zip(known)
                .chain(quad.norms.into_iter().zip(expected_quad.norms));
            for (seen, known) in pairs {
                assert!(
                    known > 0.0 && (seen - known).abs() <= 1e-11 * known,
                    "{seen} {known}"
                );
            }
        }
        sweeper.store(&mut fast);
        for (fast, plain) in fast.contacts.iter().zip(&plain.contacts) {
            for (r, expected) in fast.impulse.into_iter().zip(plain.impulse) {
                assert!((r - expected).abs() < 1e-13, "{r} instead of {expected}");
            }
        }
        for (fast, plain) in fast.records.iter().zip(&plain.records) {
            for (v, expected) in fast.velocity.into_iter().zip(plain.velocity) {
                assert!((v - expected).abs() < 1e-12, "{v} instead of {expected}");
            }
        }
        for (v, expected) in fast.boundary.velocity.iter().zip(&plain.boundary.velocity) {
            assert!((v - expected).abs() < 1e-12, "{v} instead of {expected}");
        }
    }
}
