//! The dynamic linker: opening a file, finding symbols. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::c_void;
use std::ops::Range;
use std::path::Path;

use libloading::os::unix;

/// An open library as the dynamic linker knows it; closed when dropped.
#[derive(Debug)]
pub(super) struct Handle(unix::Library);

impl Handle {
    /// Opens `file` with all symbols bound now and none of them visible to others.
    pub(super) fn open(file: &Path) -> Result<Self, String> {
        // SAFETY: the file was checked to be a complete shared object of this machine. Its
        // constructors run foreign code: that is what hosting a component means.
        let library = unsafe { unix::Library::open(Some(file), unix::RTLD_NOW | unix::RTLD_LOCAL) };
        library.map(Self).map_err(|error| {
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
        let symbol = unsafe { self.0.get::<*const c_void>(name) }.ok()?;
        let address = symbol.as_raw_ptr() as usize;
        (address != 0).then_some(address)
    }
}

/// Address ranges that `file` is mapped to and that nothing may write.
pub(super) fn constants(file: &Path) -> Vec<Range<usize>> {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let name = file.to_string_lossy();
    maps.lines().filter_map(|line| constant_range(line, &name)).collect()
}

/// The range of a line of `/proc/self/maps` that maps `file` without the right to write.
fn constant_range(line: &str, file: &str) -> Option<Range<usize>> {
    // from-to rights offset device inode path
    let mut words = line.splitn(6, ' ');
    let (from, to) = words.next()?.split_once('-')?;
    let rights = words.next()?;
    let path = words.nth(3)?.trim_start();
    let mapped = path == file && !rights.contains('w');
    let address = |text| usize::from_str_radix(text, 16).ok();
    mapped.then_some(address(from)?..address(to)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_unwritable_mappings_of_the_file_are_constant() {
        let line = "7f00-7f10 r--p 00000000 08:01 42      /tmp/my lib.so";
        assert_eq!(constant_range(line, "/tmp/my lib.so"), Some(0x7f00..0x7f10));
        assert_eq!(constant_range(line, "/tmp/lib.so"), None);
        let writable = "7f00-7f10 rw-p 00000000 08:01 42      /tmp/my lib.so";
        assert_eq!(constant_range(writable, "/tmp/my lib.so"), None);
        assert_eq!(constant_range("garbage", "garbage"), None);
    }
}
