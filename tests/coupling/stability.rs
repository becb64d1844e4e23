//! Predictions of stability before a run, and the map of them, against runs.
//!
//! Problem: an elastic bar of ten elements of 1 kg and 1 N/m, held at its far end, with masses on its other end: a glued one,
//! or a free one behind a spring.
//!
//! Exact answer: both sides are linear, so one window of a scheme is a matrix, built here from the bar's own steps; a
//! disturbance grows if its spectral radius is above one. The real coupler must give the forces of the matrix. For a
//! fixed point with constant relaxation omega the limit is omega (1 + C S) = 2 (Causin, Gerbeau and Nobile 2005).

use harness::runs::{Left, Scratch, run_in_process, thirdbody};
use harness::scene::{bar, glue, head, participant};
use harness::window_matrix::{Joint, Operator, TransmissionCondition as Condition};
use lab::bench::stability::bar::UnitBar;
use lab::bench::stability::map::{Axes, Cell, departure, map};
use lab::bench::stability::setup::keys;
use lab::bench::stability::{findings, limits};
use nalgebra::DVector;
use protocol::BoundaryInertia;
use scenario::error::Error;
use scheme::keys::{CouplingScheme, Dirichlet, Order, SchemeWord};
use scheme::predict::sprung_mass::{Masses, SprungMass};

/// Every scheme and the ends of every axis.
fn ends() -> Axes {
    Axes {
        thetas: vec![0.5, 1.0],
        mass_ratios: vec![1e-3, 1.0, 1e3],
        substeps: vec![1, 10, 10_000],
        cfls: vec![0.1, 0.9],
        stiffness_ratios: vec![1.0, f64::INFINITY],
        ..Axes::full()
    }
}

#[test]
fn the_default_is_stable_in_every_cell_and_predictions_of_stability_hold() {
    let cells = map(&ends()).expect("the models are linear");
    let found = findings(&cells, 23).expect("the coupler runs");
    println!("{}", found.table());
    assert_eq!(found.cells, 864);
    assert_eq!(found.unstable_default, 0);
    assert_eq!(found.missed, 0);
    assert_eq!(found.false_alarms, 0);
    assert!(found.sampled >= 20);
    assert!(found.departure <= 1e-6, "{:e}", found.departure);
    for word in [
        SchemeWord::StaggeredSerial,
        SchemeWord::StaggeredParallel,
        SchemeWord::FixedPointSerial,
    ] {
        let grows = |cell: &&_| -> bool {
            let cell: &lab::bench::stability::map::Cell = cell;
            cell.setup.keys == keys(word, Dirichlet::MotionDriven) && cell.growth > 2.0
        };
        assert!(cells.iter().filter(grows).count() > 10, "{word:?}");
    }
}

/// The growth of the schemes on a linear pair is the spectral radius of the hand-written matrices, or, for repeats that do not
/// contract, |1 - omega (1 + C S)|, with C S inverted where the continuum takes the motion.
#[test]
fn disturbances_grow_as_the_window_matrices_predict() {
    let cells = map(&ends()).expect("the models are linear");
    for cell in &cells {
        let expected = growth_by_matrix(cell);
        let apart = (cell.growth - expected).abs() / expected;
        assert!(apart <= 1e-8, "{:e} of {expected:e}: {cell:?}", cell.growth);
    }
}

fn growth_by_matrix(cell: &Cell) -> f64 {
    let trial = &cell.setup;
    let response = trial.bar.response(trial.substeps);
    let model = trial.model(&response);
    let (window_s, wall) = (model.window_s, model.whole());
    let continuum = trial.keys.dirichlet() == Dirichlet::ForceDriven;
    let comes_back = if continuum {
        1.0 / (response.prescribed_compliance(window_s) * wall.stiffness())
    } else {
        response.compliance() * wall.stiffness()
    };
    let condition = match (trial.keys.scheme(), continuum) {
        (CouplingScheme::FixedPoint { relaxation, .. }, _)
            if (1.0 - relaxation * (1.0 + comes_back)).abs() >= 1.0 =>
        {
            return (1.0 - relaxation * (1.0 + comes_back)).abs();
        }
        (CouplingScheme::DualSchur { .. }, _) | (CouplingScheme::FixedPoint { .. }, false) => {
            Condition::Exact
        }
        (CouplingScheme::Velocity { .. }, _) | (CouplingScheme::FixedPoint { .. }, true) => {
            Condition::Velocity
        }
        (CouplingScheme::Staggered { order, .. }, false) => match order {
            Order::Serial => Condition::LateForce,
            Order::Parallel => Condition::LateBoth,
        },
        (CouplingScheme::Staggered { order, .. }, true) => match order {
            Order::Serial => Condition::LateVelocity,
            Order::Parallel => Condition::LateVelocityAndForce,
        },
    };
    let operator = Operator {
        response: &response,
        wall,
        window_s,
        condition,
    };
    operator.growth()
}

