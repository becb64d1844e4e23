//! Shared memory is a link, keeps runs apart and leaves nothing behind.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use protocol::link::shm::{
    MAX_DOUBLES, ShmLink, WaitMode, is_alive, mark_alive, remove_dead_runs, remove_run, run_prefix,
};
use protocol::{Link, LinkError};

use crate::suite::{self, AMPLE, SHORT, numbered, receive};

/// The root and prefix of one test; dropping it removes their files.
struct Scene {
    root: PathBuf,
    prefix: String,
}

impl Scene {
    fn new() -> Scene {
        static SCENES: AtomicU64 = AtomicU64::new(0);
        let scene = SCENES.fetch_add(1, Ordering::Relaxed);
        let pid = std::process::id();
        Scene {
            // Short, since paths of sockets have a limit.
            root: std::env::temp_dir().join(format!("tb-{pid}-{scene}")),
            prefix: run_prefix(pid, scene),
        }
    }

    fn pair(&self, participant: &str, wait: WaitMode) -> (ShmLink, ShmLink) {
        (
            self.coordinator(participant, wait),
            self.participant(participant),
        )
    }

    fn coordinator(&self, participant: &str, wait: WaitMode) -> ShmLink {
        ShmLink::coordinator(&self.root, &self.prefix, participant, wait).expect("it is created")
    }

    fn participant(&self, participant: &str) -> ShmLink {
        ShmLink::participant(&self.root, &self.prefix, participant, AMPLE).expect("it is opened")
    }

    /// All files of this run in all folders, and the folders of its nodes.
    fn files(&self) -> Vec<PathBuf> {
        self.files_of(&self.prefix)
    }

    fn files_of(&self, prefix: &str) -> Vec<PathBuf> {
        let mut found = Vec::new();
        collect(&self.root, prefix, &mut found);
        // Folders in shared memory belong to other runs.
        collect(Path::new("/dev/shm"), prefix, &mut found);
        found
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        remove_run(&self.root, &self.prefix).expect("they can be removed");
        fs::remove_dir_all(&self.root).ok();
    }
}

fn collect(folder: &Path, prefix: &str, found: &mut Vec<PathBuf>) {
    let is_shared = folder == Path::new("/dev/shm");
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() && !is_shared {
            // Only the folders of nodes have names without a prefix; they disappear with their nodes.
            if folder.ends_with("nodes") {
                found.push(path.clone());
            }
            collect(&path, prefix, found);
        } else if entry.file_name().to_string_lossy().starts_with(prefix) {
            found.push(path);
        }
    }
}

#[test]
fn polled_shared_memory_is_a_link() {
    shared_memory_is_a_link(WaitMode::Poll);
}

#[test]
fn shared_memory_with_wake_ups_is_a_link() {
    shared_memory_is_a_link(WaitMode::Event);
}

fn shared_memory_is_a_link(wait: WaitMode) {
    let scene = Scene::new();
    let connections = AtomicU64::new(0);
    suite::check(|| {
        let number = connections.fetch_add(1, Ordering::Relaxed);
        let (left, right) = scene.pair(&format!("participant-{number}"), wait);
        (Box::new(left), Box::new(right))
    });
    assert_eq!(scene.files(), Vec::<PathBuf>::new());
}

#[test]
fn nothing_is_left_whichever_end_goes_first() {
    for coordinator_first in [true, false] {
        let scene = Scene::new();
        let (mut left, mut right) = scene.pair("rail", WaitMode::Poll);
        let (other_left, other_right) = scene.pair("wheel", WaitMode::Poll);
        left.send(&numbered(1, vec![1.0]), AMPLE)
            .expect("it is taken");
        receive(&mut right);
        drop((other_left, other_right));
        assert!(!scene.files().is_empty(), "one connection still stands");
        match coordinator_first {
            true => drop((left, right)),
            false => drop((right, left)),
        }
        assert_eq!(scene.files(), Vec::<PathBuf>::new());
    }
}

