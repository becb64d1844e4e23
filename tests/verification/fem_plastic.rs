//! Problem: a confined block, ezz = exx = 0, under slow tension and compression with four reversals.
//! Exact: with q = s_yy - s_xx and p the plastic part of eyy, q = 2 mu eyy - 3 mu p. The block yields at
//! q - K p = +-(Y + H a), a the sum of |dp|, and on each branch dp = 2 mu d(eyy beyond yield) / (3 mu + H + K).
//! s_yy = k eyy + 2/3 q, k the bulk modulus. Without hardening, a free block under tension in plane strain reaches
//! s_yy = 2 Y/sqrt(3), s_xx = 0, s_zz = Y/sqrt(3).
//! Source: R. Hill, The Mathematical Theory of Plasticity (1950), ch. 2 and 4.
//! Tolerance: 1e-6 for the cycles. Each branch takes 500 periods at 0.9 of the critical damping, so the remaining
//! oscillation comes from a step of 2e-3 of the force. 1e-4 for the limit, from the elastic part.

use fem_kernel::element::body::ElementKind;
use fem_node::FemNode;
use fem_node::output::probe;
use protocol::Node;
use serde_json::{Value, json};

use crate::fem_bodies::{block, node, reported, strip, window, with};

const MU: f64 = 102.5e9 / 2.6;
const YIELD: f64 = 400e6;
const ELEMENTS: [&str; 3] = ["q4_1point", "q4_2x2", "q4_bbar"];

fn bulk() -> f64 {
    102.5e9 / (3.0 * 0.4)
}

/// eyy after a monotonic change of the stress to each of `targets`, by the formulas above.
fn exact(targets: &[f64], isotropic: f64, kinematic: f64) -> Vec<f64> {
    let (mut strain, mut p, mut a, mut stress) = (0.0, 0.0, 0.0, 0.0);
    let follow = |target: &f64| {
        let sign = f64::signum(target - stress);
        // s = k e + 2/3 q and q = 2 mu e - 3 mu p give the strain at which yielding starts, then the two slopes.
        let elastic = |stress: f64| (stress + 2.0 * MU * p) / (bulk() + 4.0 / 3.0 * MU);
        let onset_q = kinematic * p + sign * (YIELD + isotropic * a);
        let onset = (onset_q + 3.0 * MU * p) / (2.0 * MU);
        let onset_stress = bulk() * onset + 2.0 / 3.0 * onset_q;
        stress = *target;
        if sign * (target - onset_stress) <= 0.0 {
            strain = elastic(*target);
            return strain;
        }
        let hardening = isotropic + kinematic;
        let share = 2.0 * MU / (3.0 * MU + hardening);
        let slope = bulk() + 2.0 / 3.0 * (2.0 * MU - 3.0 * MU * share);
        let beyond = (target - onset_stress) / slope;
        p += share * beyond;
        a += (share * beyond).abs();
        strain = onset + beyond;
        strain
    };
    targets.iter().map(follow).collect()
}

/// eyy of one element, 1 mm high and wide, after each of these stresses.
fn cycled(element: &str, targets: &[f64], isotropic: f64, kinematic: f64) -> Vec<f64> {
    let (height, modulus) = (1e-3, bulk() + 4.0 / 3.0 * MU);
    let omega = (2.0 * modulus / 7800.0).sqrt() / height;
    let mut node = node(&with(
        strip(height, height, height),
        json!({
            "element": element,
            "material": {"yield_pa": YIELD, "hardening_pa": isotropic, "kinematic_hardening_pa": kinematic},
            "time": {"mass_damping_per_s": 1.8 * omega, "safety": 0.2},
        }),
    ));
    node.couple("top").expect("a set");
    let (mut index, mut stress) = (0, 0.0);
    let mut go = |target: &f64| {
        let rise = (1..=500).map(|k| f64::from(k) / 500.0).chain([1.0; 50]);
        for share in rise {
            let force = 0.5 * 1e-6 * (stress + share * (target - stress));
            let window = window(index, 30);
            node.advance(&window, &[0.0, force, 0.0, force])
                .expect("stable");
            node.commit(&window, &[]).expect("advanced");
            index += 1;
        }
        stress = *target;
        node.state().u[node.model.body.layout.index([0, 0], 1)] / height
    };
    targets.iter().map(&mut go).collect()
}

