//! The readers of all external input, and sound inputs for each.

use std::path::{Path, PathBuf};

use coordinator::run::checkpoint::FOLDER;
use coordinator::run::checkpoint::content::{About, Checkpoint};
use coordinator::run::checkpoint::file::{MAGIC, encode, list, read};
use coordinator::run::checkpoint::keeper::about;
use harness::runs::{Scratch, node, thirdbody};
use protocol::frame::packed;
use protocol::serve::{Farewell, Hello, Welcome};
use protocol::{Frame, Header, Kind, Node, NodeError, Setting, Surface};
use scenario::load::{Loaded, load, parse};
use scenario::source::ScenarioSource;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios")
}

/// The files of this name of all scenes.
fn shipped(name: &str) -> Vec<Vec<u8>> {
    let scenes = [
        folder(),
        folder().join("verification"),
        folder().join("extremes"),
    ];
    let entries = scenes
        .iter()
        .flat_map(|scenes| std::fs::read_dir(scenes).expect("they ship"));
    let mut paths: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path().join(name))
        .collect();
    paths.sort();
    let files = paths
        .into_iter()
        .filter_map(|path| std::fs::read(path).ok());
    files.collect()
}

/// The shipped scenarios that name no file.
pub fn scenarios() -> Vec<Vec<u8>> {
    let mut all = shipped("scenario.toml");
    all.retain(|text| !String::from_utf8_lossy(text).contains(".msh"));
    assert!(all.len() > 20, "{}", all.len());
    all
}

/// Reads a scenario, up to the checks of its solvers.
pub fn scenario(bytes: &[u8]) -> bool {
    accepted(&String::from_utf8_lossy(bytes), &[])
}

fn accepted(text: &str, overrides: &[String]) -> bool {
    let source = ScenarioSource {
        name: "fuzz/scenario.toml".into(),
        text: text.into(),
        overrides: overrides.to_vec(),
    };
    match parse(source) {
        Ok(loaded) => checked(&loaded),
        Err(error) => {
            // Printing the error must not panic either.
            let _ = format!("{error}{error:?}");
            false
        }
    }
}

fn checked(loaded: &Loaded) -> bool {
    let each = loaded.scenario.participant.iter();
    let mut results = each.map(|participant| {
        let config = serde_json::to_value(&participant.config).expect("TOML has text keys");
        let setting = Setting {
            participant: participant.name.clone(),
            seed: loaded.scenario.run.seed,
            thickness_m: loaded.scenario.run.thickness_m,
            threads: 1,
            fields: None,
            cache: None,
        };
        match participant.kind.as_str() {
            "fem" => fem_node::check(&config, &setting).is_ok(),
            "dem" => dem_node::check(&config, &setting).is_ok(),
            _ => false,
        }
    });
    results.all(|sound| sound)
}

/// Overrides of `quick`.
pub fn overrides() -> Vec<Vec<u8>> {
    let sets = [
        "run.seed=2",
        "run.end_s=1e-4",
        "participant.rail.config.time.damping=0.8",
        "participant.third-body.config.law.friction=0.2",
        "participant.third-body.config.sample.press_pa=[3e8, 5e7]",
        "participant.rail.config.boundary.right={ load_table = [[0.0, 0.0], [1e-4, 5.0]], load_direction = [1.0, 0.0] }",
        "participant.rail.config.material={ kind = \"elastic\", young_pa = 1e11, poisson = 0.3, density_kg_per_m3 = 7800.0 }",
        "interface.layer-base.scheme=velocity",
        "interface.layer-base.between=[\"rail.top\", \"third-body.base\"]",
        "run.plausible.gap_rel=[0.1, 1.0]",
    ];
    sets.map(|set| set.as_bytes().to_vec()).to_vec()
}

/// `quick` with one override.
pub fn with_override(bytes: &[u8]) -> bool {
    let text = include_str!("../../scenarios/quick/scenario.toml");
    accepted(text, &[String::from_utf8_lossy(bytes).into_owned()])
}

