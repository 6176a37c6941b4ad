//! Remotes as codels see them: a C function for each, which calls a service of another component
//! and waits (genom3.md 5.8). One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{c_char, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use genom_description::model::{Direction, Indexed, Remote, RemoteIx, Span};
use genom_runtime::body::RemoteCall;
use genom_types::{DataType, Record, TypeId, foreign};

use crate::cxx::{CxxType, Exceptions, Raise, to_c, to_cxx};
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

/// A parameter, and its members in the input and output records.
struct Parameter {
    name: String,
    direction: Direction,
    class: Class,
    /// Its member in the input record.
    input: Option<Member>,
    /// Its member in the output record.
    output: Option<Member>,
}

/// A member of a record.
struct Member {
    ty: DataType,
    offset: usize,
    /// Type that codels in C++ pass.
    cxx: Option<CxxType>,
}

impl Member {
    /// Copies the value of an argument into a record.
    ///
    /// # Safety
    /// `from` holds a value of the type in the codels' language, `to` one in C layout.
    unsafe fn take(&self, from: *const u8, to: *mut u8) {
        // SAFETY: the caller's promise.
        unsafe {
            match &self.cxx {
                Some(ty) => to_c(ty, from, to),
                None => foreign::copy_value(&self.ty, from, to),
            }
        }
    }

    /// Copies a value from a record to an argument. A `fresh` argument holds no value that has to
    /// be released.
    ///
    /// # Safety
    /// As for `take`, in the other direction; a fresh argument in C is memory for the type.
    unsafe fn give(&self, from: *const u8, to: *mut u8, fresh: bool) {
        // SAFETY: the caller's promise; in C++ a reference always points to a value.
        unsafe {
            match &self.cxx {
                Some(ty) => to_cxx(ty, from, to),
                None => {
                    if fresh {
                        to.write_bytes(0, self.ty.size());
                        foreign::init_value(&self.ty, to);
                    }
                    foreign::copy_value(&self.ty, from, to);
                }
            }
        }
    }
}

impl Signature {
    /// Lays out the parameters with `lay_out`, which records errors.
    pub(crate) fn new(
        remote: &Remote,
        in_cxx: bool,
        mut lay_out: impl FnMut(TypeId, &str, Span) -> Option<DataType>,
    ) -> Option<Self> {
        let input =
            lay_out(remote.input, &format!("inputs of remote `{}`", remote.name), remote.span);
        let output =
            lay_out(remote.output, &format!("outputs of remote `{}`", remote.name), remote.span);
        let (input, output) = (input?, output?);
        let member = |record: &DataType, rank: &mut usize| {
            let (ty, offset) = (record.member(*rank)?, record.member_offset(*rank)?);
            // A type without a C++ equivalent is reported with the types of the component.
            let cxx = if in_cxx { Some(CxxType::new(&ty).ok()?) } else { None };
            let found = Member { ty, offset, cxx };
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
                class: match in_cxx {
                    true => Class::of_cxx(kind, parameter.direction),
                    false => Class::of(kind, parameter.direction),
                },
                input: into,
                output: out,
            });
        }
        Some(Self { name: remote.name.clone(), parameters, input, output })
    }
}

/// The remotes of one component.
pub(crate) struct Remotes(Indexed<RemoteIx, Handle>);

/// `comp_r` of genom3.md 5.8 or 6, and the state of its function.
struct Handle {
    /// In C, the function. In C++, the object: first the address of the functions in the vtable,
    /// then the vtable itself (offset to top, type, function).
    table: Box<[usize; 4]>,
    state: Arc<State>,
    _function: NativeFunction,
}

/// State of a remote's function.
struct State {
    signature: Signature,
    shared: Arc<Shared>,
    details: Arc<Details>,
    /// For codels in C++.
    exceptions: Option<Arc<Exceptions>>,
    /// Codels of several tasks may call at the same time; the calls are serialised.
    link: Mutex<Link>,
}

struct Link {
    call: Option<Box<dyn RemoteCall>>,
    input: Record,
    output: Record,
    /// Owns the memory that the last recorded detail points to.
    detail: Option<Detail>,
}

