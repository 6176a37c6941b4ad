//! Which files of a crate use which: a small parser of modules, imports and paths.
//!
//! File A uses file B if A's code contains a name that B defines: in an import, or in a path that
//! begins with `crate`, `super`, `self`, a child module or an imported name. Names are followed
//! through re-exports and globs to the file that defines them. Not counted are: the declaration of
//! a module, a re-export whose name the file does not use otherwise, test code (`#[test]`,
//! `#[cfg(test)]`), comments and strings. Methods and fields are not followed: code that calls a
//! method on a value usually also names the value's type.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// Files that use others, with the names they use: `(from, to) -> names`.
pub(crate) type Uses = BTreeMap<(String, String), BTreeSet<String>>;

/// The uses between the files of the crate with this root; `texts` contains its files by path.
pub(crate) fn uses(root: &str, texts: &BTreeMap<String, String>) -> Uses {
    let mut reader = Reader { texts, modules: Vec::new() };
    reader.modules.push(Module::new(root, None));
    let folder = root.rsplit_once('/').map_or("", |(folder, _)| folder);
    reader.file(root, 0, folder);
    Crate(reader.modules).uses()
}

/// A module: a file, or an inline one within a file.
struct Module {
    file: String,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    /// Names that it defines.
    items: BTreeSet<String>,
    imports: Vec<Import>,
    /// Paths in its code outside imports.
    paths: Vec<Vec<String>>,
}

/// One name of a `use` declaration, or all names of a module.
struct Import {
    path: Vec<String>,
    /// Name under which the path is imported; `None` for `*`.
    name: Option<String>,
    exported: bool,
}

impl Module {
    fn new(file: &str, parent: Option<usize>) -> Self {
        Self {
            file: file.to_owned(),
            parent,
            children: BTreeMap::new(),
            items: BTreeSet::new(),
            imports: Vec::new(),
            paths: Vec::new(),
        }
    }
}

/// Words that begin an item which ends with `;` or a block, not with a comma.
const ITEMS: &[&str] = &[
    "async",
    "const",
    "enum",
    "extern",
    "fn",
    "impl",
    "macro_rules",
    "mod",
    "static",
    "struct",
    "trait",
    "type",
    "union",
    "unsafe",
    "use",
];
/// Words that precede a name that is being defined.
const DEFINE: &[&str] = &[
    "const",
    "enum",
    "fn",
    "let",
    "macro_rules",
    "mod",
    "mut",
    "static",
    "struct",
    "trait",
    "type",
    "union",
];

fn word(token: Option<&TokenTree>) -> Option<String> {
    match token {
        Some(TokenTree::Ident(word)) => Some(word.to_string()),
        _ => None,
    }
}

fn is_word(token: Option<&TokenTree>, among: &[&str]) -> bool {
    word(token).is_some_and(|word| among.contains(&word.as_str()))
}

fn is_sign(token: Option<&TokenTree>, sign: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == sign)
}

fn group(token: Option<&TokenTree>, delimiter: Delimiter) -> Option<Vec<TokenTree>> {
    match token {
        Some(TokenTree::Group(group)) if group.delimiter() == delimiter => {
            Some(group.stream().into_iter().collect())
        }
        _ => None,
    }
}

/// Whether these are the tokens of an attribute for tests: `test`, `cfg(test)`, `cfg(all(test,
/// ..))`.
fn is_for_tests(attribute: &[TokenTree]) -> bool {
    let inside = || group(attribute.get(1), Delimiter::Parenthesis).unwrap_or_default();
    match word(attribute.first()).as_deref() {
        Some("test") => attribute.len() == 1 || !is_sign(attribute.get(1), ':'),
        Some("cfg" | "all") => {
            let all = inside();
            all.split(|token| is_sign(Some(token), ',')).any(is_for_tests)
        }
        _ => false,
    }
}

/// Reads the files of a crate, starting at its root.
struct Reader<'a> {
    texts: &'a BTreeMap<String, String>,
    modules: Vec<Module>,
}

