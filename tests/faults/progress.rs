//! Progress on stderr: a block on a terminal, a few lines elsewhere, objects for programs, nothing with `--quiet`.

use std::path::Path;
use std::process::Command;

use harness::runs::{Scratch, parse_json, program, thirdbody};
use serde_json::Value;

use crate::scene::{fails, short_quick};

/// Standard error of a short `quick` with these arguments.
fn stderr_of(work: &Path, arguments: &[&str], sets: &[&str]) -> String {
    let output = short_quick(work, sets).args(arguments).output();
    let output = output.expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    // Progress does not change stdout.
    assert_eq!(parse_json(&output.stdout)["status"], "completed");
    stderr
}

#[test]
fn a_pipe_gets_a_line_for_every_tenth_of_a_run() {
    let work = Scratch::new("lines");
    let stderr = stderr_of(work.path(), &[], &["run.end_s=4e-4"]);
    let lines: Vec<&str> = stderr.lines().collect();
    assert!((1..=11).contains(&lines.len()), "{stderr}");
    let last = lines[lines.len() - 1];
    for word in [
        "quick: 100 %",
        "ramp",
        "t = 0.400 of 0.400 ms",
        "repeats",
        "F_T/F_N",
        "energy defect",
        "waits for rail",
        "third-body",
        "own work",
        "spent",
    ] {
        assert!(last.contains(word), "no `{word}` in {last}");
    }
    assert!(!stderr.contains('\u{1b}'), "{stderr}");
}

#[test]
fn quiet_runs_still_warn() {
    let work = Scratch::new("quiet");
    let whole = ["run.end_s=1.8e-3"];
    assert_eq!(stderr_of(work.path(), &["--quiet"], &whole), "");
    let work = Scratch::new("quiet-warns");
    let warned = stderr_of(
        work.path(),
        &["--quiet"],
        &["run.plausible.energy_balance_rel=[1e-12, 1.0]"],
    );
    assert!(warned.contains("energy"), "{warned}");
    let refused = Command::new(program("thirdbody"))
        .args(["run", "quick", "--quiet", "--json-lines"])
        .output();
    fails(&refused.expect("it starts"), 2, &["--quiet"]);
}

#[test]
fn programs_get_one_object_a_line() {
    let work = Scratch::new("objects");
    let warns = ["run.plausible.energy_balance_rel=[1e-12, 1.0]"];
    let stderr = stderr_of(work.path(), &["--json-lines"], &warns);
    let objects: Vec<Value> = stderr.lines().map(|l| parse_json(l.as_bytes())).collect();
    let all = &objects;
    let of = |event: &'static str| all.iter().filter(move |object| object["event"] == event);
    let last = of("progress")
        .next_back()
        .expect("the run's end is reported");
    assert_eq!(last["done_rel"], 1.0);
    for key in [
        "t_s",
        "end_s",
        "window",
        "windows",
        "repeats",
        "repeats_mean",
        "traction_ratio",
        "energy_defect_rel",
        "own_rel",
        "spent_wall_s",
        "left_wall_s",
        "phase_done_rel",
    ] {
        assert!(last[key].is_number(), "no {key} in {last}");
    }
    assert!(last["waited_rel"]["third-body"].is_number() && last["phase"] == "ramp");
    let mut warnings = of("warning");
    let warning = warnings.find(|warning| warning["code"] == "energy_balance");
    let warning = warning.expect("it warns");
    assert!(warning["where"].is_string(), "{warning}");
    let out = work.path().join("out").display().to_string();
    let occupied = short_quick(work.path(), &[]).arg("--json-lines").output();
    let occupied = occupied.expect("it starts");
    assert_eq!(occupied.status.code(), Some(2));
    let error = parse_json(&occupied.stderr);
    assert!(
        error["event"] == "error" && error["exit_code"] == 2,
        "{error}"
    );
    assert!(
        error["text"]
            .as_str()
            .is_some_and(|text| text.contains(&out)),
        "{error}"
    );
}

#[test]
fn replays_and_unknown_words_are_reported_to_programs() {
    let work = Scratch::new("replayed");
    stderr_of(work.path(), &["--quiet"], &[]);
    let run = |arguments: &[&str]| {
        let mut command = Command::new(program("thirdbody"));
        let output = command.args(arguments).current_dir(work.path()).output();
        output.expect("it starts")
    };
    let replayed = run(&["replay", "out", "--node", "third-body", "--json-lines"]);
    assert!(replayed.status.success());
    let lines = String::from_utf8_lossy(&replayed.stderr).into_owned();
    let count = parse_json(
        lines
            .lines()
            .last()
            .expect("its end is reported")
            .as_bytes(),
    );
    assert!(count["event"] == "count" && count["things"] == "messages");
    assert!(count["done"] == count["total"] && count["total"].as_u64() > Some(0));
    assert!(run(&["replay", "out", "--quiet"]).stderr.is_empty());
    let refused = run(&["run", "quick", "--json-lines", "--no-such-word"]);
    assert_eq!(refused.status.code(), Some(2));
    let error = parse_json(&refused.stderr);
    assert!(error["event"] == "error" && error["code"] == "usage");
}

