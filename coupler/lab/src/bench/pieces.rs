//! The cost of pieces that a scene may have: without them, with them but with nothing to do, and in use.

use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use crate::quiet::whole;
use coordinator::cost::prediction::Pace;
use coordinator::participants::Registry;
use coordinator::run::session::{RunOptions, fresh_run_id, run};
use kit::scratch::Scratch;
use runs::curve::median;
use runs::files::RunFiles;
use scenario::error::{Error, Refusal};
use scenario::load::load;

/// Runs of each kind, in turns; the middle one counts.
const TURNS: usize = 5;

/// A piece by the overrides of its scene.
struct Piece {
    name: &'static str,
    scenario: &'static str,
    base: &'static [&'static str],
    without: &'static [&'static str],
    idle: Option<&'static [&'static str]>,
    used: &'static [&'static str],
}

/// A rail of finite elements alone, until 0.4 ms.
const RAIL: &[&str] = &["run.end_s=0.4e-3", "participant.rail.config.element=q4_2x2"];
/// A layer alone, until 0.6 ms.
const SHORT: &[&str] = &["run.end_s=0.6e-3"];
/// A coupled run, until 0.6 ms.
/// Contacts with friction and without bonds.
const FRICTION: &[&str] = &[
    "participant.third-body.config.law={kind='coulomb',friction=0.3,contact_stiffness_pa=2.255e11,tangential_stiffness_ratio=0.5}",
];

/// The pieces. One in use changes what a run computes, not only what a step of it costs.
const PIECES: [Piece; 7] = [
    Piece {
        name: "plasticity",
        scenario: "wheel-rail-fe-small",
        base: RAIL,
        without: &[],
        idle: Some(&[
            "participant.rail.config.material.kind=j2",
            "participant.rail.config.material.yield_pa=1e15",
        ]),
        used: &[
            "participant.rail.config.material.kind=j2",
            "participant.rail.config.material.yield_pa=4e8",
            "participant.rail.config.material.hardening_pa=2e9",
        ],
    },
    Piece {
        name: "corotation",
        scenario: "wheel-rail-fe-small",
        base: RAIL,
        without: &[],
        idle: Some(&["participant.rail.config.kinematics=small"]),
        used: &["participant.rail.config.kinematics=corotational"],
    },
    Piece {
        name: "friction",
        scenario: "layer-alone",
        base: SHORT,
        without: &[
            "participant.third-body.config.law={kind='signorini',contact_stiffness_pa=2.255e11}",
        ],
        idle: Some(&[
            "participant.third-body.config.law={kind='coulomb',friction=0.0,contact_stiffness_pa=2.255e11,tangential_stiffness_ratio=0.5}",
        ]),
        used: FRICTION,
    },
    Piece {
        name: "cohesion",
        scenario: "layer-alone",
        base: SHORT,
        without: FRICTION,
        idle: None,
        used: &[
            "participant.third-body.config.law={kind='cohesion',friction=0.3,contact_stiffness_pa=2.255e11,tangential_stiffness_ratio=0.5,cn_pa_per_m=6.4e15,ct_pa_per_m=2.56e15,w_j_per_m2=15625.0,b_pa_m_s=0.0,p=1.0,h_prime='one',alert_m=8e-6,bonds_min=2}",
        ],
    },
    Piece {
        name: "recording",
        scenario: "quick",
        base: SHORT,
        without: &["run.output.exchange=false"],
        idle: None,
        used: &["run.output.exchange=true"],
    },
    Piece {
        name: "fields",
        scenario: "quick",
        base: SHORT,
        without: &["run.output.fields=false"],
        idle: Some(&["run.output.fields=true"]),
        used: &["run.output.fields_every_s=0.5e-4"],
    },
    Piece {
        name: "checkpoints",
        scenario: "quick",
        base: SHORT,
        without: &["run.checkpoint_every_windows=0"],
        idle: Some(&["run.checkpoint_every_windows=1000000"]),
        used: &["run.checkpoint_every_windows=100"],
    },
];

/// A row of the table: processor time of all processes, medians of five runs in turns.
#[derive(Clone, Debug, Serialize)]
pub struct PieceRow {
    /// The piece.
    pub piece: String,
    /// Its scene.
    pub scene: String,
    /// Without it (s).
    pub without_s: f64,
    /// With it and nothing for it to do, over that; absent where it has no such state.
    pub idle_over_without: Option<f64>,
    /// In use, over that.
    pub used_over_without: f64,
    /// The same of a second series without it: what chance makes of a ratio of 1.
    pub again_over_without: f64,
}

/// Runs the pieces, each kind in turn with the others. The scenes are those under `scenarios/`.
///
/// # Errors
/// A run does not end as it should.
pub fn bench(registry: &Registry, program: &Path) -> Result<Vec<PieceRow>, Error> {
    let mut rows = Vec::new();
    for piece in &PIECES {
        let without = Some(piece.without);
        let kinds = [without, without, piece.idle, Some(piece.used)];
        let mut times: [Vec<f64>; 4] = Default::default();
        for _ in 0..TURNS {
            for (times, kind) in times.iter_mut().zip(kinds) {
                if let Some(set) = kind {
                    times.push(cpu_s(piece, set, registry, program)?);
                }
            }
        }
        let [without, again, idle, used] = times.map(median);
        let without = without.filter(|s| *s > 0.0);
        let without = without.ok_or_else(|| Refusal::Benchmark("a run cost nothing".into()))?;
        rows.push(PieceRow {
            piece: piece.name.into(),
            scene: piece.scenario.into(),
            without_s: without,
            idle_over_without: idle.map(|idle| idle / without),
            used_over_without: used.unwrap_or(f64::NAN) / without,
            again_over_without: again.unwrap_or(f64::NAN) / without,
        });
        if piece.name == "checkpoints" {
            rows.push(prediction(without));
        }
    }
    Ok(rows)
}

/// Processor time of all processes of a run (s).
fn cpu_s(piece: &Piece, set: &[&str], registry: &Registry, program: &Path) -> Result<f64, Error> {
    let overrides = piece.base.iter().chain(set).map(|set| set.to_string());
    let loaded = load(piece.scenario, &overrides.collect::<Vec<_>>())?;
    let scratch = Scratch::new("pieces", fresh_run_id());
    let options = RunOptions::quiet(Some(scratch.path()), registry, program);
    whole(run(&loaded, &options))?;
    let cost = RunFiles::read(scratch.path())?.cost();
    Ok(cost.get("cpu_s").copied().unwrap_or(0.0))
}

/// The foretelling of the cost, which every run does until its first second is over: time of its looks at the windows of such a run,
/// over the processor time of the run (s).
fn prediction(run_s: f64) -> PieceRow {
    const WINDOWS: u32 = 100_000;
    let mut pace = Pace::new(Vec::new());
    let start = Instant::now();
    // A run without an end: it never comes to a prediction within so few looks.
    pace.begin(start, 0.0, f64::INFINITY);
    for window in 0..WINDOWS {
        pace.see(f64::from(window));
    }
    let each_s = start.elapsed().as_secs_f64() / f64::from(WINDOWS);
    // 0.6 ms in windows of 0.612 us.
    let part = 980.0 * each_s / run_s;
    PieceRow {
        piece: "prediction".into(),
        scene: "quick".into(),
        without_s: run_s,
        idle_over_without: None,
        used_over_without: 1.0 + part,
        again_over_without: 1.0,
    }
}