impl Reader<'_> {
    /// Reads a file; `folder` contains the files of its child modules.
    fn file(&mut self, path: &str, module: usize, folder: &str) {
        let text = self.texts.get(path).unwrap_or_else(|| panic!("no file {path}"));
        let tokens: TokenStream = text.parse().unwrap_or_else(|why| panic!("{path}: {why}"));
        self.tokens(&Vec::from_iter(tokens), module, folder, true);
    }

    /// Reads tokens of a module; `top` is false inside a body, a list or a macro.
    fn tokens(&mut self, tokens: &[TokenTree], module: usize, folder: &str, top: bool) {
        let (mut at, mut for_tests, mut exported) = (0, false, false);
        while at < tokens.len() {
            let inner = usize::from(is_sign(tokens.get(at + 1), '!'));
            if is_sign(tokens.get(at), '#')
                && let Some(attribute) = group(tokens.get(at + 1 + inner), Delimiter::Bracket)
            {
                for_tests |= inner == 0 && is_for_tests(&attribute);
                at += 2 + inner;
                continue;
            }
            if for_tests {
                at = end_of_item(tokens, at);
                for_tests = false;
                continue;
            }
            if is_word(tokens.get(at), &["pub"]) {
                exported = true;
                at += 1 + usize::from(group(tokens.get(at + 1), Delimiter::Parenthesis).is_some());
                continue;
            }
            if is_word(tokens.get(at), &["use"]) {
                let length = tokens[at..].iter().position(|token| is_sign(Some(token), ';'));
                let end = length.map_or(tokens.len(), |length| at + length);
                self.import(&tokens[at + 1..end], module, &[], exported);
                exported = false;
                at = end + 1;
                continue;
            }
            if top && is_word(tokens.get(at), &["mod"]) && word(tokens.get(at + 1)).is_some() {
                self.child(&tokens[at + 1..], module, folder);
                exported = false;
                at += 3;
                continue;
            }
            if top && is_word(tokens.get(at), DEFINE) {
                // `macro_rules! name`, `const fn name`.
                let name = at + 1 + usize::from(is_sign(tokens.get(at + 1), '!'));
                if let Some(name) = word(tokens.get(name)) {
                    self.modules[module].items.insert(name);
                }
            }
            if let Some(TokenTree::Group(group)) = tokens.get(at) {
                self.tokens(&Vec::from_iter(group.stream()), module, folder, false);
                exported = false;
            }
            if let Some(path) = path_at(tokens, at) {
                self.modules[module].paths.push(path);
            }
            at += 1;
        }
    }

    /// Reads a child module, starting at its name.
    fn child(&mut self, tokens: &[TokenTree], parent: usize, folder: &str) {
        let name = word(tokens.first()).unwrap_or_default();
        let within = format!("{folder}/{name}");
        let child = self.modules.len();
        self.modules[parent].children.insert(name, child);
        if let Some(tokens) = group(tokens.get(1), Delimiter::Brace) {
            let file = self.modules[parent].file.clone();
            self.modules.push(Module::new(&file, Some(parent)));
            self.tokens(&tokens, child, &within, true);
            return;
        }
        let beside = [format!("{within}.rs"), format!("{within}/mod.rs")];
        let file = beside.iter().find(|file| self.texts.contains_key(*file));
        let file = file.unwrap_or_else(|| panic!("no file for module {within}"));
        self.modules.push(Module::new(file, Some(parent)));
        self.file(file, child, &within);
    }

    /// Reads a tree of imports below `prefix`.
    fn import(&mut self, tree: &[TokenTree], module: usize, prefix: &[String], exported: bool) {
        for part in tree.split(|token| is_sign(Some(token), ',')) {
            let mut path = prefix.to_vec();
            let mut name = None;
            let mut whole = !part.is_empty();
            let mut at = 0;
            while let Some(token) = part.get(at) {
                if is_word(Some(token), &["as"]) {
                    name = word(part.get(at + 1));
                    at += 1;
                } else if let Some(segment) = word(Some(token)) {
                    path.push(segment);
                } else if let Some(inside) = group(Some(token), Delimiter::Brace) {
                    self.import(&inside, module, &path, exported);
                    whole = false;
                } else if is_sign(Some(token), '*') {
                    let import = Import { path: path.clone(), name: None, exported };
                    self.modules[module].imports.push(import);
                    whole = false;
                }
                at += 1;
            }
            if path.len() > 1 {
                path.pop_if(|last| last == "self");
            }
            if whole && let Some(last) = path.last() {
                let name = Some(name.unwrap_or_else(|| last.clone()));
                self.modules[module].imports.push(Import { path, name, exported });
            }
        }
    }
}

/// Index after the item, field or statement that begins at `at`.
fn end_of_item(tokens: &[TokenTree], at: usize) -> usize {
    let mut first = at;
    if is_word(tokens.get(first), &["pub"]) {
        first += 1 + usize::from(group(tokens.get(first + 1), Delimiter::Parenthesis).is_some());
    }
    let item = is_word(tokens.get(first), ITEMS);
    // An item that ends with a semicolon may contain braces before it.
    let value = is_word(tokens.get(first), &["const", "let", "static", "type", "use"])
        && !is_word(tokens.get(first + 1), &["fn", "unsafe", "extern", "async"]);
    let end = tokens[at..].iter().position(|token| {
        is_sign(Some(token), ';')
            || !item && !value && is_sign(Some(token), ',')
            || !value && group(Some(token), Delimiter::Brace).is_some()
    });
    end.map_or(tokens.len(), |length| at + length + 1)
}

