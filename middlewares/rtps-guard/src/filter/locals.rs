//! Which addresses are of this machine.

use std::net::{IpAddr, Ipv4Addr, UdpSocket};

/// Addresses that are remembered.
const MOST: usize = 1024;

/// What was found out; an address is asked about once.
#[derive(Debug, Default)]
pub(crate) struct Locals(Vec<(Ipv4Addr, bool)>);

impl Locals {
    pub(crate) fn has(&mut self, address: Ipv4Addr) -> bool {
        if let Some((_, is)) = self.0.iter().find(|(of, _)| *of == address) {
            return *is;
        }
        if self.0.len() >= MOST {
            return false;
        }
        let is = is_local(address);
        self.0.push((address, is));
        is
    }
}

/// The system sends from the same address to one of its own, and from another one to all others. No
/// datagram is sent.
fn is_local(address: Ipv4Addr) -> bool {
    if address.is_loopback() {
        return true;
    }
    if address.is_multicast() || address.is_broadcast() || address.is_unspecified() {
        return false;
    }
    let from = || {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        socket.connect((address, 9))?;
        socket.local_addr()
    };
    from().is_ok_and(|from| from.ip() == IpAddr::V4(address))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_of_the_machine_are_told_from_others() {
        let mut locals = Locals::default();
        for _ in 0..2 {
            assert!(locals.has(Ipv4Addr::LOCALHOST));
            assert!(locals.has(Ipv4Addr::new(127, 0, 0, 2)));
            // RFC 5737: of nobody.
            assert!(!locals.has(Ipv4Addr::new(203, 0, 113, 7)));
            assert!(!locals.has(Ipv4Addr::new(239, 255, 0, 1)));
        }
    }
}
