//! Remotes as codels see them: one C function each, that calls a service of another component and
//! waits (genom3.md 5.8). One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{c_char, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use genom_description::model::{Direction, Remote, Span};
use genom_runtime::body::RemoteCall;
use genom_types::{DataType, Record, TypeId, foreign};

use crate::detail::{Detail, Details, UNKEX};
use crate::ffi::{Arguments, Class, NativeFunction};
use crate::shared::Shared;

/// The parameters of a remote, laid out.
pub(crate) struct Signature {
    name: String,
    parameters: Vec<Parameter>,
    input: DataType,
    output: DataType,
}

/// A parameter, and where the records keep it.
struct Parameter {
    name: String,
    direction: Direction,
    class: Class,
    /// As member of the inputs.
    input: Option<Member>,
    /// As member of the outputs.
    output: Option<Member>,
}

/// A member of a record.
struct Member {
    ty: DataType,
    offset: usize,
}

impl Signature {
    /// Lays the parameters out with `lay_out`, which notes why it cannot.
    pub(crate) fn new(
        remote: &Remote,
        mut lay_out: impl FnMut(TypeId, &str, Span) -> Option<DataType>,
    ) -> Option<Self> {
        let input =
            lay_out(remote.input, &format!("inputs of remote `{}`", remote.name), remote.span);
        let output =
            lay_out(remote.output, &format!("outputs of remote `{}`", remote.name), remote.span);
        let (input, output) = (input?, output?);
        let member = |record: &DataType, rank: &mut usize| {
            let found = Member { ty: record.member(*rank)?, offset: record.member_offset(*rank)? };
            *rank += 1;
            Some(found)
        };
        let (mut inputs, mut outputs) = (0, 0);
        let mut parameters = Vec::new();
        for parameter in &remote.parameters {
            let into = (parameter.direction != Direction::Out)
                .then(|| member(&input, &mut inputs))
                .flatten();
            let out = (parameter.direction != Direction::In)
                .then(|| member(&output, &mut outputs))
                .flatten();
            let kind = into.as_ref().or(out.as_ref())?.ty.kind();
            parameters.push(Parameter {
                name: parameter.name.clone(),
                direction: parameter.direction,
                class: Class::of(kind, parameter.direction),
                input: into,
                output: out,
            });
        }
        Some(Self { name: remote.name.clone(), parameters, input, output })
    }
}

/// The remotes of one component.
pub(crate) struct Remotes(Vec<Handle>);

/// `struct comp_r` of genom3.md 5.8, and what its function works on.
struct Handle {
    table: Box<[usize; 1]>,
    state: Arc<State>,
    _function: NativeFunction,
}

/// What a call works on.
struct State {
    signature: Signature,
    shared: Arc<Shared>,
    details: Arc<Details>,
    /// Codels of several tasks may call at once; they take turns.
    link: Mutex<Link>,
}

struct Link {
    call: Option<Box<dyn RemoteCall>>,
    input: Record,
    output: Record,
    /// Owns what the detail recorded last points to.
    detail: Option<Detail>,
}

impl Remotes {
    /// Handles for remotes; `None` when there is no memory for executable code.
    pub(crate) fn new(
        signatures: Vec<Signature>,
        shared: &Arc<Shared>,
        details: &Arc<Details>,
    ) -> Option<Self> {
        let handle = |signature: Signature| {
            let classes = signature.parameters.iter().map(|parameter| parameter.class);
            let classes: Vec<Class> = classes.chain([Class::Address]).collect();
            let link = Link {
                call: None,
                input: Record::new(&signature.input),
                output: Record::new(&signature.output),
                detail: None,
            };
            let state = Arc::new(State {
                signature,
                shared: Arc::clone(shared),
                details: Arc::clone(details),
                link: Mutex::new(link),
            });
            let function = NativeFunction::new(&classes, call, Arc::clone(&state))?;
            Some(Handle { table: Box::new([function.address()]), state, _function: function })
        };
        signatures.into_iter().map(handle).collect::<Option<_>>().map(Self)
    }

    /// What codels get for the remote.
    pub(crate) fn handle(&self, remote: usize) -> *const c_void {
        self.0[remote].table.as_ptr().cast()
    }

    /// Connects a remote, or disconnects it.
    pub(crate) fn bind(&self, remote: usize, call: Option<Box<dyn RemoteCall>>) {
        if let Some(handle) = self.0.get(remote) {
            handle.state.link.lock().unwrap_or_else(PoisonError::into_inner).call = call;
        }
    }
}

/// The function behind every remote.
fn call(state: &Arc<State>, arguments: Arguments<'_>) -> *const c_void {
    let context = arguments.pointer(state.signature.parameters.len());
    let mut link = state.link.lock().unwrap_or_else(PoisonError::into_inner);
    let event: *const c_char = match state.call(&mut link, arguments) {
        Ok(()) => std::ptr::null(),
        Err((name, detail)) => {
            link.detail = detail;
            let bytes = link.detail.as_ref().map_or(&[][..], Detail::bytes);
            state.shared.throw(context, &name, bytes)
        }
    };
    event.cast()
}

/// An exception for the calling codel.
type Thrown = (String, Option<Detail>);

impl State {
    /// Sends the arguments, waits, and fills the arguments the service makes.
    fn call(&self, link: &mut Link, arguments: Arguments<'_>) -> Result<(), Thrown> {
        let parameters = || self.signature.parameters.iter().enumerate();
        for (rank, parameter) in parameters() {
            if parameter.class == Class::Address && arguments.pointer(rank).is_null() {
                let (argument, remote) = (&parameter.name, &self.signature.name);
                return Err(self.unkex(&format!("argument `{argument}` of {remote} is NULL")));
            }
        }
        let Some(remote) = &mut link.call else {
            return Err(("::genom::no_such_service".to_owned(), None));
        };
        for (rank, parameter) in parameters() {
            let Some(Member { ty, offset }) = &parameter.input else { continue };
            // SAFETY: the argument has the class of its type, so that it is, or leads to, a value
            // of it; the member of the record is another place of that type.
            unsafe {
                let from = parameter.place(arguments, rank);
                foreign::copy_value(ty, from, link.input.as_mut_ptr().add(*offset));
            }
        }
        link.output.clear();
        remote.call(&link.input, &mut link.output).map_err(|(name, detail)| {
            let known =
                self.details.is_exception(&name) || self.shared.events.pointer(&name).is_some();
            if known {
                let detail = self.details.make(&name, &detail);
                (name, detail)
            } else {
                self.unkex(&name)
            }
        })?;
        for (rank, parameter) in parameters() {
            let Some(Member { ty, offset }) = &parameter.output else { continue };
            let to = arguments.pointer(rank);
            // SAFETY: as above. What `out` leads to need not be a value yet, so nothing of it is
            // released; `inout` was one.
            unsafe {
                if parameter.direction == Direction::Out {
                    to.write_bytes(0, ty.size());
                    foreign::init_value(ty, to);
                }
                foreign::copy_value(ty, link.output.as_ptr().add(*offset), to);
            }
        }
        Ok(())
    }

    fn unkex(&self, what: &str) -> Thrown {
        let detail = serde_json::json!({ "what": what });
        (UNKEX.to_owned(), self.details.make(UNKEX, &detail))
    }
}

impl Parameter {
    /// Where the value of argument `rank` is.
    fn place(&self, arguments: Arguments<'_>, rank: usize) -> *const u8 {
        match self.class {
            Class::Value(_) | Class::Held => arguments.place(rank),
            Class::Address => arguments.pointer(rank),
        }
    }
}
