//! Completion: keywords of the context, and names that are possible there.

use genom_description::model::Span;
use genom_description::syntax::words::{IDL, PARTS, PROPERTIES};
use genom_description::syntax::{Name, Path};

use super::Navigator;
use super::context::Context;
use super::symbol::{Space, SymbolKind};

/// A possible completion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Completion {
    /// The text to insert.
    pub label: String,
    /// Keyword, or kind of symbol.
    pub kind: CompletionKind,
    /// Its declaration, for symbols; empty for keywords.
    pub detail: String,
    /// Its documentation, if it has one.
    pub doc: Option<String>,
}

/// Kind of a completion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompletionKind {
    /// A keyword.
    Keyword,
    /// A declared name.
    Symbol(SymbolKind),
}

const TOP: &[&str] = &["component", "interface"];
const TASK: &[&str] =
    &["doc", "period", "delay", "priority", "scheduling", "stack", "codel", "async", "throws"];
const ATTRIBUTE: &[&str] = &["doc", "validate", "throws", "codel"];
const FUNCTION: &[&str] =
    &["doc", "validate", "codel", "interrupts", "before", "after", "throws", "local"];
const ACTIVITY: &[&str] = &[
    "doc",
    "task",
    "validate",
    "codel",
    "async",
    "interrupts",
    "before",
    "after",
    "throws",
    "local",
];
const TYPES: &[&str] = &[
    "boolean", "char", "octet", "short", "unsigned", "long", "float", "double", "string",
    "sequence", "optional",
];
const DIRECTIONS: &[&str] = &["in", "out", "inout"];

/// Keywords that the tables above do not contain.
const OTHERS: &[&str] = &[
    "all",
    "all-of",
    "multiple",
    "yield",
    "yields",
    "pause",
    "ether",
    "start",
    "stop",
    "wcet",
    "real-time",
    "s",
    "ms",
    "us",
    "k",
    "M",
    "codels-requires",
    "require",
    "provide",
    "use",
    "extend",
    "throw",
    "interrupt",
    "remote",
    "inport",
    "outport",
    "input",
    "output",
    "language",
    "service",
];

/// Whether a word is a keyword somewhere in the language.
pub(super) fn is_word(word: &str) -> bool {
    let tables = [TOP, TASK, ATTRIBUTE, FUNCTION, ACTIVITY, TYPES, DIRECTIONS, OTHERS];
    tables.into_iter().chain([PROPERTIES, PARTS, IDL]).any(|table| table.contains(&word))
}

/// Kinds of names that a context accepts.
#[derive(Clone, Copy)]
enum Wanted {
    Types,
    Constants,
    Exceptions,
}

impl Wanted {
    fn takes(self, kind: SymbolKind) -> bool {
        use SymbolKind as K;
        match self {
            Wanted::Types => kind.is_type(),
            Wanted::Constants => matches!(kind, K::Constant | K::Enumerator),
            Wanted::Exceptions => kind == K::Exception,
        }
    }
}

impl Navigator {
    /// What may be written at a byte offset of a file. The word that is being written is ignored.
    #[must_use]
    pub fn complete(&self, file: u32, offset: u32) -> Vec<Completion> {
        let Some(context) = self.context(file, offset) else { return Vec::new() };
        let mut found = self.candidates(&context);
        let mut seen = std::collections::HashSet::new();
        found.retain(|one| seen.insert(one.label.clone()));
        found
    }

    fn candidates(&self, context: &Context<'_>) -> Vec<Completion> {
        let scope = self.scope_of(context);
        let words = context.words();
        let last = words.last().copied().unwrap_or_default();
        let first = words.first().copied().unwrap_or_default();
        let body = self.table.body_of(scope);
        if last == "::" && words.iter().rev().nth(1) != Some(&"pause") {
            return self.inside_path(scope, &words);
        }
        match first {
            "codel" | "validate" | "async" => self.codel(scope, body, &words),
            "attribute" | "function" | "activity" | "service" => {
                self.parameters(scope, body, first, &words)
            }
            "throws" | "throw" => self.names(scope, Wanted::Exceptions),
            "task" if self.service_of(scope) != 0 => self.of_body(body, Space::Task, &[]),
            "interrupts" | "interrupt" | "before" | "after" => {
                self.of_body(body, Space::Service, &["all"])
            }
            "provides" | "provide" | "uses" | "use" | "extends" | "extend" => {
                let all = self.table.all.iter().enumerate();
                let wanted = all.filter(|(_, symbol)| symbol.kind == SymbolKind::Interface);
                wanted.filter_map(|(id, _)| self.completion(id)).collect()
            }
            "scheduling" => keywords(&["real-time"]),
            "period" | "delay" | "clock-rate" if last.is_empty() => keywords(&["s", "ms", "us"]),
            "port" => match words.get(1).copied() {
                None => keywords(&["in", "out", "multiple"]),
                Some("multiple") if words.len() == 2 => keywords(&["in", "out"]),
                _ if matches!(last, "in" | "out") => self.types(scope),
                _ => self.in_template(scope, last),
            },
            "const" | "typedef" | "local" if words.len() == 1 => self.types(scope),
            "case" => self.names(scope, Wanted::Constants),
            "const" if words.contains(&"=") => self.constants(scope),
            "" => self.statement(scope, context.block()),
            _ => self.in_template(scope, last),
        }
    }

