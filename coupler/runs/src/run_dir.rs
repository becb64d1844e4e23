//! The run directory: `runs/<id>/` with all files of a run.

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use nix::fcntl::posix_fallocate;
use nix::sys::statvfs::statvfs;
use serde_json::{Value, json};

use crate::identity::build;
use scenario::error::{Error, Refusal, Result};
use scenario::inputs::INPUTS_KEY;
use scenario::load::{CHANGED_KEY, FOLDER_KEY, Loaded};

/// A run's own folder.
pub struct RunDir {
    path: PathBuf,
    journal: Mutex<fs::File>,
    /// Disk space for the summary, reserved from the start: a run that fills the disk can still report it.
    reserved: Option<fs::File>,
    start: Instant,
}

impl RunDir {
    /// Makes the folder: `out` if given (which must be empty), otherwise `runs/<name>-<seconds>-<id>`, to which
    /// `runs/latest` then points.
    pub fn create(out: Option<&Path>, name: &str, run_id: u64) -> Result<RunDir> {
        let path = match out {
            Some(out) => checked(out)?,
            None => default_path(name, run_id)?,
        };
        for folder in ["logs", "fields"] {
            let folder = path.join(folder);
            fs::create_dir_all(&folder).map_err(Error::output(folder.display()))?;
        }
        let journal = path.join("logs/coordinator.log");
        let file = fs::File::create(&journal).map_err(Error::output(journal.display()))?;
        Ok(RunDir {
            reserved: reserve(&path.join(SUMMARY_PART)),
            path,
            journal: Mutex::new(file),
            start: Instant::now(),
        })
    }

    /// The folder itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Texts of the coordinator and its participants.
    pub fn logs(&self) -> PathBuf {
        self.path.join("logs")
    }

    /// Field files of the participants.
    pub fn fields(&self) -> PathBuf {
        self.path.join("fields")
    }

    /// Writes a whole file of the run: a reader finds the complete file or nothing.
    pub fn write(&self, name: &str, text: &str) -> Result<()> {
        let path = self.path.join(name);
        let part = self.path.join(format!("{name}.part"));
        fs::write(&part, text)
            .and_then(|()| fs::rename(&part, &path))
            .map_err(Error::output(path.display()))
    }

    /// Writes `summary.json` into its reserved space.
    pub fn write_summary(&self, text: &str) -> Result<()> {
        let Some(mut file) = self.reserved.as_ref() else {
            return self.write("summary.json", text);
        };
        let path = self.path.join("summary.json");
        file.seek(SeekFrom::Start(0))
            .and_then(|_| file.write_all(text.as_bytes()))
            .and_then(|()| file.set_len(text.len() as u64))
            .and_then(|()| fs::rename(self.path.join(SUMMARY_PART), &path))
            .map_err(Error::output(path.display()))
    }

    /// Adds a line to `logs/coordinator.log`, with the seconds since the start.
    pub fn note(&self, text: &str) {
        if let Ok(mut file) = self.journal.lock() {
            // The journal is a convenience: the exchange log and the summary report a full disk.
            let _ = writeln!(file, "{:10.3} {text}", self.start.elapsed().as_secs_f64());
        }
    }
}

/// Free space on the disk of this folder (bytes); `None` if unknown.
pub fn free_bytes(folder: &Path) -> Option<u64> {
    let disk = statvfs(folder).ok()?;
    Some(disk.blocks_available() * disk.fragment_size())
}

const SUMMARY_PART: &str = "summary.json.part";

/// Bytes reserved for the summary; with two participants it has 5 000.
const SUMMARY_BYTES: i64 = 256 << 10;

/// A file with this space; `None` if the disk reserves no space.
fn reserve(path: &Path) -> Option<fs::File> {
    let file = fs::File::create(path).ok()?;
    if posix_fallocate(&file, 0, SUMMARY_BYTES).is_err() {
        let _ = fs::remove_file(path);
        return None;
    }
    Some(file)
}

fn checked(out: &Path) -> Result<PathBuf> {
    let refuse = |why: &str| Refusal::argument(format!("--out {}", out.display()), why).into();
    if out.exists() && !out.is_dir() {
        return Err(refuse("it is not a folder"));
    }
    if fs::read_dir(out).is_ok_and(|mut entries| entries.next().is_some()) {
        let why = "the folder is not empty; a run never overwrites another: choose a new or an empty folder";
        return Err(refuse(why));
    }
    Ok(out.to_path_buf())
}

fn default_path(name: &str, run_id: u64) -> Result<PathBuf> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let seconds = since.map_or(0, |since| since.as_secs());
    let id = format!("{name}-{seconds}-{:08x}", run_id as u32);
    let path = Path::new("runs").join(&id);
    fs::create_dir_all(&path).map_err(Error::output(path.display()))?;
    point_latest(&id);
    Ok(path)
}

/// Two runs may start at the same time: the link gets a name of its own and is then renamed, which is atomic. A file or
/// folder of the user with this name stays.
fn point_latest(id: &str) {
    if fs::symlink_metadata("runs/latest").is_ok_and(|found| !found.is_symlink()) {
        return;
    }
    let temporary = Path::new("runs").join(format!(".latest-{id}"));
    if std::os::unix::fs::symlink(id, &temporary).is_ok()
        && fs::rename(&temporary, "runs/latest").is_err()
    {
        let _ = fs::remove_file(&temporary);
    }
}

/// The manifest: scenario, place and build of the run, and the checkpoint from which it was resumed.
pub fn manifest(loaded: &Loaded, run_id: u64, threads: usize, resumed: Option<Value>) -> String {
    let host = nix::unistd::gethostname().map(|name| name.into_string().unwrap_or_default());
    let mut value = json!({
        "schema": "thirdbody.manifest/1",
        "software": format!("thirdbody {}", env!("CARGO_PKG_VERSION")),
        "build": build().hash,
        "git": build().git,
        "protocol": protocol::PROTOCOL_VERSION,
        "run_id": format!("{run_id:016x}"),
        "scenario_file": loaded.source.name,
        FOLDER_KEY: loaded.folder,
        "scenario_hash": loaded.hash,
        CHANGED_KEY: loaded.changed,
        INPUTS_KEY: loaded.inputs(),
        "seed": loaded.scenario.run.seed,
        "threads": threads,
        "cores": std::thread::available_parallelism().map_or(1, usize::from),
        "host": host.unwrap_or_default(),
        "processor": processor(),
    });
    if let Some(resumed) = resumed {
        value["resumed"] = resumed;
    }
    serde_json::to_string_pretty(&value).expect("JSON values always serialise")
}

/// The processor's name, if the system reports it.
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().into())
}

/// Writes a file so that it exists completely or not at all, even if the machine stops. The file is first written to
/// the disk under a name of this process, then renamed, and the new name is written to the disk as well.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let temporary = path.with_extension(format!("{}.part", std::process::id()));
    let write = || {
        let mut file = File::create(&temporary)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&temporary, path)?;
        File::open(folder)?.sync_all()
    };
    write().map_err(Error::output(path.display()))
}
