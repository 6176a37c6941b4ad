//! The symbols of a description, and the uses of each name.

use std::collections::{HashMap, HashSet};

use genom_description::model::Span;
use genom_description::syntax::{Name, Path};

/// Kinds of symbols.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SymbolKind {
    /// Contains all others.
    Root,
    /// `module`
    Module,
    /// `component`
    Component,
    /// `interface`
    Interface,
    /// `struct`
    Struct,
    /// `union`
    Union,
    /// `enum`
    Enum,
    /// A value of an enum.
    Enumerator,
    /// `typedef`
    Typedef,
    /// `native`
    Native,
    /// `exception`
    Exception,
    /// `const`
    Constant,
    /// Member of a struct, union, exception or the IDS.
    Member,
    /// `ids`
    Ids,
    /// `task`
    Task,
    /// `port`
    Port,
    /// `attribute`
    Attribute,
    /// `function`
    Function,
    /// `activity`
    Activity,
    /// `service`, as in the papers' dialects.
    Service,
    /// Parameter of a service.
    Parameter,
    /// `local` of a service.
    Local,
    /// `codel` or `validate`
    Codel,
    /// State of a task or an activity.
    State,
    /// `event`
    Event,
}

impl SymbolKind {
    /// Whether it names a type of data.
    #[must_use]
    pub fn is_type(self) -> bool {
        use SymbolKind as K;
        matches!(self, K::Struct | K::Union | K::Enum | K::Typedef | K::Native)
    }

    /// Whether it is an attribute, function, activity or service.
    #[must_use]
    pub fn is_service(self) -> bool {
        use SymbolKind as K;
        matches!(self, K::Attribute | K::Function | K::Activity | K::Service)
    }
}

/// Something that a description declares.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Name as declared, without scopes.
    pub name: Box<str>,
    /// Kind of symbol.
    pub kind: SymbolKind,
    /// Position of the name in the declaration.
    pub span: Span,
    /// The whole declaration.
    pub extent: Span,
    /// The part of the declaration to show.
    pub signature: Span,
    /// `doc`, lines joined.
    pub doc: Option<String>,
    /// Index of the symbol that contains it.
    pub parent: usize,
    /// Index of its named type, in which its members are found.
    pub ty: Option<usize>,
}

/// Name spaces: names in different ones do not clash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Space {
    /// Types, constants, modules, components.
    Scope,
    Member,
    Task,
    Port,
    Service,
    /// Parameters and locals.
    Parameter,
    State,
}

/// All symbols; the first is the root.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) all: Vec<Symbol>,
    names: HashMap<(usize, Space, Box<str>), usize>,
    /// Interfaces that a component or interface includes.
    pub(super) provided: HashMap<usize, Vec<usize>>,
    /// Positions of names, with their symbols; declarations are included.
    pub(super) uses: Vec<(Span, usize)>,
}

impl Table {
    pub(super) fn new() -> Self {
        let nowhere = Span::default();
        let root = Symbol {
            name: "".into(),
            kind: SymbolKind::Root,
            span: nowhere,
            extent: nowhere,
            signature: nowhere,
            doc: None,
            parent: 0,
            ty: None,
        };
        Table { all: vec![root], names: HashMap::new(), provided: HashMap::new(), uses: Vec::new() }
    }

    pub(super) fn get(&self, id: usize) -> Option<&Symbol> {
        self.all.get(id)
    }

    /// Adds a symbol; one that exists (reopened, or declared twice) is kept.
    pub(super) fn add(&mut self, space: Option<Space>, symbol: Symbol) -> usize {
        let id = self.all.len();
        if let Some(space) = space {
            let key = (symbol.parent, space, symbol.name.clone());
            if let Some(known) = self.names.get(&key) {
                self.uses.push((symbol.span, *known));
                return *known;
            }
            self.names.insert(key, id);
        }
        self.uses.push((symbol.span, id));
        self.all.push(symbol);
        id
    }

