//! What sends datagrams, as the rest of this folder sees it.

use std::net::SocketAddrV4;
use std::time::Duration;

/// Where a datagram goes, and by which socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Target {
    pub(crate) socket: i32,
    pub(crate) address: SocketAddrV4,
}

/// What sends datagrams.
pub(crate) trait Wire {
    /// Sends one. Returns false if it could not be sent.
    fn send(&mut self, to: &Target, bytes: &[u8]) -> bool;

    /// Time since boot.
    fn now(&self) -> Duration;

    fn pause(&mut self, time: Duration);
}
