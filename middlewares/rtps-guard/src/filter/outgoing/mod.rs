//! What one participant of ours sends: mended where RustDDS sends it wrongly, and large samples in the
//! way that readers can take them.

mod announced;
mod cut;
mod joints;
mod kept;
mod mend;
mod pace;
mod wire;

use std::net::IpAddr;

pub(crate) use kept::Lack;
pub(crate) use mend::mended;
pub(crate) use wire::{Target, Wire};

use super::locals::Locals;
use announced::Announced;
use cut::Cut;
use joints::Joints;
use kept::Kept;
use pace::Pace;

#[derive(Debug, Default)]
pub(crate) struct Outgoing {
    pub(crate) announced: Announced,
    locals: Locals,
    joints: Joints,
    pace: Pace,
    kept: Kept,
}

impl Outgoing {
    /// Sends a message if it is part of a large sample, and for readers on this machine, or if some
    /// have lost parts of late; `None` if it may go as it is. Returns false if it could not be sent,
    /// and has to come again.
    pub(crate) fn send_part(
        &mut self,
        to: &Target,
        message: &[u8],
        wire: &mut impl Wire,
    ) -> Option<bool> {
        let cut = Cut::read(message)?;
        let Self { locals, joints, pace, kept, .. } = self;
        let (here, slow) = (locals.has(*to.address.ip()), pace.is_slow(|| wire.now()));
        if !slow && !kept.is_empty() {
            kept.clear();
        }
        if !here && (!slow || to.address.ip().is_multicast()) {
            return None;
        }
        let mut send = |to: &Target, datagram: &[u8], cut: &Cut, end| {
            if !slow {
                return wire.send(to, datagram);
            }
            let sent = send_slowly(pace, wire, to, datagram);
            if sent {
                if cut.first == 1 {
                    pace.begin();
                }
                kept.add((cut.writer, cut.number, here), to, (cut.first, end), datagram);
            }
            sent
        };
        Some(if here {
            joints.add(to, &cut, message, &mut send)
        } else {
            send(to, message, &cut, cut.end())
        })
    }

    /// A reader at this address lacks parts of a sample. Returns whether they were sent again.
    pub(crate) fn repair(
        &mut self,
        reader: Option<IpAddr>,
        lack: &Lack,
        wire: &mut impl Wire,
    ) -> bool {
        let Some(IpAddr::V4(reader)) = reader else { return false };
        let Self { locals, pace, kept, .. } = self;
        if !pace.is_slow(|| wire.now()) {
            tracing::debug!(%reader, "a reader loses parts of large samples: they are sent more slowly");
        }
        pace.lost(wire.now());
        kept.repair(lack, locals.has(reader), |to, datagram| {
            // What has no room now is asked for again.
            send_slowly(pace, wire, to, datagram);
        })
    }
}

