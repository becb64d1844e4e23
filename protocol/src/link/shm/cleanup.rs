//! Names of a run's files, which contain their owner, and the removal of files that dead runs left.
//!
//! Files that iceoryx2 0.10 creates, all of them with the prefix of the run:
//! - in `/dev/shm`: data segments, connections, the dynamic part of services, the counters of events, and one
//!   `.global_mgmt` that it never removes;
//! - in the root: sockets of events; below `services` the static part of services; below `nodes` the monitors
//!   (locked files that show whether a process lives), and a folder for each node, the only name without prefix.
//!
//! In addition there is our own `<prefix>alive`, which the coordinator holds locked. The system releases the lock when the process
//! ends, and every process that shares the memory sees the lock. Process ids would differ in another PID namespace.
//!
//! A killed process leaves all files that it created.

use std::collections::BTreeSet;
use std::fs::{self, DirBuilder, File, TryLockError};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use nix::unistd::geteuid;

const SHARED_MEMORY: &str = "/dev/shm";
const OURS: &str = "thirdbody_";

/// End of the name of the one file that iceoryx2 keeps after its last user.
const KEPT: &str = ".global_mgmt";

/// End of the name of the file that a run's coordinator holds locked.
const ALIVE: &str = "alive";

/// Longest path of a root whose sockets still fit, given the longest prefix of [`run_prefix`].
const ROOT_LENGTH: usize = 27;

/// The folder of this user's service files: `thirdbody-<uid>` in shared memory, where synchronising a file needs no disk
/// access (iceoryx2 does it dozens of times a launch), or in `/tmp` if the path would be too long for sockets.
pub fn run_root() -> PathBuf {
    let name = format!("thirdbody-{}", geteuid());
    let root = Path::new(SHARED_MEMORY).join(&name);
    if root.as_os_str().len() <= ROOT_LENGTH {
        root
    } else {
        Path::new("/tmp").join(name)
    }
}

/// The prefix of a run: it names the coordinator's process by its id and start time. `run_id` tells the runs of one process apart.
pub fn run_prefix(coordinator_pid: u32, run_id: u64) -> String {
    let start = start_time(coordinator_pid).unwrap_or(0);
    let run = (run_id ^ (run_id >> 32)) as u32;
    format!("{OURS}{coordinator_pid}_{start:x}_{run:x}_")
}

/// Marks a run as alive for as long as the file is open and its process lives.
pub fn mark_alive(prefix: &str) -> io::Result<File> {
    let path = alive_file(prefix);
    loop {
        let file = File::create(&path)?;
        file.lock()?;
        // A process that looked between the two took the run for dead, and has removed the file by now.
        if path.exists() {
            return Ok(file);
        }
    }
}

/// True while the coordinator of a run lives.
pub fn is_alive(prefix: &str) -> bool {
    let held = |file: File| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
    File::open(alive_file(prefix)).is_ok_and(held)
}

fn alive_file(prefix: &str) -> PathBuf {
    Path::new(SHARED_MEMORY).join(format!("{prefix}{ALIVE}"))
}

/// Removes every file of this prefix from shared memory and from below `root`, with the folders of its nodes,
/// and returns the number of removed files. For runs whose processes have ended. The folders that all runs
/// share stay: a run that starts at this moment may be about to use them.
pub fn remove_run(root: &Path, prefix: &str) -> io::Result<usize> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-' || c == '.';
    if prefix.is_empty() || !prefix.chars().all(is_word) {
        let what = format!("`{prefix}` is not the prefix of a run");
        return Err(io::Error::new(ErrorKind::InvalidInput, what));
    }
    let mut removed = 0;
    for file in files_of(root)? {
        if name_of(&file).starts_with(prefix) && remove_file(&file)? {
            removed += 1;
            remove_if_node(root, file.parent());
        }
    }
    Ok(removed)
}

/// Removes the files of this user's dead coordinators, and returns their prefixes.
pub fn remove_dead_runs(root: &Path) -> io::Result<Vec<String>> {
    let user = geteuid().as_raw();
    let mut seen = BTreeSet::new();
    let mut dead = Vec::new();
    for file in files_of(root)? {
        let Some(owner) = owner_of(name_of(&file)) else {
            continue;
        };
        let is_mine = fs::symlink_metadata(&file).is_ok_and(|data| data.uid() == user);
        if !is_mine || !seen.insert(owner.prefix.to_string()) {
            continue;
        }
        // The lock lasts until all files are removed: a run that is about to lock the file notices.
        let alive = File::open(alive_file(owner.prefix));
        let is_dead = match &alive {
            Ok(file) => file.try_lock().is_ok(),
            Err(_) => start_time(owner.pid) != Some(owner.start),
        };
        if is_dead {
            remove_run(root, owner.prefix)?;
            dead.push(owner.prefix.to_string());
        }
    }
    Ok(dead)
}

/// Files of a coordinator in shared memory and below `root`.
pub fn left_by(root: &Path, coordinator_pid: u32) -> io::Result<Vec<PathBuf>> {
    let own = |file: &PathBuf| owner_of(name_of(file)).is_some_and(|o| o.pid == coordinator_pid);
    Ok(files_of(root)?.into_iter().filter(own).collect())
}

/// Makes `root` a folder that only this user can enter, and refuses a file or another user's folder in its place.
pub(super) fn private_folder(root: &Path) -> io::Result<()> {
    match DirBuilder::new().recursive(true).mode(0o700).create(root) {
        Ok(()) => (),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => (),
        Err(error) => return Err(error),
    }
    let data = fs::symlink_metadata(root)?;
    if !data.is_dir() || data.uid() != geteuid().as_raw() || data.permissions().mode() & 0o022 != 0
    {
        let what = "it must be a folder that only this user can write to";
        return Err(io::Error::new(ErrorKind::PermissionDenied, what));
    }
    Ok(())
}

