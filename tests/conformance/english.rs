//! Words that stand for sentences nobody would say are counted in all sources and pages; their number only falls.

use std::path::{Path, PathBuf};

/// Most of these words by the ending of a file, equal to the number that is there: lower it with each change that makes it less.
const WORDS: [(&str, usize); 4] = [("rs", 29), ("md", 3), ("py", 0), ("toml", 4)];

/// Number of words and phrases of the habit in a text. A phrase at the end of a clause is followed by a mark.
fn habits(text: &str) -> usize {
    // Python's `is None` is no phrase.
    let plain = text.replace("is None", "").to_lowercase();
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let alone = |at: usize, length: usize| {
        let before = plain[..at].chars().next_back();
        let after = plain[at + length..].chars().next();
        !before.is_some_and(is_word) && !after.is_some_and(is_word)
    };
    let words = [
        "tell", "tells", "told", "is none", "are none", "that of", "those of", "whatever",
        "so many", "somebody",
    ];
    let counts = words.map(|word| {
        let found = plain.match_indices(word);
        found.filter(|(at, word)| alone(*at, word.len())).count()
    });
    let ends = [" of it.", " of it,", " of it;", " of it:"].map(|end| plain.matches(end).count());
    counts.iter().chain(&ends).sum()
}

/// All files below a folder but hidden ones, what is built, and runs.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("it is there").flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        let name = name.to_string_lossy();
        let made =
            name.starts_with('.') || ["target", "runs", "__pycache__", "build"].contains(&&*name);
        match path.is_dir() {
            _ if made => {}
            true => files(&path, found),
            false => found.push(path),
        }
    }
}

#[test]
fn words_of_our_dialect_only_become_fewer() {
    let mut all = Vec::new();
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."), &mut all);
    let counts = WORDS.map(|(ending, _)| {
        let of = |path: &&PathBuf| {
            // This file names the words.
            path.extension().is_some_and(|own| own == ending) && !path.ends_with("english.rs")
        };
        let text = |path: &PathBuf| std::fs::read_to_string(path).unwrap_or_default();
        let count = all.iter().filter(of).map(|path| habits(&text(path))).sum();
        (ending, count)
    });
    assert_eq!(counts, WORDS, "write plain English, or lower the numbers");
}

#[test]
fn habits_are_words_and_not_parts_of_words() {
    assert_eq!(habits("It tells. Told, a teller foretold; retell"), 2);
    assert_eq!(habits("that of the rail, those of it, so many"), 4);
    assert_eq!(habits("whatever is none of your concern"), 2);
}
