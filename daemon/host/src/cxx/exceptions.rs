//! C++ exceptions: those thrown by codels become events, and failures of ports are thrown for
//! codels to catch. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char, c_int};
use std::sync::atomic::{AtomicUsize, Ordering};

use genom_types::{DataType, Record};
use serde_json::Value;

use super::error::CxxTypeError;
use super::layout::CxxType;
use super::object;
use super::shim::{self, Raise};
use super::spelling::type_info;
use crate::detail::{Detail, Details, SYSERR, UNKEX};
use crate::library::Library;

/// Offset of `detail` in an exception: after the vtable pointer.
const DETAIL: usize = 8;

/// The exceptions that a component may throw or get.
pub(crate) struct Exceptions {
    by_type: HashMap<String, Known>,
    by_name: HashMap<String, Made>,
}

/// The detail of an exception has no type in C++.
#[derive(Debug, thiserror::Error)]
#[error("exception {exception}: {why}")]
pub(crate) struct DetailError {
    /// Full name of the exception.
    pub(crate) exception: String,
    /// The reason.
    #[source]
    pub(crate) why: CxxTypeError,
}

/// An exception that codels may throw.
struct Known {
    name: String,
    detail: Option<CxxType>,
}

/// What the host needs to make an exception.
struct Made {
    /// Offset to top, type, `what()`, and then for the shim: the name, the function that drops the
    /// detail, the detail's type.
    vtable: Box<[AtomicUsize; 6]>,
    _name: CString,
    detail: Option<Box<CxxType>>,
}

impl Exceptions {
    /// The exceptions of `types`, with their details, and those in `given`, which the host may
    /// throw.
    ///
    /// # Errors
    /// The detail of an exception has no type in C++.
    pub(crate) fn new<'a>(
        library: &Library,
        types: impl Iterator<Item = (&'a str, Option<&'a DataType>)>,
        given: &[&'a str],
    ) -> Result<Self, DetailError> {
        let mut exceptions = Self { by_type: HashMap::new(), by_name: HashMap::new() };
        for (name, detail) in types.chain(given.iter().map(|name| (*name, None))) {
            let detail = detail.map(CxxType::new).transpose();
            let detail = detail.map_err(|why| DetailError { exception: name.to_owned(), why })?;
            exceptions.add(library, name, detail);
        }
        Ok(exceptions)
    }

    fn add(&mut self, library: &Library, name: &str, detail: Option<CxxType>) {
        let Ok(text) = CString::new(name) else { return };
        if self.by_name.contains_key(name) {
            return;
        }
        // The type that `catch` compares with: that of the codels, if they have one.
        let ty = library.symbol(&format!("_ZTI{}", type_info(name)));
        let ty = ty.unwrap_or_else(shim::exception_type);
        let made = detail.clone().map(Box::new);
        let detail_type = made.as_deref().map_or(0, |ty| std::ptr::from_ref(ty) as usize);
        let (what, drop) = (shim::what_function(), destroy as *const () as usize);
        let parts = [0, ty, what, text.as_ptr() as usize, drop, detail_type];
        let vtable = Box::new(parts.map(AtomicUsize::new));
        let known = Known { name: name.to_owned(), detail: detail.clone() };
        self.by_type.insert(type_info(name), known);
        self.by_name.insert(name.to_owned(), Made { vtable, _name: text, detail: made });
    }

    /// Exchanges the types with those of another library for the same exceptions.
    pub(crate) fn exchange_types(&self, other: &Self) {
        for (name, made) in &self.by_name {
            let Some(other) = other.by_name.get(name) else { continue };
            let (own, its) = (&made.vtable[1], &other.vtable[1]);
            its.store(own.swap(its.load(Ordering::Relaxed), Ordering::Relaxed), Ordering::Relaxed);
        }
    }

    /// A type for the vtables that the host makes: `typeid` of such an object is that of the base.
    pub(crate) fn base_type() -> usize {
        shim::exception_type()
    }