#[test]
fn limits_are_found_where_they_are_predicted() {
    for limit in limits::limits(&[10], &[0.9]).expect("the coupler runs") {
        println!("{limit:?}");
        assert!(limit.difference_rel() <= 0.05, "{limit:?}");
    }
}

fn scenario(scheme: &str, theta: f64, substeps: u32) -> String {
    let end_s = 30.0 * f64::from(substeps) * 0.7;
    let masses = "glued_mass_kg = 2.0\ncount = 1\nmass_kg = 5.0\nstiffness_n_per_m = 3.0";
    let start = "x_m = 10.0\nvelocity_m_per_s = 1.0";
    let keys = format!("{start}\n{masses}\ntheta = {theta:?}\nend_s = {end_s:?}");
    [
        head("stability", 1.0, ""),
        bar("bar", 10, 0.7, "left_fixed = true"),
        participant("body", "chain", &keys),
        glue(scheme, substeps, "tolerance_rel = 1e-11"),
    ]
    .concat()
}

fn boundary_inertia(theta: f64) -> BoundaryInertia {
    BoundaryInertia {
        glued_mass_kg: 2.0,
        mass_kg: 5.0,
        stiffness_n_per_m: Some(3.0),
        theta,
        may_part: false,
    }
}

/// The verification solvers do not use the matrix: they step element by element and mass by mass.
#[test]
fn the_coupler_follows_the_window_matrix() {
    let schemes = [
        ("dual-schur", Condition::Exact),
        ("staggered-serial", Condition::LateForce),
        ("staggered-parallel", Condition::LateBoth),
        ("velocity", Condition::Velocity),
    ];
    for (scheme, condition) in schemes {
        for (theta, substeps) in [(0.5, 3), (1.0, 1), (1.0, 25)] {
            let asked = ["interface.glue.unsafe_window=true"];
            let left = run_in_process(&scenario(scheme, theta, substeps), &asked)
                .expect("it is valid")
                .completed();
            let distance = apart(&left, condition, theta, substeps);
            assert!(
                distance <= 1e-9,
                "{scheme}, {theta}, {substeps}: {distance:e}"
            );
        }
    }
}

#[test]
fn a_single_node_with_a_hundred_thousand_substeps_follows_the_matrix() {
    let left = run_in_process(&scenario("dual-schur", 1.0, 100_000), &[])
        .expect("it is valid")
        .completed();
    let distance = apart(&left, Condition::Exact, 1.0, 100_000);
    assert!(distance <= 1e-7, "{distance:e}");
    assert!(left.number("coupling.gap_max_rel") <= 1e-9);
}

/// Masses in motion meet a bar of ten elements at rest.
pub(crate) fn masses_in_motion() -> Joint {
    Joint {
        continuum: DVector::zeros(20),
        masses: Masses {
            glued_velocity: 1.0,
            position: 0.0,
            velocity: 1.0,
        },
        lambda: 0.0,
        motion: 0.0,
        position: 0.0,
    }
}

/// Largest difference of an interface force from the matrix's, over the largest force so far.
fn apart(left: &Left, condition: Condition, theta: f64, substeps: u32) -> f64 {
    let bar = UnitBar {
        elements: 10,
        step_s: 0.7,
    };
    let response = bar.response(substeps);
    let window_s = 0.7 * f64::from(substeps);
    let operator = Operator {
        response: &response,
        wall: SprungMass::new(&boundary_inertia(theta), window_s),
        window_s,
        condition,
    };
    let mut joint = masses_in_motion();
    let (mut largest, mut apart) = (0.0f64, 0.0f64);
    let forces = &left.signals["interface_fx_n"];
    assert_eq!(forces.len(), 30);
    for force in forces {
        joint = operator.advance(&joint);
        largest = largest.max(joint.lambda.abs());
        apart = apart.max((force - joint.lambda).abs() / largest);
    }
    apart
}

