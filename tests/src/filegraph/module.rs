//! The modules of a crate, with their definitions, imports and names.

use std::collections::{BTreeMap, BTreeSet};

use super::token::{Token, tokens};
use crate::source::{Sources, file_of_module, folder_of_modules, is_root, product_code};

/// Words of a path, from left to right.
pub(super) type Path = Vec<String>;

/// A module, in its own file or inside another.
#[derive(Default)]
pub(super) struct Module {
    pub(super) file: String,
    pub(super) parent: Option<usize>,
    /// The module that `crate` stands for here.
    pub(super) root: usize,
    pub(super) children: BTreeMap<String, usize>,
    /// Names defined here.
    pub(super) items: BTreeSet<String>,
    /// Names that `use` brings in here, public or not.
    pub(super) imports: BTreeMap<String, Vec<Path>>,
    /// Paths of `use path::*`.
    pub(super) globs: Vec<Path>,
    /// Paths named here, also in `use`.
    pub(super) paths: BTreeSet<Path>,
    /// Single names that may come in through a glob.
    pub(super) lone: BTreeSet<String>,
    /// Macros called by their name alone: the order of the text puts them in scope.
    pub(super) macro_calls: BTreeSet<String>,
}

/// All modules of a crate.
pub(super) struct Modules {
    pub(super) crate_name: String,
    pub(super) all: Vec<Module>,
    /// The root of the library, if there is one.
    pub(super) library: Option<usize>,
    /// The files of `macro_rules!`, by name.
    pub(super) macros: BTreeMap<String, String>,
}

/// Words before the name of an item.
const DEFINING: [&str; 8] = [
    "fn", "struct", "enum", "trait", "type", "const", "static", "union",
];

impl Modules {
    pub(super) fn read(crate_name: &str, sources: &Sources) -> Modules {
        let mut modules = Modules {
            crate_name: crate_name.into(),
            all: Vec::new(),
            library: None,
            macros: BTreeMap::new(),
        };
        for file in sources.keys().filter(|file| is_root(file)) {
            let root = modules.all.len();
            if file == "lib.rs" {
                modules.library = Some(root);
            }
            modules.all.push(Module {
                file: file.clone(),
                root,
                ..Module::default()
            });
            modules.read_file(sources, root);
        }
        modules
    }

    fn read_file(&mut self, sources: &Sources, module: usize) {
        let file = &self.all[module].file;
        let code = tokens(&product_code(file, &sources[file]));
        let folder = folder_of_modules(file);
        let mut reader = Reader {
            modules: self,
            sources,
            module,
            folder,
        };
        reader.read(&code, true);
    }

    fn add_child(&mut self, parent: usize, name: &str, file: String) -> usize {
        let child = self.all.len();
        self.all.push(Module {
            file,
            parent: Some(parent),
            root: self.all[parent].root,
            ..Module::default()
        });
        self.all[parent].children.insert(name.into(), child);
        child
    }
}

/// Reads the tokens of one module.
struct Reader<'a> {
    modules: &'a mut Modules,
    sources: &'a Sources,
    module: usize,
    /// Folder of its children's files.
    folder: String,
}

