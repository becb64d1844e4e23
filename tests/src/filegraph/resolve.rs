//! The definitions that paths lead to.

use super::module::{Module, Modules};

/// One file names an item of another file or of itself.
pub(super) struct Named {
    pub(super) from: String,
    pub(super) to: String,
    pub(super) name: String,
}

/// The item that a path leads to; the rest of the path is a variant or belongs to its type.
struct Item<'a> {
    file: &'a str,
    name: String,
    /// Files whose `use` the path went through.
    through: Vec<&'a str>,
}

/// Longest chain of re-exports to follow: circles of globs end here.
const CHAIN: usize = 24;

/// All items of this crate that its files name.
pub(super) fn names(modules: &Modules) -> Vec<Named> {
    let mut found = Vec::new();
    for (index, module) in modules.all.iter().enumerate() {
        let mut add = |item: Item| {
            for file in item.through.iter().chain([&item.file]) {
                found.push(Named {
                    from: module.file.clone(),
                    to: file.to_string(),
                    name: item.name.clone(),
                });
            }
        };
        for path in &module.paths {
            if let Some(item) = modules.resolve(index, path, 0) {
                add(item);
            }
        }
        for name in module.lone.iter().filter(|name| !is_known(module, name)) {
            for glob in &module.globs {
                let path = [glob.as_slice(), std::slice::from_ref(name)].concat();
                if let Some(item) = modules.resolve(index, &path, 0) {
                    add(item);
                }
            }
        }
        for name in &module.macro_calls {
            if let Some(file) = modules.macros.get(name) {
                found.push(Named {
                    from: module.file.clone(),
                    to: file.clone(),
                    name: format!("{name}!"),
                });
            }
        }
    }
    found
}

/// True for a name that resolves without a glob.
fn is_known(module: &Module, name: &str) -> bool {
    module.items.contains(name) || module.imports.contains_key(name)
}

impl Modules {
    /// The item of this crate that a path in `module` names; `None` for a module and for items of other crates.
    fn resolve(&self, module: usize, path: &[String], depth: usize) -> Option<Item<'_>> {
        let mut start = None;
        let mut rest = path;
        while let Some((word, more)) = rest.split_first() {
            start = match word.as_str() {
                "crate" => Some(self.all[module].root),
                "self" => start.or(Some(module)),
                "super" => Some(self.all[start.unwrap_or(module)].parent?),
                _ => break,
            };
            rest = more;
        }
        if let (None, Some((word, more))) = (start, rest.split_first()) {
            // A program names the library of its own crate as other crates do.
            if *word == self.crate_name && self.library != Some(self.all[module].root) {
                return self.walk(self.library?, more, depth);
            }
        }
        self.walk(start.unwrap_or(module), rest, depth)
    }

    /// The item that a path leads to from inside a module.
    fn walk(&self, module: usize, path: &[String], depth: usize) -> Option<Item<'_>> {
        let (name, more) = path.split_first()?;
        let here = &self.all[module];
        // A module and a function may share a name; only the module has items inside.
        if let Some(child) = here.children.get(name).filter(|_| !more.is_empty())
            && let Some(item) = self.walk(*child, more, depth)
        {
            return Some(item);
        }
        if here.items.contains(name) {
            return Some(Item {
                file: &here.file,
                name: name.clone(),
                through: Vec::new(),
            });
        }
        if depth == CHAIN {
            return None;
        }
        let imported = here.imports.get(name).into_iter().flatten();
        let through_globs = here.globs.iter();
        imported
            .filter(|target| **target != [name.as_str()])
            .map(|target| [target.as_slice(), more].concat())
            .chain(through_globs.map(|glob| [glob.as_slice(), path].concat()))
            .find_map(|path| self.resolve(module, &path, depth + 1))
            .map(|mut item| {
                item.through.push(&here.file);
                item
            })
    }
}
