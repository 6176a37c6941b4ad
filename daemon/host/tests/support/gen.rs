//! Builds components by hand, in a few calls, as the `.gen` reader would.
#![allow(dead_code)]

use std::sync::Arc;

use genom_description::model::*;
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeId, TypeTable, UnionMember};

/// A component under construction, called `demo`.
pub(crate) struct Gen {
    pub(crate) types: TypeTable,
    component: Component,
}

/// A parameter of a codel: direction, name and source.
pub(crate) type Argument<'a> = (Direction, &'a str, TypeId, Source);

impl Gen {
    /// Component `demo` with one task, `main`.
    pub(crate) fn new() -> Self {
        let component = Component {
            name: "demo".into(),
            dialect: Dialect::Current,
            doc: None,
            version: "0".into(),
            lang: "c".into(),
            email: None,
            requires: vec![],
            codels_requires: vec![],
            clock_rate: None,
            ids: None,
            tasks: [Task {
                name: "main".into(),
                doc: None,
                period: None,
                delay: std::time::Duration::ZERO,
                priority: None,
                real_time: false,
                stack: None,
                codels: vec![],
                throws: vec![],
                span: Span::default(),
            }]
            .into_iter()
            .collect(),
            ports: Indexed::default(),
            remotes: Indexed::default(),
            services: Indexed::default(),
            codels: Indexed::default(),
            states: ["ether", "start", "stop"].map(String::from).into_iter().collect(),
            sinks: vec![],
            throws: vec![],
            exclusion: vec![],
            digest: String::new(),
            span: Span::default(),
        };
        Self { types: TypeTable::default(), component }
    }

    pub(crate) fn lang(mut self, lang: &str) -> Self {
        self.component.lang = lang.into();
        self
    }

    pub(crate) fn ty(&mut self, kind: Kind) -> TypeId {
        self.types.add(kind)
    }

    pub(crate) fn string(&mut self, bound: Option<u32>) -> TypeId {
        self.ty(Kind::String { bound })
    }

    pub(crate) fn sequence(&mut self, element: TypeId, bound: Option<u32>) -> TypeId {
        self.ty(Kind::Sequence { element, bound })
    }

    fn members(members: &[(&str, TypeId)]) -> Vec<Member> {
        members.iter().map(|(name, ty)| Member { name: (*name).into(), ty: *ty }).collect()
    }

    pub(crate) fn structure(&mut self, name: &str, members: &[(&str, TypeId)]) -> TypeId {
        let name = ScopedName::new(["demo", name]);
        self.ty(Kind::Struct { name, members: Self::members(members) })
    }

    pub(crate) fn union(
        &mut self,
        name: &str,
        discriminant: TypeId,
        members: Vec<UnionMember>,
    ) -> TypeId {
        self.ty(Kind::Union { name: ScopedName::new(["demo", name]), discriminant, members })
    }

    /// An exception, which any service may throw.
    pub(crate) fn exception(&mut self, name: &str, members: &[(&str, TypeId)]) -> TypeId {
        let name = ScopedName::new(["demo", name]);
        let id = self.ty(Kind::Exception { name, members: Self::members(members) });
        self.component.throws.push(id);
        id
    }

    pub(crate) fn ids(&mut self, members: &[(&str, TypeId)]) -> TypeId {
        let id = self.structure("ids", members);
        self.component.ids = Some(id);
        id
    }

    pub(crate) fn port(
        &mut self,
        name: &str,
        direction: PortDirection,
        multiple: bool,
        ty: TypeId,
    ) -> PortIx {
        self.component.ports.push(Port {
            name: name.into(),
            direction,
            multiple,
            interface: None,
            ty,
            doc: None,
            span: Span::default(),
        })
    }

    fn parameters(parameters: &[(Direction, &str, TypeId)]) -> Vec<Parameter> {
        let parameter = |(direction, name, ty): &(Direction, &str, TypeId)| Parameter {
            name: (*name).into(),
            direction: *direction,
            ty: *ty,
            default: None,
            target: None,
            span: Span::default(),
        };
        parameters.iter().map(parameter).collect()
    }

    /// The structs of the inputs and of the outputs.
    fn records(
        &mut self,
        name: &str,
        parameters: &[(Direction, &str, TypeId)],
    ) -> (TypeId, TypeId) {
        let pick = |without| {
            let kept = parameters.iter().filter(move |parameter| parameter.0 != without);
            kept.map(|parameter| (parameter.1, parameter.2)).collect::<Vec<_>>()
        };
        let input = self.structure(&format!("{name}_input"), &pick(Direction::Out));
        let output = self.structure(&format!("{name}_output"), &pick(Direction::In));
        (input, output)
    }

