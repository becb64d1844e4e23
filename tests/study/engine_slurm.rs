//! The engine for Slurm, with a stand-in for Slurm's programs: its requests, and that tasks which Slurm loses are still done. tests/slurm
//! tests it with a real Slurm.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Output};

use harness::runs::Scratch;

use crate::rows::{SUBSTEPS, command, lasting, printed, rows, study, words};

/// `sbatch` starts every index of an array at once in its own process. The first time, an index that LOST names is listed as running,
/// but no process computes it.
const SBATCH: &str = r#"#!/bin/sh
d=$(dirname "$0")/state; mkdir -p "$d"
job=$(( $(ls "$d" | grep -c '^asked-') + 1 ))
cat > "$d/script-$job"
echo "$@" > "$d/asked-$job"
for word in "$@"; do
    case $word in
    --array=*) list=${word#--array=} ;;
    --job-name=*) name=${word#--job-name=} ;;
    esac
done
list=$(echo "${list%%%*}" | tr , ' ')
for part in $list; do
    for index in $(seq "${part%-*}" "${part#*-}"); do
        echo "$name" > "$d/job-${job}_$index"
        if [ "$job" = 1 ] && [ "$index" = "$LOST" ]; then
            sleep 1000 > /dev/null 2>&1 &
        elif [ "$job" = 1 ] && [ "$index" = "$FORGOTTEN" ]; then
            rm "$d/job-${job}_$index"
            continue
        else
            ( SLURM_ARRAY_JOB_ID=$job SLURM_ARRAY_TASK_ID=$index sh "$d/script-$job"; rm -f "$d/job-${job}_$index" ) > /dev/null 2>&1 &
        fi
        echo $! > "$d/pid-${job}_$index"
    done
done
echo $job
"#;

const SQUEUE: &str = r#"#!/bin/sh
d=$(dirname "$0")/state
for file in "$d"/job-*; do
    [ -f "$file" ] && echo "${file##*/job-}|RUNNING|$(cat "$file")"
done
exit 0
"#;

const SCANCEL: &str = r#"#!/bin/sh
d=$(dirname "$0")/state
for word in "$@"; do
    case $word in
    -*) ;;
    *) echo "$word" >> "$d/cancelled"; rm -f "$d/job-$word"; kill "$(cat "$d/pid-$word")" 2>/dev/null ;;
    esac
done
exit 0
"#;

const SCONTROL: &str = r#"#!/bin/sh
case "$*" in
"show config") echo "MaxArraySize            = 1001" ;;
*) echo "JobId=1 JobState=CANCELLED Reason=None" ;;
esac
"#;

/// A folder with the programs.
fn stand_in(work: &Scratch) -> String {
    let folder = work.path().join("slurm-programs");
    fs::create_dir_all(&folder).expect("it is writable");
    for (name, text) in [
        ("sbatch", SBATCH),
        ("squeue", SQUEUE),
        ("scancel", SCANCEL),
        ("scontrol", SCONTROL),
    ] {
        let path = folder.join(name);
        fs::write(&path, text).expect("it is writable");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("it is ours");
    }
    folder.display().to_string()
}

fn through_slurm(work: &Scratch, run: &mut Command) -> Output {
    let path = std::env::var("PATH").unwrap_or_default();
    run.env("PATH", format!("{}:{path}", stand_in(work)));
    run.output().expect("the program starts")
}

fn said(work: &Scratch, file: &str) -> String {
    let path = work.path().join("slurm-programs/state").join(file);
    fs::read_to_string(path).unwrap_or_default()
}

#[test]
fn an_array_gives_the_rows_of_the_local_engine_also_when_slurm_loses_tasks() {
    let work = Scratch::new("study-slurm");
    let file = study(&work, SUBSTEPS);
    let more = [
        "--engine",
        "slurm",
        "--silent-s",
        "2",
        "--jobs",
        "7",
        "--sbatch=--partition=all",
    ];
    let mut run = command(&work, "run", &file, &more);
    let output = through_slurm(&work, run.env("LOST", "2").env("FORGOTTEN", "1"));
    assert_eq!(output.status.code(), Some(0), "{}", words(&output));
    let notes = words(&output);
    assert!(
        notes.contains("submitted 5 tasks as job array 1"),
        "{notes}"
    );
    assert!(
        notes.contains("task 2: 1_2 is RUNNING but has no heartbeat"),
        "{notes}"
    );
    assert_eq!(said(&work, "cancelled").lines().next(), Some("1_2"));
    let asked = said(&work, "asked-1");
    for part in [
        "--array=0-4%7",
        "--cpus-per-task=1",
        "--mem=512M",
        "--time=10",
        "--partition=all",
    ] {
        assert!(asked.contains(part), "{part} in {asked}");
    }
    let through = rows(&work);
    assert!(
        through.iter().all(|row| row["attempts"] == "1"),
        "{through:?}"
    );

    let local = Scratch::new("study-slurm-local");
    let file = study(&local, SUBSTEPS);
    printed(&mut command(&local, "run", &file, &[]), 0);
    assert_eq!(lasting(&through), lasting(&rows(&local)));
}

#[test]
fn without_slurm_the_missing_program_is_named() {
    let work = Scratch::new("study-no-slurm");
    let file = study(&work, SUBSTEPS);
    let mut run = command(&work, "run", &file, &["--engine", "slurm"]);
    let output = run
        .env("PATH", work.path())
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(2), "{}", words(&output));
    let words = words(&output);
    for part in ["`squeue` of Slurm", "study exec", "page `cluster`"] {
        assert!(words.contains(part), "{part} in {words}");
    }
}
