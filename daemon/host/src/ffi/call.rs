//! Calls into a library through interfaces prepared at load. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{c_char, c_int, c_void};

use libffi::middle::{Cif, Type};

use super::registers::RegisterPlan;
use super::{Class, Scalar};
use crate::cxx::Catcher;
use crate::what::WHAT;

unsafe extern "C" {
    fn genom_host_guarded_call(
        cif: *mut c_void,
        function: *const c_void,
        result: *mut c_void,
        arguments: *mut *mut c_void,
        what: *mut c_char,
        room: usize,
        who: *mut c_void,
    ) -> c_int;

    fn genom_host_guarded_registers(
        function: *const c_void,
        result: *mut *const c_char,
        integers: *const u64,
        count: usize,
        floats: *const f64,
        what: *mut c_char,
        room: usize,
        who: *mut c_void,
    ) -> c_int;
}

/// No event was returned; the reason is in the buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Thrown {
    /// A C++ exception escaped.
    Exception,
    /// The codel tried to end its thread.
    Left,
}

/// How to call functions of one C type that returns an event.
#[derive(Debug)]
pub(crate) struct Interface {
    cif: Cif,
    /// For calls without libffi, where possible.
    registers: Option<RegisterPlan>,
}

// SAFETY: after construction the interface is only read; it owns what its pointers point to.
unsafe impl Send for Interface {}
// SAFETY: as above.
unsafe impl Sync for Interface {}

impl Interface {
    /// The interface of `genom_event f(arguments)`; `None` when libffi does not support it.
    pub(crate) fn new(arguments: &[Class]) -> Option<Self> {
        let types = arguments.iter().copied().map(ffi_type);
        let cif = Cif::try_new(types, Type::pointer()).ok()?;
        Some(Self { cif, registers: RegisterPlan::new(arguments) })
    }

    /// Returns the libffi interface, for a function that C calls.
    pub(super) fn into_cif(self) -> Cif {
        self.cif
    }

    /// Calls `function`; `arguments` are addresses of the values, one for each argument.
    ///
    /// # Safety
    /// `function` is a C function of this interface, in a library that stays loaded. Each argument
    /// points to a value of its class that nobody changes during the call.
    pub(crate) unsafe fn call(
        &self,
        function: usize,
        arguments: &mut [*mut c_void],
        what: &mut [u8; WHAT],
        who: Option<&mut Catcher>,
    ) -> Result<*const c_char, Thrown> {
        let who = who.map_or(std::ptr::null_mut(), |who| std::ptr::from_mut(who).cast());
        let mut result: *const c_char = std::ptr::null();
        let function = function as *const c_void;
        let what = what.as_mut_ptr().cast();
        let threw = match &self.registers {
            // SAFETY: the caller's promise; both arrays have the sizes that the guard reads.
            Some(plan) => unsafe {
                let values = plan.read(arguments);
                genom_host_guarded_registers(
                    function,
                    &raw mut result,
                    values.integers.as_ptr(),
                    plan.integers(),
                    values.floats.as_ptr().cast(),
                    what,
                    WHAT,
                    who,
                )
            },
            // SAFETY: the caller's promise; `result` has the size of the return type.
            None => unsafe {
                genom_host_guarded_call(
                    self.cif.as_raw_ptr().cast(),
                    function,
                    (&raw mut result).cast(),
                    arguments.as_mut_ptr(),
                    what,
                    WHAT,
                    who,
                )
            },
        };
        match threw {
            0 => Ok(result),
            1 => Err(Thrown::Exception),
            _ => Err(Thrown::Left),
        }
    }
}

fn ffi_type(class: Class) -> Type {
    match class {
        Class::Value(Scalar::Bool | Scalar::U8) => Type::u8(),
        Class::Value(Scalar::I8) => Type::i8(),
        Class::Value(Scalar::I16) => Type::i16(),
        Class::Value(Scalar::U16) => Type::u16(),
        Class::Value(Scalar::I32) => Type::i32(),
        Class::Value(Scalar::U32) => Type::u32(),
        Class::Value(Scalar::I64) => Type::i64(),
        Class::Value(Scalar::U64) => Type::u64(),
        Class::Value(Scalar::F32) => Type::f32(),
        Class::Value(Scalar::F64) => Type::f64(),
        Class::Held | Class::Address => Type::pointer(),
    }
}
