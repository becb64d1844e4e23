//! One trial: a run of the program as a user starts it, in its own folder, with all its processes.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use protocol::link::shm;
use protocol::session::SESSION_VARIABLE;
use serde_json::Value;

use super::row::{FaultOutcome, FaultResult, Wrong};
use coordinator::participants::Watch;
use coordinator::run::checkpoint::{FOLDER, file};
use coordinator::run::session::fresh_run_id;
use kit::scratch::Scratch;
use lab::random::Random;
use scenario::error::Error;

/// Keys that give the scene `quick` a short run, many checkpoints and short deadlines.
const SCENE: [&str; 6] = [
    "run.end_s=2e-4",
    "run.checkpoint_every_windows=30",
    "run.output.flush_every_windows=5",
    "run.deadlines={ setup_s = 20.0, answer_s = 2.0, idle_s = 20.0 }",
    "participant.third-body.config.sample.half_width_m=3e-3",
    "participant.third-body.config.plausible.contact_width_rel=[1.0, 1.0]",
];

/// Windows between two of its checkpoints.
const CADENCE: u64 = 30;

/// `run.deadlines.answer_s` of the scene (s).
pub const ANSWER_S: f64 = 2.0;

/// Time after which a run counts as hanging.
pub const HANGS: Duration = Duration::from_secs(60);

/// Time between two polls.
const LOOK: Duration = Duration::from_millis(1);

/// The program, and its undisturbed run.
pub struct UndisturbedRun {
    /// The program.
    pub program: PathBuf,
    /// Signals that end the campaign.
    pub watch: Watch,
    /// Hashes of exchange and state of the undisturbed run.
    pub hashes: [Value; 2],
    /// Time until its first window.
    pub handshake: Duration,
    /// Time until its end.
    pub whole: Duration,
}

/// The part of a run in which a fault comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunPhase {
    /// From the launch to the first window.
    Handshake,
    /// Anywhere in the windows.
    Windows,
    /// Right after the start of a checkpoint.
    Checkpoint,
    /// From the first field file of the end on.
    Finish,
}

/// The phases, one trial after the other.
const PHASES: [RunPhase; 4] = [
    RunPhase::Windows,
    RunPhase::Handshake,
    RunPhase::Checkpoint,
    RunPhase::Finish,
];

/// The participants, each for four trials.
const PARTICIPANTS: [&str; 2] = ["rail", "third-body"];

impl UndisturbedRun {
    /// Runs the scene undisturbed, twice: the first run also fills the caches of the machine.
    pub fn new(program: PathBuf, watch: &Watch) -> Result<UndisturbedRun, Wrong> {
        let mut undisturbed = UndisturbedRun {
            program,
            watch: watch.clone(),
            hashes: Default::default(),
            handshake: Duration::ZERO,
            whole: Duration::ZERO,
        };
        for _ in 0..2 {
            let start = Instant::now();
            let mut trial = FaultTrial::new(&undisturbed, 0, 0)?;
            trial.start(&[])?;
            trial.until(|trial| trial.log().contains("windows of"))?;
            let handshake = start.elapsed();
            let status = trial.end()?;
            let hashes = trial.hashes("out");
            if !status.success() || hashes.contains(&Value::Null) {
                return Err(format!("the undisturbed run failed: {}", trial.said()).into());
            }
            drop(trial);
            undisturbed.hashes = hashes;
            undisturbed.handshake = handshake;
            undisturbed.whole = start.elapsed();
        }
        Ok(undisturbed)
    }
}

/// One trial. Dropping it kills its processes and removes its folder.
pub struct FaultTrial<'a> {
    /// The undisturbed run.
    pub undisturbed: &'a UndisturbedRun,
    /// Number of the trial in its row.
    pub index: u64,
    /// Its instants and choices.
    pub random: Random,
    folder: Scratch,
    child: Option<Child>,
    /// Process numbers of the started coordinators.
    coordinators: Vec<u32>,
}

