//! Running the shipped scenes by the real command.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use harness::runs::{parse_json, thirdbody};
use serde_json::Value;

/// The folder of a shipped scene.
pub fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../scenarios")
        .join(name)
}

/// `thirdbody run quick --out <work>/out --json`, shortened to about 100 windows, with more `--set`s.
pub fn short_quick(work: &Path, sets: &[&str]) -> Command {
    let mut command = thirdbody(work);
    command
        .arg("run")
        .arg(folder("quick"))
        .arg("--out")
        .arg(work.join("out"))
        .arg("--json");
    for set in ["run.end_s=6e-5"].iter().chain(sets) {
        command.args(["--set", set]);
    }
    command
}

/// Runs it and returns its summary; it must have completed.
pub fn completed(command: &mut Command) -> Value {
    let output = command.output().expect("the program starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    parse_json(&output.stdout)
}

/// Asserts an exit code and that stderr contains all of these words.
pub fn fails(output: &Output, code: i32, words: &[&str]) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    // Long lines are wrapped for the terminal; only the words count.
    let flat: String = stderr.split_whitespace().collect::<Vec<_>>().join(" ");
    for word in words {
        assert!(flat.contains(word), "no `{word}` in: {stderr}");
    }
}

/// A run in the background; dropping it ends the process.
pub struct Running {
    /// The coordinator.
    pub child: Child,
    out: PathBuf,
}

impl Running {
    /// Starts a command whose run directory will be `out`.
    pub fn start(command: &mut Command, out: &Path) -> Running {
        let child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        Running {
            child,
            out: out.to_path_buf(),
        }
    }

    /// Waits until the coordinator's log holds this text.
    pub fn wait_for(&mut self, text: &str) {
        let start = Instant::now();
        while !self.log().contains(text) {
            let ended = self.child.try_wait().expect("it is our child");
            assert!(ended.is_none(), "it ended before `{text}`: {}", self.log());
            assert!(
                start.elapsed() < Duration::from_secs(60),
                "no `{text}` in {}",
                self.log()
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// The coordinator's log so far.
    pub fn log(&self) -> String {
        std::fs::read_to_string(self.out.join("logs/coordinator.log")).unwrap_or_default()
    }

    /// Process ids of the participants, from the log.
    pub fn participants(&self) -> Vec<i32> {
        self.log()
            .lines()
            .filter_map(|line| {
                line.split_once(") pid ")
                    .and_then(|(_, pid)| pid.trim().parse().ok())
            })
            .collect()
    }

    /// Waits for the end, at most `limit`; returns the output and the time it took.
    pub fn end_within(mut self, limit: Duration) -> (Output, Duration) {
        let start = Instant::now();
        while self.child.try_wait().expect("it is our child").is_none() {
            assert!(
                start.elapsed() < limit,
                "still running after {limit:?}: {}",
                self.log()
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        let took = start.elapsed();
        (
            self.child.wait_with_output().expect("its output was piped"),
            took,
        )
    }
}

/// Waits at most `limit` until all these processes have ended.
pub fn gone_within(pids: &[i32], limit: Duration) {
    let start = Instant::now();
    let alive = |pid: &i32| {
        std::fs::read_to_string(format!("/proc/{pid}/stat")).is_ok_and(|stat| !stat.contains(") Z"))
    };
    while pids.iter().any(alive) {
        assert!(
            start.elapsed() < limit,
            "orphans of {pids:?} after {limit:?}"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Files in shared memory under the name of this coordinator.
pub fn shared_memory_of(coordinator: u32) -> Vec<String> {
    let root = protocol::link::shm::run_root();
    [
        Path::new("/dev/shm"),
        &root,
        &root.join("nodes"),
        &root.join("services"),
    ]
    .iter()
    .flat_map(|folder| std::fs::read_dir(folder).into_iter().flatten().flatten())
    .filter_map(|entry| entry.file_name().into_string().ok())
    .filter(|name| name.contains(&format!("_{coordinator}_")))
    .collect()
}
