//! Hostile RTPS.

use std::net::UdpSocket;

use super::dice::Dice;
use super::forger::{
    Forger, PARTICIPANTS, READERS, USER, WRITERS, acknack, announcement_ports, data, fragment, gap,
    heartbeat, nack_fragments,
};

/// Length of the header of RTPS.
const HEADER: usize = 20;

/// A participant that sends hostile datagrams.
pub(super) struct Attacker {
    forger: Forger,
    socket: UdpSocket,
    domain: u16,
    /// The topic of which it claims to be a writer.
    topic: String,
    count: i32,
}

impl Attacker {
    pub(super) fn new(domain: u16, topic: String) -> Self {
        let socket = UdpSocket::bind(("127.0.0.1", 0)).expect("a socket");
        Self { forger: Forger(*b"\x01\x10siege....."), socket, domain, topic, count: 1 }
    }

    /// Announces itself as a writer of the topic, without which most is ignored.
    pub(super) fn announce(&self) {
        let port = self.socket.local_addr().expect("it is bound").port();
        let all = [
            self.forger.announcement(1, port, 100),
            self.forger.writer(&self.topic, "std_msgs::msg::dds_::Float64_"),
        ];
        for to in announcement_ports(self.domain) {
            all.iter().for_each(|datagram| self.send(datagram, to));
        }
    }

    pub(super) fn send(&self, datagram: &[u8], to: u16) {
        // Nobody may be there: a gateway that is starting again.
        let _ = self.socket.send_to(datagram, ("127.0.0.1", to));
    }

    /// The three datagrams that end RustDDS, or its flow of samples, without a guard.
    pub(super) fn deadly(&mut self) -> [Vec<u8>; 3] {
        self.count += 1;
        [
            heartbeat(USER, 1, 1 << 31, self.count),
            fragment(USER, 1, (1, 1, u16::MAX), u32::MAX, &[0; 1000]),
            gap(USER, 1, 1 << 40),
        ]
        .map(|one| self.forger.message(&[one]))
    }

    /// The next datagram by chance: noise, or what means something with changes in it.
    pub(super) fn next(&mut self, dice: &mut Dice) -> Vec<u8> {
        self.count += 1;
        let (noise, number) = (dice.below(1400), dice.below(1 << 20));
        let sequence = i64::try_from(number).unwrap_or(1);
        let prefix = dice.bytes(12);
        let size = dice.below(1000);
        let payload = dice.bytes(size);
        let one = match dice.below(10) {
            0 => return dice.bytes(noise),
            1 => [&b"RTPS\x02\x04\x01\x10"[..], &prefix, &dice.bytes(noise)].concat(),
            2 => self.forger.announcement(sequence, 7411, 100),
            3 => self.forger.writer(&self.topic, "std_msgs::msg::dds_::Float64_"),
            4 => self.forger.message(&[heartbeat(USER, 1, sequence, self.count)]),
            5 => self.forger.message(&[gap(USER, 1, sequence)]),
            6 => self.forger.message(&[data(USER, sequence, &payload)]),
            7 => {
                let sizes = (1, 1, u16::try_from(size + 1).unwrap_or(1));
                self.forger.message(&[fragment(USER, sequence, sizes, 1 << 20, &payload)])
            }
            8 => {
                let all = [PARTICIPANTS, WRITERS, READERS];
                let ask = acknack(&prefix, all[dice.below(all.len())], self.count);
                self.forger.message(&[ask, nack_fragments(USER, sequence, 1, self.count)])
            }
            _ => self.forger.message(&[
                heartbeat(WRITERS, 1, sequence, self.count),
                heartbeat(PARTICIPANTS, 1, sequence, self.count),
                data(USER, sequence, &payload),
            ]),
        };
        let mut one = one;
        if dice.below(8) > 0 {
            dice.spoil(&mut one, HEADER);
        }
        one
    }
}
