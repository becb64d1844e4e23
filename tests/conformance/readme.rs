//! `protocol/README.md` names the formats of files in the versions that the code writes.

use std::collections::BTreeSet;
use std::path::Path;

use harness::source::read_sources;

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
    let sources = read_sources(&root.join("coupler"));
    let written: BTreeSet<&str> = sources.values().flat_map(|text| formats(text)).collect();
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