/// A terminal that knows the codes that move the cursor up and clear the lines below it.
#[derive(Default)]
struct Screen {
    lines: Vec<String>,
    line: usize,
    column: usize,
}

impl Screen {
    fn show(&mut self, text: &str) {
        let mut rest = text.chars();
        while let Some(c) = rest.next() {
            match c {
                '\r' => self.column = 0,
                '\n' => self.line += 1,
                '\u{1b}' => {
                    assert_eq!(rest.next(), Some('['));
                    let mut code = String::new();
                    while !code.ends_with(|c: char| c.is_ascii_alphabetic()) {
                        code.extend(rest.next());
                    }
                    self.obey(&code);
                }
                c => self.put(c),
            }
        }
    }

    fn obey(&mut self, code: &str) {
        let number: usize = code[..code.len() - 1].parse().unwrap_or(0);
        match code.chars().last() {
            Some('A') => self.line -= number.max(1),
            Some('J') => {
                let column = self.column;
                self.current().truncate(column);
                self.lines.truncate(self.line + 1);
            }
            _ => panic!("an unknown code: {code}"),
        }
    }

    fn current(&mut self) -> &mut String {
        let lines = self.lines.len().max(self.line + 1);
        self.lines.resize(lines, String::new());
        &mut self.lines[self.line]
    }

    fn put(&mut self, c: char) {
        let column = self.column;
        let line = self.current();
        let missing = column.saturating_sub(line.len());
        line.push_str(&" ".repeat(missing));
        line.replace_range(column..line.len().min(column + 1), &c.to_string());
        self.column += 1;
    }
}

/// On a terminal of 80 columns the block is redrawn in place, and messages that come meanwhile stand above it. `script` (util-linux)
/// provides the terminal.
#[test]
fn a_terminal_gets_one_block_that_never_wraps() {
    let work = Scratch::new("block");
    if Command::new("script").arg("--version").output().is_err() {
        eprintln!("there is no `script` here: the block is tested without a terminal only");
        return;
    }
    let run = format!(
        "stty cols 80 rows 24; exec {} run quick --json --out out --set run.end_s=3e-4 --set 'run.plausible.energy_balance_rel=[1e-12, 1.0]' > summary.json",
        program("thirdbody").display()
    );
    let output = Command::new("script")
        .args(["--quiet", "--return", "--command", &run, "/dev/null"])
        .current_dir(work.path())
        .envs([("TERM", "xterm"), ("SHELL", "/bin/sh")])
        .env("XDG_CACHE_HOME", work.path())
        .output()
        .expect("it is here");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text:?}");
    assert!(
        text.matches("quick [").count() > 1,
        "it is redrawn: {text:?}"
    );
    let mut screen = Screen::default();
    screen.show(&text);
    let shown: Vec<&str> = screen.lines.iter().map(|line| line.trim_end()).collect();
    // Warnings are sentences, which may wrap: they are above the block and stay there.
    let drawn = text.lines().filter_map(|line| line.rsplit("[J").next());
    let drawn: Vec<&str> = drawn.collect();
    let of_block = |line: &&&str| line.starts_with("quick") || line.starts_with("  ");
    let widest = drawn.iter().filter(of_block).map(|line| line.len()).max();
    assert!(
        widest.is_some_and(|widest| (40..=80).contains(&widest)),
        "{drawn:#?}"
    );
    let heads = shown.iter().filter(|line| line.starts_with("quick ["));
    assert_eq!(heads.count(), 1, "{shown:#?}");
    let at = |word: &str| shown.iter().position(|line| line.contains(word));
    let head = at("quick [####################] 100 %").expect("it came to its end");
    assert!(
        shown[head + 3].starts_with("  time: waits for rail"),
        "{shown:#?}"
    );
    assert!(
        at("energy_balance").is_some_and(|line| line < head),
        "{shown:#?}"
    );
}

#[test]
fn a_long_set_up_is_reported_while_it_lasts() {
    let work = Scratch::new("prepares");
    let node = program("verification-node").display().to_string();
    let late = format!("sleep 1.3; exec {node} bar");
    crate::commands::scene(work.path(), &["sh", "-c", &late], 20);
    let output = thirdbody(work.path())
        .args(["run", ".", "--out", "out", "--json-lines"])
        .output()
        .expect("it starts");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    let objects = stderr.lines().map(|line| parse_json(line.as_bytes()));
    let events: Vec<Value> = objects
        .filter(|object| object["event"] == "prepares")
        .collect();
    assert_eq!(events.len(), 1, "{stderr}");
    assert_eq!(events[0]["participant"], "bar");
    assert_eq!(events[0]["limit_s"], 300.0);
    assert!(
        events[0]["waited_s"]
            .as_f64()
            .is_some_and(|s| (1.0..1.3).contains(&s)),
        "{stderr}"
    );
}
