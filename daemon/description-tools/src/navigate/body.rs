//! Collects symbols of components and interfaces: IDS, ports, tasks, services and their codels.

use genom_description::syntax::{
    Body, Codel, CodelParameter, Export, PortDeclaration, Property, PropertyKind, Qualifier,
    Service, ServiceKind, ServiceParameters, Variable,
};

use super::symbol::{Space, Symbol, SymbolKind};
use super::walk::{Pending, Walker};

impl Walker<'_> {
    pub(super) fn body(&mut self, body: &Body, kind: SymbolKind) {
        let signature = self.extents.head(body.name.span);
        let doc = docs(body.exports.iter().filter_map(|export| match export {
            Export::Property(property) => Some(property),
            _ => None,
        }));
        let symbol = Symbol { signature, doc, ..self.symbol(0, &body.name, kind) };
        let id = self.table.add(Some(Space::Scope), symbol);
        for export in &body.exports {
            self.export(id, export);
        }
        // genom3.md 4.8.
        if kind == SymbolKind::Component
            && let Some(genom) = self.table.local(0, Space::Scope, "genom")
        {
            self.table.provided.entry(id).or_default().push(genom);
        }
    }

    pub(super) fn export(&mut self, body: usize, export: &Export) {
        use SymbolKind as K;
        match export {
            Export::Idl(idl) => self.idl(body, idl),
            Export::Property(property) => self.property(body, body, property),
            Export::Ids(ids) => {
                let word = genom_description::syntax::Name { text: "ids".into(), span: ids.span };
                let symbol = self.symbol(body, &word, K::Ids);
                let id = self.table.add(Some(Space::Member), symbol);
                self.members(id, &ids.members);
            }
            Export::Task(task) => {
                let signature = self.extents.head(task.name.span);
                let doc = docs(&task.properties);
                let symbol = Symbol { signature, doc, ..self.symbol(body, &task.name, K::Task) };
                let id = self.table.add(Some(Space::Task), symbol);
                for property in &task.properties {
                    self.property(body, id, property);
                }
            }
            Export::Port(port) => self.port(body, port),
            Export::Service(service) => self.service(body, service),
            Export::Events(names) => {
                for name in names {
                    let symbol = self.symbol(body, name, K::Event);
                    self.table.add(Some(Space::State), symbol);
                }
            }
            Export::Pragma(..) => {}
        }
    }

    fn port(&mut self, body: usize, port: &PortDeclaration) {
        let signature = port.span.to(port.name.span);
        let doc = docs(&port.properties);
        let symbol = Symbol { signature, doc, ..self.symbol(body, &port.name, SymbolKind::Port) };
        let id = self.table.add(Some(Space::Port), symbol);
        self.spec(body, &port.ty, Some(id));
    }

    fn service(&mut self, body: usize, service: &Service) {
        let kind = match service.kind {
            ServiceKind::Attribute => SymbolKind::Attribute,
            ServiceKind::Function => SymbolKind::Function,
            ServiceKind::Activity => SymbolKind::Activity,
            ServiceKind::Service => SymbolKind::Service,
        };
        let signature = self.extents.call(service.span, service.name.span);
        let doc = docs(&service.properties);
        let symbol = Symbol { signature, doc, ..self.symbol(body, &service.name, kind) };
        let id = self.table.add(Some(Space::Service), symbol);
        match &service.parameters {
            ServiceParameters::Typed(list) => {
                for parameter in list {
                    let name = &parameter.declarator.name;
                    let extent = self.extents.element(parameter.ty.span);
                    let doc = parameter.initializer.as_ref().and_then(|it| it.doc.as_ref());
                    let doc = doc.map(|doc| doc.text.clone());
                    let symbol = Self::listed(id, name, SymbolKind::Parameter, extent, doc);
                    let symbol = self.table.add(Some(Space::Parameter), symbol);
                    self.typed(body, &parameter.ty, &parameter.declarator, symbol);
                    if let Some(initializer) = &parameter.initializer {
                        self.initial(body, symbol, initializer);
                    }
                }
            }
            ServiceParameters::Variables(list) => {
                for parameter in list {
                    let Some(variable) = &parameter.variable else { continue };
                    let name = parameter.rename.as_ref().unwrap_or_else(|| variable.last());
                    let extent = self.extents.element(variable.root.span);
                    let doc = parameter.initializer.as_ref().and_then(|it| it.doc.as_ref());
                    let doc = doc.map(|doc| doc.text.clone());
                    let symbol = Self::listed(id, name, SymbolKind::Parameter, extent, doc);
                    let symbol = self.table.add(Some(Space::Parameter), symbol);
                    if parameter.rename.is_none() {
                        // The name refers to the member: that is the declaration to go to.
                        self.table.uses.pop();
                    }
                    let places = vec![(body, Space::Member)];
                    let (variable, typed) = (variable.clone(), Some(symbol));
                    self.pending.push(Pending::Variable { places, variable, typed });
                    if let Some(initializer) = &parameter.initializer {
                        self.initial(body, symbol, initializer);
                    }
                }
            }
        }
        // States are declared by triggers, which may come after the codels that yield them.
        for property in &service.properties {
            self.property(body, id, property);
        }
    }

    fn property(&mut self, body: usize, owner: usize, property: &Property) {
        let mut named = |space, names: &[genom_description::syntax::Name]| {
            for name in names {
                self.pending.push(Pending::Named { body, space, name: name.clone() });
            }
        };
        match &property.kind {
            PropertyKind::Task(name) => named(Space::Task, std::slice::from_ref(name)),
            PropertyKind::Interrupts(names)
            | PropertyKind::Before(names)
            | PropertyKind::After(names) => named(Space::Service, names),
            PropertyKind::Provides(names)
            | PropertyKind::Uses(names)
            | PropertyKind::Extends(names) => {
                for name in names {
                    self.pending.push(Pending::Interface { body, name: name.clone() });
                }
            }
            PropertyKind::Throws(paths) => {
                for path in paths {
                    let path = path.clone();
                    self.pending.push(Pending::Path { scope: body, path, typed: None });
                }
            }
            PropertyKind::IdsType(path) => {
                let word = genom_description::syntax::Name {
                    text: "ids".into(),
                    span: property.keyword.span,
                };
                let symbol = self.symbol(body, &word, SymbolKind::Ids);
                let typed = Some(self.table.add(Some(Space::Member), symbol));
                self.pending.push(Pending::Path { scope: body, path: path.clone(), typed });
            }
            PropertyKind::Local(ty, declarators) => {
                for declarator in declarators {
                    let symbol = self.symbol(owner, &declarator.name, SymbolKind::Local);
                    let symbol = self.table.add(Some(Space::Parameter), symbol);
                    self.typed(body, ty, declarator, symbol);
                }
            }
            PropertyKind::Validate(codel) | PropertyKind::Codel(codel) => {
                self.codel(body, owner, codel);
            }
            PropertyKind::Input(list) | PropertyKind::Output(list) => {
                for variable in list {
                    let (places, variable) = (vec![(body, Space::Member)], variable.clone());
                    self.pending.push(Pending::Variable { places, variable, typed: None });
                }
            }
            _ => {}
        }
    }

    fn codel(&mut self, body: usize, owner: usize, codel: &Codel) {
        let symbol = self.symbol(owner, &codel.name, SymbolKind::Codel);
        self.table.add(None, symbol);
        if let Some((triggers, yields)) = &codel.machine {
            for trigger in triggers {
                let symbol = self.symbol(owner, &trigger.name, SymbolKind::State);
                self.table.add(Some(Space::State), symbol);
            }
            for state in yields {
                // An event of the component is a state of every service.
                self.pending.push(Pending::Variable {
                    places: vec![(owner, Space::State), (body, Space::State)],
                    variable: Variable { root: state.name.clone(), steps: Vec::new() },
                    typed: None,
                });
            }
        }
        for parameter in &codel.parameters {
            self.codel_parameter(body, owner, parameter);
        }
    }

    // genom3.md 4.4: a name without qualifier is searched in this order.
    fn codel_parameter(&mut self, body: usize, owner: usize, parameter: &CodelParameter) {
        let Some(variable) = &parameter.variable else { return };
        let mut places = Vec::new();
        let wanted = parameter.qualifier;
        let is = |it| wanted.is_none_or(|wanted| wanted == it);
        if is(Qualifier::Local) {
            places.push((owner, Space::Parameter));
        }
        if is(Qualifier::Ids) {
            places.push((body, Space::Member));
        }
        if is(Qualifier::Port) {
            places.push((body, Space::Port));
        }
        if is(Qualifier::Remote) {
            places.push((body, Space::Service));
        }
        self.pending.push(Pending::Variable { places, variable: variable.clone(), typed: None });
    }
}

fn docs<'p>(properties: impl IntoIterator<Item = &'p Property>) -> Option<String> {
    let texts: Vec<&str> = properties
        .into_iter()
        .filter_map(|property| match &property.kind {
            PropertyKind::Doc(text) => Some(text.text.as_str()),
            _ => None,
        })
        .collect();
    (!texts.is_empty()).then(|| texts.join("\n"))
}
