//! Scenes and studies inside the program: they give the bits of the source tree in any folder, and can be listed and copied.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::Value;

use crate::scene::{completed, fails, folder, short_quick};

fn output(work: &Path, arguments: &[&str]) -> Output {
    let mut command = thirdbody(work);
    command
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// Runs it, which must succeed; returns what it printed.
fn printed(work: &Path, arguments: &[&str]) -> String {
    let output = output(work, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn run(work: &Path, scene: &str, out: &str, sets: &[&str]) -> Value {
    let mut command = thirdbody(work);
    command.args(["run", scene, "--json", "--out", out]);
    for set in sets {
        command.args(["--set", set]);
    }
    completed(&mut command)
}

#[test]
fn a_scene_inside_the_program_gives_the_bits_of_the_source_tree() {
    let [here, there] = ["inside", "tree"].map(Scratch::new);
    let inside = run(here.path(), "quick", "out", &["run.end_s=6e-5"]);
    let tree = completed(&mut short_quick(there.path(), &[]));
    assert!(inside["hashes"]["exchange"].is_string());
    assert_eq!(inside["hashes"], tree["hashes"]);
    let manifest = here.path().join("out/manifest.json");
    let manifest = parse_json(&std::fs::read(manifest).expect("it ran"));
    assert_eq!(manifest["scenario_file"], "quick (built in)");
}

/// The paper's rail takes minutes to pack, and this cache is empty.
#[test]
fn a_check_does_not_wait_for_a_sample_that_takes_minutes() {
    let work = Scratch::new("unpacked");
    let text = printed(work.path(), &["check", "wheel-rail-de"]);
    let words = "cost: not predicted, the set-up of participant rail takes longer than 8 s";
    assert!(text.contains(words), "{text}");
    assert!(!text.contains("cost: about"), "{text}");
}

/// The cache folder has the name of the build, so a sample of another build is not used.
#[test]
fn samples_are_kept_by_build() {
    let work = Scratch::new("by-build");
    let sets = ["run.end_s=7e-7"];
    let first = run(work.path(), "wheel-rail-de-small", "first", &sets);
    let again = run(work.path(), "wheel-rail-de-small", "again", &sets);
    let kept = |summary: &Value| summary["participants"]["rail"]["prepared_from_cache"].clone();
    assert_eq!([kept(&first), kept(&again)], [false, true]);
    let manifest = std::fs::read(work.path().join("first/manifest.json")).expect("it ran");
    let manifest = parse_json(&manifest);
    let build = manifest["build"].as_str().expect("a hash");
    let cache = work.path().join("cache/thirdbody");
    let [own, other] = [build, "0123456789abcdef"].map(|b| cache.join(format!("samples-{b}")));
    std::fs::rename(own, other).expect("it was kept there");
    let anew = run(work.path(), "wheel-rail-de-small", "anew", &sets);
    assert_eq!(
        (kept(&anew), &anew["hashes"]),
        (false.into(), &first["hashes"])
    );
}

/// The signals have one row per window. The traction at the end of the hold is in the run directory and among the fields.
#[test]
fn every_table_of_a_run_can_be_checked_by_its_summary() {
    let work = Scratch::new("tables");
    let past_the_hold = ["run.end_s=8.3e-4"];
    let summary = run(work.path(), "wheel-rail-fe-small", "out", &past_the_hold);
    let tables = summary["tables"].as_object().expect("a table of tables");
    let names: Vec<&str> = tables.keys().map(String::as_str).collect();
    let hold = "fields/rail-hold-profile.csv";
    assert!(names.contains(&hold), "{names:?}");
    for (name, table) in tables {
        let bytes = std::fs::read(work.path().join("out").join(name)).expect(name);
        let lines = bytes.iter().filter(|byte| **byte == b'\n').count();
        assert_eq!(table["bytes"], bytes.len(), "{name}");
        assert_eq!(table["rows"], lines - 1, "{name}");
        let hash = blake3::hash(&bytes).to_hex().to_string();
        assert_eq!(table["blake3"], hash, "{name}");
    }
    assert_eq!(tables["signals.csv"]["rows"], summary["windows"]);
    assert_eq!(tables["profile.csv"], tables[hold]);
}

/// A flipped bit in a field changes only pictures.
#[test]
fn a_report_names_a_changed_field() {
    let work = Scratch::new("flipped");
    let summary = run(
        work.path(),
        "wheel-rail-fe-small",
        "out",
        &["run.end_s=8.3e-4"],
    );
    let hashes = summary["fields"]["blake3"]
        .as_object()
        .expect("a hash of each file");
    let name = hashes.keys().next().expect("there is one");
    let path = work.path().join("out").join(name);
    printed(work.path(), &["report", "out"]);
    let mut bytes = std::fs::read(&path).expect("it is there");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).expect("it is writable");
    fails(
        &output(work.path(), &["report", "out"]),
        6,
        &[name, "was changed since"],
    );
    let movie = output(work.path(), &["report", "out", "--movie"]);
    fails(&movie, 6, &[name, "was changed since"]);
}

/// The hash in the summary proves that its keys belong to the run, and a summary has at least a status.
#[test]
fn a_comparison_finds_another_scenario_and_another_summary() {
    let work = Scratch::new("exchanged");
    for out in ["a", "b"] {
        run(work.path(), "verification/bouncing-disk", out, &[]);
    }
    let compare = || output(work.path(), &["compare", "a", "b"]);
    let map = |map: &str| output(work.path(), &["compare", "a", "b", "--map", map]);
    assert!(compare().status.success());
    assert!(map("kinetic_j=impact_j").status.success());
    fails(&map("kinetic_j=t_s"), 2, &["\"J\"", "\"s\""]);
    let [scenario, summary] = ["b/scenario.toml", "b/summary.json"].map(|at| work.path().join(at));
    let text = std::fs::read_to_string(&scenario).expect("it was written");
    std::fs::write(&scenario, text.replace("9.81", "9.82")).expect("it is writable");
    fails(&compare(), 6, &["scenario.toml", "was changed since"]);
    std::fs::remove_file(&scenario).expect("it is there");
    fails(&compare(), 6, &["scenario.toml", "cannot be read"]);
    std::fs::write(&summary, "{}").expect("it is writable");
    fails(&compare(), 2, &["summary.json", "has no status"]);
}

/// The scenario's hash covers the path of the mesh; the hashes of the results do not.
#[test]
fn a_replay_finds_a_mesh_inside_the_program() {
    const SCENE: &str = "verification/pressurised-cylinder";
    const NODE: &str = "cylinder";
    let work = Scratch::new("mesh");
    let logged = ["run.output.exchange=true"];
    let inside = run(work.path(), SCENE, "inside", &logged);
    let tree = folder(SCENE).display().to_string();
    let tree = run(work.path(), &tree, "tree", &logged);
    for hash in ["exchange", "state"] {
        assert!(inside["hashes"][hash].is_string());
        assert_eq!(inside["hashes"][hash], tree["hashes"][hash], "{hash}");
    }
    printed(work.path(), &["replay", "inside", "--node", NODE]);
    let without = output(work.path(), &["run", SCENE, "--cache", "none"]);
    fails(&without, 2, &[SCENE, "--cache DIR", "thirdbody new"]);
}

/// The program rewrites a damaged file of the cache and never uses a foreign file under the mesh's name.
#[test]
fn a_damaged_mesh_in_the_cache_is_repaired() {
    const SCENE: &str = "verification/pressurised-cylinder";
    let work = Scratch::new("mended");
    let first = run(work.path(), SCENE, "first", &[]);
    let cache = work.path().join("cache/thirdbody");
    let mut kept = std::fs::read_dir(cache).expect("it was made").flatten();
    let kept = kept.next().expect("the scenes").path();
    let mesh = kept.join(SCENE).join("cylinder.msh");
    let whole = std::fs::read(&mesh).expect("it was kept");
    std::fs::write(&mesh, "$MeshFormat").expect("writable");
    let second = run(work.path(), SCENE, "second", &[]);
    assert_eq!(first["hashes"], second["hashes"]);
    assert_eq!(std::fs::read(&mesh).expect("it is repaired"), whole);
}

#[test]
fn all_scenes_on_the_disk_are_listed() {
    let work = Scratch::new("listed");
    let listed = parse_json(printed(work.path(), &["scenes", "--json"]).as_bytes());
    let listed = listed["results"].as_array().expect("rows").clone();
    let names: BTreeSet<String> = listed
        .iter()
        .map(|row| row["name"].as_str().expect("a text").to_string())
        .collect();
    let mut on_disk = BTreeSet::new();
    let top = folder("");
    for group in [
        "",
        "benchmarks",
        "extremes",
        "foreign",
        "heat",
        "rolling",
        "studies",
        "verification",
    ] {
        for entry in std::fs::read_dir(top.join(group))
            .expect("it ships")
            .flatten()
        {
            let files = ["scenario.toml", "study.toml"];
            if files.iter().any(|file| entry.path().join(file).is_file()) {
                let name = Path::new(group).join(entry.file_name());
                on_disk.insert(name.display().to_string());
            }
        }
    }
    assert_eq!(names, on_disk);
    let text = printed(work.path(), &["scenes"]);
    for word in [
        "quick (3 s)",
        "foreign/winkler",
        "Python package",
        "thirdbody new NAME",
    ] {
        assert!(text.contains(word), "no `{word}` in {text}");
    }
}

#[test]
fn a_mistyped_scene_or_study_is_proposed() {
    let work = Scratch::new("mistyped");
    let of = |arguments: &[&str]| output(work.path(), arguments);
    fails(
        &of(&["run", "quik"]),
        2,
        &["`quik`", "did you mean `quick`?"],
    );
    let winkler = ["check", "winkler"];
    fails(&of(&winkler), 2, &["did you mean `foreign/winkler`?"]);
    let study = ["study", "status", "tradeof-coupled"];
    fails(
        &of(&study),
        2,
        &["did you mean `studies/tradeoff-coupled`?"],
    );
    fails(&of(&["new", "quik"]), 2, &["did you mean `quick`?"]);
}

#[test]
fn a_copy_keeps_its_comments_and_runs_as_edited() {
    let work = Scratch::new("copy");
    let shown = printed(work.path(), &["new", "quick", "mine"]);
    for word in ["mine/scenario.toml", "check mine", "run mine", "report"] {
        assert!(shown.contains(word), "no `{word}` in {shown}");
    }
    let file = work.path().join("mine/scenario.toml");
    let text = std::fs::read_to_string(&file).expect("it was copied");
    let shipped = folder("quick").join("scenario.toml");
    let shipped = std::fs::read_to_string(shipped).expect("it ships");
    let own = "name = \"mine\"\nderived_from = \"quick\"";
    // All lines and comments are there; comments between them explain the keys.
    let shipped = shipped.replacen("name = \"quick\"", own, 1);
    let kept = |line: &&str| shipped.lines().any(|own| own == *line);
    assert!(text.lines().filter(kept).eq(shipped.lines()), "{text}");
    let edited = text.replace("seed = 1", "seed = 2\nend_s = 6e-5");
    assert!(text.starts_with('#') && edited != text);
    std::fs::write(&file, edited).expect("writable");
    let ours = run(work.path(), "mine", "out", &[]);
    let built_in = ["run.end_s=6e-5", "run.seed=2"];
    let theirs = run(work.path(), "quick", "theirs", &built_in);
    assert_eq!(ours["hashes"]["state"], theirs["hashes"]["state"]);
    // The manifest lists all differences from the shipped scene: from the file, the command line and a repeated run.
    let changed = |run: &str| {
        let manifest = std::fs::read(work.path().join(run).join("manifest.json")).expect("it ran");
        parse_json(&manifest)["changed"].clone()
    };
    let set = serde_json::json!({ "run.seed": ["1", "2"], "run.end_s": [null, "0.00006"] });
    assert_eq!(changed("out"), set);
    assert_eq!(changed("theirs"), set);
    run(
        work.path(),
        "theirs/scenario.toml",
        "third",
        &["run.seed=3"],
    );
    let again = serde_json::json!({ "run.seed": ["1", "3"], "run.end_s": [null, "0.00006"] });
    assert_eq!(changed("third"), again);
    let shown = printed(work.path(), &["compare", "third", "theirs"]);
    assert!(
        shown.contains("run.seed") && !shown.contains("run.end_s"),
        "{shown}"
    );
    let everything = printed(work.path(), &["compare", "third", "theirs", "--all"]);
    assert!(
        everything.lines().count() > shown.lines().count(),
        "{shown}"
    );
    printed(work.path(), &["report", "theirs"]);
    let page = std::fs::read_to_string(work.path().join("theirs/report.html")).expect("a page");
    let place = work
        .path()
        .canonicalize()
        .expect("it is there")
        .join("theirs/scenario.toml");
    for words in [
        "run.seed = 2 (was 1)",
        &format!("thirdbody run {}", place.display()),
    ] {
        assert!(page.contains(words), "{words}");
    }
    let again = output(work.path(), &["new", "quick", "mine"]);
    fails(&again, 2, &["mine", "not empty"]);
    let crate_scene = output(work.path(), &["new", "foreign/rust-bed"]);
    fails(&crate_scene, 2, &["new-node rust"]);
}

/// A folder takes precedence over the built-in scene of its name, and a note says so.
#[test]
fn a_folder_with_the_name_of_a_scene_takes_precedence() {
    let work = Scratch::new("before");
    printed(work.path(), &["new", "quick"]);
    let check = ["check", "quick", "--no-start"];
    let same = output(work.path(), &check);
    assert!(same.status.success() && same.stderr.is_empty());
    let file = work.path().join("quick/scenario.toml");
    let text = std::fs::read_to_string(&file).expect("it was copied");
    std::fs::write(&file, text.replace("seed = 1", "seed = 3")).expect("writable");
    let other = output(work.path(), &check);
    fails(
        &other,
        0,
        &["quick/scenario.toml", "differs from the built-in"],
    );
}

#[test]
fn studies_budgets_and_suites_work_in_any_folder() {
    let work = Scratch::new("anywhere");
    let status = output(work.path(), &["study", "status", "tradeoff-coupled"]);
    fails(&status, 8, &[]);
    let status = String::from_utf8_lossy(&status.stdout).into_owned();
    assert!(status.contains("study    tradeoff-coupled"), "{status}");
    let budget = ["run", "quick-bonded", "--budget", "error=5%", "--json"];
    let summary = parse_json(printed(work.path(), &budget).as_bytes());
    assert_eq!(summary["budget"]["study"], "quick-bonded", "{summary:#}");
    let suite = printed(work.path(), &["validate", "--json"]);
    assert!(suite.matches("\"holds\":true").count() >= 10, "{suite}");
    printed(work.path(), &["new", "studies/quick-bonded", "mine"]);
    // A changed study must not choose by the results of another study.
    let copied = |file: &str| work.path().join("mine").join(file).is_file();
    assert!(copied("study.toml") && !copied("study.json"));
}

#[test]
fn shells_complete_and_every_verb_has_a_page() {
    let work = Scratch::new("pages");
    for shell in ["bash", "zsh", "fish"] {
        let text = printed(work.path(), &["completions", shell]);
        assert!(text.contains("new-node"), "{shell}: {text}");
    }
    let bash = printed(work.path(), &["completions", "bash"]);
    std::fs::write(work.path().join("completions"), bash).expect("writable");
    let words = "source completions; COMP_WORDS=(thirdbody sce); COMP_CWORD=1; _thirdbody thirdbody sce thirdbody; echo ${COMPREPLY[@]}";
    let mut shell = Command::new("bash");
    let completed = shell.current_dir(work.path()).args(["-c", words]).output();
    let completed = completed.expect("bash starts").stdout;
    assert_eq!(String::from_utf8_lossy(&completed).trim(), "scenes");
    assert!(printed(work.path(), &["man"]).contains(".TH thirdbody 1"));
    printed(work.path(), &["man", "pages"]);
    for page in ["thirdbody.1", "thirdbody-run.1", "thirdbody-study-run.1"] {
        let text = std::fs::read_to_string(work.path().join("pages").join(page));
        assert!(text.is_ok_and(|text| text.contains(".SH")), "{page}");
    }
    let hidden = work.path().join("pages/thirdbody-exec-child.1");
    assert!(!hidden.exists());
}
