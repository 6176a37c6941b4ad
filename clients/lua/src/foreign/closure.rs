//! C functions that call this program: codels.

use std::ffi::c_void;
use std::fmt;

use libffi::low;
use libffi::middle::{Cif, Type};

use super::calls::{Class, Function};
use super::memory::At;

/// What a C function calls.
pub(crate) trait Callee: Send + Sync {
    /// Returns the address of an event, or 0.
    fn call(&self, arguments: Arguments) -> usize;
}

/// The arguments of a call, which lie in memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arguments(*const *const c_void);

impl Arguments {
    /// Where an argument lies: its value, or its address.
    pub(crate) fn at(self, rank: usize) -> At {
        // SAFETY: libffi passes as many as the closure was made for, and ranks are of these.
        At::new(unsafe { *self.0.add(rank) })
    }
}

/// Its address has one word, as data of libffi has to have.
struct Held(Box<dyn Callee>);

/// A C function. It returns an address.
pub(crate) struct Closure {
    closure: *mut low::ffi_closure,
    code: usize,
    // libffi keeps the addresses of both.
    cif: Box<Cif>,
    callee: Box<Held>,
}

impl fmt::Debug for Closure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Closure({:#x})", self.code)
    }
}

// SAFETY: it is only called once it is made, and what it calls is `Send` and `Sync`.
unsafe impl Send for Closure {}
// SAFETY: as above.
unsafe impl Sync for Closure {}

impl Closure {
    /// `None` when there is no memory for code.
    pub(crate) fn new(classes: &[Class], callee: Box<dyn Callee>) -> Option<Self> {
        let types = classes.iter().map(|class| class.in_libffi());
        let cif = Box::new(Cif::new(types, Type::pointer()));
        let callee = Box::new(Held(callee));
        let (closure, code) = low::try_closure_alloc()?;
        let address = code.as_ptr() as usize;
        let made = Self { closure, code: address, cif, callee };
        let (cif, callee) = (made.cif.as_raw_ptr(), &raw const *made.callee);
        // SAFETY: closure and code are new and belong together; the interface and the callee are in
        // boxes that live as long.
        unsafe { low::prep_closure(closure, cif, enter, callee, code) }.ok()?;
        Some(made)
    }

    /// For C code to call.
    pub(crate) fn address(&self) -> usize {
        self.code
    }

    /// For this program to call.
    pub(crate) fn function(&self) -> Function {
        Function::at(self.code)
    }
}

impl Drop for Closure {
    fn drop(&mut self) {
        // SAFETY: allocated in `new`; genomd says that nothing calls it any more.
        unsafe { low::closure_free(self.closure) };
    }
}

unsafe extern "C" fn enter(
    _: &low::ffi_cif,
    result: &mut usize,
    arguments: *const *const c_void,
    callee: &Held,
) {
    *result = callee.0.call(Arguments(arguments));
}