#[test]
fn cycles_follow_isotropic_and_kinematic_hardening() {
    let targets = [1.5e9, -1.2e9, 2.0e9, -2.2e9, 0.5e9];
    for (isotropic, kinematic) in [(20e9, 0.0), (0.0, 20e9), (5e9, 10e9)] {
        let expected = exact(&targets, isotropic, kinematic);
        for element in ELEMENTS {
            let measured = cycled(element, &targets, isotropic, kinematic);
            for (measured, exact) in measured.iter().zip(&expected) {
                let close = (measured - exact).abs() <= 1e-6 * 0.01;
                assert!(
                    close,
                    "{element} {isotropic} {kinematic}: {measured:e} {exact:e}"
                );
            }
        }
    }
}

/// The two laws differ after a reversal.
#[test]
fn kinematic_hardening_yields_earlier_in_reverse() {
    let targets = [1.5e9, -1.2e9];
    let (widened, moved) = (exact(&targets, 20e9, 0.0), exact(&targets, 0.0, 20e9));
    assert_eq!(widened[0], moved[0]);
    assert!(
        (widened[1] - moved[1]).abs() > 1e-4,
        "{widened:?} {moved:?}"
    );
}

#[test]
fn a_pulled_block_reaches_the_limit_of_plane_strain() {
    for element in ELEMENTS {
        let mut node = node(&with(
            strip(1e-3, 1e-3, 1e-3),
            json!({
                "element": element, "sides": "free",
                "material": {"kind": "j2", "yield_pa": YIELD},
                "time": {"mass_damping_per_s": 3e4},
                "boundary": {"top": {"displacement_m": ["free", 5e-5], "ramp_s": 2e-3}},
            }),
        ));
        let steps = (1.9e-3 / node.model.scheme.step) as u32;
        node.advance_alone(&window(0, steps)).expect("stable");
        let [sxx, syy, sxy] = probe::stress(&node.model, node.state(), [0, 0], [0.0, 0.0]);
        let limit = 2.0 / 3f64.sqrt() * YIELD;
        assert!(
            (syy / limit - 1.0).abs() < 1e-4,
            "{element}: {syy:e} {limit:e}"
        );
        assert!(
            sxx.abs() < 1e-4 * limit && sxy.abs() < 1e-4 * limit,
            "{sxx:e} {sxy:e}"
        );
        let pressure = probe::pressure(&node.model, node.state(), [0, 0], [0.0, 0.0]);
        let close = (pressure / (-0.5 * limit) - 1.0).abs() < 1e-4;
        assert!(
            close,
            "{element}: {pressure:e}, the mean of limit, limit/2 and 0"
        );
    }
}

/// A crowned block with a low yield stress. The cases' forces make it yield.
fn soft(element: &str) -> Value {
    with(
        block(),
        json!({"element": element,
               "material": {"yield_pa": 1e5, "hardening_pa": 5e9, "kinematic_hardening_pa": 3e9}}),
    )
}

fn force(points: usize, seed: u64) -> Vec<f64> {
    (0..2 * points as u64)
        .map(|k| 100.0 * (((seed * 37 + k * 11) % 101) as f64 / 101.0 - 0.5))
        .collect()
}

/// Largest |W - E - D| / sum |W| over the windows, and the share of plastic dissipation at the end.
fn closure(config: &Value) -> (f64, f64) {
    let mut node = node(config);
    let points = node.couple("top").expect("a set").len();
    let mut worst: f64 = 0.0;
    let mut share = 0.0;
    for index in 0..100 {
        node.advance(&window(index, 10), &force(points, index))
            .expect("stable");
        let report = node.commit(&window(index, 10), &[]).expect("advanced");
        let term = |name| reported(&node, &report, name);
        let work = [term("interface_work"), term("applied_work")];
        let gone = ["strain", "kinetic", "numerical_loss", "plastic"].map(term);
        let total: f64 = work.iter().map(|w| w.abs()).sum();
        worst = worst.max((work.iter().sum::<f64>() - gone.iter().sum::<f64>()).abs() / total);
        share = term("plastic") / total;
    }
    (worst, share)
}

