//! Paths to arguments, in the layout of C or C++. One of the few unsafe modules.
#![allow(unsafe_code)]

use genom_types::CompiledPath;

use crate::cxx::CxxPath;

/// The path from a root to a datum.
#[derive(Debug)]
pub(super) enum Way {
    /// In a record.
    C(CompiledPath),
    /// In a C++ object.
    Cxx(CxxPath),
}

impl Way {
    /// Offset of the datum from the root in bytes, when no sequence is on the path.
    pub(super) fn constant_offset(&self) -> Option<usize> {
        match self {
            Self::C(path) => path.constant_offset(),
            Self::Cxx(path) => path.constant_offset(),
        }
    }

    /// Address of the datum; `None` when a sequence on the path is too short.
    ///
    /// # Safety
    /// `root` holds a value of the root type, in the path's language, that nobody changes
    /// meanwhile.
    pub(super) unsafe fn locate(&self, root: *mut u8) -> Option<*mut u8> {
        // SAFETY: the caller's promise.
        unsafe {
            match self {
                Self::C(path) => path.locate(root),
                Self::Cxx(path) => path.locate(root),
            }
        }
    }
}
