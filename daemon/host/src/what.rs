//! Messages of C++ exceptions.

/// Bytes kept of a message, its NUL included: as in `genom_unkex_detail`.
pub(crate) const WHAT: usize = 128;