#[test]
fn two_runs_do_not_receive_each_others_frames() {
    let (one, mut two) = (Scene::new(), Scene::new());
    two.root.clone_from(&one.root);
    let (mut one_left, mut one_right) = one.pair("rail", WaitMode::Auto { processes: 2 });
    let (mut two_left, mut two_right) = two.pair("rail", WaitMode::Auto { processes: 99 });
    one_left
        .send(&numbered(1, vec![1.0]), AMPLE)
        .expect("it is taken");
    assert_eq!(two_right.receive(SHORT), Ok(None));
    two_left
        .send(&numbered(2, vec![2.0]), AMPLE)
        .expect("it is taken");
    assert_eq!(receive(&mut one_right).header.window, 1);
    assert_eq!(receive(&mut two_right).header.window, 2);
    assert_eq!(one_right.receive(SHORT), Ok(None));
}

#[test]
fn the_first_frame_waits_for_a_participant_that_comes_late() {
    let scene = Scene::new();
    let mut left = scene.coordinator("rail", WaitMode::Event);
    assert_eq!(left.receive(SHORT), Ok(None), "it has not come, nor left");
    let sender = thread::spawn(move || {
        left.send(&numbered(1, vec![1.0]), AMPLE)
            .expect("it is taken");
        left
    });
    thread::sleep(SHORT);
    let mut right = scene.participant("rail");
    assert_eq!(receive(&mut right).header.window, 1);
    sender.join().expect("the sender ends");
}

#[test]
fn a_participant_that_comes_first_waits_for_the_coordinator() {
    let scene = Scene::new();
    let (root, prefix) = (scene.root.clone(), scene.prefix.clone());
    let late = thread::spawn(move || ShmLink::participant(&root, &prefix, "rail", AMPLE));
    thread::sleep(SHORT);
    let mut left = scene.coordinator("rail", WaitMode::Poll);
    let mut right = late
        .join()
        .expect("it does not panic")
        .expect("it is opened");
    left.send(&numbered(1, vec![]), AMPLE).expect("it is taken");
    assert_eq!(receive(&mut right).header.window, 1);
}

/// A sleep with less than a microsecond left once never ended: the system rounds it down to zero, which means no limit.
#[test]
fn a_patience_that_ends_within_a_microsecond_of_a_sleep_ends() {
    let scene = Scene::new();
    let (mut coordinator, _participant) = scene.pair("rail", WaitMode::Event);
    let (sender, counts) = std::sync::mpsc::channel();
    // A wait is awake for 20 us, unless another program needs the core, and then sleeps.
    let patience_ns = (0..2_000).step_by(50).chain((19_000..24_000).step_by(25));
    thread::spawn(move || {
        let heard = patience_ns.map(|ns| coordinator.receive(Duration::from_nanos(ns)));
        sender.send(heard.filter(|heard| !matches!(heard, Ok(None))).count())
    });
    assert_eq!(counts.recv_timeout(AMPLE), Ok(0));
}

#[test]
fn a_participant_without_coordinator_gives_up() {
    let scene = Scene::new();
    let opened = ShmLink::participant(&scene.root, &scene.prefix, "rail", SHORT);
    assert!(matches!(opened.err(), Some(LinkError::Transport(_))));
    assert_eq!(scene.files(), Vec::<PathBuf>::new());
}

#[test]
fn a_name_is_used_once_in_a_run() {
    let scene = Scene::new();
    let _first = scene.coordinator("rail", WaitMode::Poll);
    let second = ShmLink::coordinator(&scene.root, &scene.prefix, "rail", WaitMode::Poll);
    assert!(matches!(second.err(), Some(LinkError::Transport(_))));
}

#[test]
fn a_frame_beyond_the_capacity_is_refused_before_anything_is_sent() {
    let scene = Scene::new();
    let (mut left, mut right) = scene.pair("rail", WaitMode::Poll);
    let mut frame = numbered(1, vec![]);
    frame.payload = vec![0.0; MAX_DOUBLES + 1];
    let expected = LinkError::TooLong {
        doubles: MAX_DOUBLES + 1,
        capacity: MAX_DOUBLES,
    };
    assert_eq!(left.send(&frame, AMPLE), Err(expected));
    left.send(&numbered(2, vec![]), AMPLE)
        .expect("the link still works");
    assert_eq!(receive(&mut right).header.window, 2);
}

