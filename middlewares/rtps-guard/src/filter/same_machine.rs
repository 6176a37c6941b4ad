//! Peers on this machine, which are reached over the loopback interface.
//!
//! A peer announces the addresses of all interfaces. RustDDS 0.15.1 sends to each of them, in datagrams
//! that fit the smallest network that one is on, also if the peer is on this machine: an image of 6 MB
//! goes as thousands of small datagrams, and once more for each further interface, such as that of a
//! container engine. Only to a peer that announced the loopback address, and that sends from there,
//! does it send once, in datagrams of nearly 64 KiB (`rtps/transmit.rs`, `is_same_host`). Few peers do,
//! but the socket of most is bound to no address, and hears its port on all. Where that is so, the
//! loopback address takes the place of those that were announced, and of that which it sends from.

use std::io::ErrorKind;
use std::net::{IpAddr, Ipv4Addr, SocketAddrV4, UdpSocket};

use super::discovery::{Locator, UNICAST};
use super::locals::Locals;

/// An address of this machine that nobody has a reason to bind a socket to.
const NOBODYS: Ipv4Addr = Ipv4Addr::new(127, 83, 71, 59);

/// Before the value of a parameter are its id and its length.
const HEAD: usize = 4;

/// The id of a parameter that means nothing (9.6.4).
const PAD: [u8; 2] = [0; 2];

#[derive(Debug, Default)]
pub(crate) struct SameMachine {
    locals: Locals,
    /// Whether RustDDS has to see the present datagram come from the loopback address: an announcement
    /// in it was rewritten.
    needs_loopback: bool,
}

impl SameMachine {
    /// Another datagram comes.
    pub(crate) fn begin(&mut self) {
        self.needs_loopback = false;
    }

    /// Whether RustDDS has to see the present datagram come from the loopback address.
    pub(crate) fn needs_loopback(&self) -> bool {
        self.needs_loopback
    }

    /// Rewrites the payload of an announcement, in which these locators were read, if it comes from an
    /// address of this machine.
    pub(crate) fn rewrite(
        &mut self,
        payload: &mut [u8],
        locators: &[Locator],
        from: Option<IpAddr>,
    ) {
        if !matches!(from, Some(IpAddr::V4(from)) if self.locals.has(from)) {
            return;
        }
        for id in UNICAST {
            let all = locators.iter().filter(|one| one.id == id);
            // Over others than of IPv4 the peer may be meant to be reached.
            let all: Option<Vec<_>> = all.map(|one| Some((one.at, one.address?))).collect();
            let Some(all) = all else { continue };
            let known = matches!(all[..], [(_, at)] if *at.ip() == Ipv4Addr::LOCALHOST);
            if known || !all.iter().all(|(_, at)| self.locals.has(*at.ip())) {
                continue;
            }
            let mut ports: Vec<u16> = all.iter().map(|(_, at)| at.port()).collect();
            ports.sort_unstable();
            ports.dedup();
            if ports.into_iter().all(is_heard_everywhere) {
                replace(payload, &all);
                self.needs_loopback |= !all.is_empty();
            }
        }
    }
}

/// Puts the loopback address in the place of the first locator of each port; the others become padding.
fn replace(payload: &mut [u8], all: &[(usize, SocketAddrV4)]) {
    for (rank, (at, address)) in all.iter().enumerate() {
        let first = all.iter().position(|(_, other)| other.port() == address.port());
        let (place, bytes) = match first {
            Some(first) if first == rank => {
                (at + Locator::ADDRESS, &Ipv4Addr::LOCALHOST.octets()[..])
            }
            _ => (at - HEAD, &PAD[..]),
        };
        if let Some(place) = payload.get_mut(place..place + bytes.len()) {
            place.copy_from_slice(bytes);
        }
    }
}

