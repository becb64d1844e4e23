//! Pages that tell of the code: `protocol/README.md` names the formats of files in the versions that the code writes,
//! `coupler/ERRORS.md` has an entry for each code of an error or a warning.

use std::collections::BTreeSet;
use std::path::Path;

use harness::source::{Sources, product_code, product_crates, read_sources};
use proc_macro2::{Delimiter, TokenTree};
use scenario::error::{Code, Explanation, explanation, explanations};

/// Names of formats with their versions, `thirdbody.<format>/<version>`, in a text.
fn formats(text: &str) -> BTreeSet<&str> {
    let parts = text.match_indices("thirdbody.").map(|(at, _)| &text[at..]);
    let names = parts.map(|part| {
        let of_name = |c: char| c.is_ascii_alphanumeric() || "./_".contains(c);
        &part[..part.find(|c| !of_name(c)).unwrap_or(part.len())]
    });
    names.filter(|name| name.contains('/')).collect()
}

#[test]
fn the_versions_of_formats_are_those_that_the_code_writes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let crates = product_crates().into_iter();
    let sources: Vec<Sources> = crates.map(|(_, folder)| read_sources(&folder)).collect();
    let texts = sources.iter().flat_map(|sources| sources.values());
    let written: BTreeSet<&str> = texts.flat_map(|text| formats(text)).collect();
    let readme = std::fs::read_to_string(root.join("protocol/README.md")).expect("it is text");
    let named = formats(&readme);
    assert!(
        named.len() >= 2,
        "the log's and the checkpoint's: {named:?}"
    );
    assert!(
        named.is_subset(&written),
        "{named:?} are named, {written:?} are written"
    );
}

/// Calls whose first text is the code of a warning.
const MAKERS: [&str; 3] = ["judge", "advice", "lost"];

/// Codes in the calls of a piece of code.
fn codes(tokens: &[TokenTree], found: &mut BTreeSet<String>) {
    for (place, token) in tokens.iter().enumerate() {
        let TokenTree::Group(group) = token else {
            continue;
        };
        let inside: Vec<TokenTree> = group.stream().into_iter().collect();
        let before = place
            .checked_sub(1)
            .map(|before| tokens[before].to_string());
        let is_call = group.delimiter() == Delimiter::Parenthesis
            && before
                .as_ref()
                .is_some_and(|name| MAKERS.contains(&name.as_str()));
        if is_call {
            found.extend(first_text(&inside));
        }
        // Of the macro the bounds come first, and the code is the first text.
        let is_macro = before.is_some_and(|mark| mark == "!")
            && place
                .checked_sub(2)
                .is_some_and(|name| tokens[name].to_string() == "judge");
        if is_macro {
            found.extend(inside.chunks(1).find_map(first_text));
        }
        codes(&inside, found);
    }
}

/// The text that arguments begin with, alone or at the head of a tuple.
fn first_text(arguments: &[TokenTree]) -> Option<String> {
    match arguments.first()? {
        TokenTree::Group(tuple) => {
            let inside: Vec<TokenTree> = tuple.stream().into_iter().collect();
            first_text(&inside)
        }
        first => {
            let text = first.to_string();
            let text = text.strip_prefix('"')?.strip_suffix('"')?;
            let is_word = text.chars().all(|c| c.is_ascii_lowercase() || c == '_');
            is_word.then(|| text.to_string())
        }
    }
}

#[test]
fn each_warning_of_the_code_has_an_entry_and_each_entry_a_warning() {
    let mut written = BTreeSet::new();
    for (_, folder) in product_crates() {
        for (file, text) in read_sources(&folder) {
            // Files of tests alone are known by their names.
            if !file.ends_with("tests.rs") {
                codes(&product_code(&file, &text), &mut written);
            }
        }
    }
    let told = explanations().filter(|explanation| exit_code(explanation).is_none());
    let told: BTreeSet<String> = told
        .map(|explanation| explanation.code.to_string())
        .collect();
    assert!(written.len() > 20, "{written:?}");
    assert_eq!(written, told);
}

#[test]
fn each_code_of_an_error_has_one_entry_with_its_exit_code() {
    let told: Vec<Explanation> = explanations().collect();
    let names: BTreeSet<&str> = told.iter().map(|explanation| explanation.code).collect();
    assert_eq!(names.len(), told.len(), "a code is there twice");
    let codes: BTreeSet<&str> = Code::all().map(Code::word).collect();
    assert_eq!(codes.len(), Code::all().count(), "a word means two codes");
    for code in Code::all() {
        let explanation =
            explanation(code.word()).unwrap_or_else(|| panic!("no entry {}", code.word()));
        assert_eq!(
            exit_code(&explanation),
            Some(code.exit_code()),
            "{}",
            code.word()
        );
    }
    let of_errors = told
        .iter()
        .filter(|explanation| exit_code(explanation).is_some());
    let of_errors: BTreeSet<&str> = of_errors.map(|explanation| explanation.code).collect();
    assert_eq!(of_errors, codes);
}

#[test]
fn each_entry_says_why_and_what_to_do() {
    for explanation in explanations() {
        let code = explanation.code;
        assert!(
            explanation.line().len() > 10,
            "{code}: {}",
            explanation.line()
        );
        let first = explanation.text.lines().next().unwrap_or_default();
        assert_ne!(
            first.ends_with("A warning."),
            exit_code(&explanation).is_some(),
            "{code}"
        );
        for part in ["\n- Why: ", "\n- Do: "] {
            assert_eq!(
                explanation.text.matches(part).count(),
                1,
                "{code} has no `{part}`"
            );
        }
    }
}

/// The exit code that an entry tells; none for a warning.
fn exit_code(explanation: &Explanation) -> Option<i32> {
    let first = explanation.text.lines().next()?;
    let (_, told) = first.split_once(" Exit code ")?;
    let digits: String = told.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().ok()
}

/// Longest glossary (words).
const GLOSSARY: usize = 60;

#[test]
fn the_glossary_is_short_and_says_each_word_once() {
    let page = include_str!("../../protocol/README.md");
    let (_, glossary) = page.split_once("## Glossary\n").expect("there is one");
    let glossary = glossary.split("\n## ").next().unwrap_or(glossary);
    let rows = glossary.lines().filter(|line| line.starts_with("| *"));
    let mut words: Vec<&str> = rows.filter_map(|row| row.split('*').nth(1)).collect();
    let all = words.len();
    assert!((20..=GLOSSARY).contains(&all), "{all} words");
    words.sort_unstable();
    words.dedup();
    assert_eq!(words.len(), all, "a word stands there twice");
}
