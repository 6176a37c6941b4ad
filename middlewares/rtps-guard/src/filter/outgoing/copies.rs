//! Copies of large samples for readers that have several addresses on this machine.
//!
//! A reader announces the addresses of all interfaces, and RustDDS 0.15.1 sends to each of them
//! unless the reader sends from one of these itself (`rtps/writer.rs`, `send_message_to_readers`).
//! So on a machine with another interface, such as that of a container engine, each image comes
//! twice. A socket that is bound to no address hears its port on all of them: there one is enough.

use std::io::ErrorKind;
use std::net::{Ipv4Addr, UdpSocket};

use super::super::message::Entity;
use super::cut::Cut;
use super::wire::Target;

/// An address of this machine that nobody has a reason to bind a socket to.
const NOBODYS: Ipv4Addr = Ipv4Addr::new(127, 83, 71, 59);

/// Pairs of a writer and a reader's port that are remembered.
const MOST: usize = 256;

/// How far a sample has gone to the first address of a reader.
#[derive(Debug)]
struct Progress {
    to: Target,
    ends: (Entity, Entity),
    number: i64,
    next: u32,
    /// Whether one socket hears the port on all addresses.
    one: bool,
}

#[derive(Debug, Default)]
pub(crate) struct Copies(Vec<Progress>);

impl Copies {
    /// Whether the reader at an address of this machine gets this part at another one.
    pub(crate) fn has(&mut self, to: &Target, cut: &Cut) -> bool {
        let (port, ends) = (to.address.port(), (cut.writer, cut.reader));
        let of = |one: &&mut Progress| {
            (one.to.socket, one.to.address.port(), one.ends) == (to.socket, port, ends)
        };
        let (number, next) = (cut.number, cut.end());
        let Some(first) = self.0.iter_mut().find(of) else {
            if self.0.len() >= MOST {
                self.0.remove(0);
            }
            self.0.push(Progress { to: *to, ends, number, next, one: false });
            return false;
        };
        if first.to != *to && first.number == number && next <= first.next {
            if cut.first == 1 {
                first.one = is_heard_everywhere(port);
            }
            return first.one;
        }
        // The address that is used first, also if it was another one before.
        first.one &= first.to == *to;
        (first.to, first.number, first.next) = (*to, number, next);
        false
    }
}

/// Whether a socket that is bound to no address has this port.
fn is_heard_everywhere(port: u16) -> bool {
    let bound = UdpSocket::bind((NOBODYS, port));
    bound.is_err_and(|error| error.kind() == ErrorKind::AddrInUse)
}

#[cfg(test)]
mod tests {
    use std::net::SocketAddrV4;

    use super::super::super::tests::forger::{Forger, USER, fragment};
    use super::*;

    const US: Forger = Forger(*b"\x01\x12ourselves.");
    const ONE: Ipv4Addr = Ipv4Addr::LOCALHOST;
    const OTHER: Ipv4Addr = Ipv4Addr::new(127, 0, 0, 2);

    /// A part of a sample of three.
    fn part(number: i64, first: u32) -> Cut {
        let message = US.message(&[fragment(USER, number, (first, 1, 100), 300, &[0; 100])]);
        Cut::read(&message).unwrap()
    }

    /// Where the parts of a sample go that are sent to these addresses.
    fn sent(copies: &mut Copies, number: i64, port: u16, to: &[Ipv4Addr]) -> Vec<Ipv4Addr> {
        let all = (1..=3).flat_map(|first| to.iter().map(move |to| (first, *to)));
        let goes = |(first, to): &(u32, Ipv4Addr)| {
            let target = Target { socket: 3, address: SocketAddrV4::new(*to, port) };
            !copies.has(&target, &part(number, *first))
        };
        all.filter(goes).map(|(_, to)| to).collect()
    }

    #[test]
    fn a_socket_that_hears_all_addresses_gets_one_copy() {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
        let port = socket.local_addr().unwrap().port();
        let mut copies = Copies::default();
        for number in [1, 2, 2] {
            assert_eq!(sent(&mut copies, number, port, &[ONE, OTHER]), [ONE; 3]);
        }
        // It has another address from now on, and both in another order.
        assert_eq!(sent(&mut copies, 3, port, &[OTHER]), [OTHER; 3]);
        assert_eq!(sent(&mut copies, 4, port, &[OTHER, ONE]), [OTHER; 3]);
        assert_eq!(sent(&mut copies, 4, port, &[ONE]).len(), 0, "it has those");
        assert_eq!(sent(&mut copies, 5, port, &[ONE]), [ONE; 3]);
    }

    #[test]
    fn sockets_that_hear_one_address_each_get_one_each() {
        let socket = UdpSocket::bind((ONE, 0)).unwrap();
        let port = socket.local_addr().unwrap().port();
        let mut copies = Copies::default();
        for number in 1..3 {
            let to = sent(&mut copies, number, port, &[ONE, OTHER]);
            assert_eq!(to, [ONE, OTHER, ONE, OTHER, ONE, OTHER]);
        }
    }
}
