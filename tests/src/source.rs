//! The code of a crate as tokens, without comments and without code that `#[cfg(test)]` leaves out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// Texts by the path of their file below `src`, with `/` between folders.
pub type Sources = BTreeMap<String, String>;

/// Names and folders of the crates of the product, from the lowest up.
pub fn product_crates() -> Vec<(String, PathBuf)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).expect("it is there");
    let manifest: toml::Table = manifest.parse().expect("it is TOML");
    let members = manifest["workspace"]["members"].as_array().expect("a list");
    let folders = members.iter().filter_map(|member| member.as_str());
    let product = folders.filter(|folder| !folder.starts_with("tests"));
    product
        .map(|folder| (name_of_crate(&root.join(folder)), root.join(folder)))
        .collect()
}

/// The name in the manifest of a crate.
fn name_of_crate(folder: &Path) -> String {
    let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).expect("it is there");
    let manifest: toml::Table = manifest.parse().expect("it is TOML");
    let name = manifest["package"]["name"].as_str().expect("a name");
    name.to_string()
}

/// All Rust files below `crate_folder/src`.
pub fn read_sources(crate_folder: &Path) -> Sources {
    let mut sources = Sources::new();
    let top = crate_folder.join("src");
    let mut folders = vec![top.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("it is there").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let name = path.strip_prefix(&top).expect("it is below");
                let text = std::fs::read_to_string(&path).expect("it is text");
                sources.insert(name.to_string_lossy().replace('\\', "/"), text);
            }
        }
    }
    sources
}

/// True for a file from which a crate is compiled: the library, the program, programs in `bin`.
pub fn is_root(file: &str) -> bool {
    matches!(file, "lib.rs" | "main.rs") || file.starts_with("bin/")
}

/// The file of the module `name` that a module of `folder` declares.
pub fn file_of_module(sources: &Sources, folder: &str, name: &str) -> Option<String> {
    [
        format!("{folder}{name}.rs"),
        format!("{folder}{name}/mod.rs"),
    ]
    .into_iter()
    .find(|file| sources.contains_key(file))
}

/// The folder, with a `/` at its end, in which the modules that `file` declares have their files.
pub fn folder_of_modules(file: &str) -> String {
    let (folder, name) = match file.rsplit_once('/') {
        Some((folder, name)) => (format!("{folder}/"), name),
        None => (String::new(), file),
    };
    if is_root(file) || name == "mod.rs" {
        folder
    } else {
        format!("{folder}{}/", name.trim_end_matches(".rs"))
    }
}

/// The tokens of a text without comments, documentation, and items, fields and statements that `#[cfg(test)]` or `#[test]` marks.
pub fn product_code(file: &str, text: &str) -> Vec<TokenTree> {
    let stream: TokenStream = text
        .parse()
        .unwrap_or_else(|error| panic!("{file} is no Rust: {error}"));
    without_tests(stream)
}

/// Lines of a text that hold product code: not blank, no comment, no test.
pub fn code_lines(file: &str, text: &str) -> usize {
    let mut covered = BTreeSet::new();
    cover(&product_code(file, text), &mut covered);
    let lines = text.lines().enumerate();
    lines
        .filter(|(index, line)| covered.contains(&(index + 1)) && !line.trim().is_empty())
        .count()
}

/// Lines of product code of a crate. Files of the modules `tests` are left out; a file with another name counts, even if only tests
/// use it.
pub fn crate_lines(sources: &Sources) -> usize {
    let files = sources.iter().filter(|(file, _)| !is_of_tests(file));
    files.map(|(file, text)| code_lines(file, text)).sum()
}

/// True for a file of a module `tests`, or of one below it.
fn is_of_tests(file: &str) -> bool {
    let mut names = file.split('/');
    names.any(|name| name == "tests.rs" || name == "tests")
}

/// Collects the numbers of all lines that tokens stand on.
fn cover(tokens: &[TokenTree], covered: &mut BTreeSet<usize>) {
    for token in tokens {
        if let TokenTree::Group(group) = token {
            covered.insert(group.span_open().start().line);
            covered.insert(group.span_close().end().line);
            let inside: Vec<TokenTree> = group.stream().into_iter().collect();
            cover(&inside, covered);
        } else {
            let span = token.span();
            covered.extend(span.start().line..=span.end().line);
        }
    }
}

