//! The compliance of a strip as the coupler receives it in the handshake (case 6 of the coupling page).
//!
//! Problem: a clamped strip of 10 x 20 elements with free sides, its upper edge of 11 nodes coupled; the coupler asks for
//! the columns of windows of 1 to 1 000 steps, through a channel and over shared memory.
//!
//! Exact answer: C = sum phi phi^T (1 - cos(omega H)) / omega^2 for synchronised steps, hence symmetric and positive
//! definite for any window, and C(1) = h^2 / 2 M^-1. Tolerance 1e-12 relative: rounding of 1 000 steps.

use coordinator::participants::remote::Remote;
use coordinator::participants::{Launcher, Watch, handshake};
use coordinator::run::session::fresh_run_id;
use harness::runs::{Scratch, as_programs, program};
use harness::scene::{head, interface, plate, strip};
use nalgebra::DMatrix;
use protocol::Window;
use runs::run_dir::RunDir;
use scenario::load::parse;
use scenario::source::ScenarioSource;
use scheme::group::Group;
use scheme::join::join;
use scheme::participants::Participants;

const STEP_S: f64 = 6.0e-8;
const SUBSTEPS: [u32; 4] = [1, 10, 100, 1000];

fn scenario() -> String {
    let time = format!("time = {{ step_s = {STEP_S:?}, damping = 0.5 }}");
    let sets = ["strip.top", "plate.row"];
    [
        head("columns", 1e-3, ""),
        strip("strip", ["clamped", "free"], 8e-3, &time),
        plate(23, 0.0, 1e-4),
        interface("glue", sets, "dual-schur", 10, "tolerance_rel = 1e-9"),
    ]
    .concat()
}

/// The group of a scenario after its handshake, and C (m/N) for each number of substeps.
fn asked(text: String, transport: &str) -> (Group, Vec<DMatrix<f64>>) {
    let source = ScenarioSource {
        name: "columns.toml".into(),
        text,
        overrides: vec![format!("run.transport={transport}")],
    };
    let loaded = parse(source).expect("it is valid");
    let scratch = Scratch::new("columns");
    let run_id = fresh_run_id();
    let rundir = RunDir::create(Some(scratch.path()), "columns", run_id).expect("an empty folder");
    let registry = harness::registry();
    let launcher = Launcher {
        loaded: &loaded,
        registry: &registry,
        program: program("thirdbody"),
        run_id,
        threads: 1,
        rundir: &rundir,
    };
    let scenario = &loaded.scenario;
    let started = launcher.start(&scenario.participant, Watch::default());
    let mut peers = started.expect("they start");
    let greeted = handshake::greet(&mut peers, &loaded, run_id).expect("they answer");
    let remote = &mut Remote::new(&mut peers, &greeted);
    let mut groups = join(remote, &scenario.interface).expect("they fit");
    let group = groups.remove(0);
    let side = &group.force_driven[0];
    let n = 2 * side.range.len();
    let matrices = SUBSTEPS.map(|m| {
        let window = Window {
            substeps: m,
            ..Window::default()
        };
        remote
            .compliance(side.peer, &window, n)
            .expect("it is stable")
    });
    (group, matrices.to_vec())
}

#[test]
fn the_compliance_of_a_window_is_symmetric_and_positive_definite() {
    let (group, inside) = asked(scenario(), "channel");
    for (m, c) in SUBSTEPS.iter().zip(&inside) {
        let asymmetry = (c - c.transpose()).amax() / c.amax();
        let eigenvalues = (0.5 * (c + c.transpose())).symmetric_eigen().eigenvalues;
        let (least, most) = (eigenvalues.min(), eigenvalues.max());
        println!("m = {m}: asymmetry {asymmetry:.1e}, eigenvalues {least:.3e} to {most:.3e} m/N");
        assert_eq!(c.nrows(), 2 * group.nodes.len());
        assert!(asymmetry <= 1e-12, "m = {m}: asymmetry {asymmetry:e}");
        assert!(least > 1e-9 * most, "m = {m}: {least:e} of {most:e}");
    }
    for (i, mass) in group.nodes.mass_kg.iter().enumerate() {
        let exact = 0.5 * STEP_S * STEP_S / mass;
        assert!((inside[0][(2 * i, 2 * i)] / exact - 1.0).abs() <= 1e-12);
    }
    let (_, outside) = asked(as_programs(&scenario()), "shm");
    assert_eq!(inside, outside, "shared memory changes no bit");
}