/// Sends a datagram after the pause that it needs.
fn send_slowly(pace: &mut Pace, wire: &mut impl Wire, to: &Target, datagram: &[u8]) -> bool {
    if let Some(time) = pace.pause(datagram.len(), wire.now()) {
        wire.pause(time);
    }
    wire.send(to, datagram)
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, SocketAddrV4};
    use std::time::Duration;

    use super::super::message::{Bitmap, Fields};
    use super::super::tests::forger::{Forger, USER, data, fragment, heartbeat};
    use super::*;

    const US: Forger = Forger(*b"\x01\x12ourselves.");
    const HERE: Target = at(Ipv4Addr::LOCALHOST);
    const READER: Option<IpAddr> = Some(IpAddr::V4(Ipv4Addr::LOCALHOST));

    /// Fragments of a datagram on a network, of 256 bytes each, and of a sample.
    const CUT: u16 = 4;
    const SIZE: u16 = 256;
    const FRAGMENTS: u32 = 23_437;
    const WHOLE: u32 = (FRAGMENTS - 1) * SIZE as u32 + 200;

    const fn at(address: Ipv4Addr) -> Target {
        Target { socket: 3, address: SocketAddrV4::new(address, 7411) }
    }

    /// A network that has no room from time to time.
    #[derive(Default)]
    struct Net {
        sent: Vec<Vec<u8>>,
        now: Duration,
        paused: u32,
        /// Each so-many-th datagram has no room; 0 if there always is.
        full: usize,
        tried: usize,
    }

    impl Wire for Net {
        fn send(&mut self, _: &Target, bytes: &[u8]) -> bool {
            self.tried += 1;
            let room = self.full == 0 || !self.tried.is_multiple_of(self.full);
            if room {
                self.sent.push(bytes.to_vec());
            }
            room
        }

        fn now(&self) -> Duration {
            Duration::from_secs(9) + self.now
        }

        fn pause(&mut self, time: Duration) {
            self.paused += 1;
            self.now += time;
        }
    }

    fn octet(number: i64, at: u32) -> u8 {
        (i64::from(at % 251) + number).to_le_bytes()[0]
    }

    /// The messages with which RustDDS sends a sample.
    fn messages(number: i64) -> Vec<Vec<u8>> {
        let step = usize::from(CUT);
        let of = |first: u32| {
            let count = u32::from(CUT).min(FRAGMENTS + 1 - first);
            let begin = (first - 1) * u32::from(SIZE);
            let end = WHOLE.min(begin + count * u32::from(SIZE));
            let payload: Vec<u8> = (begin..end).map(|at| octet(number, at)).collect();
            let cut = (first, u16::try_from(count).unwrap(), SIZE);
            US.message(&[fragment(USER, number, cut, WHOLE, &payload)])
        };
        (1..=FRAGMENTS).step_by(step).map(of).collect()
    }

    fn send(all: &mut Outgoing, net: &mut Net, number: i64) {
        for message in messages(number) {
            // RustDDS sends again what had no room.
            while all.send_part(&HERE, &message, net) == Some(false) {}
        }
    }

    /// Fragments of datagrams, each with its content checked.
    fn parts(number: i64, datagrams: &[Vec<u8>]) -> Vec<(u32, u32)> {
        let of = |datagram: &Vec<u8>| {
            let cut = Cut::read(datagram).unwrap();
            assert_eq!((cut.writer, cut.number), (USER, number));
            assert_eq!(cut.last, cut.end() > FRAGMENTS);
            let begin = (cut.first - 1) * u32::from(SIZE);
            let payload = &datagram[cut.payload..];
            let whole = (cut.end() - 1) * u32::from(SIZE);
            assert_eq!(payload.len(), (whole.min(WHOLE) - begin) as usize);
            let sound = |(at, octet_is): (u32, &u8)| octet(number, at) == *octet_is;
            assert!((begin..).zip(payload).all(sound));
            (cut.first, cut.end())
        };
        datagrams.iter().map(of).collect()
    }

    /// Whether these are all of a sample, once and in order.
    fn is_all(parts: &[(u32, u32)]) -> bool {
        let ends = parts.first().is_some_and(|part| part.0 == 1)
            && parts.last().is_some_and(|part| part.1 == FRAGMENTS + 1);
        ends && parts.windows(2).all(|pair| pair[0].1 == pair[1].0)
    }

    /// A reader lacks these and following fragments, in so far as there is room to say so.
    fn lack(number: i64, missing: std::ops::Range<u32>) -> Lack {
        let length = (missing.end - missing.start).min(Bitmap::MOST);
        let mut body = length.to_le_bytes().to_vec();
        for word in 0..length.div_ceil(32) {
            let used = (length - word * 32).min(32);
            body.extend((u32::MAX << (32 - used)).to_le_bytes());
        }
        let missing_bits = Fields::new(&body, true).bitmap().unwrap();
        Lack { writer: USER, number, base: missing.start, missing: missing_bits }
    }

    /// Outgoing messages of which a reader has lost parts, and that have sent sample 2 since.
    fn slow() -> (Outgoing, Net) {
        let (mut all, mut net) = (Outgoing::default(), Net::default());
        send(&mut all, &mut net, 1);
        assert!(!all.repair(READER, &lack(1, 1..5), &mut net), "nothing is kept yet");
        net.sent.clear();
        send(&mut all, &mut net, 2);
        assert!(is_all(&parts(2, &net.sent)));
        net.sent.clear();
        (all, net)
    }

    #[test]
    fn a_large_sample_goes_to_readers_on_this_machine_in_large_datagrams() {
        let (mut all, mut net) = (Outgoing::default(), Net::default());
        send(&mut all, &mut net, 1);
        let parts = parts(1, &net.sent);
        assert!(is_all(&parts));
        assert!(parts.len() < WHOLE as usize / 63_000, "{}", parts.len());
        assert!(net.sent.iter().all(|datagram| datagram.len() < 65_507));
        assert_eq!(net.paused, 0, "nothing was lost");
    }

    #[test]
    fn other_machines_and_other_messages_are_left_as_they_are() {
        let (mut all, mut net) = (Outgoing::default(), Net::default());
        let part = US.message(&[fragment(USER, 1, (1, 4, 256), 9000, &[0; 1024])]);
        for address in [Ipv4Addr::new(203, 0, 113, 7), Ipv4Addr::new(239, 255, 0, 1)] {
            assert_eq!(all.send_part(&at(address), &part, &mut net), None);
        }
        let announcement = fragment([0, 0, 3, 0xc2], 1, (1, 4, 256), 9000, &[0; 1024]);
        let others = [
            US.message(&[data(USER, 1, &[0, 1, 0, 0])]),
            US.message(&[heartbeat(USER, 1, 1, 1)]),
            US.message(&[announcement]),
        ];
        for other in others {
            assert_eq!(all.send_part(&HERE, &other, &mut net), None);
        }
        for length in 0..part.len() {
            // No panic, whatever is there.
            let _ = all.send_part(&HERE, &part[..length], &mut net);
        }
    }

    #[test]
    fn what_has_no_room_is_neither_lost_nor_sent_twice() {
        for full in 2..7 {
            let (mut all, mut net) = (Outgoing::default(), Net { full, ..Net::default() });
            send(&mut all, &mut net, 1);
            send(&mut all, &mut net, 2);
            let of_first = |datagram: &Vec<u8>| Cut::read(datagram).unwrap().number == 1;
            let (first, second): (Vec<_>, Vec<_>) = net.sent.drain(..).partition(of_first);
            assert!(is_all(&parts(1, &first)) && is_all(&parts(2, &second)), "{full}");
        }
    }

    #[test]
    fn the_messages_for_several_readers_are_joined_for_each() {
        let (mut all, mut net) = (Outgoing::default(), Net::default());
        let mut other = HERE;
        other.address.set_port(7413);
        for message in messages(1) {
            for to in [HERE, other, HERE] {
                // Once more to the first, since the second had no room.
                assert_eq!(all.send_part(&to, &message, &mut net), Some(true));
            }
        }
        let all = parts(1, &net.sent);
        let mut once = all.clone();
        once.dedup();
        assert!(is_all(&once[..once.len() - 1]) || is_all(&once));
        assert!(all.len() <= 2 * once.len() + 1);
    }

    #[test]
    fn what_is_begun_and_not_ended_is_bounded_and_goes_too() {
        let (mut all, mut net) = (Outgoing::default(), Net::default());
        let begins = &messages(1)[0];
        let targets = (0..1000).map(|port| {
            let mut to = HERE;
            to.address.set_port(port);
            to
        });
        for to in targets {
            assert_eq!(all.send_part(&to, begins, &mut net), Some(true));
        }
        assert!(net.sent.len() > 900 && net.sent.iter().all(|sent| sent == begins));
    }

    #[test]
    fn a_reader_that_lost_parts_gets_those_again_and_the_next_sample_more_slowly() {
        let (mut all, mut net) = slow();
        assert!(net.paused > 40, "{}", net.paused);
        assert!(all.repair(READER, &lack(2, 600..601), &mut net));
        let again = parts(2, &net.sent);
        assert_eq!(again.len(), 1);
        assert!(again[0].0 <= 600 && 600 < again[0].1);
        // Of another sample, nothing is there; nor for readers elsewhere.
        assert!(!all.repair(READER, &lack(1, 600..601), &mut net));
        let elsewhere = Some(IpAddr::from([203, 0, 113, 7]));
        assert!(!all.repair(elsewhere, &lack(2, 600..601), &mut net));
        assert!(!all.repair(None, &lack(2, 600..601), &mut net));
    }

    #[test]
    fn readers_on_other_machines_get_again_what_they_lost_too_in_datagrams_as_small_as_before() {
        let (mut all, mut net) = slow();
        let elsewhere = at(Ipv4Addr::new(203, 0, 113, 7));
        for message in messages(3) {
            assert_eq!(all.send_part(&elsewhere, &message, &mut net), Some(true));
        }
        assert_eq!(net.sent, messages(3));
        net.sent.clear();
        let reader = Some(IpAddr::V4(*elsewhere.address.ip()));
        assert!(all.repair(reader, &lack(3, 600..608), &mut net));
        assert_eq!(parts(3, &net.sent), [(597, 601), (601, 605), (605, 609)]);
        assert!(!all.repair(READER, &lack(3, 600..608), &mut net), "nobody here had that");
        let multicast = at(Ipv4Addr::new(239, 255, 0, 1));
        assert_eq!(all.send_part(&multicast, &messages(3)[0], &mut net), None);
    }

    #[test]
    fn a_reader_that_lost_much_gets_it_with_few_requests() {
        let (mut all, mut net) = slow();
        let (from, to) = (100, 20_000);
        let mut missing: Vec<bool> = (0..=FRAGMENTS).map(|n| (from..to).contains(&n)).collect();
        let mut requests = 0;
        while let Some(first) = missing.iter().position(|missing| *missing) {
            net.sent.clear();
            let base = u32::try_from(first).unwrap();
            assert!(all.repair(READER, &lack(2, base..to), &mut net));
            for (first, end) in parts(2, &net.sent) {
                missing[first as usize..end as usize].fill(false);
            }
            requests += 1;
        }
        assert!(requests <= 7, "{requests}");
    }

    #[test]
    fn requests_that_never_end_are_left_to_rustdds() {
        let (mut all, mut net) = slow();
        let request = lack(2, 1..FRAGMENTS);
        while all.repair(READER, &request, &mut net) {
            let bytes: usize = net.sent.iter().map(Vec::len).sum();
            assert!(bytes < 6 * WHOLE as usize, "{bytes}");
        }
        let before = net.sent.len();
        for _ in 0..1000 {
            assert!(!all.repair(READER, &request, &mut net));
        }
        assert_eq!(net.sent.len(), before);
        // The next sample is repaired.
        send(&mut all, &mut net, 3);
        assert!(all.repair(READER, &lack(3, 1..FRAGMENTS), &mut net));
    }

    #[test]
    fn when_nothing_was_lost_for_long_nothing_is_kept() {
        let (mut all, mut net) = slow();
        net.now += Duration::from_secs(601);
        net.paused = 0;
        send(&mut all, &mut net, 3);
        assert_eq!(net.paused, 0);
        assert!(all.kept.is_empty());
    }
}
