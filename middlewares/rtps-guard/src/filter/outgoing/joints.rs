//! Fragments for readers on the same machine, joined to datagrams of nearly 64 KiB.
//!
//! RustDDS 0.15.1 cuts what it sends for the smallest network that any address of a reader is on
//! (`rtps/rtps_reader_proxy.rs`, `resolve_path_mtu`), also if it is on the same machine, where all
//! goes over the loopback interface. A reader of another library announces the addresses of all
//! interfaces; so an image of 6 MB comes as thousands of small datagrams. Most of the buffer of its
//! socket is taken by what the system adds to each of them, and reading them takes longer than the
//! time between two images.
//!
//! The size of a fragment stays as it is, which is the same for all readers (RTPS 2.5, 8.4.14.1.1);
//! only how many a datagram has changes.

use super::cut::Cut;
use super::wire::Target;

/// Largest datagram in bytes; UDP over IPv4 has room for 65,507.
const MOST: usize = 65_400;

/// From this size on, a message goes as it is.
const LARGE: usize = MOST / 2;

/// Datagrams that are being joined at a time. The oldest goes when there are more.
const OPEN: usize = 64;

/// The beginning of a datagram, to which what follows is added.
#[derive(Debug)]
struct Joint {
    to: Target,
    /// Of its first message.
    cut: Cut,
    /// The fragment that follows.
    next: u32,
    bytes: Vec<u8>,
}

#[derive(Debug, Default)]
pub(crate) struct Joints(Vec<Joint>);

/// Sends a datagram to an address: with the fragments from the first of `Cut` to before this one.
/// Returns false if it could not be sent.
pub(crate) type Send<'a> = &'a mut dyn FnMut(&Target, &[u8], &Cut, u32) -> bool;

impl Joints {
    /// Adds a message that ends with `cut`, and sends what is complete by that.
    ///
    /// Returns false if something could not be sent: then RustDDS keeps the message, and sends it
    /// again.
    pub(crate) fn add(&mut self, to: &Target, cut: &Cut, message: &[u8], send: Send<'_>) -> bool {
        let of = |joint: &Joint| {
            (joint.to, joint.cut.writer, joint.cut.reader) == (*to, cut.writer, cut.reader)
        };
        let at = self.0.iter().position(of);
        if let Some(at) = at
            && let Some(joint) = self.0.get_mut(at)
        {
            if joint.has(cut) {
                // It went to several readers, and the socket had no room for it to another one.
                return true;
            }
            if joint.is_followed_by(cut, message) {
                let sent = joint.append(cut, message, send);
                if sent && cut.last {
                    self.0.remove(at);
                }
                return sent;
            }
            // What is there of another sample is dropped: RustDDS has given that up.
            if joint.cut.number == cut.number && !joint.send(send) {
                return false;
            }
            self.0.remove(at);
        }
        if cut.last || message.len() >= LARGE {
            return send(to, message, cut, cut.end());
        }
        if self.0.len() >= OPEN {
            if !self.0.first_mut().is_none_or(|oldest| oldest.send(send)) {
                return false;
            }
            self.0.remove(0);
        }
        let mut bytes = Vec::with_capacity(MOST);
        bytes.extend_from_slice(message);
        self.0.push(Joint { to: *to, cut: *cut, next: cut.end(), bytes });
        true
    }
}

impl Joint {
    fn has(&self, cut: &Cut) -> bool {
        let same = self.cut.number == cut.number;
        same && cut.first >= self.cut.first && cut.end() <= self.next
    }

    fn is_followed_by(&self, cut: &Cut, message: &[u8]) -> bool {
        let fits = self.bytes.len() + message.len().saturating_sub(cut.payload) <= MOST;
        self.cut.number == cut.number && cut.first == self.next && fits
    }

    /// Adds the fragments of a message. With the last ones of the sample all goes; if it cannot, it
    /// is as before.
    fn append(&mut self, cut: &Cut, message: &[u8], send: Send<'_>) -> bool {
        let before = (self.bytes.len(), self.next);
        self.bytes.extend_from_slice(message.get(cut.payload..).unwrap_or_default());
        self.next = cut.end();
        if cut.last && !self.send(send) {
            self.bytes.truncate(before.0);
            self.next = before.1;
            return false;
        }
        true
    }

    fn send(&mut self, send: Send<'_>) -> bool {
        self.cut.extend(&mut self.bytes, self.next);
        send(&self.to, &self.bytes, &self.cut, self.next)
    }
}