impl FaultTrial<'_> {
    /// An empty folder.
    pub fn new(
        undisturbed: &UndisturbedRun,
        seed: u64,
        index: u64,
    ) -> Result<FaultTrial<'_>, Error> {
        let folder = Scratch::new("fault", fresh_run_id());
        fs::create_dir_all(folder.path()).map_err(Error::output(folder.path().display()))?;
        Ok(FaultTrial {
            undisturbed,
            index,
            random: Random::new(seed),
            folder,
            child: None,
            coordinators: Vec::new(),
        })
    }

    /// The part of the run in which its fault comes.
    pub fn phase(&self) -> RunPhase {
        PHASES[(self.index % 4) as usize]
    }

    /// The participant that its fault hits.
    pub fn participant_name(&self) -> &'static str {
        PARTICIPANTS[(self.index / 4 % 2) as usize]
    }

    /// A file or folder of the trial.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The scene with more keys, run into the folder `out`.
    pub fn run_command(&self, sets: &[&str]) -> Command {
        let mut command = Command::new(&self.undisturbed.program);
        self.add_run(&mut command, "out", sets);
        command
    }

    /// Adds the words that run the scene into a folder.
    pub fn add_run(&self, command: &mut Command, out: &str, sets: &[&str]) {
        command.args(["run", "quick", "--json", "--out"]);
        command.arg(self.path(out));
        for set in SCENE.iter().chain(sets) {
            command.args(["--set", set]);
        }
    }

    /// Writes `study.toml`: the scene with two seeds.
    pub fn write_study(&self) -> Result<(), Error> {
        let text = format!(
            "[study]\nname = \"fault\"\nscenario = \"quick\"\nset = {SCENE:?}\n[reference]\nset = []\nperturb = 0\n\
             [[vary]]\nkey = \"run.seed\"\nseeds = 2\n\
             [[measure]]\nname = \"height\"\nof = \"signals.wheel_y_m\"\nnorm = \"max\"\n"
        );
        let path = self.path("study.toml");
        fs::write(&path, text).map_err(Error::output(path.display()))
    }

    /// Starts the scene; its output goes to files.
    pub fn start(&mut self, sets: &[&str]) -> Result<(), Error> {
        self.spawn(self.run_command(sets))
    }

    /// Starts the scene, and waits for the instant of the fault.
    pub fn begin(&mut self, sets: &[&str]) -> Result<(), Wrong> {
        self.start(sets)?;
        self.reach()
    }

    /// Starts a command whose output goes to files.
    pub fn spawn(&mut self, mut command: Command) -> Result<(), Error> {
        let file = |name: &str| {
            let path = self.path(name);
            File::create(&path).map_err(Error::output(path.display()))
        };
        command.stdout(file("stdout")?).stderr(file("stderr")?);
        self.spawn_as_it_is(command)
    }

    /// Starts a command.
    pub fn spawn_as_it_is(&mut self, mut command: Command) -> Result<(), Error> {
        let child = command.stdin(Stdio::null()).spawn();
        let child = child.map_err(Error::input(self.undisturbed.program.display()))?;
        self.coordinators.push(child.id());
        self.child = Some(child);
        Ok(())
    }

    /// Closes the reading end of the program's output.
    pub fn close_output(&mut self) {
        if let Some(child) = &mut self.child {
            (child.stdout, child.stderr) = (None, None);
        }
    }

    /// Runs a verb to its end and returns its exit code; its output goes to files.
    pub fn verb(&mut self, words: &[&str]) -> Result<Option<i32>, Wrong> {
        let mut command = Command::new(&self.undisturbed.program);
        command.args(words).current_dir(self.folder.path());
        self.spawn(command)?;
        Ok(self.end()?.code())
    }

    /// Waits for the end of the last command.
    pub fn end(&mut self) -> Result<ExitStatus, Wrong> {
        let start = Instant::now();
        loop {
            self.look(start)?;
            let child = self.child.as_mut().expect("it was started");
            let waited = child.try_wait();
            if let Some(status) = waited.map_err(Error::input("waiting for a process"))? {
                self.child = None;
                return Ok(status);
            }
        }
    }

    /// Pauses for a moment; fails after [`HANGS`] and after a signal.
    fn look(&self, start: Instant) -> Result<(), Wrong> {
        if let Some(interrupted) = self.undisturbed.watch.interrupted() {
            return Err(interrupted.into());
        }
        if start.elapsed() > HANGS {
            return Err(format!("it hangs: {} {}", self.said(), self.log()).into());
        }
        std::thread::sleep(LOOK);
        Ok(())
    }

    /// Waits until `seen` returns true, or the run has ended.
    pub fn until(&mut self, mut seen: impl FnMut(&FaultTrial) -> bool) -> Result<(), Wrong> {
        let start = Instant::now();
        while !seen(self) && self.is_running() {
            self.look(start)?;
        }
        Ok(())
    }

    fn is_running(&mut self) -> bool {
        let child = self.child.as_mut();
        child.is_some_and(|child| matches!(child.try_wait(), Ok(None)))
    }

    /// Waits until a random instant of the phase, or until the run has ended.
    pub fn reach(&mut self) -> Result<(), Wrong> {
        let (handshake, whole) = (self.undisturbed.handshake, self.undisturbed.whole);
        let windows = whole.saturating_sub(handshake);
        let more = match self.phase() {
            RunPhase::Handshake => handshake,
            RunPhase::Windows => {
                self.until(|trial| trial.log().contains("windows of"))?;
                windows
            }
            RunPhase::Checkpoint => {
                let which = 1 + self.random.below(10);
                self.until(|trial| {
                    let found = file::list(&trial.path("out").join(FOLDER));
                    let last = found.last();
                    last.is_some_and(|last| last.window >= CADENCE * which)
                })?;
                windows / 10
            }
            RunPhase::Finish => {
                let fields = self.path("out/fields");
                self.until(|_| fs::read_dir(&fields).is_ok_and(|mut all| all.next().is_some()))?;
                windows / 10
            }
        };
        let (start, instant) = (Instant::now(), more.mul_f64(self.random.share()));
        self.until(|_| start.elapsed() >= instant)
    }

    /// Waits for the process of a participant; `None` if the run ended before.
    pub fn participant(&mut self, name: &str) -> Result<Option<Pid>, Wrong> {
        let mut found = None;
        self.until(|trial| {
            let mut all = trial.participants().into_iter();
            found = all.find(|(_, participant)| participant == name);
            found.is_some()
        })?;
        Ok(found.map(|(pid, _)| pid))
    }

    /// Running participants: all processes whose session file is in this folder.
    pub fn participants(&self) -> Vec<(Pid, String)> {
        let folder = self.folder.path();
        let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
        let numbers = processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        let found = numbers.filter_map(|number: i32| {
            let session = session_of(number).filter(|session| session.starts_with(folder))?;
            let file = session.file_name()?.to_str()?;
            let name = file.strip_suffix(".session.json")?;
            Some((Pid::from_raw(number), name.to_string()))
        });
        found.collect()
    }

    /// Sends a signal to the coordinator.
    pub fn signal(&self, signal: Signal) {
        if let Some(child) = &self.child {
            send(Pid::from_raw(child.id() as i32), signal);
        }
    }

    /// Waits until no participant is left; returns the waiting time (s).
    pub fn deserted(&self, limit: Duration) -> Result<f64, Wrong> {
        let start = Instant::now();
        while let left = self.participants()
            && !left.is_empty()
        {
            if start.elapsed() > limit {
                return Err(format!("{left:?} were left after {limit:?}").into());
            }
            self.look(start)?;
        }
        Ok(start.elapsed().as_secs_f64())
    }

    /// The coordinator's log so far.
    pub fn log(&self) -> String {
        fs::read_to_string(self.path("out/logs/coordinator.log")).unwrap_or_default()
    }

    /// The text on stderr, on one line.
    pub fn said(&self) -> String {
        let said = fs::read_to_string(self.path("stderr")).unwrap_or_default();
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// A JSON file of a run directory.
    pub fn json(&self, name: &str) -> Value {
        let text = fs::read(self.path(name)).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or(Value::Null)
    }

    /// Hashes of exchange and state of a completed run.
    pub fn hashes(&self, out: &str) -> [Value; 2] {
        let summary = self.json(&format!("{out}/summary.json"));
        let completed = summary["exit_code"] == 0;
        let hash = |of: &str| completed.then(|| summary["hashes"][of].clone());
        ["exchange", "state"].map(|of| hash(of).unwrap_or_default())
    }

    /// Refuses a run that did not complete with the hashes of the undisturbed one.
    pub fn is_bit_equal(&self, out: &str) -> Result<(), Wrong> {
        if self.hashes(out) == self.undisturbed.hashes {
            return Ok(());
        }
        let summary = self.json(&format!("{out}/summary.json"));
        let (status, hashes) = (&summary["status"], &summary["hashes"]);
        let said = self.said();
        Err(format!("{out} is not bit-equal: {status} {hashes} {said}").into())
    }

    /// The outcome of a run that completed.
    pub fn completed(&self) -> FaultResult {
        self.is_bit_equal("out")?;
        Ok(FaultOutcome::of("completed"))
    }

    /// Number of processes, and of files in shared memory and of services, that are left of this trial.
    pub fn leftovers(&self) -> u64 {
        let root = shm::run_root();
        let left = |pid: &u32| shm::left_by(&root, *pid).map_or(0, |files| files.len());
        let files: usize = self.coordinators.iter().map(left).sum();
        (files + self.participants().len()) as u64
    }
}

impl Drop for FaultTrial<'_> {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            let _ = child.kill();
            let _ = child.wait();
        }
        for (pid, _) in self.participants() {
            send(pid, Signal::SIGKILL);
        }
        // The next run removes files that cannot be removed here.
        let _ = shm::remove_dead_runs(&shm::run_root());
    }
}

/// Sends a signal; a process that has ended before needs none.
pub fn send(pid: Pid, signal: Signal) {
    let _ = kill(pid, signal);
}

/// The session file that a living process was launched with.
fn session_of(number: i32) -> Option<PathBuf> {
    let bytes = fs::read(format!("/proc/{number}/environ")).ok()?;
    let mut variables = bytes.split(|byte| *byte == 0);
    let value = variables.find_map(|variable| {
        let rest = variable.strip_prefix(SESSION_VARIABLE.as_bytes())?;
        rest.strip_prefix(b"=")
    })?;
    Some(Path::new(std::str::from_utf8(value).ok()?).to_path_buf())
}