    /// Completes `sequence<` and `optional<` with types, a dimension with constants.
    fn in_template(&self, scope: usize, last: &str) -> Vec<Completion> {
        match last {
            "<" | "switch" => self.types(scope),
            "[" | "=" => self.constants(scope),
            _ => Vec::new(),
        }
    }

    fn statement(&self, scope: usize, block: &str) -> Vec<Completion> {
        match block {
            "" | "module" => keywords(&[TOP, IDL].concat()),
            "component" | "interface" => keywords(&[PROPERTIES, PARTS, IDL].concat()),
            "task" => keywords(TASK),
            "attribute" => keywords(ATTRIBUTE),
            "function" => keywords(FUNCTION),
            "activity" | "service" => keywords(ACTIVITY),
            "port" => keywords(&["doc"]),
            "ids" | "struct" | "exception" => self.types(scope),
            "union" => keywords(&["case", "default"]),
            _ => Vec::new(),
        }
    }

    /// Completes the parameters of a service.
    fn parameters(&self, scope: usize, body: usize, kind: &str, words: &[&str]) -> Vec<Completion> {
        let Some(open) = words.iter().position(|word| *word == "(") else { return Vec::new() };
        if words.last() == Some(&")") {
            return Vec::new();
        }
        let part = part(words, open);
        let of_ids = matches!(kind, "attribute" | "service");
        match part {
            [] => keywords(DIRECTIONS),
            [.., "in" | "out" | "inout"] if of_ids => self.ids(body),
            [.., "in" | "out" | "inout" | "<"] => self.types(scope),
            [_, path @ .., "."] => {
                let (name, steps) = variable(path);
                self.members_of(
                    self.table.ids(body).find_map(|ids| self.table.local(ids, Space::Member, name)),
                    &steps,
                )
            }
            [.., "="] => self.constants(scope),
            _ => Vec::new(),
        }
    }

    /// Completes `codel<state> name(parameters) yield states`.
    fn codel(&self, scope: usize, body: usize, words: &[&str]) -> Vec<Completion> {
        let last = words.last().copied().unwrap_or_default();
        let Some(open) = words.iter().position(|word| *word == "(") else {
            return match last {
                "<" | "," => self.states(scope, body, &["start", "stop"]),
                "async" => keywords(&["codel"]),
                _ => Vec::new(),
            };
        };
        let close = words.iter().position(|word| *word == ")");
        let Some(close) = close else {
            return self.arguments(scope, body, part(words, open));
        };
        let rest = words.get(close + 1..).unwrap_or_default();
        match rest {
            [] => keywords(&["yield", "wcet"]),
            [.., "yield" | "yields" | ","] => {
                self.states(scope, body, &["pause::", "ether", "stop"])
            }
            [.., "::"] => self.states(scope, body, &["start", "stop"]),
            _ => Vec::new(),
        }
    }

    /// Completes the parameters of a codel.
    fn arguments(&self, scope: usize, body: usize, part: &[&str]) -> Vec<Completion> {
        let owner = self.service_of(scope);
        let qualifiers = ["ids", "local", "port", "remote"];
        let (qualifier, rest) = match part {
            [first, rest @ ..] if qualifiers.contains(first) => (*first, rest),
            _ => ("", part),
        };
        match rest {
            [] if qualifier.is_empty() => keywords(&[DIRECTIONS, &qualifiers].concat()),
            [] => keywords(DIRECTIONS),
            [_] => {
                let mut found = Vec::new();
                if matches!(qualifier, "" | "local") {
                    found.extend(self.of(owner, Space::Parameter));
                }
                if matches!(qualifier, "" | "ids") {
                    found.extend(self.ids(body));
                }
                if matches!(qualifier, "" | "port") {
                    found.extend(self.of_body(body, Space::Port, &[]));
                }
                if qualifier == "remote" {
                    found.extend(self.of_body(body, Space::Service, &[]));
                }
                found
            }
            [_, path @ .., "."] => {
                let (name, steps) = variable(path);
                let root = self.table.local(owner, Space::Parameter, name).or_else(|| {
                    self.table.ids(body).find_map(|ids| self.table.local(ids, Space::Member, name))
                });
                self.members_of(root, &steps)
            }
            _ => Vec::new(),
        }
    }

    fn members_of(&self, root: Option<usize>, steps: &[&str]) -> Vec<Completion> {
        let end = steps.iter().try_fold(root, |at, step| Some(self.table.member(at?, step)));
        let ty = end.flatten().and_then(|id| self.table.get(id)?.ty);
        ty.map(|ty| self.of(self.table.record(ty), Space::Member)).unwrap_or_default()
    }

