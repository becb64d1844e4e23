//! Cost of optional features of a scene: runs without a feature, with an idle one, and with one in use. A feature in use changes the
//! results of a run, not only the cost of a step.
//!
//! ```sh
//! cargo bench -p tests --bench pieces
//! ```
//!
//! Solvers and coordinator run on one core, so the time of a run is their total processor time.

use std::fmt;
use std::path::Path;
use std::time::Instant;

use coordinator::cost::prediction::Pace;
use coordinator::run::session::{RunOptions, run};
use divan::Bencher;
use harness::runs::Scratch;
use nix::sched::{CpuSet, sched_getcpu, sched_setaffinity};
use nix::unistd::Pid;
use scenario::load::load;

fn main() {
    let mut core = CpuSet::new();
    let here = sched_getcpu().and_then(|here| core.set(here));
    here.and_then(|()| sched_setaffinity(Pid::from_raw(0), &core))
        .expect("the core of this thread is one that it may use");
    divan::main();
}

/// A rail of finite elements alone, until 0.4 ms.
const RAIL: &[&str] = &["run.end_s=0.4e-3", "participant.rail.config.element=q4_2x2"];
/// A layer alone or a coupled run, until 0.6 ms.
const SHORT: &[&str] = &["run.end_s=0.6e-3"];
/// Contacts with friction and without bonds.
const FRICTION: &[&str] = &[
    "participant.third-body.config.law={kind='coulomb',friction=0.3,contact_stiffness_pa=2.255e11,tangential_stiffness_ratio=0.5}",
];

/// A name, and the overrides of the scene.
struct Variant(&'static str, &'static [&'static str]);

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.0)
    }
}

const PLASTICITY: [Variant; 3] = [
    Variant("without", &[]),
    Variant(
        "idle",
        &[
            "participant.rail.config.material.kind=j2",
            "participant.rail.config.material.yield_pa=1e15",
        ],
    ),
    Variant(
        "used",
        &[
            "participant.rail.config.material.kind=j2",
            "participant.rail.config.material.yield_pa=4e8",
            "participant.rail.config.material.hardening_pa=2e9",
        ],
    ),
];

const COROTATION: [Variant; 3] = [
    Variant("without", &[]),
    Variant("idle", &["participant.rail.config.kinematics=small"]),
    Variant("used", &["participant.rail.config.kinematics=corotational"]),
];

const CONTACT_FRICTION: [Variant; 3] = [
    Variant(
        "without",
        &["participant.third-body.config.law={kind='signorini',contact_stiffness_pa=2.255e11}"],
    ),
    Variant(
        "idle",
        &[
            "participant.third-body.config.law={kind='coulomb',friction=0.0,contact_stiffness_pa=2.255e11,tangential_stiffness_ratio=0.5}",
        ],
    ),
    Variant("used", FRICTION),
];

const COHESION: [Variant; 2] = [
    Variant("without", FRICTION),
    Variant(
        "used",
        &[
            "participant.third-body.config.law={kind='cohesion',friction=0.3,contact_stiffness_pa=2.255e11,tangential_stiffness_ratio=0.5,cn_pa_per_m=6.4e15,ct_pa_per_m=2.56e15,w_j_per_m2=15625.0,b_pa_m_s=0.0,p=1.0,h_prime='one',alert_m=8e-6,bonds_min=2}",
        ],
    ),
];

const RECORDING: [Variant; 2] = [
    Variant("without", &["run.output.exchange=false"]),
    Variant("used", &["run.output.exchange=true"]),
];

const FIELDS: [Variant; 3] = [
    Variant("without", &["run.output.fields=false"]),
    Variant("idle", &["run.output.fields=true"]),
    Variant("used", &["run.output.fields_every_s=0.5e-4"]),
];

const CHECKPOINTS: [Variant; 3] = [
    Variant("without", &["run.checkpoint_every_windows=0"]),
    Variant("idle", &["run.checkpoint_every_windows=1000000"]),
    Variant("used", &["run.checkpoint_every_windows=100"]),
];

#[divan::bench(args = PLASTICITY, sample_count = 5, sample_size = 1)]
fn plasticity(bencher: Bencher, variant: &Variant) {
    time_run(bencher, "wheel-rail-fe-small", RAIL, variant);
}

#[divan::bench(args = COROTATION, sample_count = 5, sample_size = 1)]
fn corotation(bencher: Bencher, variant: &Variant) {
    time_run(bencher, "wheel-rail-fe-small", RAIL, variant);
}

#[divan::bench(args = CONTACT_FRICTION, sample_count = 5, sample_size = 1)]
fn friction(bencher: Bencher, variant: &Variant) {
    time_run(bencher, "layer-alone", SHORT, variant);
}

#[divan::bench(args = COHESION, sample_count = 5, sample_size = 1)]
fn cohesion(bencher: Bencher, variant: &Variant) {
    time_run(bencher, "layer-alone", SHORT, variant);
}

#[divan::bench(args = RECORDING, sample_count = 5, sample_size = 1)]
fn recording(bencher: Bencher, variant: &Variant) {
    time_run(bencher, "quick", SHORT, variant);
}

#[divan::bench(args = FIELDS, sample_count = 5, sample_size = 1)]
fn fields(bencher: Bencher, variant: &Variant) {
    time_run(bencher, "quick", SHORT, variant);
}

#[divan::bench(args = CHECKPOINTS, sample_count = 5, sample_size = 1)]
fn checkpoints(bencher: Bencher, variant: &Variant) {
    time_run(bencher, "quick", SHORT, variant);
}

/// Every run predicts its cost during its first second: the looks at the windows of a run of `quick` of 0.6 ms in windows of 0.612 us.
#[divan::bench]
fn prediction() -> Pace {
    let mut pace = Pace::new(Vec::new());
    // A run without an end, which reaches no prediction within these looks.
    pace.begin(Instant::now(), 0.0, f64::INFINITY);
    for window in 0..980 {
        pace.see(f64::from(window));
    }
    pace
}

/// Whole runs of a scene in threads of this process.
fn time_run(bencher: Bencher, scene: &str, base: &[&str], Variant(_, own): &Variant) {
    let sets = ["run.transport=channel"].iter().chain(base).chain(*own);
    let sets: Vec<String> = sets.map(|set| set.to_string()).collect();
    let loaded = load(scene, &sets).expect("the scene is valid");
    let registry = harness::registry();
    bencher
        .with_inputs(|| Scratch::new("pieces"))
        .bench_refs(|scratch| {
            let options = RunOptions::quiet(Some(scratch.path()), &registry, Path::new(""));
            let ended = run(&loaded, &options).expect("it starts");
            assert!(ended.error.is_none(), "{:?}", ended.error);
        });
}
