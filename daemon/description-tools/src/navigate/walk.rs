//! Walks the tree: declarations become symbols, uses of names are recorded.
//!
//! Names are resolved at the end, so the order of declarations does not matter: this index is for
//! texts that are being written, it checks nothing.

use genom_description::model::Span;
use genom_description::syntax::{
    Constructed, Declarator, Expression, ExpressionKind, Idl, InitialStep, InitialValue,
    Initializer, Member, Name, Path, Statement, Tree, TypeSpec, TypeSpecKind, Variable,
    VariableStep,
};

use super::extent::Extents;
use super::symbol::{Space, Symbol, SymbolKind, Table};

/// A use of a name, to be resolved at the end.
pub(super) enum Pending {
    /// A type, constant or exception; it becomes the type of symbol `typed`, if given.
    Path { scope: usize, path: Path, typed: Option<usize> },
    /// A name in one name space of a component.
    Named { body: usize, space: Space, name: Name },
    /// An interface that `body` includes.
    Interface { body: usize, name: Name },
    /// The source of a codel's or attribute's parameter, with the name spaces to search (members
    /// are those of the IDS of the body); `typed` gets its type.
    Variable { places: Vec<(usize, Space)>, variable: Variable, typed: Option<usize> },
    /// `.member =` in the initial value of a symbol.
    Initial { of: usize, value: Initializer },
}

pub(super) struct Walker<'a> {
    pub(super) table: Table,
    pub(super) extents: Extents<'a>,
    pub(super) pending: Vec<Pending>,
}