#[test]
fn a_compliance_of_4000_rows_arrives() {
    let scene = Scene::new();
    let (mut left, mut right) = scene.pair("rail", WaitMode::Auto { processes: 2 });
    let frame = numbered(1, (0..4000 * 4000).map(|i| f64::from(i).sin()).collect());
    let sent = frame.clone();
    let sender = thread::spawn(move || {
        left.send(&sent, AMPLE).expect("it is taken");
        left
    });
    assert!(receive(&mut right) == frame);
    sender.join().expect("the sender ends");
}

#[test]
fn after_a_frame_that_was_cut_off_nothing_is_sent() {
    let scene = Scene::new();
    let (mut left, mut right) = scene.pair("rail", WaitMode::Poll);
    let long = numbered(1, vec![1.0; 300_000]);
    assert!(matches!(
        left.send(&long, SHORT),
        Err(LinkError::Full { .. })
    ));
    assert_eq!(
        right.receive(SHORT),
        Ok(None),
        "half a frame is not delivered"
    );
    assert!(matches!(
        left.send(&numbered(2, vec![]), AMPLE),
        Err(LinkError::Transport(_))
    ));
    assert_eq!(right.receive(SHORT), Ok(None));
}

#[test]
fn places_that_cannot_work_are_refused() {
    let scene = Scene::new();
    let long = Path::new("/tmp").join("x".repeat(60));
    for (root, prefix, participant) in [
        (long.as_path(), scene.prefix.as_str(), "rail"),
        (Path::new("/proc/nowhere"), &scene.prefix, "rail"),
        (&scene.root, "a/b", "rail"),
        (&scene.root, &scene.prefix, &"x".repeat(300)),
    ] {
        let created = ShmLink::coordinator(root, prefix, participant, WaitMode::Poll);
        assert!(matches!(created.err(), Some(LinkError::Transport(_))));
    }
}

#[test]
fn a_root_that_others_can_write_to_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let scene = Scene::new();
    fs::create_dir(&scene.root).expect("it is new");
    fs::set_permissions(&scene.root, fs::Permissions::from_mode(0o777)).expect("it is ours");
    let created = ShmLink::coordinator(&scene.root, &scene.prefix, "rail", WaitMode::Poll);
    assert!(matches!(created.err(), Some(LinkError::Transport(_))));
}

#[test]
fn the_signal_handlers_of_the_process_stay() {
    let caught = || {
        let status = fs::read_to_string("/proc/self/status").expect("this is Linux");
        let line = status.lines().find(|line| line.starts_with("SigCgt"));
        line.map(str::to_string).expect("every process has it")
    };
    let before = caught();
    let scene = Scene::new();
    let (mut left, mut right) = scene.pair("rail", WaitMode::Event);
    left.send(&numbered(1, vec![1.0; 40_000]), AMPLE)
        .expect("it is taken");
    receive(&mut right);
    assert_eq!(right.receive(SHORT), Ok(None));
    assert_eq!(caught(), before);
}

const ROLE: &str = "THIRDBODY_TEST_ROLE";
const ROOT: &str = "THIRDBODY_TEST_ROOT";
const PREFIX: &str = "THIRDBODY_TEST_PREFIX";

/// Not a test by itself: the program of the processes that the tests below start and kill.
#[test]
fn child_process() {
    let Ok(role) = std::env::var(ROLE) else {
        return;
    };
    let variable = |name| std::env::var(name).expect("the parent sets it");
    let root = PathBuf::from(variable(ROOT));
    let mut link = match role.as_str() {
        "participant" => ShmLink::participant(&root, &variable(PREFIX), "rail", AMPLE),
        _ => {
            let prefix = run_prefix(std::process::id(), 1);
            ShmLink::coordinator(&root, &prefix, "rail", WaitMode::Event)
        }
    }
    .expect("the connection is there");
    fs::write(root.join("ready"), "").expect("the root is there");
    while let Ok(Some(frame)) = link.receive(AMPLE) {
        link.send(&frame, AMPLE).expect("it is taken");
    }
}