fn without_tests(stream: TokenStream) -> Vec<TokenTree> {
    let tokens: Vec<TokenTree> = stream.into_iter().collect();
    let mut kept = Vec::with_capacity(tokens.len());
    let mut at = 0;
    while at < tokens.len() {
        match attribute(&tokens[at..]) {
            Some(found) if found.is_test => at = end_of_marked(&tokens, at + found.length),
            Some(found) if found.is_doc => at += found.length,
            Some(found) => {
                kept.extend_from_slice(&tokens[at..at + found.length]);
                at += found.length;
            }
            None => {
                kept.push(inside_without_tests(&tokens[at]));
                at += 1;
            }
        }
    }
    kept
}

fn inside_without_tests(token: &TokenTree) -> TokenTree {
    let TokenTree::Group(group) = token else {
        return token.clone();
    };
    let inside = without_tests(group.stream()).into_iter().collect();
    let mut stripped = Group::new(group.delimiter(), inside);
    stripped.set_span(group.span());
    TokenTree::Group(stripped)
}

/// An attribute at the beginning of some tokens.
pub(crate) struct Attribute {
    /// Tokens that it takes.
    pub(crate) length: usize,
    is_test: bool,
    is_doc: bool,
}

/// The attribute that tokens begin with, `#[..]` or `#![..]`.
pub(crate) fn attribute(tokens: &[TokenTree]) -> Option<Attribute> {
    if !is_mark(tokens.first()?, '#') {
        return None;
    }
    let length = if is_mark(tokens.get(1)?, '!') { 3 } else { 2 };
    let TokenTree::Group(group) = tokens.get(length - 1)? else {
        return None;
    };
    if group.delimiter() != Delimiter::Bracket {
        return None;
    }
    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
    let name = inside.first()?.to_string();
    Some(Attribute {
        length,
        is_test: name == "test" || (name == "cfg" && inside.get(1).is_some_and(asks_for_test)),
        is_doc: name == "doc" && inside.get(1).is_some_and(|mark| is_mark(mark, '=')),
    })
}

/// `(test)` and `(all(test, ..))`.
fn asks_for_test(condition: &TokenTree) -> bool {
    let TokenTree::Group(group) = condition else {
        return false;
    };
    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
    match inside.as_slice() {
        [only] => only.to_string() == "test",
        [all, TokenTree::Group(parts)] if all.to_string() == "all" => parts
            .stream()
            .into_iter()
            .any(|part| part.to_string() == "test"),
        _ => false,
    }
}

/// The index behind the code that an attribute marks, which ends at `at`: an item ends with its `;` or its braces, a field,
/// variant or statement also with its `,`.
fn end_of_marked(tokens: &[TokenTree], mut at: usize) -> usize {
    while let Some(next) = tokens.get(at..).and_then(attribute) {
        at += next.length;
    }
    let is_item = begins_item(&tokens[at..]);
    while let Some(token) = tokens.get(at) {
        at += 1;
        let ends = match token {
            TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
            _ => is_mark(token, ';') || (is_mark(token, ',') && !is_item),
        };
        if ends {
            break;
        }
    }
    at
}

const ITEM_WORDS: [&str; 15] = [
    "fn",
    "mod",
    "struct",
    "enum",
    "impl",
    "trait",
    "use",
    "const",
    "static",
    "type",
    "union",
    "macro_rules",
    "unsafe",
    "async",
    "extern",
];

fn begins_item(tokens: &[TokenTree]) -> bool {
    let mut words = tokens.iter().filter_map(|token| match token {
        TokenTree::Ident(word) if word != "pub" => Some(Some(word.to_string())),
        TokenTree::Ident(_) => None,
        TokenTree::Group(group) if group.delimiter() == Delimiter::Parenthesis => None,
        _ => Some(None),
    });
    matches!(words.next(), Some(Some(word)) if ITEM_WORDS.contains(&word.as_str()))
}

/// True for this punctuation mark.
pub(crate) fn is_mark(token: &TokenTree, mark: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == mark)
}