/// Frames as bytes: the numbers of the header, then the payload.
pub fn frames() -> Vec<Vec<u8>> {
    let header = |kind: Kind| Header {
        run_id: 7,
        window: 3,
        step: 27,
        substeps: 9,
        t0_s: 1e-6,
        t1_s: 2e-6,
        ..Header::of(kind)
    };
    let json = |value: serde_json::Value| value.to_string();
    let hello = json(
        serde_json::json!({"protocol": 2, "run_id": 7, "scenario_hash": "ab", "participant": "rail", "units": "SI"}),
    );
    let fault = json(serde_json::json!({"code": "diverged", "message": "it left"}));
    let made = [
        Frame::new(header(Kind::Advance), vec![1.0, -2.5, 3e4]),
        Frame::new(
            header(Kind::Surface),
            vec![0.0, 1.0, 0.1, 0.2, 0.3, 1.0, 1.0, 0.1, 0.2, 0.3],
        ),
        Frame::new(header(Kind::Hello), packed(&hello)),
        Frame::new(header(Kind::Fault), packed(&fault)),
        Frame::new(header(Kind::State), packed([1, 2, 3, 4, 5, 6, 7, 8, 9])),
    ];
    made.iter().map(to_bytes).collect()
}

fn to_bytes(frame: &Frame) -> Vec<u8> {
    let h = &frame.header;
    let words = [
        u64::from(h.kind) << 32 | u64::from(h.protocol),
        h.run_id,
        u64::from(h.interface) << 32 | u64::from(h.iteration),
        h.window,
        h.step,
        u64::from(h.substeps) << 32 | u64::from(h.count),
        h.t0_s.to_bits(),
        h.t1_s.to_bits(),
        h.checksum,
    ];
    let numbers = frame.payload.iter().map(|value| value.to_bits());
    words
        .into_iter()
        .chain(numbers)
        .flat_map(u64::to_le_bytes)
        .collect()
}

/// Passes a frame to all its readers.
pub fn frame(bytes: &[u8]) -> bool {
    let words = bytes.chunks_exact(8);
    let mut words = words.map(|word| u64::from_le_bytes(word.try_into().expect("eight bytes")));
    let mut next = || words.next().unwrap_or_default();
    let both = |word: u64| ((word >> 32) as u32, word as u32);
    let (kind, protocol) = both(next());
    let run_id = next();
    let (interface, iteration) = both(next());
    let (window, step) = (next(), next());
    let (substeps, count) = both(next());
    let (t0_s, t1_s) = (f64::from_bits(next()), f64::from_bits(next()));
    let checksum = next();
    let header = Header {
        kind,
        protocol,
        run_id,
        interface,
        iteration,
        window,
        step,
        substeps,
        count,
        t0_s,
        t1_s,
        checksum,
    };
    let mut frame = Frame {
        header,
        payload: words.map(f64::from_bits).collect(),
    };
    let sound = frame.verify().is_ok() && frame.kind().is_ok();
    let _ = frame.bytes();
    if let Ok(text) = frame.text() {
        let _ = serde_json::from_str::<Hello>(&text);
        let _ = serde_json::from_str::<Welcome>(&text);
        let _ = serde_json::from_str::<Farewell>(&text);
        let _ = serde_json::from_str::<NodeError>(&text);
    }
    if let Some(surface) = Surface::from_rows(&frame.payload) {
        assert_eq!(surface.to_rows().len(), frame.payload.len());
    }
    let _ = frame.open(3);
    sound
}

/// Meshes of both formats.
pub fn meshes() -> Vec<Vec<u8>> {
    let mut all = shipped("cylinder.msh");
    assert!(!all.is_empty());
    let small = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
                 $Elements\n2\n1 3 2 1 1 1 2 3 4\n2 1 2 2 1 3 4\n$EndElements\n";
    all.push(small.into());
    all
}

