//! The message by which a participant leaves, in a form that every DDS implementation understands.
//!
//! RustDDS identifies the leaving participant in the body of the message. Fast DDS, the default of
//! ROS 2, reads it from the key hash only (RTPS 2.5, 9.6.4.8), and would keep showing topics and
//! services of a daemon that has ended. It still does so for single ends that are closed while the
//! daemon runs: those are announced over RustDDS's own reliable channel.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};

use crate::dds::rustdds::GUID;

/// Number of participants per host that are notified by unicast; there are usually fewer.
const PARTICIPANTS: u16 = 32;

/// Multicast address for discovery (RTPS 9.6.1.4).
const EVERYBODY: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);

/// Sends the message when dropped, which must be after the participant was dropped.
pub(crate) struct Farewell {
    pub(crate) participant: GUID,
    pub(crate) domain: u16,
    /// Addresses of the interfaces in use; `None` for all.
    pub(crate) addresses: Option<Vec<IpAddr>>,
}

impl Drop for Farewell {
    fn drop(&mut self) {
        let message = message(&self.participant.to_bytes());
        // RTPS 9.6.1.1: 250 ports per domain; the first two for multicast, then two per
        // participant.
        let Some(first) = self.domain.checked_mul(250).and_then(|port| port.checked_add(7400))
        else {
            return;
        };
        let all = [IpAddr::from(Ipv4Addr::UNSPECIFIED), Ipv4Addr::LOCALHOST.into()];
        let addresses = self.addresses.clone().unwrap_or(all.to_vec());
        for address in addresses.into_iter().filter(IpAddr::is_ipv4) {
            // Best effort: without it, others notice when the lease expires.
            let Ok(socket) = UdpSocket::bind((address, 0)) else { continue };
            let tell = |to: IpAddr, port: Option<u16>| {
                if let Some(port) = port {
                    let _ = socket.send_to(&message, SocketAddr::new(to, port));
                }
            };
            if !address.is_loopback() {
                tell(EVERYBODY.into(), Some(first));
            }
            if !address.is_unspecified() {
                for number in 0..PARTICIPANTS {
                    tell(address, first.checked_add(10 + 2 * number));
                }
            }
        }
    }
}

/// A DATA message of the participant's announcer with status "disposed and unregistered".
fn message(participant: &[u8; 16]) -> Vec<u8> {
    let prefix = participant.get(..12).unwrap_or_default();
    let maker = participant.get(..2).unwrap_or_default();
    let mut out = Vec::new();
    // RTPS 9.4.4: protocol, version, vendor, participant.
    out.extend_from_slice(b"RTPS\x02\x03");
    out.extend_from_slice(maker);
    out.extend_from_slice(prefix);
    // 9.4.5.4: DATA, little endian, with inline QoS and without payload, 52 bytes long.
    out.extend_from_slice(&[0x15, 0x03, 52, 0]);
    // No extra flags; inline QoS after 16 bytes; reader and writer of participant announcements.
    out.extend_from_slice(&[0, 0, 16, 0, 0, 1, 0, 0xc7, 0, 1, 0, 0xc2]);
    // A sequence number greater than any that it has sent.
    out.extend_from_slice(&[1, 0, 0, 0, 0, 0, 0, 0]);
    // 9.6.4.8: the key hash is the GUID itself.
    out.extend_from_slice(&[0x70, 0, 16, 0]);
    out.extend_from_slice(participant);
    // 9.6.4.9: status "disposed and unregistered".
    out.extend_from_slice(&[0x71, 0, 4, 0, 0, 0, 0, 3]);
    // End of the parameter list.
    out.extend_from_slice(&[1, 0, 0, 0]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_length_of_the_message_is_what_it_says() {
        let message = message(&[7; 16]);
        // 20 bytes of message header, 4 of submessage header.
        assert_eq!(message.len(), 20 + 4 + usize::from(message[22]));
    }
}