#[test]
fn an_unstable_choice_is_refused_by_name_and_can_be_forced() {
    let text = scenario("staggered-serial", 1.0, 1);
    let heavy = "participant.body.config.glued_mass_kg=100.0";
    let left = run_in_process(&text, &[heavy]).expect("it is valid");
    let error = left.ended.error.as_ref().expect("it is predicted to fail");
    assert!(matches!(error, Error::Refused(_)), "{error}");
    let cure = "take scheme = \"dual-schur\" or fewer substeps";
    for word in [
        "`glue`",
        "staggered-serial",
        "added mass",
        cure,
        "unsafe_window",
    ] {
        assert!(error.to_string().contains(word), "no {word} in {error}");
    }
    // No window length helps a continuum that is unstable by itself.
    let long = "participant.bar.config.step_s=1.01";
    let alone = run_in_process(&scenario("dual-schur", 1.0, 1), &[long]).expect("it is valid");
    let why = alone
        .ended
        .error
        .expect("it is predicted to fail")
        .to_string();
    assert!(
        why.contains("CFL") && why.contains("shorten the continuum's own step"),
        "{why}"
    );
    assert_eq!(left.number("exit_code"), 2.0);
    assert_eq!(left.number("windows"), 0.0);
    let insisted = run_in_process(&text, &[heavy, "interface.glue.unsafe_window=true"])
        .expect("it is valid")
        .completed();
    assert_eq!(insisted.number("windows"), 30.0);
}

#[test]
fn a_run_logs_the_prediction() {
    let left = run_in_process(&scenario("dual-schur", 1.0, 3), &[])
        .expect("it is valid")
        .completed();
    let log = std::fs::read_to_string(left.scratch.path().join("logs/coordinator.log"))
        .expect("every run has one");
    assert!(log.contains("interface `glue`: predicted: stable"), "{log}");
    assert!(log.contains("CFL"), "{log}");
}

#[test]
fn check_says_which_bound_decides() {
    let work = Scratch::new("bounds");
    let check = |sets: &[&str], code: i32| -> String {
        let output = thirdbody(work.path())
            .args(["check", "quick"])
            .args(sets)
            .output()
            .expect("the command starts");
        assert_eq!(output.status.code(), Some(code), "{output:?}");
        String::from_utf8(output.stdout).expect("text")
    };
    let default = check(&[], 0);
    for word in [
        "predicted: stable",
        "CFL",
        "first period / 4",
        "inertial time",
    ] {
        assert!(default.contains(word), "no {word} in {default}");
    }
    // `check` exits with the code of the refused run.
    let naive = check(
        &["--set", "interface.layer-base.scheme=staggered-serial"],
        2,
    );
    assert!(naive.contains("predicted: UNSTABLE"), "{naive}");
    assert!(naive.contains("added mass decides"), "{naive}");
    let fixed_point = [
        "--set",
        "interface.layer-base.scheme=fixed-point-serial",
        "--set",
        "interface.layer-base.dirichlet=continuum",
        "--set",
        "interface.layer-base.acceleration=constant",
        "--set",
        "interface.layer-base.tolerance_rel=1e-4",
    ];
    let swapped = check(&fixed_point, 0);
    for word in ["predicted: stable", "added mass", "the wall resists"] {
        assert!(swapped.contains(word), "no {word} in {swapped}");
    }
    assert!(!check(&["--no-start"], 0).contains("predicted"));
}

/// One cell of each scheme, at the corner with the largest forces.
#[test]
fn stiff_and_heavy_cells_follow_the_matrix_too() {
    let mut axes = Axes::full();
    axes.thetas = vec![1.0];
    axes.mass_ratios = vec![1e3];
    axes.substeps = vec![100];
    axes.cfls = vec![0.99];
    axes.stiffness_ratios = vec![100.0];
    for cell in map(&axes).expect("the models are linear") {
        let distance = departure(&cell, 12).expect("the coupler runs");
        assert!(distance <= 1e-6, "{:?}: {distance:e}", cell.setup.keys);
    }
}
