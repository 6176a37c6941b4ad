//! C++ exceptions: those that codels throw become events, and failures of ports become exceptions
//! that codels can catch. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char, c_int};

use genom_types::{DataType, Record};
use serde_json::Value;

use super::layout::CxxType;
use super::object;
use super::shim::{self, Raise};
use super::spelling::type_info;
use crate::detail::{Details, SYSERR, UNKEX};
use crate::library::Library;

/// Where `detail` lies in an exception: behind the vtable pointer.
const DETAIL: usize = 8;

/// The exceptions a component may throw or be given.
pub(crate) struct Exceptions {
    by_type: HashMap<String, Known>,
    by_name: HashMap<String, Made>,
}

/// An exception of the codels.
struct Known {
    name: String,
    detail: Option<CxxType>,
}

/// What exceptions that the host makes are made of.
struct Made {
    /// Offset to top, type, `what()`, and the name, which that function gives.
    vtable: Box<[usize; 4]>,
    _name: CString,
    detail: Option<CxxType>,
}

impl Exceptions {
    /// Those of `types`, with their details, and those in `given` that the host may throw.
    ///
    /// # Errors
    /// The exception whose detail has no C++ type, and why.
    pub(crate) fn new<'a>(
        library: &Library,
        types: impl Iterator<Item = (&'a str, Option<&'a DataType>)>,
        given: &[&'a str],
    ) -> Result<Self, (String, String)> {
        let mut exceptions = Self { by_type: HashMap::new(), by_name: HashMap::new() };
        for (name, detail) in types.chain(given.iter().map(|name| (*name, None))) {
            let detail = detail.map(CxxType::new).transpose();
            let detail = detail.map_err(|why| (name.to_owned(), why))?;
            exceptions.add(library, name, detail);
        }
        Ok(exceptions)
    }

    fn add(&mut self, library: &Library, name: &str, detail: Option<CxxType>) {
        let Ok(text) = CString::new(name) else { return };
        if self.by_name.contains_key(name) {
            return;
        }
        // What `catch` compares with: the codels' own type where they have one.
        let ty = library.symbol(&format!("_ZTI{}", type_info(name)));
        let ty = ty.unwrap_or_else(shim::exception_type);
        let vtable = Box::new([0, ty, shim::what_function(), text.as_ptr() as usize]);
        let known = Known { name: name.to_owned(), detail: detail.clone() };
        self.by_type.insert(type_info(name), known);
        self.by_name.insert(name.to_owned(), Made { vtable, _name: text, detail });
    }

    /// The exception for the shim to throw. It is read at once: the next one on this thread takes
    /// its place.
    pub(super) fn raise(&self, name: &str, detail: &[u8]) -> *const Raise {
        thread_local! {
            static LAST: RefCell<(Raise, Vec<u64>)> = const {
                RefCell::new((Raise { vtable: 0, ty: 0, detail: std::ptr::null(), size: 0 }, vec![]))
            };
        }
        let Some(made) = self.by_name.get(name).or_else(|| self.by_name.get("::genom::fatal"))
        else {
            return std::ptr::null();
        };
        // Larger than any detail without pointers, which are the only ones the host makes.
        let plain = made.detail.as_ref().is_none_or(|detail| detail.is_plain());
        let detail = if plain { detail } else { &[] };
        LAST.with_borrow_mut(|(raise, words)| {
            words.clear();
            words.resize(detail.len().div_ceil(8), 0);
            for (word, bytes) in words.iter_mut().zip(detail.chunks(8)) {
                let mut whole = [0; 8];
                whole[..bytes.len()].copy_from_slice(bytes);
                *word = u64::from_ne_bytes(whole);
            }
            *raise = Raise {
                vtable: (&raw const made.vtable[2]) as usize,
                ty: made.vtable[1],
                detail: words.as_ptr().cast(),
                size: detail.len(),
            };
            std::ptr::from_ref(raise)
        })
    }
}

/// Told of exceptions that escape codels; the guard knows its first field.
#[repr(C)]
pub(crate) struct Catcher {
    caught: unsafe extern "C" fn(*mut Catcher, *const c_char, *const c_char, *const u8) -> c_int,
    exceptions: *const Exceptions,
    found: Option<(String, Option<Value>)>,
    details: *const Details,
}

impl Catcher {
    /// One that knows these exceptions.
    pub(crate) fn new(exceptions: &Exceptions, details: &Details) -> Self {
        Self { caught, exceptions, found: None, details }
    }

    /// The exception caught: its name and detail.
    pub(crate) fn take(&mut self) -> Option<(String, Option<Value>)> {
        self.found.take()
    }
}

/// Notes an exception of type `ty`; not 0 when it is known.
unsafe extern "C" fn caught(
    this: *mut Catcher,
    ty: *const c_char,
    what: *const c_char,
    object: *const u8,
) -> c_int {
    // SAFETY: the guard passes the catcher it was called with, the names of the exception's type
    // and of itself, and the exception, which lives until this returns.
    let (this, ty, what) = unsafe { (&mut *this, CStr::from_ptr(ty), CStr::from_ptr(what)) };
    // SAFETY: both outlive the call that this catcher was made for.
    let (exceptions, details) = unsafe { (&*this.exceptions, &*this.details) };
    let ty = ty.to_string_lossy();
    // One that the host threw, and that the codels have no type for.
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
            // SAFETY: the exception has a detail of this type, behind its vtable pointer.
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
