//! Addresses of sockets, as the system writes them.

use std::ffi::c_int;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::ptr;

/// `None` if there is none, or one of another kind than IPv4 and IPv6.
///
/// # Safety
/// `name` is null, or refers to an address of `length` bytes.
pub(super) unsafe fn read(
    name: *const libc::sockaddr,
    length: libc::socklen_t,
) -> Option<SocketAddr> {
    let length = length as usize;
    if name.is_null() || length < size_of::<libc::sa_family_t>() {
        return None;
    }
    // SAFETY: each address begins with its family, and no more is read than that family has.
    unsafe {
        match c_int::from(ptr::read_unaligned(name.cast::<libc::sa_family_t>())) {
            libc::AF_INET if length >= size_of::<libc::sockaddr_in>() => {
                let name = ptr::read_unaligned(name.cast::<libc::sockaddr_in>());
                let address = Ipv4Addr::from(u32::from_be(name.sin_addr.s_addr));
                Some((address, u16::from_be(name.sin_port)).into())
            }
            libc::AF_INET6 if length >= size_of::<libc::sockaddr_in6>() => {
                let name = ptr::read_unaligned(name.cast::<libc::sockaddr_in6>());
                let address = Ipv6Addr::from(name.sin6_addr.s6_addr);
                Some((address, u16::from_be(name.sin6_port)).into())
            }
            _ => None,
        }
    }
}