fn start_child(scene: &Scene, role: &str) -> Child {
    let program = std::env::current_exe().expect("a test knows its own file");
    Command::new(program)
        .args(["--exact", "shm::child_process", "--nocapture"])
        .env(ROLE, role)
        .env(ROOT, &scene.root)
        .env(PREFIX, &scene.prefix)
        .stdout(Stdio::null())
        .spawn()
        .expect("it starts again")
}

fn kill(mut child: Child) {
    child.kill().expect("it lives");
    child.wait().expect("it ends");
}

fn wait_until_ready(scene: &Scene) {
    let start = Instant::now();
    while !scene.root.join("ready").exists() {
        assert!(start.elapsed() < AMPLE, "the child never got ready");
        thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_killed_participant_blocks_no_one_and_its_files_can_be_removed() {
    for wait in [WaitMode::Poll, WaitMode::Event] {
        let scene = Scene::new();
        let mut left = scene.coordinator("rail", wait);
        let child = start_child(&scene, "participant");
        let frame = numbered(1, vec![1.0; 40_000]);
        left.send(&frame, AMPLE).expect("it is taken");
        assert_eq!(receive(&mut left), frame);
        kill(child);
        assert_eq!(left.receive(SHORT), Ok(None));
        let refused = (0..64).find_map(|_| left.send(&frame, SHORT).err());
        assert!(matches!(refused, Some(LinkError::Full { .. })));
        drop(left);
        assert!(!scene.files().is_empty(), "the dead leave files");
        assert!(remove_run(&scene.root, &scene.prefix).expect("they can be removed") > 0);
        assert_eq!(scene.files(), Vec::<PathBuf>::new());
    }
}

#[test]
fn a_later_run_removes_the_files_of_a_killed_coordinator_and_spares_the_living() {
    let scene = Scene::new();
    let (mut left, mut right) = scene.pair("rail", WaitMode::Poll);
    let child = start_child(&scene, "coordinator");
    wait_until_ready(&scene);
    let prefix = run_prefix(child.id(), 1);
    assert!(
        !remove_dead_runs(&scene.root)
            .expect("removed")
            .contains(&prefix)
    );
    kill(child);
    assert!(
        remove_dead_runs(&scene.root)
            .expect("removed")
            .contains(&prefix)
    );
    let mut left_over = scene.files_of(&prefix);
    left_over.retain(|file| !file.is_dir());
    assert_eq!(left_over, Vec::<PathBuf>::new());
    left.send(&numbered(1, vec![]), AMPLE)
        .expect("the living still speak");
    assert_eq!(receive(&mut right).header.window, 1);
}

/// A program that shares the memory may see the coordinator under another process number, or not at all.
#[test]
fn a_run_marked_alive_is_spared_for_any_process_number() {
    let mut scene = Scene::new();
    scene.prefix = run_prefix(u32::MAX, u64::from(std::process::id()));
    assert!(!is_alive(&scene.prefix));
    let mark = mark_alive(&scene.prefix).expect("shared memory is there");
    let (mut left, mut right) = scene.pair("rail", WaitMode::Poll);
    assert!(is_alive(&scene.prefix));
    let removed = || remove_dead_runs(&scene.root).expect("removed");
    assert!(!removed().contains(&scene.prefix));
    left.send(&numbered(1, vec![]), AMPLE).expect("it is taken");
    assert_eq!(receive(&mut right).header.window, 1);
    drop(mark);
    assert!(!is_alive(&scene.prefix));
    assert!(removed().contains(&scene.prefix));
    let mut left_over = scene.files();
    left_over.retain(|file| !file.is_dir());
    assert_eq!(left_over, Vec::<PathBuf>::new());
}

/// One thread is about to lock its file while another removes unlocked files.
#[test]
fn a_mark_is_never_of_a_file_that_is_gone() {
    let scene = Scene::new();
    let ended = std::sync::atomic::AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            while !ended.load(Ordering::Relaxed) {
                remove_dead_runs(&scene.root).expect("removed");
            }
        });
        for _ in 0..2_000 {
            let prefix = run_prefix(u32::MAX - 1, u64::from(std::process::id()));
            let mark = mark_alive(&prefix).expect("shared memory is there");
            assert!(is_alive(&prefix));
            drop(mark);
        }
        ended.store(true, Ordering::Relaxed);
    });
}
