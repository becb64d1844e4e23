//! The files of a crate that name each other, read from the sources.
//!
//! File A names file B when A contains the name of an item defined in B: in a `use`, in a path, in the body of a macro.
//! A path through a re-export names both the file of the re-export and the file of the definition, since a reader who follows it
//! opens both. A parent that names an item of its child (also by `pub use child::Item`) and a child that names one of its parent
//! (`super::Item`) both count; `mod child;` alone does not. Comments, strings, attributes, method calls and code that
//! `#[cfg(test)]` leaves out do not count.
//!
//! - `token`: the code as words and marks; `module`: modules with what they define, import and name;
//! - `resolve`: the file that a path leads to.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::Sources;
use module::Modules;

mod module;
mod resolve;
mod token;

/// For each file the files that it names, with the names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileGraph {
    edges: BTreeMap<String, BTreeMap<String, BTreeSet<String>>>,
}

impl FileGraph {
    /// Reads the graph from the sources of a crate; its programs may call the library `crate_name`.
    pub fn of(crate_name: &str, sources: &Sources) -> FileGraph {
        let modules = Modules::read(crate_name, sources);
        let mut graph = FileGraph::default();
        for named in resolve::names(&modules) {
            if named.from != named.to {
                let targets = graph.edges.entry(named.from).or_default();
                targets.entry(named.to).or_default().insert(named.name);
            }
        }
        graph
    }

    /// Groups of files that all lead to each other, the largest first.
    pub fn circles(&self) -> Vec<BTreeSet<String>> {
        let reached: BTreeMap<&String, BTreeSet<&String>> = self
            .edges
            .keys()
            .map(|file| (file, self.reached(file)))
            .collect();
        let mut circles: Vec<BTreeSet<String>> = Vec::new();
        for (file, targets) in &reached {
            if !targets.contains(file) || circles.iter().any(|circle| circle.contains(*file)) {
                continue;
            }
            let circle = targets.iter().filter(|target| {
                let back = reached.get(*target);
                back.is_some_and(|back| back.contains(file))
            });
            circles.push(circle.map(|file| file.to_string()).collect());
        }
        circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
        circles
    }

    /// All files that a file leads to, itself included if it is on a circle.
    fn reached(&self, file: &str) -> BTreeSet<&String> {
        let mut reached = BTreeSet::new();
        let mut waiting = vec![file];
        while let Some(file) = waiting.pop() {
            for target in self.edges.get(file).into_iter().flat_map(BTreeMap::keys) {
                if reached.insert(target) {
                    waiting.push(target);
                }
            }
        }
        reached
    }

    /// The names that connect the files of a circle, one edge per line.
    pub fn describe(&self, circle: &BTreeSet<String>) -> String {
        let mut text = format!("circle of {} files\n", circle.len());
        for file in circle {
            for (target, names) in self.edges.get(file).into_iter().flatten() {
                if circle.contains(target) {
                    let names: Vec<&str> = names.iter().map(String::as_str).collect();
                    text += &format!("  {file} -> {target}: {}\n", names.join(", "));
                }
            }
        }
        text
    }

    /// The names of items of `to` that `from` holds.
    pub fn names(&self, from: &str, to: &str) -> Vec<&str> {
        let targets = self.edges.get(from).and_then(|targets| targets.get(to));
        targets.into_iter().flatten().map(String::as_str).collect()
    }
}
