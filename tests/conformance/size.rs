//! The product stays small enough to be read. Lines of product code count: no blank lines, comments or documentation, no
//! code that `#[cfg(test)]` marks, and no file of a module `tests`. The Python package and the player of movies are counted separately.

use std::path::Path;

use harness::source::{Sources, code_lines, crate_lines, product_crates, read_sources};

/// Lines of each crate, equal to the actual count. A change that makes a crate smaller lowers its number; an issue with an allowance
/// raises numbers by at most that allowance.
const LINES: [(&str, usize); 19] = [
    ("protocol", 2_354),
    ("kit", 2_020),
    ("network", 823),
    ("fem-kernel", 9_099),
    ("fem-node", 8_007),
    ("dem-kernel", 11_533),
    ("dem-node", 8_901),
    ("scheme", 4_340),
    ("exchange-log", 2_060),
    ("scenes", 179),
    ("scenario", 1_390),
    ("runs", 1_945),
    ("coordinator", 5_034),
    ("terminal", 357),
    ("draw", 843),
    ("report", 4_592),
    ("study", 5_029),
    ("lab", 3_617),
    ("coupler", 2_940),
];

/// Lines in other languages: modules of the Python package, and the player of a movie.
const BESIDE: usize = 3_407;

#[test]
fn the_crates_have_the_lines_of_their_limits() {
    let crates = product_crates().into_iter();
    let counts: Vec<(String, usize)> = crates
        .map(|(name, folder)| (name, crate_lines(&read_sources(&folder))))
        .collect();
    let total: usize = counts.iter().map(|(_, lines)| lines).sum();
    println!("{total} lines of code: {counts:?}");
    let limits = LINES.map(|(name, lines)| (name.to_string(), lines));
    assert_eq!(
        counts, limits,
        "lower the numbers of crates that have become smaller"
    );
}

#[test]
fn files_in_other_languages_have_at_most_the_lines_of_their_limit() {
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
    println!("{total} lines in other languages, without blank ones");
    assert!(total <= BESIDE, "{total} lines, more than {BESIDE}");
}

#[test]
fn comments_blank_lines_and_tests_are_no_code() {
    let text = "//! A crate.\n\n/// Adds.\n#[inline]\nfn add(a: u32) -> u32 {\n    // Why.\n    a + 1 /* one */\n}\n\n\
                #[cfg(test)]\nmod tests {\n    #[test]\n    fn adds() {}\n}\n";
    assert_eq!(code_lines("lib.rs", text), 4);
    let string = "const TEXT: &str = \"one\n\n// two\n\";\n";
    assert_eq!(
        code_lines("lib.rs", string),
        3,
        "the blank line does not count"
    );
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