    fn states(&self, scope: usize, body: usize, given: &[&str]) -> Vec<Completion> {
        let mut found = self.of(self.service_of(scope), Space::State);
        found.extend(self.of(body, Space::State));
        found.extend(keywords(given));
        found
    }

    /// Completes after `scope::`.
    fn inside_path(&self, scope: usize, words: &[&str]) -> Vec<Completion> {
        let mut segments = Vec::new();
        let mut rest = words;
        while let [before @ .., name, "::"] = rest {
            let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
            if !is_name || matches!(*name, "in" | "out" | "inout") {
                break;
            }
            segments.insert(0, Name { text: (*name).into(), span: Span::default() });
            rest = before;
        }
        if segments.is_empty() {
            return self.of(0, Space::Scope);
        }
        let path = Path { absolute: false, segments, span: Span::default() };
        let inner = self.table.path(scope, &path).last().copied();
        inner.map(|inner| self.of(inner, Space::Scope)).unwrap_or_default()
    }

    fn types(&self, scope: usize) -> Vec<Completion> {
        let mut found = self.names(scope, Wanted::Types);
        found.extend(keywords(TYPES));
        found
    }

    fn constants(&self, scope: usize) -> Vec<Completion> {
        let mut found = self.names(scope, Wanted::Constants);
        found.extend(keywords(&["TRUE", "FALSE"]));
        found
    }

    /// Names that can be used without `::`, inner scopes first, and scopes.
    fn names(&self, scope: usize, wanted: Wanted) -> Vec<Completion> {
        use SymbolKind as K;
        let mut found = Vec::new();
        let mut at = scope;
        loop {
            for (id, symbol) in self.table.children(at) {
                if wanted.takes(symbol.kind)
                    || (at == 0 && matches!(symbol.kind, K::Module | K::Component | K::Interface))
                    || symbol.kind == K::Module
                {
                    found.extend(self.completion(id));
                }
                if symbol.kind == K::Enum && wanted.takes(K::Enumerator) {
                    found.extend(self.of(id, Space::Member));
                }
            }
            if at == 0 {
                return found;
            }
            at = self.table.get(at).map_or(0, |symbol| symbol.parent);
        }
    }

    fn ids(&self, body: usize) -> Vec<Completion> {
        self.table.ids(body).flat_map(|ids| self.of(ids, Space::Member)).collect()
    }

    fn of_body(&self, body: usize, space: Space, given: &[&str]) -> Vec<Completion> {
        let bodies = self.table.bodies(body);
        let mut found: Vec<_> = bodies.into_iter().flat_map(|body| self.of(body, space)).collect();
        found.extend(keywords(given));
        found
    }

    /// Names that `parent` declares in one name space.
    fn of(&self, parent: usize, space: Space) -> Vec<Completion> {
        use SymbolKind as K;
        let fits = |kind: SymbolKind| match space {
            Space::Member => matches!(kind, K::Member | K::Enumerator),
            Space::Task => kind == K::Task,
            Space::Port => kind == K::Port,
            Space::Service => kind.is_service(),
            Space::Parameter => matches!(kind, K::Parameter | K::Local),
            Space::State => matches!(kind, K::State | K::Event),
            Space::Scope => {
                kind.is_type()
                    || matches!(kind, K::Module | K::Component | K::Interface)
                    || matches!(kind, K::Constant | K::Exception)
            }
        };
        let children = self.table.children(parent).filter(|(_, symbol)| fits(symbol.kind));
        children.filter_map(|(id, _)| self.completion(id)).collect()
    }

    fn completion(&self, id: usize) -> Option<Completion> {
        let symbol = self.table.get(id)?;
        let detail = self.signature(symbol).split_whitespace().collect::<Vec<_>>().join(" ");
        Some(Completion {
            label: symbol.name.to_string(),
            kind: CompletionKind::Symbol(symbol.kind),
            detail,
            doc: self.doc(symbol),
        })
    }
}

fn keywords(words: &[&str]) -> Vec<Completion> {
    let one = |word: &&str| Completion {
        label: (*word).to_owned(),
        kind: CompletionKind::Keyword,
        detail: String::new(),
        doc: None,
    };
    words.iter().map(one).collect()
}

/// The parameter being written, of the list opened at `open`.
fn part<'w, 'a>(words: &'w [&'a str], open: usize) -> &'w [&'a str] {
    let inside = words.get(open + 1..).unwrap_or_default();
    let mut depth = 0_usize;
    let mut start = 0;
    for (rank, word) in inside.iter().enumerate() {
        match *word {
            "{" | "(" | "<" | "[" => depth += 1,
            "}" | ")" | ">" | "]" => depth = depth.saturating_sub(1),
            "," if depth == 0 => start = rank + 1,
            _ => {}
        }
    }
    inside.get(start..).unwrap_or_default()
}

/// Splits `a [ 2 ] . b` into `a` and the members after it.
fn variable<'a>(words: &[&'a str]) -> (&'a str, Vec<&'a str>) {
    let is_name = |word: &&&str| word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    let mut names = words.iter().filter(is_name).copied();
    (names.next().unwrap_or_default(), names.collect())
}