/// The path that begins at `at`, if there is one.
fn path_at(tokens: &[TokenTree], at: usize) -> Option<Vec<String>> {
    let mut path = vec![word(tokens.get(at))?];
    let before = at.checked_sub(1).and_then(|before| tokens.get(before));
    let inside = [':', '.', '\''].iter().any(|sign| is_sign(before, *sign));
    // `a: T` has a single colon before T; `..T` has two dots.
    let before_that = at.checked_sub(2).and_then(|before| tokens.get(before));
    let single = is_sign(before, ':') && !is_sign(before_that, ':')
        || is_sign(before, '.') && is_sign(before_that, '.');
    if inside && !single || is_word(before, DEFINE) {
        return None;
    }
    let mut next = at + 1;
    while is_sign(tokens.get(next), ':') && is_sign(tokens.get(next + 1), ':') {
        let Some(segment) = word(tokens.get(next + 2)) else { break };
        path.push(segment);
        next += 3;
    }
    // The name of a field or a parameter.
    let named =
        path.len() == 1 && is_sign(tokens.get(next), ':') && !is_sign(tokens.get(next + 1), ':');
    (!named).then_some(path)
}

/// The modules of a crate, the root first.
struct Crate(Vec<Module>);

/// What a path refers to.
enum Place<'a> {
    Module(usize),
    /// An item of this file.
    Item(&'a str),
}

impl Crate {
    fn uses(&self) -> Uses {
        let mut uses = Uses::new();
        for (own, module) in self.0.iter().enumerate() {
            let imports = module.imports.iter();
            let taken = imports.filter(|i| !i.exported && i.name.is_some()).map(|i| &i.path);
            for path in taken.chain(&module.paths) {
                let Some(Place::Item(file)) = self.find(own, path, &mut Vec::new()) else {
                    continue;
                };
                if file != module.file {
                    let between = (module.file.clone(), file.to_owned());
                    uses.entry(between).or_default().insert(path.join("::"));
                }
            }
        }
        uses
    }

    /// What `path` in module `from` refers to; `None` if it leads out of the crate.
    fn find(
        &self,
        from: usize,
        path: &[String],
        seen: &mut Vec<(usize, String)>,
    ) -> Option<Place<'_>> {
        let mut module = from;
        let mut rest = path;
        while let [first, others @ ..] = rest {
            module = match first.as_str() {
                "crate" => 0,
                "self" => module,
                "super" => self.0[module].parent?,
                _ => break,
            };
            rest = others;
        }
        self.descend(module, rest, seen)
    }

    /// What the names of `path` refer to, starting in `module`.
    fn descend(
        &self,
        module: usize,
        path: &[String],
        seen: &mut Vec<(usize, String)>,
    ) -> Option<Place<'_>> {
        let [name, rest @ ..] = path else { return Some(Place::Module(module)) };
        let here = (module, name.clone());
        if seen.contains(&here) {
            return None;
        }
        seen.push(here);
        let own = &self.0[module];
        let found = match own.children.get(name) {
            // A module and a function may have the same name; if the path continues, it is the
            // module.
            Some(child) if !rest.is_empty() || !self.defines(module, name) => {
                self.descend(*child, rest, seen)
            }
            _ if own.items.contains(name) => Some(Place::Item(&own.file)),
            _ => {
                let named = own.imports.iter().filter(|import| import.name.as_ref() == Some(name));
                let named = named.filter_map(|import| self.find(module, &import.path, seen)).next();
                match named {
                    Some(Place::Module(imported)) => self.descend(imported, rest, seen),
                    Some(item) => Some(item),
                    None => self.by_glob(module, path, seen),
                }
            }
        };
        seen.pop();
        found
    }

    /// Whether the module defines this name other than as a child module.
    fn defines(&self, module: usize, name: &str) -> bool {
        let own = &self.0[module];
        let child = |import: &Import| import.path.last().is_some_and(|last| last == name);
        own.items.contains(name)
            || own
                .imports
                .iter()
                .any(|i| i.name.as_deref() == Some(name) && i.path.len() > 1 && child(i))
    }

    fn by_glob(
        &self,
        module: usize,
        path: &[String],
        seen: &mut Vec<(usize, String)>,
    ) -> Option<Place<'_>> {
        let globs = self.0[module].imports.iter().filter(|import| import.name.is_none());
        globs
            .filter_map(|glob| match self.find(module, &glob.path, seen)? {
                Place::Module(source) => self.descend(source, path, seen),
                Place::Item(_) => None,
            })
            .next()
    }
}
