//! One name, one thing: no public type of the product has the name of another one, in whichever crates they are. The words of the
//! product are in the glossary of `protocol/README.md`.

use std::collections::BTreeMap;

use harness::source::{Sources, product_code, product_crates, read_sources};
use proc_macro2::{Delimiter, TokenTree};

const DEFINING: [&str; 5] = ["struct", "enum", "trait", "type", "union"];

/// Longest glossary (words).
const GLOSSARY: usize = 60;

#[test]
fn no_public_type_has_the_name_of_another_one() {
    let mut homes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (name, folder) in product_crates() {
        for (file, defined) in public_types(&read_sources(&folder)) {
            homes
                .entry(defined)
                .or_default()
                .push(format!("{name}/src/{file}"));
        }
    }
    let twice: Vec<String> = homes
        .iter()
        .filter(|(_, files)| files.len() > 1)
        .map(|(name, files)| format!("{name}: {}", files.join(", ")))
        .collect();
    assert!(twice.is_empty(), "\n{}", twice.join("\n"));
}

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

/// File and name of each public type, aliases included.
fn public_types(sources: &Sources) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let files = sources
        .iter()
        .filter(|(file, _)| !file.ends_with("tests.rs") && !file.contains("tests/"));
    for (file, text) in files {
        let mut names = Vec::new();
        types_of(&product_code(file, text), &mut names);
        found.extend(names.into_iter().map(|name| (file.clone(), name)));
    }
    found
}

/// Names behind `pub struct` and its kin, in modules inside the file too; what is public inside its crate only, or in an `impl`, does
/// not count.
fn types_of(code: &[TokenTree], names: &mut Vec<String>) {
    let mut public = false;
    let mut module = false;
    let mut tokens = code.iter().peekable();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Ident(word) if word == "pub" => {
                let inside = |next: &TokenTree| matches!(next, TokenTree::Group(group) if group.delimiter() == Delimiter::Parenthesis);
                public = !tokens.peek().is_some_and(|next| inside(next));
            }
            TokenTree::Ident(word) if word == "mod" => module = true,
            TokenTree::Ident(word) if public && DEFINING.contains(&word.to_string().as_str()) => {
                if let Some(TokenTree::Ident(name)) = tokens.peek() {
                    names.push(name.to_string());
                }
                public = false;
            }
            TokenTree::Ident(word) if word == "fn" || word == "use" || word == "const" => {
                public = false;
            }
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                if module {
                    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
                    types_of(&inside, names);
                }
                (public, module) = (false, false);
            }
            _ => {}
        }
    }
}

#[test]
fn names_of_public_types_are_found() {
    let sources = Sources::from([
        (
            "a.rs".into(),
            "pub struct Row; mod b { pub enum Row { A } pub(super) enum Own { A } }".into(),
        ),
        (
            "c.rs".into(),
            "struct Own; pub fn f() {} impl T for Own { type Row = u8; }".into(),
        ),
        ("c/tests.rs".into(), "pub struct Row;".into()),
    ]);
    let names: Vec<String> = public_types(&sources)
        .into_iter()
        .map(|(_, name)| name)
        .collect();
    assert_eq!(names, ["Row", "Row"]);
}