/// Fails if `bytes` of shared memory are not available: the system would kill iceoryx2 with SIGBUS at its first
/// write to a segment without room.
pub(super) fn probe_room(prefix: &str, bytes: usize) -> io::Result<()> {
    static PROBES: AtomicU64 = AtomicU64::new(0);
    let probe = PROBES.fetch_add(1, Ordering::Relaxed);
    let name = format!("{prefix}room_{}_{probe}", std::process::id());
    let path = Path::new(SHARED_MEMORY).join(name);
    let written = fs::write(&path, vec![0; bytes]);
    remove_file(&path)?;
    written
}

/// Removes the file that iceoryx2 shares between ends and leaves behind, when the last end of a prefix is dropped.
pub(super) struct SharedFile {
    pub(super) root: PathBuf,
    pub(super) prefix: String,
}

impl Drop for SharedFile {
    fn drop(&mut self) {
        // An error leaves the file to `remove_run`.
        let Ok(files) = files_of(&self.root) else {
            return;
        };
        let (kept, used): (Vec<_>, Vec<_>) = files
            .iter()
            .filter(|file| name_of(file).starts_with(&self.prefix))
            .partition(|file| name_of(file).ends_with(KEPT));
        if used.is_empty() {
            for file in kept {
                let _ = remove_file(file);
            }
        }
    }
}

/// The coordinator that a file belongs to.
#[derive(Debug, PartialEq)]
struct Owner<'a> {
    /// Prefix of its run.
    prefix: &'a str,
    /// Its process.
    pid: u32,
    /// Start of that process, in ticks since the start of the machine.
    start: u64,
}

/// The owner in the name of a file, if it is one of ours.
fn owner_of(name: &str) -> Option<Owner<'_>> {
    let mut parts = name.strip_prefix(OURS)?.splitn(4, '_');
    let pid = parts.next()?.parse().ok()?;
    let start = u64::from_str_radix(parts.next()?, 16).ok()?;
    u32::from_str_radix(parts.next()?, 16).ok()?;
    let rest = parts.next()?;
    let prefix = &name[..name.len() - rest.len()];
    Some(Owner { prefix, pid, start })
}

/// Start of a process, in ticks since the start of the machine; `None` if it has ended.
fn start_time(pid: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program, in parentheses, may hold anything. State is field 3, start time field 22.
    let mut fields = stat.rsplit_once(')')?.1.split_ascii_whitespace();
    let state = fields.next()?;
    match state {
        "Z" | "X" => None,
        _ => fields.nth(18)?.parse().ok(),
    }
}

/// All files in places where a run of this root can have files: shared memory, the root, and two levels below.
fn files_of(root: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files = entries(Path::new(SHARED_MEMORY))?;
    let mut folders = vec![(root.to_path_buf(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        for entry in entries(&folder)? {
            let is_folder = fs::symlink_metadata(&entry).is_ok_and(|data| data.is_dir());
            if !is_folder {
                files.push(entry);
            } else if depth < 2 {
                folders.push((entry, depth + 1));
            }
        }
    }
    Ok(files)
}

fn entries(folder: &Path) -> io::Result<Vec<PathBuf>> {
    match fs::read_dir(folder) {
        Ok(entries) => entries.map(|entry| Ok(entry?.path())).collect(),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error),
    }
}

fn name_of(file: &Path) -> &str {
    file.file_name()
        .and_then(|name| name.to_str())
        .unwrap_or_default()
}

/// Removes a file; false if there was none.
fn remove_file(file: &Path) -> io::Result<bool> {
    match fs::remove_file(file) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Removes the folder of a node if it is empty: the system refuses to remove others.
fn remove_if_node(root: &Path, folder: Option<&Path>) {
    if let Some(folder) = folder
        && folder.parent() == Some(&root.join("nodes"))
    {
        let _ = fs::remove_dir(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prefix_names_its_owner() {
        let pid = std::process::id();
        let prefix = run_prefix(pid, u64::MAX - 1);
        let file = format!("{prefix}0354_17.data");
        let start = start_time(pid).expect("this process lives");
        let prefix = prefix.as_str();
        assert_eq!(owner_of(&file), Some(Owner { prefix, pid, start }));
        for foreign in ["iox2_1_2_3_4", "thirdbody_x_2_3_4", "thirdbody_1_2_3"] {
            assert_eq!(owner_of(foreign), None, "{foreign}");
        }
    }

    #[test]
    fn runs_of_one_process_have_their_own_prefixes() {
        assert_ne!(run_prefix(7, 1), run_prefix(7, 2));
        assert_ne!(run_prefix(7, 1), run_prefix(7, 1 << 33));
    }

    #[test]
    fn a_process_that_has_ended_has_no_start_time() {
        let mut child = std::process::Command::new("true")
            .spawn()
            .expect("`true` is everywhere");
        let pid = child.id();
        // Its status has not been read yet: the process has ended but still exists.
        let ended = (0..10_000).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(1));
            start_time(pid).is_none()
        });
        assert!(ended, "it still seems to run");
        child.wait().expect("it ends");
        assert_eq!(start_time(pid), None);
        assert!(start_time(1).is_some());
    }

    #[test]
    fn a_removal_without_a_prefix_is_refused() {
        for prefix in ["", "../", "a b"] {
            let removed = remove_run(Path::new("/nowhere"), prefix);
            assert_eq!(
                removed.map_err(|error| error.kind()),
                Err(ErrorKind::InvalidInput)
            );
        }
    }

    #[test]
    fn the_default_root_leaves_room_for_sockets() {
        assert!(run_root().as_os_str().len() <= ROOT_LENGTH);
    }
}
