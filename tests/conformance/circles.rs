//! No files of a crate name each other in a circle, so each can be read after the files that it names. [`harness::filegraph`] defines the
//! rule.

use harness::filegraph::FileGraph;
use harness::source::{Sources, product_crates, read_sources};

#[test]
fn no_files_of_a_crate_name_each_other_in_a_circle() {
    let mut found = String::new();
    for (name, folder) in product_crates() {
        let graph = FileGraph::of(&name.replace('-', "_"), &read_sources(&folder));
        for circle in graph.circles() {
            found += &format!("{name}: {}", graph.describe(&circle));
        }
    }
    assert!(found.is_empty(), "\n{found}");
}

/// The graph of a crate `own` of these files.
fn graph(files: &[(&str, &str)]) -> FileGraph {
    let sources: Sources = files
        .iter()
        .map(|(file, text)| (file.to_string(), text.to_string()))
        .collect();
    FileGraph::of("own", &sources)
}

/// The circles of a crate of these files, each as its files in alphabetical order.
fn circles(files: &[(&str, &str)]) -> Vec<String> {
    let found = graph(files).circles();
    let joined = found.iter().map(|circle| {
        let files: Vec<&str> = circle.iter().map(String::as_str).collect();
        files.join(" ")
    });
    joined.collect()
}

const NONE: [&str; 0] = [];

#[test]
fn a_circle_of_two_files_is_found() {
    let a = ("a.rs", "use crate::b::B; pub struct A(B);");
    let lib = ("lib.rs", "mod a; mod b;");
    let b = "pub struct B; impl B { fn a(&self) -> crate::a::A { todo!() } }";
    assert_eq!(circles(&[lib, a, ("b.rs", b)]), ["a.rs b.rs"]);
    assert_eq!(circles(&[lib, a, ("b.rs", "pub struct B;")]), NONE);
}

#[test]
fn a_circle_of_three_files_is_found() {
    let lib = ("lib.rs", "pub mod a; mod b; mod c;");
    let a = ("a.rs", "use super::b; pub fn f() { b::f() }");
    let b = ("b.rs", "pub fn f() { crate::c::f(0..super::c::N) }");
    let c = (
        "c.rs",
        "use crate::a::{self as first}; pub const N: u32 = 3; pub fn f() { first::f() }",
    );
    let open = ("c.rs", "pub const N: u32 = 3; pub fn f() {}");
    assert_eq!(circles(&[lib, a, b, c]), ["a.rs b.rs c.rs"]);
    assert_eq!(circles(&[lib, a, b, open]), NONE);
    assert_eq!(graph(&[lib, a, b, c]).names("b.rs", "c.rs"), ["N", "f"]);
}

#[test]
fn a_parent_and_its_child_that_name_each_other_are_a_circle() {
    let lib = ("lib.rs", "mod parent;");
    let child = ("parent/child.rs", "pub fn f(_: super::P) {}");
    for parent in [
        "mod child; pub struct P; fn g() { child::f(P) }",
        "mod child; pub use child::f; pub struct P;",
        "mod child; use self::child::f as h; pub struct P;",
    ] {
        let found = circles(&[lib, ("parent.rs", parent), child]);
        assert_eq!(found, ["parent.rs parent/child.rs"], "{parent}");
    }
    assert_eq!(
        circles(&[lib, ("parent.rs", "mod child; pub struct P;"), child]),
        NONE
    );
}

#[test]
fn a_reexport_names_the_file_that_it_stands_in_and_the_one_that_it_leads_to() {
    let lib = ("lib.rs", "mod parent;");
    let parent = ("parent/mod.rs", "mod a; mod b; pub use a::f; pub use b::*;");
    let through = "use super::B; pub fn f(b: B) { B::new(b) }";
    let straight = "use super::b::B; pub fn f(b: B) { B::new(b) }";
    let with = |a| {
        [
            lib,
            parent,
            ("parent/a.rs", a),
            ("parent/b.rs", "pub struct B;"),
        ]
    };
    assert_eq!(circles(&with(through)), ["parent/a.rs parent/mod.rs"]);
    assert_eq!(circles(&with(straight)), NONE);
    let found = graph(&with(through));
    assert_eq!(found.names("parent/a.rs", "parent/b.rs"), ["B"]);
    assert_eq!(found.names("parent/a.rs", "parent/mod.rs"), ["B"]);
}

