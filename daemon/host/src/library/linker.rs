//! The dynamic linker: opening a file, finding symbols. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ops::Range;
use std::os::unix::ffi::OsStrExt as _;
use std::path::{Path, PathBuf};

use libloading::os::unix;

use genom_elf::{OpenError, Segment};

use crate::last_words;
use crate::running;
use crate::what::WHAT;

unsafe extern "C" {
    /// As `dlopen`; returns 1 if a constructor threw, with its message in `what`, NUL-terminated.
    fn genom_host_guarded_open(
        file: *const c_char,
        mode: c_int,
        handle: *mut *mut c_void,
        what: *mut c_char,
        room: usize,
    ) -> c_int;
}

/// The dynamic linker could not open a file.
#[derive(Debug, thiserror::Error)]
#[error("{said}")]
pub(super) struct LinkError {
    /// Its message, without the name of the file.
    pub(super) said: String,
}

impl LinkError {
    /// What it means for `path`, of which a copy was opened.
    pub(super) fn of(&self, path: PathBuf) -> OpenError {
        let said = self.said.as_str();
        if let Some((_, symbol)) = said.split_once("undefined symbol: ") {
            let symbol = symbol.split([',', ' ']).next().unwrap_or(symbol).to_owned();
            return OpenError::UndefinedSymbol { path, symbol };
        }
        if let Some((dependency, _)) = said.split_once(": cannot open shared object file") {
            return OpenError::MissingDependency { path, dependency: dependency.to_owned() };
        }
        OpenError::Refused { path, why: said.to_owned() }
    }
}

/// A library opened by the dynamic linker; closed when dropped.
#[derive(Debug)]
pub(super) struct Handle {
    library: Option<unix::Library>,
    bias: usize,
}

impl Handle {
    /// Opens `file`, a copy of `library`; all its symbols are bound now, and invisible to other
    /// libraries.
    pub(super) fn open(file: &Path, library: &Path) -> Result<Self, LinkError> {
        let name = CString::new(file.as_os_str().as_bytes())
            .map_err(|error| LinkError { said: error.to_string() })?;
        let words = format!("a constructor of {}", library.display());
        let (mut handle, mut what) = (std::ptr::null_mut(), [0u8; WHAT]);
        let constructor = running::running(&words);
        // SAFETY: the file was checked to be a complete shared object for this machine. Its
        // constructors run foreign code, which loading a component implies.
        let threw = unsafe {
            let mode = unix::RTLD_NOW | unix::RTLD_LOCAL;
            let what = what.as_mut_ptr().cast();
            genom_host_guarded_open(name.as_ptr(), mode, &raw mut handle, what, WHAT)
        };
        if threw != 0 {
            let what = CStr::from_bytes_until_nul(&what).unwrap_or_default();
            last_words::constructor_threw(&what.to_string_lossy());
        }
        drop(constructor);
        if handle.is_null() {
            // SAFETY: the error message of this thread's last call, if there is one.
            let said = unsafe { libc::dlerror().as_ref() }
                // SAFETY: it is a C string, valid until the next call.
                .map(|said| unsafe { CStr::from_ptr(said) }.to_string_lossy().into_owned())
                .unwrap_or_default();
            let own = format!("{}: ", file.display());
            return Err(LinkError { said: said.strip_prefix(&own).unwrap_or(&said).to_owned() });
        }
        // SAFETY: the dynamic linker has just returned this handle, to nobody else.
        let library = Some(unsafe { unix::Library::from_raw(handle) });
        Ok(Self { library, bias: bias(handle) })
    }

    /// Where these segments are mapped. Computed from the linker's data: the list of all mappings
    /// of the process grows with each component.
    pub(super) fn place(&self, segments: &[Segment]) -> Vec<Mapping> {
        let at = |address: u64| {
            usize::try_from(address).ok().map(|address| self.bias.wrapping_add(address))
        };
        let place = segments.iter().filter_map(|segment| {
            let Segment { ref range, writable, executable } = *segment;
            Some(Mapping { range: at(range.start)?..at(range.end)?, writable, executable })
        });
        place.collect()
    }

    /// Address of a symbol.
    pub(super) fn symbol(&self, name: &str) -> Option<usize> {
        // SAFETY: only the address is taken; nothing is read or called through it here.
        let symbol = unsafe { self.library.as_ref()?.get::<*const c_void>(name) }.ok()?;
        let address = symbol.as_raw_ptr() as usize;
        (address != 0).then_some(address)
    }

    /// Calls the functions that closing the library would call, the last one first, and marks them
    /// as called.
    ///
    /// # Safety
    /// `first` is the address of a table of `count` such functions (`DT_FINI_ARRAY`), and `size`
    /// the address of its size in bytes, as the dynamic linker sees it (`DT_FINI_ARRAYSZ`).
    pub(super) unsafe fn finish(&self, first: usize, count: usize, size: usize) {
        type Finisher = Option<unsafe extern "C" fn()>;
        for rank in (0..count).rev() {
            // SAFETY: the caller's promise: the table contains functions of this type.
            let finish = unsafe { *(first as *const Finisher).add(rank) };
            if let Some(finish) = finish {
                // SAFETY: closing would call it now.
                unsafe { finish() }
            }
        }
        // SAFETY: the page holds the library's dynamic table, which only the dynamic linker reads.
        unsafe {
            let page = usize::try_from(libc::sysconf(libc::_SC_PAGESIZE)).unwrap_or(4096);
            let start = (size - size % page) as *mut c_void;
            let both = libc::PROT_READ | libc::PROT_WRITE;
            if libc::mprotect(start, page, both) == 0 {
                *(size as *mut usize) = 0;
            }
        }
    }

    /// Keeps the library open for the rest of the process.
    pub(super) fn keep(&mut self) {
        std::mem::forget(self.library.take());
    }
}

/// A segment of a library in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mapping {
    /// Its addresses.
    pub(super) range: Range<usize>,
    /// Whether the process may write there; data that becomes read-only after relocation counts as
    /// writable.
    pub(super) writable: bool,
    /// Whether it contains code.
    pub(super) executable: bool,
}

/// The file that contains `address`, by the path the dynamic linker opened; empty if there is none.
pub(super) fn file_of(address: usize) -> String {
    // SAFETY: all zeros is a valid value, which the call overwrites.
    let mut found: libc::Dl_info = unsafe { std::mem::zeroed() };
    // SAFETY: any address is allowed.
    if unsafe { libc::dladdr(address as *const c_void, &raw mut found) } == 0 {
        return String::new();
    }
    // SAFETY: the name is a C string of the dynamic linker, valid as long as the file is open.
    let name = unsafe { found.dli_fname.as_ref() }.map(|name| unsafe { CStr::from_ptr(name) });
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The first field of `struct link_map`, which is the same in every C library.
#[repr(C)]
struct LinkMap {
    /// Difference between addresses in memory and in the file.
    bias: usize,
}

/// Difference between addresses in memory and in the file, for an open library.
fn bias(handle: *mut c_void) -> usize {
    let mut map: *const LinkMap = std::ptr::null();
    let place = (&raw mut map).cast();
    // SAFETY: the handle is open, and this request writes a pointer.
    let told = unsafe { libc::dlinfo(handle, libc::RTLD_DI_LINKMAP, place) };
    // SAFETY: the pointer points to the library's entry, which is valid while it is open.
    if told == 0 { unsafe { map.as_ref() }.map_or(0, |map| map.bias) } else { 0 }
}
