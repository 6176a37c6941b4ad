//! Whether multicast works, by which ROS 2 peers find each other.

use std::io::ErrorKind;
use std::net::{Ipv4Addr, UdpSocket};
use std::time::{Duration, Instant};

use genom_protocol::Diagnosis;

/// The multicast group by which DDS participants discover each other.
const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);
/// Within a machine a datagram arrives at once, or not at all.
const PATIENCE: Duration = Duration::from_millis(500);

/// Sends a datagram to the group and waits for it, up to half a second.
#[must_use]
pub fn multicast() -> Diagnosis {
    const ABOUT: &str = "multicast";
    match echo() {
        Ok(()) => Diagnosis::ok(ABOUT, "a datagram to 239.255.0.1 comes back"),
        Err(error) => Diagnosis::note(
            ABOUT,
            format!(
                "a datagram to 239.255.0.1 does not come back ({error}): ROS 2 peers do not find each other"
            ),
            "a route for multicast (`ip route add 239.0.0.0/8 dev lo`), and a firewall that lets UDP pass",
        ),
    }
}

fn echo() -> std::io::Result<()> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    socket.set_read_timeout(Some(PATIENCE))?;
    socket.join_multicast_v4(&GROUP, &Ipv4Addr::UNSPECIFIED)?;
    socket.set_multicast_loop_v4(true)?;
    let mark = std::process::id().to_le_bytes();
    socket.send_to(&mark, (GROUP, socket.local_addr()?.port()))?;
    let mut came = [0; 4];
    let begun = Instant::now();
    // Datagrams of other programs are skipped, for as long.
    while begun.elapsed() < PATIENCE {
        if socket.recv(&mut came)? == mark.len() && came == mark {
            return Ok(());
        }
    }
    Err(ErrorKind::TimedOut.into())
}