/// Whether a socket that is bound to no address has this port.
fn is_heard_everywhere(port: u16) -> bool {
    let bound = UdpSocket::bind((NOBODYS, port));
    bound.is_err_and(|error| error.kind() == ErrorKind::AddrInUse)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use super::super::discovery::{UDP_V4, UDP_V6, read};
    use super::super::tests::forger::{Forger, data};
    use super::super::{Guard, Limits};
    use super::*;

    const PEER: Forger = Forger(*b"\x01\x10somebody..");

    const OTHER: Ipv4Addr = Ipv4Addr::new(127, 0, 0, 2);
    /// RFC 5737: of nobody.
    const FAR: Ipv4Addr = Ipv4Addr::new(203, 0, 113, 7);

    fn locator(kind: u32, port: u16, address: Ipv4Addr, little: bool) -> Vec<u8> {
        let four = |n: u32| if little { n.to_le_bytes() } else { n.to_be_bytes() };
        [&four(kind)[..], &four(port.into()), &[0; 12], &address.octets()].concat()
    }

    /// An announcement with these locators under an id.
    fn announced(id: u16, little: bool, all: &[Vec<u8>]) -> Vec<u8> {
        let two = |n: u16| if little { n.to_le_bytes() } else { n.to_be_bytes() };
        let mut payload = vec![0, 2 + u8::from(little), 0, 0];
        for value in all {
            payload.extend([two(id), two(24)].concat());
            payload.extend(value);
        }
        payload.extend([two(1), two(0)].concat());
        payload
    }

    fn rewrite(same: &mut SameMachine, payload: &mut [u8], from: Option<Ipv4Addr>) {
        let announced = read(payload, &PEER.0).unwrap();
        same.rewrite(payload, &announced.unicast, from.map(IpAddr::V4));
    }

    /// What is left of the locators of an announcement.
    fn left(id: u16, little: bool, all: &[(u16, Ipv4Addr)]) -> Vec<(u16, Ipv4Addr)> {
        let values: Vec<_> =
            all.iter().map(|(port, address)| locator(UDP_V4, *port, *address, little)).collect();
        let mut payload = announced(id, little, &values);
        let mut unseen = payload.clone();
        let mut same = SameMachine::default();
        rewrite(&mut same, &mut unseen, Some(FAR));
        rewrite(&mut same, &mut unseen, None);
        assert_eq!((&unseen, same.needs_loopback()), (&payload, false), "it comes from elsewhere");
        rewrite(&mut same, &mut payload, Some(OTHER));
        assert_eq!(same.needs_loopback(), payload != unseen);
        assert_eq!(payload.len(), unseen.len());
        let left = read(&payload, &PEER.0).unwrap().unicast;
        assert!(left.iter().all(|one| one.id == id));
        left.into_iter().filter_map(|one| Some((one.address?.port(), *one.address?.ip()))).collect()
    }

    /// A socket that hears everywhere, and its port.
    fn open() -> (UdpSocket, u16) {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
        let port = socket.local_addr().unwrap().port();
        (socket, port)
    }

    #[test]
    fn a_peer_on_this_machine_is_reached_once_and_over_the_loopback_interface() {
        let ((_one, one), (_two, two)) = (open(), open());
        for (id, little) in UNICAST.into_iter().flat_map(|id| [(id, false), (id, true)]) {
            let all = [(one, OTHER), (one, Ipv4Addr::LOCALHOST), (two, OTHER), (one, OTHER)];
            let wanted = [(one, Ipv4Addr::LOCALHOST), (two, Ipv4Addr::LOCALHOST)];
            assert_eq!(left(id, little, &all), wanted);
            assert_eq!(left(id, little, &all[..1]), wanted[..1]);
        }
    }

    #[test]
    fn peers_elsewhere_and_sockets_that_hear_at_one_address_are_left_as_they_are() {
        let (_open, port) = open();
        let id = UNICAST[0];
        // Of another machine, which has an address that this one has, too.
        let far = [(port, OTHER), (port, FAR)];
        assert_eq!(left(id, true, &far), far);
        let bound = UdpSocket::bind((OTHER, 0)).unwrap();
        let bound = [(bound.local_addr().unwrap().port(), OTHER)];
        assert_eq!(left(id, true, &bound), bound);
        assert_eq!(left(id, true, &[]), []);
        let both = [locator(UDP_V4, port, OTHER, true), locator(UDP_V6, port, OTHER, true)];
        let mut payload = announced(id, true, &both);
        let before = payload.clone();
        rewrite(&mut SameMachine::default(), &mut payload, Some(OTHER));
        assert_eq!(payload, before, "it may be meant to be reached over IPv6");
    }

    #[test]
    fn announcements_of_participants_and_of_their_ends_are_rewritten() {
        let (_open, port) = open();
        let mut guard = Guard::new(Limits::default(), Arc::default());
        let mut heard = |mut datagram: Vec<u8>| {
            let (from, now) = (Some(OTHER.into()), Duration::from_secs(9));
            assert!(guard.screen(&mut datagram, from, now, &mut |_, _| false));
            (datagram, guard.needs_loopback())
        };
        let parameter = |id: u16, address| {
            [&id.to_le_bytes()[..], &[24, 0], &locator(UDP_V4, port, address, true)].concat()
        };
        let has = |datagram: &[u8], id, address| {
            let part = parameter(id, address);
            datagram.windows(part.len()).any(|window| window == part)
        };
        let mut participant = PEER.announcement(1, port, 20);
        while let Some(at) = participant.windows(4).position(|four| four == [127, 0, 0, 1]) {
            participant[at..at + 4].copy_from_slice(&OTHER.octets());
        }
        let (participant, elsewhere) = heard(participant);
        assert!(elsewhere);
        assert!(has(&participant, 0x31, Ipv4Addr::LOCALHOST));
        assert!(has(&participant, 0x32, OTHER), "discovery goes on as before");
        let mut reader = PEER.end([0, 0, 1, 4], "rt/image", "Image");
        reader.truncate(reader.len() - 4);
        reader.extend([&parameter(0x2f, OTHER)[..], &[1, 0, 0, 0]].concat());
        let (reader, elsewhere) = heard(PEER.message(&[data([0, 0, 4, 0xc2], 1, &reader)]));
        assert!(elsewhere);
        assert!(has(&reader, 0x2f, Ipv4Addr::LOCALHOST));
        assert!(!heard(PEER.message(&[])).1);
    }
}