/// A mesh of Gmsh.
pub fn mesh(bytes: &[u8]) -> bool {
    fem_node::mesh::gmsh::parse(bytes, 1e-3).is_ok()
}

/// A log of a short run.
pub fn logs() -> Vec<Vec<u8>> {
    let run = CheckpointedRun::new();
    vec![std::fs::read(run.out.join("exchange.mcap")).expect("the run wrote it")]
}

/// Reads a log strictly, tolerantly and as a summary.
pub fn log(path: &Path, bytes: &[u8]) -> bool {
    std::fs::write(path, bytes).expect("the folder is ours");
    let strictly = exchange_log::read(path).is_ok_and(|mut log| log.all(|entry| entry.is_ok()));
    if let Ok(entries) = exchange_log::recover(path) {
        assert!(entries.count() < 100_000, "more entries than were written");
    }
    let _ = exchange_log::summarize(path, true);
    strictly
}

/// A short run of `quick` with checkpoints.
pub struct CheckpointedRun {
    _scratch: Scratch,
    out: PathBuf,
    loaded: Loaded,
}

impl CheckpointedRun {
    /// Runs it.
    pub fn new() -> CheckpointedRun {
        let scratch = Scratch::new("fuzz-run");
        let out = scratch.path().join("out");
        let mut command = thirdbody(scratch.path());
        command
            .arg("run")
            .arg(folder().join("quick"))
            .args(["--out", "out"]);
        for set in ["run.end_s=6e-6", "run.checkpoint_every_windows=4"] {
            command.args(["--set", set]);
        }
        let output = command.output().expect("the program starts");
        assert!(output.status.success(), "{output:?}");
        let loaded = load(&out.display().to_string(), &[]).expect("it ran");
        CheckpointedRun {
            _scratch: scratch,
            out,
            loaded,
        }
    }

    /// Its checkpoints.
    pub fn files(&self) -> Vec<Vec<u8>> {
        let found = list(&self.out.join(FOLDER));
        assert!(!found.is_empty());
        let files = found.iter().map(|found| std::fs::read(&found.path));
        files.map(|file| file.expect("it is there")).collect()
    }

    fn last(&self) -> (About, Checkpoint) {
        let found = list(&self.out.join(FOLDER)).pop().expect("there is one");
        read(&found.path, &about(&self.loaded)).expect("it is sound")
    }

    /// Reads a checkpoint with these bytes, once as they are and once with the matching hash.
    pub fn read(&self, bytes: &[u8]) -> bool {
        let path = self.out.join("fuzzed.checkpoint");
        let mut sound = false;
        let start = MAGIC.len() + 32;
        let hashed = (bytes.len() > start).then(|| {
            let hash = blake3::hash(&bytes[start..]);
            [MAGIC, hash.as_bytes(), &bytes[start..]].concat()
        });
        for form in [Some(bytes.to_vec()), hashed].into_iter().flatten() {
            std::fs::write(&path, form).expect("the folder is ours");
            if let Ok((about, checkpoint)) = read(&path, &about(&self.loaded)) {
                sound = true;
                let _ = encode(&about, &checkpoint);
            }
        }
        sound
    }

    /// State and node of the participant of a kind.
    pub fn node(&self, kind: &str) -> (Vec<u8>, Box<dyn Node>) {
        let scenario = &self.loaded.scenario;
        let place = scenario.participant.iter().position(|p| p.kind == kind);
        let place = place.expect("quick has both");
        let config =
            serde_json::to_value(&scenario.participant[place].config).expect("TOML has text keys");
        let mut node = node(kind, (scenario.run.seed, scenario.run.thickness_m), config);
        let set = if kind == "fem" { "top" } else { "base" };
        let surface = node.couple(set).expect("it has this set");
        let points: Vec<usize> = (0..surface.len()).collect();
        node.select(&points).expect("all of them");
        (self.last().1.nodes[place].clone(), node)
    }
}