impl Walker<'_> {
    pub(super) fn tree(&mut self, tree: &Tree) {
        // In the papers' dialects, statements outside belong to the component of the file.
        let component = tree.statements.iter().find_map(|statement| match statement {
            Statement::Component(body) => Some(body),
            _ => None,
        });
        for statement in &tree.statements {
            match statement {
                Statement::Idl(idl) => self.idl(0, idl),
                Statement::Component(body) => self.body(body, SymbolKind::Component),
                Statement::Interface(body) => self.body(body, SymbolKind::Interface),
                Statement::Outside(_) | Statement::Pragma(..) => {}
            }
        }
        let home = component
            .and_then(|body| self.table.local(0, Space::Scope, &body.name.text))
            .unwrap_or(0);
        for statement in &tree.statements {
            if let Statement::Outside(export) = statement {
                self.export(home, export);
            }
        }
    }

    /// A symbol for `name`, with the statement around it as its extent.
    pub(super) fn symbol(&self, parent: usize, name: &Name, kind: SymbolKind) -> Symbol {
        let extent = self.extents.statement(name.span);
        Symbol {
            name: name.text.as_ref().into(),
            kind,
            span: name.span,
            extent,
            signature: extent,
            doc: None,
            parent,
            ty: None,
        }
    }

    /// A symbol that is an element of a list.
    pub(super) fn listed(
        parent: usize,
        name: &Name,
        kind: SymbolKind,
        extent: Span,
        doc: Option<String>,
    ) -> Symbol {
        let (name, span, signature) = (name.text.as_ref().into(), name.span, extent);
        Symbol { name, kind, span, extent, signature, doc, parent, ty: None }
    }

    pub(super) fn idl(&mut self, scope: usize, idl: &Idl) {
        use SymbolKind as K;
        match idl {
            Idl::Module { name, statements } => {
                let signature = self.extents.head(name.span);
                let module = Symbol { signature, ..self.symbol(scope, name, K::Module) };
                let module = self.table.add(Some(Space::Scope), module);
                for statement in statements {
                    self.idl(module, statement);
                }
            }
            Idl::Const(constant) => {
                let symbol = self.symbol(scope, &constant.name, K::Constant);
                let id = self.table.add(Some(Space::Scope), symbol);
                self.spec(scope, &constant.ty, Some(id));
                self.expression(scope, &constant.value);
            }
            Idl::Typedef(typedef) => {
                for declarator in &typedef.declarators {
                    let symbol = self.symbol(scope, &declarator.name, K::Typedef);
                    let id = self.table.add(Some(Space::Scope), symbol);
                    self.typed(scope, &typedef.ty, declarator, id);
                }
            }
            Idl::Native(name) => {
                let symbol = self.symbol(scope, name, K::Native);
                self.table.add(Some(Space::Scope), symbol);
            }
            Idl::Pragma(..) => {}
            Idl::Exceptions(list) => {
                for exception in list {
                    let symbol = self.symbol(scope, &exception.name, K::Exception);
                    let id = self.table.add(Some(Space::Scope), symbol);
                    self.members(id, &exception.members);
                }
            }
            Idl::Constructed(constructed) => {
                self.constructed(scope, constructed);
            }
            // Going to the definition is preferred to going to the forward declaration.
            Idl::Forward { name, .. } => self.pending.push(Pending::Path {
                scope,
                path: Path { absolute: false, segments: vec![name.clone()], span: name.span },
                typed: None,
            }),
        }
    }

    fn constructed(&mut self, scope: usize, constructed: &Constructed) -> usize {
        use SymbolKind as K;
        match constructed {
            Constructed::Struct(it) => {
                let symbol = self.symbol(scope, &it.name, K::Struct);
                let id = self.table.add(Some(Space::Scope), symbol);
                self.members(id, &it.members);
                id
            }
            Constructed::Union(it) => {
                let symbol = self.symbol(scope, &it.name, K::Union);
                let id = self.table.add(Some(Space::Scope), symbol);
                self.spec(id, &it.switch, None);
                for case in &it.cases {
                    for label in case.labels.iter().filter_map(|label| label.value.as_ref()) {
                        self.expression(id, label);
                    }
                    self.member(id, &case.ty, &case.declarator);
                }
                id
            }
            Constructed::Enum(it) => {
                let symbol = self.symbol(scope, &it.name, K::Enum);
                let id = self.table.add(Some(Space::Scope), symbol);
                for name in &it.enumerators {
                    let one = Self::listed(id, name, K::Enumerator, name.span, None);
                    let one = self.table.add(Some(Space::Member), one);
                    self.table.alias(scope, &name.text, one);
                }
                id
            }
        }
    }

    pub(super) fn members(&mut self, record: usize, members: &[Member]) {
        for member in members {
            for declarator in &member.declarators {
                self.member(record, &member.ty, declarator);
            }
        }
    }

    fn member(&mut self, record: usize, ty: &TypeSpec, declarator: &Declarator) {
        let symbol = self.symbol(record, &declarator.name, SymbolKind::Member);
        let id = self.table.add(Some(Space::Member), symbol);
        self.typed(record, ty, declarator, id);
    }

    /// Records the type and dimensions of a symbol.
    pub(super) fn typed(&mut self, scope: usize, ty: &TypeSpec, d: &Declarator, id: usize) {
        self.spec(scope, ty, Some(id));
        for dimension in &d.dimensions {
            self.expression(scope, dimension);
        }
    }

    pub(super) fn spec(&mut self, scope: usize, ty: &TypeSpec, typed: Option<usize>) {
        match &ty.kind {
            TypeSpecKind::String(Some(bound)) => self.expression(scope, bound),
            TypeSpecKind::Sequence(element, bound) => {
                self.spec(scope, element, typed);
                if let Some(bound) = bound {
                    self.expression(scope, bound);
                }
            }
            TypeSpecKind::Optional(element) => self.spec(scope, element, typed),
            TypeSpecKind::Named(path) => {
                self.pending.push(Pending::Path { scope, path: path.clone(), typed });
            }
            TypeSpecKind::Constructed(constructed) => {
                let id = self.constructed(scope, constructed);
                if let Some(symbol) = typed.and_then(|typed| self.table.all.get_mut(typed)) {
                    symbol.ty = Some(id);
                }
            }
            _ => {}
        }
    }

    pub(super) fn expression(&mut self, scope: usize, expression: &Expression) {
        match &expression.kind {
            ExpressionKind::Name(path) => {
                self.pending.push(Pending::Path { scope, path: path.clone(), typed: None });
            }
            ExpressionKind::Unary(_, inner) => self.expression(scope, inner),
            ExpressionKind::Chain(first, rest) => {
                self.expression(scope, first);
                for (_, operand) in rest {
                    self.expression(scope, operand);
                }
            }
            ExpressionKind::Literal(_) | ExpressionKind::Error => {}
        }
    }

    /// Records constants in an initial value, and members it sets.
    pub(super) fn initial(&mut self, scope: usize, of: usize, value: &Initializer) {
        self.constants(scope, value);
        self.pending.push(Pending::Initial { of, value: value.clone() });
    }

    fn constants(&mut self, scope: usize, value: &Initializer) {
        if let Some(InitialStep::Index(index)) = &value.step {
            self.expression(scope, index);
        }
        match &value.value {
            Some(InitialValue::Scalar(expression)) => self.expression(scope, expression),
            Some(InitialValue::Compound(list)) => {
                for one in list {
                    self.constants(scope, one);
                }
            }
            None => {}
        }
    }

    /// Resolves all recorded names, as far as possible.
    pub(super) fn resolve(mut self) -> Table {
        let pending = std::mem::take(&mut self.pending);
        let mut later = Vec::new();
        for one in pending {
            match one {
                Pending::Path { scope, path, typed } => {
                    let found = self.table.path(scope, &path);
                    for (segment, id) in path.segments.iter().zip(&found) {
                        self.table.uses.push((segment.span, *id));
                    }
                    if let Some(symbol) = typed.and_then(|typed| self.table.all.get_mut(typed)) {
                        symbol.ty = found.last().copied();
                    }
                }
                Pending::Interface { body, name } => {
                    if let Some(id) = self.table.local(0, Space::Scope, &name.text) {
                        self.table.uses.push((name.span, id));
                        self.table.provided.entry(body).or_default().push(id);
                    }
                }
                other => later.push(other),
            }
        }
        // Members need the types of the symbols that contain them; variables need the interfaces.
        for one in later {
            match one {
                Pending::Named { body, space, name } => {
                    if let Some(id) = self.table.in_body(body, space, &name.text) {
                        self.table.uses.push((name.span, id));
                    }
                }
                Pending::Variable { places, variable, typed } => {
                    self.variable(&places, &variable, typed);
                }
                Pending::Initial { of, value } => self.steps(of, &value),
                Pending::Path { .. } | Pending::Interface { .. } => {}
            }
        }
        self.table.uses.sort_by_key(|(span, _)| (span.file, span.start, span.end));
        self.table
    }

    fn variable(&mut self, places: &[(usize, Space)], variable: &Variable, typed: Option<usize>) {
        let root = &variable.root;
        let table = &self.table;
        let found = places.iter().find_map(|(scope, space)| match space {
            Space::Member => table.ids(*scope).find_map(|ids| table.local(ids, *space, &root.text)),
            _ => table.in_body(*scope, *space, &root.text),
        });
        let Some(mut at) = found else { return };
        self.table.uses.push((root.span, at));
        for step in &variable.steps {
            if let VariableStep::Member(name) = step {
                let Some(member) = self.table.member(at, &name.text) else { return };
                self.table.uses.push((name.span, member));
                at = member;
            }
        }
        let ty = self.table.get(at).and_then(|symbol| symbol.ty);
        if let Some(symbol) = typed.and_then(|typed| self.table.all.get_mut(typed)) {
            symbol.ty = ty;
        }
    }

    fn steps(&mut self, of: usize, value: &Initializer) {
        let mut at = of;
        if let Some(InitialStep::Member(name)) = &value.step {
            let Some(member) = self.table.member(of, &name.text) else { return };
            self.table.uses.push((name.span, member));
            at = member;
        }
        if let Some(InitialValue::Compound(list)) = &value.value {
            for one in list {
                self.steps(at, one);
            }
        }
    }
}
