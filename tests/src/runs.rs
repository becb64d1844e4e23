//! Running a scenario text in-process or over shared memory, and reading its output.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU64, Ordering};

use coordinator::events::Listener;
use coordinator::participants::Watch;
use coordinator::run::session::{Ended, RunOptions, run};
use protocol::{Node, PROTOCOL_VERSION, Session, Setting, Transport};
use runs::table::Table;
use scenario::error::Error;
use scenario::load::parse;
use scenario::source::ScenarioSource;
use serde_json::Value;

/// A new folder below the system's temporary one, removed when dropped.
pub struct Scratch {
    path: PathBuf,
}

impl Scratch {
    /// A new empty folder; `name` helps to find it while a test runs.
    pub fn new(name: &str) -> Scratch {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let unique = format!(
            "thirdbody-test-{name}-{}-{}",
            std::process::id(),
            COUNT.fetch_add(1, Ordering::Relaxed)
        );
        let path = std::env::temp_dir().join(unique);
        std::fs::create_dir_all(&path).expect("the temporary folder is writable");
        Scratch { path }
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

/// Files and summary of a run.
pub struct Left {
    /// The end of the run: error, exit code, results.
    pub ended: Ended,
    /// Columns of signals.csv by name.
    pub signals: BTreeMap<String, Vec<f64>>,
    /// The run directory, kept while this lives.
    pub scratch: Scratch,
}

impl Left {
    /// The run, which must have reached its end.
    pub fn completed(self) -> Left {
        if let Some(error) = &self.ended.error {
            let logs = self.scratch.path().join("logs");
            let texts = std::fs::read_dir(&logs).into_iter().flatten().flatten();
            let texts: Vec<String> = texts
                .flat_map(|entry| std::fs::read_to_string(entry.path()))
                .collect();
            panic!("the run ended early: {error}\n{}", texts.join("\n"));
        }
        self
    }

    /// A number of summary.json by its path, for instance `coupling.gap_max_rel`.
    pub fn number(&self, path: &str) -> f64 {
        let value = self.ended.summary.value();
        path.split('.')
            .fold(&value, |value, key| &value[key])
            .as_f64()
            .unwrap_or_else(|| panic!("no number {path} in {value:#}"))
    }

    /// A text of summary.json by its path.
    pub fn text(&self, path: &str) -> String {
        let value = self.ended.summary.value();
        let found = path.split('.').fold(&value, |value, key| &value[key]);
        found
            .as_str()
            .unwrap_or_else(|| panic!("no text {path} in {value:#}"))
            .to_string()
    }
}

/// Runs a scenario text with the verification solvers in threads of this process.
pub fn run_in_process(text: &str, overrides: &[&str]) -> Result<Left, Error> {
    let mut all = vec!["run.transport=channel"];
    all.extend(overrides);
    run_text(text, &all)
}

/// Runs a scenario text over shared memory: verification solvers as foreign programs, shipped ones by `thirdbody`.
pub fn run_over_shared_memory(text: &str, overrides: &[&str]) -> Result<Left, Error> {
    run_text(&as_programs(text), overrides)
}

/// Runs a scenario text in-process and over shared memory, to the same bits; returns the second run.
pub fn run_both_ways(text: &str, overrides: &[&str]) -> Left {
    let inside = run_in_process(text, overrides).expect("it is valid");
    let outside = run_over_shared_memory(text, overrides).expect("it is valid");
    let (inside, outside) = (inside.completed(), outside.completed());
    assert_eq!(inside.signals, outside.signals);
    for hash in ["hashes.state", "hashes.exchange"] {
        assert_eq!(inside.text(hash), outside.text(hash));
    }
    outside
}

/// A solver by itself, as a run with this seed and this thickness (m) builds it.
pub fn node(kind: &str, (seed, thickness_m): (u64, f64), config: Value) -> Box<dyn Node> {
    let registry = crate::registry();
    let solver = registry.get(kind).expect("it is registered");
    let session = Session {
        protocol: PROTOCOL_VERSION,
        run_id: 1,
        scenario_hash: String::new(),
        coordinator_pid: std::process::id(),
        setting: Setting {
            participant: kind.into(),
            seed,
            thickness_m,
            threads: 1,
            fields: None,
            cache: None,
        },
        transport: Transport::Channel,
        idle_deadline_s: 60.0,
        config,
    };
    (solver.build)(&session).expect("it is valid")
}

/// A scenario text with the verification solvers as foreign programs.
pub fn as_programs(text: &str) -> String {
    let mut table: toml::Table = text.parse().expect("the test's scenario is TOML");
    let participants = table["participant"].as_array_mut().expect("a list");
    for participant in participants {
        let participant = participant.as_table_mut().expect("a table");
        let kind = participant["kind"].as_str().expect("a text").to_string();
        if !["fem", "dem"].contains(&kind.as_str()) {
            let program = program("verification-node").display().to_string();
            participant.insert("command".into(), vec![program, kind].into());
        }
    }
    toml::to_string(&table).expect("it was TOML before")
}

fn run_text(text: &str, overrides: &[&str]) -> Result<Left, Error> {
    let source = ScenarioSource {
        name: "test.toml".into(),
        text: text.into(),
        overrides: overrides.iter().map(|set| set.to_string()).collect(),
    };
    let loaded = parse(source)?;
    let scratch = Scratch::new(&loaded.scenario.run.name);
    let registry = crate::registry();
    let ended = run(
        &loaded,
        &RunOptions {
            out: Some(scratch.path()),
            threads: 1,
            registry: &registry,
            program: program("thirdbody"),
            watch: Watch::default(),
            listener: Listener::default(),
            strict: false,
            dry_run: false,
            budget: None,
        },
    )?;
    let signals = read_csv(&scratch.path().join("signals.csv"));
    Ok(Left {
        ended,
        signals,
        scratch,
    })
}

/// Columns of a table of a run by name; empty if there is no table.
pub fn read_csv(path: &Path) -> BTreeMap<String, Vec<f64>> {
    Table::read_whole_rows(path).columns.into_iter().collect()
}

/// A program of this workspace, built with the tests.
pub fn program(name: &str) -> PathBuf {
    let mut folder = std::env::current_exe().expect("a test knows its own path");
    folder.pop();
    if folder.ends_with("deps") {
        folder.pop();
    }
    let path = folder.join(name);
    assert!(
        path.is_file(),
        "{} is not built: run `cargo test --release` on the whole workspace",
        path.display()
    );
    path
}

/// The command `thirdbody`, started in this folder.
pub fn thirdbody(folder: &Path) -> Command {
    let mut command = Command::new(program("thirdbody"));
    command.current_dir(folder);
    // The tests leave the user's cache alone.
    command.env("XDG_CACHE_HOME", folder.join("cache"));
    command
}

/// summary.json as a command printed it with `--json`.
pub fn parse_json(stdout: &[u8]) -> Value {
    serde_json::from_slice(stdout)
        .unwrap_or_else(|error| panic!("{error} in {}", String::from_utf8_lossy(stdout)))
}

/// A hash of the bits of numbers.
pub fn bits_hash<'a>(numbers: impl Iterator<Item = &'a f64>) -> String {
    let mut hash = blake3::Hasher::new();
    for number in numbers {
        hash.update(&number.to_bits().to_le_bytes());
    }
    hash.finalize().to_hex().to_string()
}