    /// Makes the exception that the shim throws. The shim reads it at once: the next one on this
    /// thread replaces it.
    pub(crate) fn raise(&self, name: &str, detail: Detail) -> *const Raise {
        thread_local! {
            static LAST: RefCell<Option<(Raise, Kept)>> = const { RefCell::new(None) };
        }
        let Some(made) = self.by_name.get(name).or_else(|| self.by_name.get("::genom::fatal"))
        else {
            return std::ptr::null();
        };
        let mut raise = Raise {
            vtable: (&raw const made.vtable[2]) as usize,
            ty: made.vtable[1].load(Ordering::Relaxed),
            detail: std::ptr::null(),
            size: made.detail.as_ref().map_or(0, |detail| detail.size()),
            construct: None,
        };
        let kept = match detail {
            Detail::Record(record) if made.detail.is_some() => {
                raise.construct = Some(construct);
                Kept::Record(Box::new(record))
            }
            Detail::Bytes(bytes) if made.detail.as_ref().is_none_or(|ty| ty.is_plain()) => {
                raise.size = bytes.len();
                Kept::Bytes(bytes)
            }
            _ => {
                raise.size = 0;
                Kept::Bytes(Vec::new())
            }
        };
        LAST.with_borrow_mut(|last| {
            let (raise, kept) = last.insert((raise, kept));
            raise.detail = match kept {
                Kept::Record(record) => (&raw const **record).cast(),
                Kept::Bytes(bytes) => bytes.as_ptr(),
            };
            std::ptr::from_ref(raise)
        })
    }
}

/// Keeps the detail of an exception alive.
enum Kept {
    Record(Box<Record>),
    Bytes(Vec<u8>),
}

/// Constructs a detail in memory of the shim.
unsafe extern "C" fn construct(from: *const Record, ty: *const CxxType, to: *mut u8) {
    // SAFETY: `from` is the record of this exception, whose type corresponds to the C++ type in the
    // vtable; the shim allocated the size of that.
    unsafe { object::construct(&*ty, (*from).as_ptr(), to) }
}

/// Drops a detail that [`construct`] made.
unsafe extern "C" fn destroy(ty: *const CxxType, at: *mut u8) {
    // SAFETY: the shim passes the type in the vtable, and a detail that is not used any more.
    unsafe { object::destroy(&*ty, at) }
}

/// Receives exceptions that escape from codels; the guard knows the type of its first field.
#[repr(C)]
pub(crate) struct Catcher {
    caught: unsafe extern "C" fn(*mut Catcher, *const c_char, *const c_char, *const u8) -> c_int,
    exceptions: *const Exceptions,
    found: Option<(String, Option<Value>)>,
    details: *const Details,
}

impl Catcher {
    /// A catcher that recognises these exceptions.
    pub(crate) fn new(exceptions: &Exceptions, details: &Details) -> Self {
        Self { caught, exceptions, found: None, details }
    }

    /// The exception caught: its name and detail.
    pub(crate) fn take(&mut self) -> Option<(String, Option<Value>)> {
        self.found.take()
    }
}

/// Receives an exception of type `ty`; returns 0 when that is unknown.
unsafe extern "C" fn caught(
    this: *mut Catcher,
    ty: *const c_char,
    what: *const c_char,
    object: *const u8,
) -> c_int {
    // SAFETY: the guard passes the catcher it was called with, the name of the exception's type,
    // its message, and the exception, which lives until this returns.
    let (this, ty, what) = unsafe { (&mut *this, CStr::from_ptr(ty), CStr::from_ptr(what)) };
    // SAFETY: both outlive the call that this catcher was made for.
    let (exceptions, details) = unsafe { (&*this.exceptions, &*this.details) };
    let ty = ty.to_string_lossy();
    // An exception that the host threw, and for which the codels have no type.
    let own = || match ty.as_ref() {
        "N5genom9exceptionE" => {
            what.to_str().ok().and_then(|name| exceptions.by_type.get(&type_info(name)))
        }
        _ => None,
    };
    let Some(known) = exceptions.by_type.get(ty.as_ref()).or_else(own) else { return 0 };
    let detail = match (&known.detail, known.name.as_str()) {
        (Some(ty), _) => {
            let mut record = Record::new(ty.c());
            // SAFETY: the exception has a detail of this type after its vtable pointer.
            unsafe { object::to_c(ty, object.add(DETAIL), record.as_mut_ptr()) };
            Some(record.to_json())
        }
        (None, UNKEX) => plain(details, UNKEX, object, 128),
        (None, SYSERR) => plain(details, SYSERR, object, 4),
        _ => None,
    };
    this.found = Some((known.name.clone(), detail));
    1
}

/// The detail of an exception of the run time.
fn plain(details: &Details, name: &str, object: *const u8, size: usize) -> Option<Value> {
    let mut words = vec![0_u64; size.div_ceil(8)];
    // SAFETY: the exception is that of genom3/c++/exception.h, whose size the shim asserts.
    unsafe {
        words.as_mut_ptr().cast::<u8>().copy_from_nonoverlapping(object.add(DETAIL), size);
    }
    details.to_json(name, &words, size)
}