    pub(crate) fn service(
        &mut self,
        kind: ServiceKind,
        name: &str,
        parameters: &[(Direction, &str, TypeId)],
        locals: &[(&str, TypeId)],
    ) -> ServiceIx {
        let (input, output) = self.records(name, parameters);
        let local = self.structure(&format!("{name}_local"), locals);
        let locals: Vec<_> = locals.iter().map(|(n, ty)| (Direction::InOut, *n, *ty)).collect();
        self.component.services.push(Service {
            kind,
            name: name.into(),
            doc: None,
            parameters: Self::parameters(parameters),
            locals: Self::parameters(&locals),
            input,
            output,
            local,
            task: (kind == ServiceKind::Activity).then_some(TaskIx::new(0)),
            interrupts: vec![],
            before: vec![],
            after: vec![],
            validates: vec![],
            codels: vec![],
            throws: vec![],
            standard: false,
            through_ids: false,
            digest: String::new(),
            call_digest: String::new(),
            span: Span::default(),
        })
    }

    /// Makes parameter `parameter` of attribute `service` set or get a member of the IDS.
    pub(crate) fn target(&mut self, service: ServiceIx, parameter: usize, path: &[PathStep]) {
        self.component.services[service].parameters[parameter].target =
            Some(AttributeTarget { path: path.to_vec() });
    }

    pub(crate) fn remote(
        &mut self,
        name: &str,
        parameters: &[(Direction, &str, TypeId)],
    ) -> RemoteIx {
        let (input, output) = self.records(name, parameters);
        self.component.remotes.push(Remote {
            name: name.into(),
            interface: "other".into(),
            kind: ServiceKind::Function,
            parameters: Self::parameters(parameters),
            input,
            output,
            throws: vec![],
            digest: String::new(),
            span: Span::default(),
        })
    }

    /// Adds a codel of a service or task, of the kind that its owner runs.
    pub(crate) fn codel(
        &mut self,
        owner: Owner,
        name: &str,
        arguments: &[Argument<'_>],
    ) -> CodelIx {
        let ix = CodelIx::new(self.component.codels.len());
        let fsm = CodelKind::Fsm {
            triggers: vec![StateIx::new(1)],
            yields: vec![Yield { state: StateIx::new(0), pause: false }],
        };
        let kind = match owner {
            Owner::Task(task) => {
                self.component.tasks[task].codels.push(ix);
                fsm
            }
            Owner::Service(service) => {
                let service = &mut self.component.services[service];
                match service.kind {
                    ServiceKind::Attribute => service.validates.push(ix),
                    _ => service.codels.push(ix),
                }
                match service.kind {
                    ServiceKind::Attribute => CodelKind::Validate,
                    ServiceKind::Function => CodelKind::Simple,
                    ServiceKind::Activity => fsm,
                }
            }
        };
        let parameter = |(direction, name, ty, source): &Argument<'_>| CodelParameter {
            name: (*name).into(),
            direction: *direction,
            ty: *ty,
            source: source.clone(),
            span: Span::default(),
        };
        self.component.codels.push(Codel {
            name: name.into(),
            owner,
            kind,
            asynchronous: false,
            parameters: arguments.iter().map(parameter).collect(),
            wcet: None,
            span: Span { file: 0, start: u32::try_from(ix.index()).unwrap(), end: 0 },
        })
    }

    /// Adds a function with these parameters and one codel that takes all of them, in order.
    pub(crate) fn function(
        &mut self,
        name: &str,
        parameters: &[(Direction, &str, TypeId)],
    ) -> (ServiceIx, CodelIx) {
        let service = self.service(ServiceKind::Function, &format!("s_{name}"), parameters, &[]);
        let arguments: Vec<_> = parameters
            .iter()
            .enumerate()
            .map(|(index, (d, n, t))| (*d, *n, *t, Source::Parameter { index, path: vec![] }))
            .collect();
        (service, self.codel(Owner::Service(service), name, &arguments))
    }

    pub(crate) fn specification(self) -> Specification {
        Specification {
            types: Arc::new(self.types),
            components: vec![self.component],
            ..Specification::default()
        }
    }
}

/// A record of this type with the value of this JSON.
pub(crate) fn record(specification: &Specification, ty: TypeId, json: serde_json::Value) -> Record {
    let ty = DataType::new(&specification.types, ty).expect("a type with a layout");
    let mut record = Record::new(&ty);
    record.merge_json(&json).expect("a value of the type");
    record
}
