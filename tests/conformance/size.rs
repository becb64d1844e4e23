//! The crates stay small enough to be read: at most 31 500 lines of code for what they did when the schemes became pure
//! algorithms, and an allowance for each feature since. A line counts that holds code of the product:
//! not blank, no comment or documentation, no code that `#[cfg(test)]` marks, and in no file of a module `tests`.

use harness::source::{Sources, code_lines, crate_lines, product_crates, read_sources};

/// Lines of code of all crates together at that time.
const REDESIGN: usize = 31_500;

/// Features since, with the lines that they may take.
const SINCE: [(&str, usize); 45] = [
    ("checks of plausibility", 1020),
    ("strict logs", 420),
    ("limits of disk, files and words", 240),
    ("honest ledgers", 320),
    ("references of suites", 40),
    ("turns of messages and the fault campaign", 2100),
    ("cures of errors of the system", 30),
    ("what participants say is checked, and ends with them", 430),
    ("nothing is asked for that was not offered", 250),
    ("rules of conformance", 1570),
    (
        "participants to begin with, and the time of their answers",
        280,
    ),
    ("time by who was at work, and the cost foretold", 350),
    ("waiting beside a busy neighbour", 110),
    (
        "repeats of what a change can reach, pieces of columns",
        1790,
    ),
    ("sweeps of bonded layers, banded boundaries", 100),
    (
        "vectors in registers, one pass over the nodes of a row",
        420,
    ),
    ("threads that stand by", 90),
    ("sweeps that creep, flee and circle", 140),
    ("driven clusters, disks by the rectangle and the row", 560),
    ("laws by pair", 260),
    ("profiles", 340),
    ("contacts by pivoting", 560),
    (
        "initial velocities, probes, reactions, plastic elements, static increments",
        620,
    ),
    ("loads over time, accepted steps, benchmarks", 320),
    ("forces of sets over time, momentum of free bodies", 120),
    ("interfaces that repeat along x", 210),
    (
        "rails of grains, radii by any power, grains from a file",
        530,
    ),
    ("prepared samples that are kept", 260),
    ("stress in cells, flows of third body", 820),
    ("wheels of disks", 170),
    ("sweeps over contacts and failing bonds on all threads", 440),
    ("stress and velocities of grains in the report", 220),
    (
        "repeats on all threads, vectors of 512 bits, aligned fields",
        660,
    ),
    (
        "fields within phases, displacement fields, the tribological circuit",
        320,
    ),
    (
        "contacts of glued disks and bonds are counted into order",
        30,
    ),
    (
        "grains that are fed in, fields of runs without phases, adhesion",
        480,
    ),
    ("a run beside another one, checkpoints by the clock", 500),
    (
        "studies here and on a cluster, budgets, perturbed starts, the cost of pieces",
        4010,
    ),
    (
        "scenes inside the program, live progress, completions and manual pages",
        760,
    ),
    ("codes of errors with cause and cure, keys as a schema", 980),
    ("a player of fields in a page", 1_720),
    (
        "fields as raw bytes, of contacts and interfaces, all in one collection",
        850,
    ),
    ("a report with a verdict, units, scales, comparison", 2_100),
    ("wall-clock times of requests, traces of them", 690),
    ("elastic forces of plastic bodies that do not yield", 560),
];

#[test]
fn the_crates_have_no_more_lines_than_the_limit() {
    let counts: Vec<(String, usize)> = product_crates()
        .into_iter()
        .map(|(name, folder)| (name, crate_lines(&read_sources(&folder))))
        .collect();
    let total: usize = counts.iter().map(|(_, lines)| lines).sum();
    println!("{total} lines of code: {counts:?}");
    let limit = REDESIGN + SINCE.iter().map(|(_, lines)| lines).sum::<usize>();
    assert!(
        total <= limit,
        "{total} lines, more than {limit}: {counts:?}"
    );
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