impl Reader<'_> {
    fn here(&mut self) -> &mut Module {
        &mut self.modules.all[self.module]
    }

    /// Reads tokens; items count only `at_top`, since the items in the body of a function are local.
    fn read(&mut self, code: &[Token], at_top: bool) {
        let mut at = 0;
        while at < code.len() {
            at += match &code[at..] {
                [Token::Word(word), Token::Word(name), body, ..] if word == "mod" => {
                    self.child(name, body);
                    3
                }
                [Token::Word(word), next, ..] if word == "use" && *next != Token::Mark('<') => {
                    1 + self.use_tree(&code[at + 1..], &[])
                }
                [Token::Word(word), Token::Mark('!'), Token::Word(name), ..]
                    if word == "macro_rules" =>
                {
                    let file = self.here().file.clone();
                    self.modules.macros.insert(name.clone(), file);
                    self.here().items.insert(name.clone());
                    3
                }
                [Token::Word(word), rest @ ..]
                    if defines(word, at_top) && defined(rest).is_some() =>
                {
                    let (name, length) = defined(rest).expect("it was just found");
                    self.here().items.insert(name.into());
                    1 + length
                }
                [Token::Word(_), ..] => self.path(code, at),
                [Token::Group { inside, .. }, ..] => {
                    self.read(inside, false);
                    1
                }
                _ => 1,
            };
        }
    }

    /// `mod name;` or `mod name { .. }`.
    fn child(&mut self, name: &str, body: &Token) {
        if let Token::Group { inside, .. } = body {
            let file = self.here().file.clone();
            let child = self.modules.add_child(self.module, name, file);
            let mut reader = Reader {
                modules: &mut *self.modules,
                sources: self.sources,
                module: child,
                folder: format!("{}{name}/", self.folder),
            };
            reader.read(inside, true);
        } else if let Some(file) = file_of_module(self.sources, &self.folder, name) {
            let child = self.modules.add_child(self.module, name, file);
            self.modules.read_file(self.sources, child);
        }
    }

    /// One tree of a `use` below `prefix`; returns the tokens that it takes.
    fn use_tree(&mut self, code: &[Token], prefix: &[String]) -> usize {
        let mut path = prefix.to_vec();
        let mut at = 0;
        while let Some(token) = code.get(at) {
            at += 1;
            match token {
                Token::PathMark => {}
                Token::Word(word) => {
                    path.push(word.clone());
                    if code.get(at) != Some(&Token::PathMark) {
                        return at + self.import(path, &code[at..]);
                    }
                }
                Token::Mark('*') => {
                    self.here().paths.insert(path.clone());
                    self.here().globs.push(path);
                    break;
                }
                Token::Group { inside, .. } => {
                    for tree in inside.split(|token| *token == Token::Mark(',')) {
                        self.use_tree(tree, &path);
                    }
                    break;
                }
                Token::Mark(_) => break,
            }
        }
        at
    }

    /// A name that `use` brings in, with its `as`; returns the tokens that this takes.
    fn import(&mut self, mut path: Path, rest: &[Token]) -> usize {
        if path.len() > 1 && path.last().is_some_and(|word| word == "self") {
            path.pop();
        }
        let (name, length) = match rest {
            [Token::Word(word), Token::Word(name), ..] if word == "as" => (name.clone(), 2),
            _ => (path.last().expect("it has a word").clone(), 0),
        };
        let here = self.here();
        here.paths.insert(path.clone());
        here.imports.entry(name).or_default().push(path);
        length
    }

    /// A path or a single name in code; returns the tokens that it takes.
    fn path(&mut self, code: &[Token], start: usize) -> usize {
        let mut path = Vec::new();
        let mut at = start;
        while let Some(Token::Word(word)) = code.get(at) {
            path.push(word.clone());
            at += 1;
            if code.get(at) != Some(&Token::PathMark) {
                break;
            }
            if let Some(Token::Word(_)) = code.get(at + 1) {
                at += 1;
            }
        }
        let before = |back: usize| start.checked_sub(back).map(|at| &code[at]);
        let is_member =
            before(1) == Some(&Token::Mark('.')) && before(2) != Some(&Token::Mark('.'));
        if !is_member && before(1) != Some(&Token::PathMark) {
            let next = code.get(at);
            self.name(path, next);
        }
        at - start
    }

    fn name(&mut self, path: Path, next: Option<&Token>) {
        let here = self.here();
        if path.len() > 1 {
            here.paths.insert(path);
            return;
        }
        let name = path.into_iter().next().expect("it has a word");
        let is_called = matches!(next, Some(Token::Group { brace: false, .. }));
        if next == Some(&Token::Mark('!')) {
            here.macro_calls.insert(name);
        } else if is_called || name.starts_with(char::is_uppercase) {
            // Lower-case names count only when called: most others are variables.
            here.lone.insert(name);
        }
    }
}

/// True where an item's name may follow: items of a module, and statics inside `thread_local!`.
fn defines(word: &str, at_top: bool) -> bool {
    (at_top && DEFINING.contains(&word)) || word == "static"
}

/// The name of the item behind its defining word, and the number of tokens up to and including it.
fn defined(rest: &[Token]) -> Option<(&str, usize)> {
    let skipped = usize::from(rest.first().is_some_and(|token| token.is("mut")));
    let name = rest.get(skipped)?.word()?;
    let is_name = !["fn", "unsafe", "extern", "async", "_"].contains(&name);
    is_name.then_some((name, skipped + 1))
}
