//! Calls of functions that genomd passed.

use std::ffi::{CStr, c_char, c_void};

use libffi::middle::{Arg, Cif, CodePtr, Type};

use super::memory::At;

/// How C passes an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    Address,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Class {
    pub(super) fn in_libffi(self) -> Type {
        match self {
            Self::Address => Type::pointer(),
            Self::U8 => Type::u8(),
            Self::I16 => Type::i16(),
            Self::U16 => Type::u16(),
            Self::I32 => Type::i32(),
            Self::U32 => Type::u32(),
            Self::I64 => Type::i64(),
            Self::U64 => Type::u64(),
            Self::F32 => Type::f32(),
            Self::F64 => Type::f64(),
        }
    }
}

/// The address of a function.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Function(usize);

impl Function {
    /// One of ours.
    pub(super) fn at(address: usize) -> Self {
        Self(address)
    }

    /// That at this rank of a table.
    pub(crate) fn of(table: At, rank: usize) -> Option<Self> {
        table.plus(rank * size_of::<usize>()).follow().map(|function| Self(function.address()))
    }
}

fn found(address: *const c_void) -> Option<At> {
    (!address.is_null()).then(|| At::new(address))
}

/// Calls a function of a port: it takes the context.
pub(crate) fn simple(function: Function, context: At) -> Option<At> {
    type Simple = unsafe extern "C" fn(*mut c_void) -> *const c_void;
    // SAFETY: functions of a port that is not multiple are of this type.
    let function: Simple = unsafe { std::mem::transmute(function.0) };
    // SAFETY: the codel that was passed the port has not returned.
    found(unsafe { function(context.pointer()) })
}

/// Calls a function of a multiple port: it takes the name of an element, and the context.
pub(crate) fn named(function: Function, element: &CStr, context: At) -> Option<At> {
    type Named = unsafe extern "C" fn(*const c_char, *mut c_void) -> *const c_void;
    // SAFETY: functions of a multiple port are of this type.
    let function: Named = unsafe { std::mem::transmute(function.0) };
    // SAFETY: as in `simple`.
    found(unsafe { function(element.as_ptr(), context.pointer()) })
}

/// Calls a remote: its arguments lie at these places, and the context is the last one.
pub(crate) fn passed(function: Function, arguments: &[(Class, At)], context: At) -> Option<At> {
    let types = arguments.iter().map(|(class, _)| class.in_libffi());
    let types: Vec<Type> = types.chain([Type::pointer()]).collect();
    let cif = Cif::new(types, Type::pointer());
    let pointer = context.pointer();
    let each = arguments.iter().map(|(_, at)| {
        // SAFETY: a value of its class lies there; libffi reads no more.
        Arg::new(unsafe { &*at.pointer().cast::<u8>() })
    });
    let each: Vec<Arg<'_>> = each.chain([Arg::new(&pointer)]).collect();
    // SAFETY: the function of a remote has these parameters, as the description says.
    found(unsafe {
        cif.call::<*const c_void>(CodePtr::from_ptr(function.0 as *const c_void), &each)
    })
}

/// Calls a codel with one argument, an address, or with none.
pub(crate) fn codel(function: Function, argument: Option<At>, context: At) -> Option<At> {
    let pointer = context.pointer();
    let event = match argument.map(At::address) {
        Some(address) => {
            type Codel = unsafe extern "C" fn(usize, *mut c_void) -> *const c_void;
            // SAFETY: the codel was made for one address.
            let function: Codel = unsafe { std::mem::transmute(function.0) };
            // SAFETY: what lies there, and the context, live longer than the call.
            unsafe { function(address, pointer) }
        }
        None => {
            type Codel = unsafe extern "C" fn(*mut c_void) -> *const c_void;
            // SAFETY: the codel was made for no parameters.
            let function: Codel = unsafe { std::mem::transmute(function.0) };
            // SAFETY: as above.
            unsafe { function(pointer) }
        }
    };
    found(event)
}

/// A context of this program: an exception is its event, without detail.
#[derive(Debug)]
pub(crate) struct Context([usize; 2]);

impl Default for Context {
    fn default() -> Self {
        unsafe extern "C" fn raise(event: usize, _: usize, _: usize, _: usize) -> usize {
            event
        }
        Self([raise as unsafe extern "C" fn(usize, usize, usize, usize) -> usize as usize, 0])
    }
}

impl Context {
    pub(crate) fn at(&mut self) -> At {
        At::new(self.0.as_mut_ptr().cast())
    }
}

/// Records an exception with its detail in the context; returns what the codel is to return.
pub(crate) fn raise(context: At, event: usize, detail: At, size: usize) -> usize {
    type Raise = unsafe extern "C" fn(usize, *const c_void, usize, *mut c_void) -> usize;
    let Some(function) = context.follow() else { return event };
    // SAFETY: the first function of a context is of this type.
    let function: Raise = unsafe { std::mem::transmute(function.address()) };
    // SAFETY: the detail has this size, and is copied; the context is that of the call.
    unsafe { function(event, detail.pointer(), size, context.pointer()) }
}

/// The detail of the exception that was recorded last in the context, if it is this one.
pub(crate) fn raised(context: At, event: At) -> Option<At> {
    type Raised = unsafe extern "C" fn(*mut *const c_void, *mut c_void) -> *const c_void;
    let function = context.plus(size_of::<usize>()).follow()?;
    // SAFETY: the second function of a context is of this type.
    let function: Raised = unsafe { std::mem::transmute(function.address()) };
    let mut recorded = std::ptr::null();
    // SAFETY: the context is that of the call.
    let detail = unsafe { function(&raw mut recorded, context.pointer()) };
    found(detail).filter(|_| recorded as usize == event.address())
}