    /// Makes a symbol visible in another scope too.
    pub(super) fn alias(&mut self, scope: usize, name: &str, id: usize) {
        self.names.entry((scope, Space::Scope, name.into())).or_insert(id);
    }

    pub(super) fn local(&self, parent: usize, space: Space, name: &str) -> Option<usize> {
        self.names.get(&(parent, space, name.into())).copied()
    }

    /// Finds a name in a body, or in the interfaces that it includes.
    pub(super) fn in_body(&self, body: usize, space: Space, name: &str) -> Option<usize> {
        self.bodies(body).into_iter().find_map(|id| self.local(id, space, name))
    }

    /// A body and the interfaces that it includes.
    pub(super) fn bodies(&self, body: usize) -> Vec<usize> {
        let mut found = vec![body];
        let mut seen: HashSet<usize> = [body].into();
        let mut at = 0;
        while let Some(id) = found.get(at) {
            for from in self.provided.get(id).into_iter().flatten() {
                if seen.insert(*from) {
                    found.push(*from);
                }
            }
            at += 1;
        }
        found
    }

    /// The symbols of all segments of a path; empty if it cannot be resolved.
    // genom3.md 4.2: each scope outwards, the name tried as a whole.
    pub(super) fn path(&self, from: usize, path: &Path) -> Vec<usize> {
        let mut scope = if path.absolute { 0 } else { from };
        loop {
            let found = self.path_in(scope, &path.segments);
            if found.len() == path.segments.len() || scope == 0 {
                return if found.len() == path.segments.len() { found } else { Vec::new() };
            }
            scope = self.get(scope).map_or(0, |symbol| symbol.parent);
        }
    }

    fn path_in(&self, mut scope: usize, segments: &[Name]) -> Vec<usize> {
        let mut found = Vec::new();
        for segment in segments {
            match self.local(scope, Space::Scope, &segment.text) {
                Some(id) => scope = id,
                None => break,
            }
            found.push(scope);
        }
        found
    }

    /// The struct, union, exception or IDS behind typedefs.
    pub(super) fn record(&self, mut id: usize) -> usize {
        // The number of steps is limited: `typedef a b; typedef b a;` must not hang.
        for _ in 0..self.all.len() {
            match self.get(id) {
                Some(Symbol { kind: SymbolKind::Typedef, ty: Some(ty), .. }) => id = *ty,
                _ => break,
            }
        }
        id
    }

    /// The member `name` of a symbol's type.
    pub(super) fn member(&self, of: usize, name: &str) -> Option<usize> {
        let symbol = self.get(of)?;
        self.local(self.record(symbol.ty?), Space::Member, name)
    }

    /// The symbols that contain the members of the IDS of a body: its own, and those of its
    /// interfaces.
    pub(super) fn ids(&self, body: usize) -> impl Iterator<Item = usize> {
        self.bodies(body).into_iter().filter_map(|body| {
            let ids = self.local(body, Space::Member, "ids")?;
            // In the 2010 dialect, the IDS is a struct that is declared separately.
            Some(self.get(ids)?.ty.map_or(ids, |ty| self.record(ty)))
        })
    }

    /// The symbols declared directly in `parent`.
    pub(super) fn children(&self, parent: usize) -> impl Iterator<Item = (usize, &Symbol)> {
        self.all.iter().enumerate().skip(1).filter(move |(_, symbol)| symbol.parent == parent)
    }

    /// The innermost symbol of the wanted kinds that contains `id`, or `id` itself.
    pub(super) fn around(&self, mut id: usize, wanted: impl Fn(SymbolKind) -> bool) -> usize {
        while let Some(symbol) = self.get(id).filter(|_| id != 0) {
            if wanted(symbol.kind) {
                return id;
            }
            id = symbol.parent;
        }
        0
    }

    /// The component or interface that contains a symbol; 0 if there is none.
    pub(super) fn body_of(&self, id: usize) -> usize {
        self.around(id, |kind| matches!(kind, SymbolKind::Component | SymbolKind::Interface))
    }
}
