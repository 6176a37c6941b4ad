//! The last word of a participant, in a form that every maker's DDS reads.
//!
//! RustDDS names a participant that leaves in the body of a message; Fast DDS, the default of
//! ROS 2, reads such names in the key hash only (RTPS 2.5, 9.6.4.8), and goes on showing the
//! topics and services of a daemon that has ended. It still does with single ends that are closed
//! in a daemon that runs on: those go over a reliable channel that is RustDDS's own.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};

use rustdds::GUID;

/// Participants of a host that are told one by one: those that there usually are.
const PARTICIPANTS: u16 = 32;

/// Where participants meet (RTPS 9.6.1.4).
const EVERYBODY: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);

/// Says the last word when dropped: after the participant itself.
pub(crate) struct Farewell {
    pub(crate) participant: GUID,
    pub(crate) domain: u16,
    /// Addresses of the interfaces in use; none: all.
    pub(crate) addresses: Option<Vec<IpAddr>>,
}

impl Drop for Farewell {
    fn drop(&mut self) {
        let message = message(&self.participant.to_bytes());
        // RTPS 9.6.1.1: 250 ports a domain; two for all, then two for each participant.
        let Some(first) = self.domain.checked_mul(250).and_then(|port| port.checked_add(7400))
        else {
            return;
        };
        let all = [IpAddr::from(Ipv4Addr::UNSPECIFIED), Ipv4Addr::LOCALHOST.into()];
        let addresses = self.addresses.clone().unwrap_or(all.to_vec());
        for address in addresses.into_iter().filter(IpAddr::is_ipv4) {
            // Best effort: others notice later without it.
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

/// A message of the participant's announcer that says that it is disposed of and unregistered.
fn message(participant: &[u8; 16]) -> Vec<u8> {
    let prefix = participant.get(..12).unwrap_or_default();
    let maker = participant.get(..2).unwrap_or_default();
    let mut out = Vec::new();
    // RTPS 9.4.4: protocol, version, maker, participant.
    out.extend_from_slice(b"RTPS\x02\x03");
    out.extend_from_slice(maker);
    out.extend_from_slice(prefix);
    // 9.4.5.4: DATA, little endian, with inline QoS and no body, of 52 bytes.
    out.extend_from_slice(&[0x15, 0x03, 52, 0]);
    // No further flags; QoS after 16 bytes; to readers and from the writer of participants.
    out.extend_from_slice(&[0, 0, 16, 0, 0, 1, 0, 0xc7, 0, 1, 0, 0xc2]);
    // A number beyond all that it has sent.
    out.extend_from_slice(&[1, 0, 0, 0, 0, 0, 0, 0]);
    // 9.6.4.8: the key hash is the id itself.
    out.extend_from_slice(&[0x70, 0, 16, 0]);
    out.extend_from_slice(participant);
    // 9.6.4.9: disposed and unregistered.
    out.extend_from_slice(&[0x71, 0, 4, 0, 0, 0, 0, 3]);
    // The end of the list.
    out.extend_from_slice(&[1, 0, 0, 0]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_length_of_the_message_is_what_it_says() {
        let message = message(&[7; 16]);
        // 20 bytes of header, 4 of the submessage's own.
        assert_eq!(message.len(), 20 + 4 + usize::from(message[22]));
    }
}
