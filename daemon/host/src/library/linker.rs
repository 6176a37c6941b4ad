//! The dynamic linker: opening a file, finding symbols. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ops::Range;
use std::os::unix::ffi::OsStrExt as _;
use std::path::Path;

use libloading::os::unix;

use crate::ffi::WHAT;
use crate::last_words;

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
pub(super) struct Handle(Option<unix::Library>);

impl Handle {
    /// Opens `file`, a copy of `library`, with all symbols bound now and none of them visible to
    /// others.
    pub(super) fn open(file: &Path, library: &Path) -> Result<Self, String> {
        let name = CString::new(file.as_os_str().as_bytes()).map_err(|error| error.to_string())?;
        let words = format!("a constructor of {}", library.display());
        let (mut handle, mut what) = (std::ptr::null_mut(), [0u8; WHAT]);
        let running = last_words::running(&words);
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
        drop(running);
        if handle.is_null() {
            // SAFETY: what the dynamic linker says of the last call of this thread, if anything.
            let said = unsafe { libc::dlerror().as_ref() }
                // SAFETY: it says it as a string, until the next call.
                .map(|said| unsafe { CStr::from_ptr(said) }.to_string_lossy().into_owned())
                .unwrap_or_default();
            let own = format!("{}: ", file.display());
            return Err(said.strip_prefix(&own).unwrap_or(&said).to_owned());
        }
        // SAFETY: the dynamic linker just gave this handle, to nobody else.
        Ok(Self(Some(unsafe { unix::Library::from_raw(handle) })))
    }

    /// Address of a symbol.
    pub(super) fn symbol(&self, name: &str) -> Option<usize> {
        // SAFETY: only the address is taken; nothing is read or called through it here.
        let symbol = unsafe { self.0.as_ref()?.get::<*const c_void>(name) }.ok()?;
        let address = symbol.as_raw_ptr() as usize;
        (address != 0).then_some(address)
    }

    /// Calls the library's functions for the end as closing does, the last one first, and sees to
    /// it that closing does not call them again.
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
        std::mem::forget(self.0.take());
    }
}

/// Part of a file in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mapping {
    /// Where it lies.
    pub(super) range: Range<usize>,
    /// Whether the process may write there.
    pub(super) writable: bool,
    /// Whether code lies there.
    pub(super) executable: bool,
    /// The file.
    pub(super) file: String,
}

/// Every file that is mapped now.
pub(super) fn mappings() -> Vec<Mapping> {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    maps.lines().filter_map(mapping).collect()
}

/// Reads a line of `/proc/self/maps`.
fn mapping(line: &str) -> Option<Mapping> {
    // from-to rights offset device inode path
    let mut words = line.splitn(6, ' ');
    let (from, to) = words.next()?.split_once('-')?;
    let rights = words.next()?;
    let (writable, executable) = (rights.contains('w'), rights.contains('x'));
    let file = words.nth(3)?.trim_start().to_owned();
    let address = |text| usize::from_str_radix(text, 16).ok();
    Some(Mapping { range: address(from)?..address(to)?, writable, executable, file })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_maps_is_read() {
        let line = "7f00-7f10 r--p 00000000 08:01 42      /tmp/my lib.so";
        let file = "/tmp/my lib.so".to_owned();
        let range = 0x7f00..0x7f10;
        let read = Mapping { range, writable: false, executable: false, file };
        assert_eq!(mapping(line), Some(read));
        assert!(mapping("7f00-7f10 rw-p 00000000 08:01 42 /x").is_some_and(|m| m.writable));
        assert!(mapping("7f00-7f10 r-xp 00000000 08:01 42 /x").is_some_and(|m| m.executable));
        assert_eq!(mapping("garbage"), None);
        assert_eq!(mapping("7f00-7f10 rw-p 00000000 00:00 0"), None, "no file");
    }
}