#[test]
fn every_joule_of_plastic_work_is_accounted_for() {
    for element in ELEMENTS {
        for damping in [0.5, 0.75] {
            let config = with(
                soft(element),
                json!({"time": {"damping": damping},
                       "boundary": {"right": {"traction_pa": [2e6, 1e6], "ramp_s": 5e-6}}}),
            );
            let (worst, share) = closure(&config);
            assert!(worst <= 1e-10, "{element} b {damping}: {worst:e}");
            assert!(
                share > 0.3,
                "{element} b {damping}: only {share} was dissipated"
            );
        }
    }
}

#[test]
fn a_repeat_starts_from_the_committed_history() {
    for element in ELEMENTS {
        let (mut plain, mut repeated) = (node(&soft(element)), node(&soft(element)));
        let points = plain.couple("top").expect("a set").len();
        repeated.couple("top").expect("a set");
        for index in 0..20 {
            let wrong = force(points, index + 100);
            repeated.advance(&window(index, 3), &wrong).expect("stable");
            let right = force(points, index);
            let answers = [&mut plain, &mut repeated]
                .map(|node| node.advance(&window(index, 9), &right).expect("stable"));
            assert_eq!(answers[0], answers[1]);
            let reports = [&mut plain, &mut repeated]
                .map(|node| node.commit(&window(index, 9), &[]).expect("advanced"));
            assert_eq!(reports[0], reports[1]);
        }
        let hash = |node: &mut FemNode| node.finish().expect("it ends").state_hash;
        assert_eq!(hash(&mut plain), hash(&mut repeated));
    }
}

#[test]
fn threads_do_not_change_a_bit_of_a_plastic_body() {
    let run = |threads: usize| {
        let config = with(
            crate::fem_bodies::rail(crate::fem_bodies::small()),
            json!({"element": "q4_2x2", "material": {"yield_pa": 1e5}}),
        );
        let mut node = crate::fem_bodies::node_on(&config, threads);
        let points = node.couple("top").expect("a set").len();
        for index in 0..3 {
            node.advance(&window(index, 10), &force(points, index))
                .expect("stable");
            node.commit(&window(index, 10), &[]).expect("advanced");
        }
        assert!(node.ledger().plastic > 0.0);
        node.finish().expect("it ends").state_hash
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn an_elastic_body_has_no_plastic_term_and_a_plastic_one_has() {
    let has = |config: &Value| {
        let terms = node(config).describe().ledger;
        terms.iter().any(|term| term.name == "plastic")
    };
    assert!(!has(&block()));
    assert!(has(&soft("q4_1point")));
}

/// Plastic flow keeps the volume, which locks the other elements.
#[test]
fn a_plastic_body_has_an_element_without_locking_by_default() {
    let element = |change: Value| node(&with(block(), change)).model.element;
    let plastic = json!({"material": {"yield_pa": 1e5}});
    assert_eq!(element(plastic.clone()), ElementKind::Q4MeanDilatation);
    assert_eq!(element(json!({})), ElementKind::Q4OnePoint);
    let named = with(plastic, json!({"element": "q4_2x2"}));
    assert_eq!(element(named), ElementKind::Q4Full);
}

#[test]
fn a_less_accurate_element_is_reported_once_it_has_yielded() {
    let codes = |element: &str, traction: f64| {
        let mut body = node(&with(
            soft(element),
            json!({"boundary": {"right": {"traction_pa": [traction, 0.0]}}}),
        ));
        body.advance_alone(&window(0, 300)).expect("stable");
        let findings = body.finish().expect("it ends").findings;
        let codes = findings.into_iter().map(|found| found.code);
        codes.filter(|code| code == "plastic_element").count()
    };
    assert_eq!(codes("q4_1point", 3e5), 1);
    assert_eq!(codes("q4_2x2", 3e5), 1);
    assert_eq!(codes("q4_bbar", 3e5), 0);
    assert_eq!(codes("q4_2x2", 3e3), 0, "it has not yielded");
}
