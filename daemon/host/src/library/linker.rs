//! The dynamic linker: opening a file, finding symbols. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ops::Range;
use std::os::unix::ffi::OsStrExt as _;
use std::path::Path;

use libloading::os::unix;

use super::elf::Segment;
use super::error::LinkError;
use crate::last_words;
use crate::running;
use crate::what::WHAT;

unsafe extern "C" {
    /// `dlopen`, and 1 if a constructor threw: `what` then says what, with its NUL.
    fn genom_host_guarded_open(
        file: *const c_char,
        mode: c_int,
        handle: *mut *mut c_void,
        what: *mut c_char,
        room: usize,
    ) -> c_int;
}

/// An open library as the dynamic linker knows it; closed when dropped.
#[derive(Debug)]
pub(super) struct Handle {
    library: Option<unix::Library>,
    bias: usize,
}

impl Handle {
    /// Opens `file`, a copy of `library`, with all symbols bound now and none of them visible to
    /// others.
    pub(super) fn open(file: &Path, library: &Path) -> Result<Self, LinkError> {
        let name = CString::new(file.as_os_str().as_bytes())
            .map_err(|error| LinkError { said: error.to_string() })?;
        let words = format!("a constructor of {}", library.display());
        let (mut handle, mut what) = (std::ptr::null_mut(), [0u8; WHAT]);
        let constructor = running::running(&words);
        // SAFETY: the file was checked to be a complete shared object of this machine. Its
        // constructors run foreign code: that is what hosting a component means.
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
            // SAFETY: what the dynamic linker says of the last call of this thread, if anything.
            let said = unsafe { libc::dlerror().as_ref() }
                // SAFETY: it says it as a string, until the next call.
                .map(|said| unsafe { CStr::from_ptr(said) }.to_string_lossy().into_owned())
                .unwrap_or_default();
            let own = format!("{}: ", file.display());
            return Err(LinkError { said: said.strip_prefix(&own).unwrap_or(&said).to_owned() });
        }
        // SAFETY: the dynamic linker just gave this handle, to nobody else.
        let library = Some(unsafe { unix::Library::from_raw(handle) });
        Ok(Self { library, bias: bias(handle) })
    }

    /// Where these parts of the file lie. Asked of the linker: the list of all that is mapped
    /// grows with each component.
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
    /// `first` is the first of `count` addresses of such functions (`DT_FINI_ARRAY`), and `size` the
    /// word that tells the dynamic linker how many bytes they take (`DT_FINI_ARRAYSZ`).
    pub(super) unsafe fn finish(&self, first: usize, count: usize, size: usize) {
        type Finisher = Option<unsafe extern "C" fn()>;
        for rank in (0..count).rev() {
            // SAFETY: the caller's promise: such a word leads to a function of this type.
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

    /// Leaves the library open for good.
    pub(super) fn keep(&mut self) {
        std::mem::forget(self.library.take());
    }
}

/// Part of a library in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mapping {
    /// Where it lies.
    pub(super) range: Range<usize>,
    /// Whether the process may write there; what becomes constant once it is linked counts as
    /// written.
    pub(super) writable: bool,
    /// Whether code lies there.
    pub(super) executable: bool,
}

/// The file that holds `address`, as the dynamic linker opened it; empty when it did not.
pub(super) fn file_of(address: usize) -> String {
    // SAFETY: zeros are such a record, and the call fills it.
    let mut found: libc::Dl_info = unsafe { std::mem::zeroed() };
    // SAFETY: any address may be asked for.
    if unsafe { libc::dladdr(address as *const c_void, &raw mut found) } == 0 {
        return String::new();
    }
    // SAFETY: a name that is told is a string of the dynamic linker's, as long as the file is open.
    let name = unsafe { found.dli_fname.as_ref() }.map(|name| unsafe { CStr::from_ptr(name) });
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The beginning of `struct link_map`, which is the same in every C library.
#[repr(C)]
struct LinkMap {
    /// What the file's addresses are moved by.
    bias: usize,
}

/// What the addresses of an open library are moved by.
fn bias(handle: *mut c_void) -> usize {
    let mut map: *const LinkMap = std::ptr::null();
    let place = (&raw mut map).cast();
    // SAFETY: the handle is open, and this request writes a pointer.
    let told = unsafe { libc::dlinfo(handle, libc::RTLD_DI_LINKMAP, place) };
    // SAFETY: the pointer leads to the library's entry, which lives as long as it is open.
    if told == 0 { unsafe { map.as_ref() }.map_or(0, |map| map.bias) } else { 0 }
}
