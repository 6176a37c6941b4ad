//! Sizes and layouts of C++ library objects, as determined by the shim. One of the few unsafe
//! modules.
#![allow(unsafe_code)]

use std::ffi::c_int;
use std::sync::OnceLock;

unsafe extern "C" {
    fn genom_host_cxx_layout_holds() -> c_int;
    fn genom_host_string_size() -> usize;
    fn genom_host_flags_size() -> usize;
}

/// Bytes of `std::string` and of `std::vector<bool>`; `None` when the layout of `std::vector` in
/// this host's C++ library is not the one that this code assumes.
pub(super) fn sizes() -> Option<(usize, usize)> {
    static SIZES: OnceLock<Option<(usize, usize)>> = OnceLock::new();
    // SAFETY: these functions have no precondition.
    *SIZES.get_or_init(|| unsafe {
        (genom_host_cxx_layout_holds() != 0)
            .then(|| (genom_host_string_size(), genom_host_flags_size()))
    })
}
