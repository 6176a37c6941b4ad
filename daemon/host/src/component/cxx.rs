//! Memory of codels in C++ (genom3.md 6): objects that correspond to the records of requests. One
//! of the few unsafe modules.
#![allow(unsafe_code)]

use std::cell::{Cell, OnceCell};

use genom_description::model::{
    Component as Model, Dialect, Indexed, Port, PortIx, Service, ServiceIx, Span,
};
use genom_types::{CompiledPath, DataType, PathStep, Record};

use super::checker::Checker;
use super::copies::{Copies, Place};
use super::types::ServiceTypes;
use crate::cxx::{CxxPath, CxxPathError, CxxType, Object, copy, to_cxx};

/// Types of a component in C++; `None` for a wrong one, which was reported.
pub(super) struct CxxTypes {
    pub(super) ids: Option<CxxType>,
    pub(super) services: Indexed<ServiceIx, Option<CxxService>>,
    pub(super) ports: Indexed<PortIx, Option<CxxType>>,
}

/// Objects of a service, and the copies between them, the request and the IDS.
#[derive(Debug)]
pub(super) struct CxxService {
    pub(super) input: CxxType,
    pub(super) output: CxxType,
    pub(super) local: CxxType,
    pub(super) copies: Copies<Transfer>,
}

/// A value to copy.
#[derive(Debug)]
pub(super) struct Transfer {
    from: From,
    to: CxxPath,
}

#[derive(Debug)]
enum From {
    /// The request's inputs.
    Request(CompiledPath),
    Object(CxxPath),
}

impl CxxTypes {
    /// The C++ types of `model`, whose records are laid out already.
    pub(super) fn new(
        checker: &mut Checker<'_>,
        model: &Model,
        ids: Option<&DataType>,
        services: &[Option<ServiceTypes>],
        ports: &[Option<DataType>],
    ) -> Self {
        for remote in &model.remotes {
            for record in [remote.input, remote.output] {
                let what = format!("remote `{}`", remote.name);
                if let Some(record) = checker.lay_out(record, &what, remote.span) {
                    in_cxx(checker, &record, &what, remote.span);
                }
            }
        }
        let ids = ids.and_then(|ids| in_cxx(checker, ids, "the ids", model.span));
        let of = |(service, types): (&Service, &Option<ServiceTypes>)| {
            CxxService::new(checker, service, types.as_ref()?, ids.as_ref(), model.dialect)
        };
        let services = model.services.iter().zip(services).map(of).collect();
        let port = |(port, ty): (&Port, &Option<DataType>)| {
            in_cxx(checker, ty.as_ref()?, &format!("port `{}`", port.name), port.span)
        };
        let ports = model.ports.iter().zip(ports).map(port).collect();
        Self { ids, services, ports }
    }
}

/// The type in C++; records an error if there is none.
fn in_cxx(checker: &mut Checker<'_>, c: &DataType, what: &str, span: Span) -> Option<CxxType> {
    checker.made(CxxType::new(c), what, span)
}

impl CxxService {
    fn new(
        checker: &mut Checker<'_>,
        service: &Service,
        types: &ServiceTypes,
        ids: Option<&CxxType>,
        dialect: Dialect,
    ) -> Option<Self> {
        let what = |part| format!("{part} of service `{}`", service.name);
        let input = in_cxx(checker, &types.input, &what("inputs"), service.span);
        let output = in_cxx(checker, &types.output, &what("outputs"), service.span);
        let local = in_cxx(checker, &types.local, &what("local variables"), service.span);
        let (input, output, local) = (input?, output?, local?);
        let object = |place: &Place<'_, CxxType>| match place {
            Place::Input(rank) => CxxPath::new(&input, &[PathStep::Member(*rank)]),
            Place::Output(rank) => CxxPath::new(&output, &[PathStep::Member(*rank)]),
            Place::Ids(ids, steps) => CxxPath::new(ids, steps),
        };
        let copies = Copies::new(checker, service, ids, dialect, |from, to| {
            let from = match from {
                Place::Input(rank) => {
                    From::Request(CompiledPath::new(&types.input, &[PathStep::Member(*rank)])?)
                }
                place => From::Object(object(place)?),
            };
            Ok::<_, CxxPathError>(Transfer { from, to: object(to)? })
        });
        Some(Self { input, output, local, copies })
    }
}

/// The objects of one run of a service.
pub(super) struct Objects {
    pub(super) input: Object,
    pub(super) output: Object,
    pub(super) local: Object,
    /// The outputs in C layout, as computed since codels last ran.
    output_in_c: OnceCell<Record>,
    /// Memory for that, kept for reuse.
    spare: Cell<Option<Record>>,
}

impl Objects {
    /// Empty objects.
    pub(super) fn new(types: &CxxService) -> Self {
        Self {
            input: Object::new(&types.input),
            output: Object::new(&types.output),
            local: Object::new(&types.local),
            output_in_c: OnceCell::new(),
            spare: Cell::new(Some(Record::new(types.output.c()))),
        }
    }

    /// Begins a run with the inputs of a request.
    pub(super) fn begin(&mut self, types: &CxxService, request: &Record) {
        self.changed();
        self.output.clear();
        self.local.clear();
        self.input.set(request);
        self.transfer(&types.copies.inout, request, self.output.at(), self.output.at());
    }

    /// Codels may have changed the outputs: discards the computed ones.
    pub(super) fn changed(&mut self) {
        if let Some(output) = self.output_in_c.take() {
            self.spare.set(Some(output));
        }
    }

    /// The outputs in C layout.
    pub(super) fn output_in_c(&self) -> &Record {
        self.output_in_c.get_or_init(|| {
            let spare = self.spare.take();
            let mut output = spare.unwrap_or_else(|| Record::new(self.output.ty().c()));
            self.output.get(&mut output);
            output
        })
    }

    /// Makes the copies from the request, or the object at `from`, to the object at `to`.
    pub(super) fn transfer(
        &self,
        transfers: &[Transfer],
        request: &Record,
        from: *mut u8,
        to: *mut u8,
    ) {
        for transfer in transfers {
            // SAFETY: the roots hold values of the paths' root types; the runtime excludes every
            // codel that may change them meanwhile (genom3.md 4.5). Source and target are different
            // memory: the request, the inputs, the outputs and the IDS.
            let done = unsafe {
                match (&transfer.from, transfer.to.locate(to)) {
                    (From::Request(path), Some(to)) => {
                        let from = path.locate(request.as_ptr().cast_mut());
                        from.map(|from| to_cxx(transfer.to.target(), from, to))
                    }
                    (From::Object(path), Some(to)) => {
                        path.locate(from).map(|from| copy(transfer.to.target(), from, to))
                    }
                    (_, None) => None,
                }
            };
            if done.is_none() {
                tracing::error!("an attribute's element of a sequence in the ids is missing");
            }
        }
    }
}
