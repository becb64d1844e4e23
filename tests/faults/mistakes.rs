//! The typical mistakes of the book: the test makes each, and the message must be the one on the page. The command prints the pages of
//! causes and cures.

use std::path::Path;

use harness::runs::{Scratch, thirdbody};

use crate::scene::{fails, folder};

/// A mistake of the page: lines removed from and added to `quick`, and the message that follows.
struct Mistake<'a> {
    title: &'a str,
    change: &'a str,
    message: &'a str,
}

/// The book's pages, from the root of the repository.
const BOOK: &str = "scenarios/book/src";

fn page(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
    std::fs::read_to_string(path).expect("it ships")
}

/// The mistakes of the section, by their headings.
fn mistakes(page: &str) -> Vec<Mistake<'_>> {
    let (_, section) = page
        .split_once("\n## Typical mistakes")
        .expect("the section");
    let section = section.split("\n## ").next().unwrap_or_default();
    let entries = section.split("\n### ").skip(1);
    entries
        .map(|entry| {
            let block = |language: &str| {
                let (_, rest) = entry
                    .split_once(&format!("```{language}\n"))
                    .expect("a block");
                rest.split_once("\n```").expect("its end").0
            };
            Mistake {
                title: entry.lines().next().unwrap_or_default(),
                change: block("diff"),
                message: block("text"),
            }
        })
        .collect()
}

/// `quick` with the change of a mistake: the new lines replace the old ones, which occur once in the scene.
fn changed(change: &str) -> String {
    let text = std::fs::read_to_string(folder("quick").join("scenario.toml")).expect("it ships");
    let lines = |sign: char| {
        let own = change.lines().filter_map(|line| line.strip_prefix(sign));
        own.collect::<Vec<&str>>().join("\n")
    };
    let (old, new) = (lines('-'), lines('+'));
    assert_eq!(text.matches(&old).count(), 1, "`{old}` in quick");
    text.replace(&old, &new)
}

/// The exit code and the message of `check`, with whole lines and without trailing spaces.
fn message(text: &str) -> (Option<i32>, String) {
    let work = Scratch::new("mistake");
    std::fs::write(work.path().join("scenario.toml"), text).expect("the folder is writable");
    let output = thirdbody(work.path())
        .args(["check", "scenario.toml"])
        .current_dir(work.path())
        .envs([("LC_ALL", "C.UTF-8"), ("NO_COLOR", "1"), ("TERM", "dumb")])
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    let here = work.path().display().to_string();
    let said = said.replace(&here, "/home/me/scene");
    let lines: Vec<&str> = said.trim_matches('\n').lines().map(str::trim_end).collect();
    (output.status.code(), lines.join("\n"))
}

#[test]
fn the_messages_of_typical_mistakes_match_the_pages() {
    let pages = ["keys", "values", "names-and-files", "scene"];
    let pages = pages.map(|name| page(&format!("{BOOK}/howto/mistakes/{name}.md")));
    let mistakes = Vec::from_iter(pages.iter().flat_map(|page| mistakes(page)));
    assert!(mistakes.len() >= 10, "{}", mistakes.len());
    let mut wrong = String::new();
    for mistake in mistakes {
        let (code, message) = message(&changed(mistake.change));
        if code != Some(2) || message != mistake.message {
            wrong += &format!("## {} ({code:?})\n{message}\n\n", mistake.title);
        }
    }
    assert!(
        wrong.is_empty(),
        "other messages than on the page:\n{wrong}"
    );
}

#[test]
fn explain_prints_the_entry_of_a_code_and_proposes_the_nearest() {
    let work = Scratch::new("explain");
    let explain = |words: &[&str]| {
        let output = thirdbody(work.path()).arg("explain").args(words).output();
        output.expect("the program starts")
    };
    let listed = explain(&[]);
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    for code in ["unknown-key", "peer-lost", "wheel_at_rest"] {
        assert!(
            listed.lines().any(|line| line.starts_with(code)),
            "{code}: {listed}"
        );
        let printed = explain(&[code]);
        let printed = String::from_utf8_lossy(&printed.stdout).into_owned();
        let entry = printed.split_once("\n\n").expect("code and text").1;
        let pages = ["errors", "findings"].map(|name| page(&format!("{BOOK}/reference/{name}.md")));
        assert!(
            pages.iter().any(|page| page.contains(entry.trim())),
            "{printed}"
        );
    }
    let unknown = explain(&["peer-list"]);
    fails(&unknown, 2, &["error[usage]", "did you mean `peer-lost`?"]);
    fails(
        &explain(&["a", "b"]),
        2,
        &["error[usage]: unexpected argument"],
    );
}
