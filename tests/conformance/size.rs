//! The product stays small enough to be read. A line counts that holds code of the product: not blank, no comment or documentation, no
//! code that `#[cfg(test)]` marks, and in no file of a module `tests`. The Python package and the player of movies are counted beside it.

use std::path::Path;

use harness::source::{Sources, code_lines, crate_lines, product_crates, read_sources};

/// Lines of all crates together, without the room that issues name for themselves.
const ALL: usize = 57_000;

/// Lines of the largest crate.
const CRATE: usize = 14_000;

/// Room that an open issue names for itself, by its name and the crate that takes it.
const ROOM: [(&str, &str, usize); 21] = [
    ("A third body that converges", "dem-node", 690),
    ("A third body that converges", "report", 210),
    ("A third body that converges", "study", 200),
    ("A third body that converges", "others", 100),
    ("Honest to the end, second part", "fem-node", 100),
    ("Honest to the end, second part", "lab", 150),
    ("Honest to the end, second part", "others", 450),
    ("Five minutes for a cycle", "dem-node", 600),
    ("Grains meet the whole surface", "dem-node", 1_217),
    ("Grains meet the whole surface", "fem-node", 209),
    ("Grains meet the whole surface", "others", 63),
    ("Cohesion that comes back", "dem-node", 949),
    ("Cohesion that comes back", "others", 95),
    ("The paper in one command", "dem-node", 450),
    ("The paper in one command", "others", 438),
    ("What a newcomer still trips over", "others", 891),
    ("Swap in what people have", "others", 226),
    ("Fidelity that follows the scene", "others", 1_800),
    ("A participant on another host", "others", 1_400),
    ("The first page must be true", "dem-node", 400),
    ("The first page must be true", "others", 300),
];

/// Lines that are no Rust: modules of the Python package, and the player of a movie.
const BESIDE: usize = 3_100;

#[test]
fn the_crates_have_no_more_lines_than_the_limit() {
    let counts: Vec<(String, usize)> = product_crates()
        .into_iter()
        .map(|(name, folder)| (name, crate_lines(&read_sources(&folder))))
        .collect();
    let total: usize = counts.iter().map(|(_, lines)| lines).sum();
    println!("{total} lines of code: {counts:?}");
    let limit = ALL + ROOM.iter().map(|(_, _, lines)| lines).sum::<usize>();
    assert!(
        total <= limit,
        "{total} lines, more than {limit}: {counts:?}"
    );
    for (name, lines) in &counts {
        let own = ROOM.iter().filter(|(_, of, _)| of == name);
        let limit = CRATE + own.map(|(_, _, lines)| lines).sum::<usize>();
        assert!(
            *lines <= limit,
            "{name} has {lines} lines, more than {limit}"
        );
    }
}

#[test]
fn what_is_no_rust_has_no_more_lines_than_its_limit() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let package = root.join("protocol/python/thirdbody");
    let package = std::fs::read_dir(package).expect("it is there").flatten();
    let mut files: Vec<_> = package.map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "py"));
    files.push(root.join("coupler/report/src/movie/player.html"));
    let lines = |path: &std::path::PathBuf| {
        let text = std::fs::read_to_string(path).expect("it is text");
        let is_code = |line: &&str| !line.trim().is_empty();
        text.lines().filter(is_code).count()
    };
    let total: usize = files.iter().map(lines).sum();
    println!("{total} lines that are no Rust, blank ones left out");
    assert!(total <= BESIDE, "{total} lines, more than {BESIDE}");
}

#[test]
fn comments_blank_lines_and_tests_are_no_code() {
    let text = "//! A crate.\n\n/// Adds.\n#[inline]\nfn add(a: u32) -> u32 {\n    // Why.\n    a + 1 /* one */\n}\n\n\
                #[cfg(test)]\nmod tests {\n    #[test]\n    fn adds() {}\n}\n";
    assert_eq!(code_lines("lib.rs", text), 4);
    let string = "const TEXT: &str = \"one\n\n// two\n\";\n";
    assert_eq!(code_lines("lib.rs", string), 3, "the blank line is none");
}

#[test]
fn modules_of_tests_are_no_code() {
    let sources = Sources::from([
        ("lib.rs".into(), "mod a;\n#[cfg(test)]\nmod tests;\n".into()),
        ("tests.rs".into(), "mod below;\nfn f() {}\n".into()),
        ("tests/below.rs".into(), "fn f() {}\n".into()),
        ("a.rs".into(), "fn f() {\n}\n".into()),
        ("main.rs".into(), "fn main() {}\n".into()),
    ]);
    assert_eq!(crate_lines(&sources), 1 + 2 + 1);
}