impl Remotes {
    /// Handles for remotes; `None` when there is no memory for executable code.
    pub(crate) fn new(
        signatures: Indexed<RemoteIx, Signature>,
        shared: &Arc<Shared>,
        details: &Arc<Details>,
        exceptions: Option<&Arc<Exceptions>>,
    ) -> Option<Self> {
        let handle = |signature: Signature| {
            let classes: Vec<Class> =
                signature.parameters.iter().map(|parameter| parameter.class).collect();
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
                exceptions: exceptions.map(Arc::clone),
                link: Mutex::new(link),
            });
            let data = Arc::clone(&state);
            let (mut table, function) = match exceptions {
                // genom_context self
                None => {
                    let classes = [&classes[..], &[Class::Address]].concat();
                    let function = NativeFunction::new(&classes, call, data)?;
                    (Box::new([function.address(), 0, 0, 0]), function)
                }
                // this
                Some(_) => {
                    let classes = [&[Class::Address], &classes[..]].concat();
                    let function = NativeFunction::throwing(&classes, call_in_cxx, data)?;
                    (Box::new([0, 0, Exceptions::base_type(), function.address()]), function)
                }
            };
            if exceptions.is_some() {
                table[0] = (&raw const table[3]) as usize;
            }
            Some(Handle { table, state, _function: function })
        };
        signatures.into_iter().map(handle).collect::<Option<_>>().map(Self)
    }

    /// The pointer that codels get for the remote.
    pub(crate) fn handle(&self, remote: RemoteIx) -> *const c_void {
        self.0[remote].table.as_ptr().cast()
    }

    /// Connects a remote, or disconnects it with `None`.
    pub(crate) fn bind(&self, remote: RemoteIx, call: Option<Box<dyn RemoteCall>>) {
        if let Some(handle) = self.0.get(remote) {
            handle.state.link.lock().unwrap_or_else(PoisonError::into_inner).call = call;
        }
    }
}

/// The implementation of every remote's function.
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

/// The implementation of every remote's function for codels in C++.
fn call_in_cxx(state: &Arc<State>, arguments: Arguments<'_>) -> *const Raise {
    let mut link = state.link.lock().unwrap_or_else(PoisonError::into_inner);
    let (Err((name, detail)), Some(exceptions)) =
        (state.call(&mut link, arguments), &state.exceptions)
    else {
        return std::ptr::null();
    };
    exceptions.raise(&name, detail.unwrap_or(Detail::Bytes(Vec::new())))
}

/// An exception for the calling codel.
type Thrown = (String, Option<Detail>);

impl State {
    /// Sends the arguments, waits, and stores the outputs.
    fn call(&self, link: &mut Link, arguments: Arguments<'_>) -> Result<(), Thrown> {
        // In C++ the object comes first.
        let first = usize::from(self.exceptions.is_some());
        let parameters = || (first..).zip(&self.signature.parameters);
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
            let Some(member) = &parameter.input else { continue };
            // SAFETY: the argument has the class of its type, so it is, or points to, a value of
            // that type; the member of the record is another one.
            unsafe {
                let from = parameter.place(arguments, rank);
                member.take(from, link.input.as_mut_ptr().add(member.offset));
            }
        }
        link.output.clear();
        remote.call(&link.input, &mut link.output).map_err(|(name, detail)| {
            let known = self.details.is_exception(&name)
                || self.shared.events.get().pointer(&name).is_some();
            if known {
                let detail = self.details.make(&name, &detail);
                (name, detail)
            } else {
                self.unkex(&name)
            }
        })?;
        for (rank, parameter) in parameters() {
            let Some(member) = &parameter.output else { continue };
            let to = arguments.pointer(rank);
            // SAFETY: as above. The target of an `out` argument need not hold a value yet, so
            // nothing of it is released; that of `inout` holds one.
            unsafe {
                let from = link.output.as_ptr().add(member.offset);
                member.give(from, to, parameter.direction == Direction::Out);
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
    /// Address of the value of argument `rank`.
    fn place(&self, arguments: Arguments<'_>, rank: usize) -> *const u8 {
        match self.class {
            Class::Value(_) | Class::Held => arguments.place(rank),
            Class::Address => arguments.pointer(rank),
        }
    }
}
