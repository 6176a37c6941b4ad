//! What C++ exceptions say of themselves.

/// Bytes kept of it, its NUL included: as in `genom_unkex_detail`.
pub(crate) const WHAT: usize = 128;
