//! Ways to arguments, in the layout of either language. One of the few unsafe modules.
#![allow(unsafe_code)]

use genom_types::CompiledPath;

use crate::cxx::CxxPath;

/// The way from a root to a datum.
#[derive(Debug)]
pub(super) enum Way {
    /// In a record.
    C(CompiledPath),
    /// In a C++ object.
    Cxx(CxxPath),
}

impl Way {
    /// Where the datum lies from the root, when no sequence is on the way.
    pub(super) fn constant_offset(&self) -> Option<usize> {
        match self {
            Self::C(path) => path.constant_offset(),
            Self::Cxx(path) => path.constant_offset(),
        }
    }

    /// Address of the datum; `None` when a sequence on the way is too short.
    ///
    /// # Safety
    /// `root` holds a value of the root type, in the way's language, that nobody changes
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