#[test]
fn a_chain_of_three_files_through_reexports_is_a_circle() {
    let lib = ("lib.rs", "mod a; mod b; mod c; pub use c::C;");
    let a = ("a.rs", "pub use super::b::B; pub struct A;");
    let b = ("b.rs", "use crate::c::{C, inner}; pub struct B(C);");
    let c = ("c.rs", "pub struct C; pub fn inner() { crate::a::B; }");
    assert_eq!(circles(&[lib, a, b, c]), ["a.rs b.rs c.rs"]);
    let open = ("c.rs", "pub struct C; pub fn inner() {}");
    assert_eq!(circles(&[lib, a, b, open]), NONE);
}

#[test]
fn variants_and_globs_lead_to_the_file_of_the_definition() {
    let lib = ("lib.rs", "mod a; mod b;");
    let b = (
        "b.rs",
        "pub enum Kind { One } pub fn call() {} pub struct Unused;",
    );
    for a in [
        "use super::b::*; fn f() { match k { Kind::One => call() } }",
        "fn f() { use crate::b::{Kind::*, call}; One; }",
    ] {
        let found = graph(&[lib, ("a.rs", a), b]);
        assert_eq!(found.names("a.rs", "b.rs"), ["Kind", "call"], "{a}");
    }
}

#[test]
fn names_in_macros_count_and_macros_are_named() {
    let lib = ("lib.rs", "#[macro_use] mod a; mod b;");
    let a = "macro_rules! add { ($x:expr) => { $crate::b::f($x) } }";
    let b = "pub fn f(x: u32) { assert_eq!(x, 1); add!(x) }";
    assert_eq!(circles(&[lib, ("a.rs", a), ("b.rs", b)]), ["a.rs b.rs"]);
}

#[test]
fn tests_comments_and_strings_do_not_count() {
    let lib = ("lib.rs", "pub mod a; mod b;");
    let a = ("a.rs", "pub struct A; fn g() { crate::b::f() }");
    for b in [
        "pub fn f() {} #[cfg(test)] mod tests { use super::super::a::A; }",
        "pub fn f() {} #[cfg(test)] fn h<S, T>(_: crate::a::A) {} fn i() {}",
        "pub struct F { #[cfg(test)] pub a: crate::a::A, b: u32 } pub fn f() {}",
        "pub fn f() {} #[cfg(test)] mod tests;",
        "//! [`crate::a::A`]\n/// crate::a::A\npub fn f() {} // crate::a::A\n/* crate::a::A */",
        "pub fn f() { let _ = \"crate::a::A\"; let _ = r#\"crate::a::A\"#; }",
    ] {
        let tests = ("b/tests.rs", "use crate::a::A;");
        assert_eq!(circles(&[lib, a, ("b.rs", b), tests]), NONE, "{b}");
    }
    let b = (
        "b.rs",
        "pub fn f() {} #[cfg(not(test))] fn h(_: crate::a::A) {}",
    );
    assert_eq!(circles(&[lib, a, b]), ["a.rs b.rs"]);
}

#[test]
fn a_program_names_the_library_by_its_name() {
    let lib = ("lib.rs", "mod a; pub use a::run;");
    let files = [
        lib,
        ("a.rs", "pub fn run() {}"),
        ("main.rs", "fn main() { own::run() }"),
    ];
    assert_eq!(graph(&files).names("main.rs", "a.rs"), ["run"]);
    assert_eq!(graph(&files).names("main.rs", "lib.rs"), ["run"]);
}

#[test]
fn modules_inside_a_file_belong_to_it() {
    let lib = (
        "lib.rs",
        "mod a { pub mod inner; pub struct A; } fn f(_: a::inner::I) {}",
    );
    let inner = ("a/inner.rs", "pub struct I(super::A);");
    assert_eq!(circles(&[lib, inner]), ["a/inner.rs lib.rs"]);
}
