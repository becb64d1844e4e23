//! Faults of the surroundings of a run: disks, shared memory, terminals, and other runs at the same time.

use std::fs;
use std::process::{Command, Stdio};
use std::time::Instant;

use nix::sys::signal::Signal;

use super::resumes::resumes;
use super::row::{FaultOutcome, FaultResult};
use super::trial::FaultTrial;
use scenario::error::Error;

/// Bytes of a block of the limit on the size of files (POSIX `ulimit -f`).
const BLOCK: u64 = 512;

/// The same command with files limited to `blocks` blocks.
fn limited(command: &Command, blocks: u64) -> Command {
    let mut shell = Command::new("sh");
    // Without the trap, the signal for a too long file would end the shell's child before it can print anything.
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
    shell.args(["-c", &script, "sh"]).arg(command.get_program());
    shell.args(command.get_args());
    shell
}

/// Limits the size of the run's files at random. The limit stands for a full disk and needs no superuser rights. It also applies to
/// shared memory, so the solvers run as threads. Right: the run ends with code 9 and
/// names the file, its summary says so, and it resumes bit-equal where there is room; or it fits and completes bit-equal.
pub fn disk(trial: &mut FaultTrial) -> FaultResult {
    // From a size for the scenario and the summary to a size for the log.
    let bytes = trial.random.between(1.5e4, 6e5);
    let command = trial.run_command(&["run.transport=channel"]);
    trial.spawn(limited(&command, bytes as u64 / BLOCK))?;
    let status = trial.end()?;
    let summary = trial.json("out/summary.json");
    let said = trial.said();
    match status.code() {
        Some(0) => trial.completed(),
        Some(9) if summary["status"] == "output_failed" && said.contains("File too large") => {
            Ok(FaultOutcome {
                windows_lost: resumes(trial)?,
                ..FaultOutcome::of("named")
            })
        }
        _ => Err(format!("limit of {bytes:.0} bytes: {status}: {said}").into()),
    }
}

/// Leaves no room in shared memory: the same limit, below the size of a connection. Right: the run ends at once with a
/// message about shared memory, and the next run, with room, is bit-equal.
pub fn shared_memory(trial: &mut FaultTrial) -> FaultResult {
    let command = trial.run_command(&[]);
    let bytes = trial.random.between(2e4, 2e5);
    trial.spawn(limited(&command, bytes as u64 / BLOCK))?;
    let start = Instant::now();
    let status = trial.end()?;
    let detection_s = start.elapsed().as_secs_f64();
    let said = trial.said();
    if status.success() || !said.contains("shared memory") {
        return Err(format!("{status}: {said}").into());
    }
    resumes(trial)?;
    Ok(FaultOutcome::after(detection_s, "named", None))
}

/// Closes the terminal: nobody reads the output of the run, and every other trial also sends SIGHUP. Right: the run ends in order
/// by that signal (code 129) and resumes bit-equal, or it completes bit-equal.
pub fn terminal(trial: &mut FaultTrial) -> FaultResult {
    let mut command = trial.run_command(&[]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    trial.spawn_as_it_is(command)?;
    trial.close_output();
    trial.reach()?;
    let start = Instant::now();
    let hung_up = trial.index.is_multiple_of(2);
    if hung_up {
        trial.signal(Signal::SIGHUP);
    }
    let status = trial.end()?;
    let detection_s = start.elapsed().as_secs_f64();
    match status.code() {
        Some(0) => trial.completed(),
        Some(129) if hung_up => {
            let lost = resumes(trial)?;
            Ok(FaultOutcome::after(detection_s, "ended in order", lost))
        }
        _ => Err(format!("{status} {}", trial.log()).into()),
    }
}

/// Starts a study twice at the same time in a new folder. Right: both end with code 0, and no run was made twice.
pub fn studies(trial: &mut FaultTrial) -> FaultResult {
    trial.write_study()?;
    let words = "study run study.toml --out study --jobs 1";
    let words: Vec<&str> = words.split(' ').collect();
    let mut beside = Command::new(&trial.undisturbed.program);
    beside.args(&words).current_dir(trial.path(""));
    beside.stdin(Stdio::null()).stdout(Stdio::null());
    let beside = beside.stderr(Stdio::null()).spawn();
    let mut beside = beside.map_err(Error::input("starting a study"))?;
    let own = trial.verb(&words);
    if own.is_err() {
        let _ = beside.kill();
    }
    let other = beside.wait().map_err(Error::input("waiting for a study"))?;
    let rows = fs::read_to_string(trial.path("study/results.csv")).unwrap_or_default();
    if own? == Some(0) && other.success() && rows.matches(",completed,0,1,").count() == 3 {
        return Ok(FaultOutcome::of("completed"));
    }
    Err(format!("one {}, the other {other}: {rows}", trial.said()).into())
}

/// Runs the scene a second time in another PID namespace, as in a container with the same shared memory. Right: both
/// complete bit-equal; not tried where the system forbids such a namespace.
pub fn namespace(trial: &mut FaultTrial) -> FaultResult {
    let apart = || {
        let words = "--user --map-root-user --pid --fork --mount-proc";
        let mut command = Command::new("unshare");
        command.args(words.split(' ')).stdin(Stdio::null());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let tried = apart().arg("true").status();
    if !tried.is_ok_and(|status| status.success()) {
        return Ok(FaultOutcome::of("not tried"));
    }
    trial.begin(&[])?;
    let mut beside = apart();
    beside.arg(&trial.undisturbed.program);
    trial.add_run(&mut beside, "beside", &[]);
    let beside = beside.status().map_err(Error::input("unshare"))?;
    let status = trial.end()?;
    trial.is_bit_equal("beside")?;
    if status.success() && beside.success() {
        return trial.completed();
    }
    Err(format!("{status}, the other {beside}: {}", trial.said()).into())
}
