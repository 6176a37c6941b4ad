//! The dynamic linker: opening a file, finding symbols. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::c_void;
use std::ops::Range;
use std::path::Path;

use libloading::os::unix;

/// An open library as the dynamic linker knows it; closed when dropped.
#[derive(Debug)]
pub(super) struct Handle(Option<unix::Library>);

impl Handle {
    /// Opens `file` with all symbols bound now and none of them visible to others.
    pub(super) fn open(file: &Path) -> Result<Self, String> {
        // SAFETY: the file was checked to be a complete shared object of this machine. Its
        // constructors run foreign code: that is what hosting a component means.
        let library = unsafe { unix::Library::open(Some(file), unix::RTLD_NOW | unix::RTLD_LOCAL) };
        library.map(|library| Self(Some(library))).map_err(|error| {
            let said = match &error {
                libloading::Error::DlOpen { source, .. } => source.to_string(),
                other => other.to_string(),
            };
            let own = format!("{}: ", file.display());
            said.strip_prefix(&own).unwrap_or(&said).to_owned()
        })
    }

    /// Address of a symbol.
    pub(super) fn symbol(&self, name: &str) -> Option<usize> {
        // SAFETY: only the address is taken; nothing is read or called through it here.
        let symbol = unsafe { self.0.as_ref()?.get::<*const c_void>(name) }.ok()?;
        let address = symbol.as_raw_ptr() as usize;
        (address != 0).then_some(address)
    }

    /// Calls the function that the word at `place` leads to, as closing does.
    ///
    /// # Safety
    /// `place` is the first of the library's finishing functions (`.fini_array`).
    pub(super) unsafe fn finish(&self, place: usize) {
        // SAFETY: the caller's promise: such a word leads to a function of this type.
        let finish = unsafe { *(place as *const Option<unsafe extern "C" fn()>) };
        if let Some(finish) = finish {
            // SAFETY: closing would call it now.
            unsafe { finish() }
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
