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

/// Samples that are being joined at a time; more go as RustDDS cuts them.
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

impl Joints {
    /// Adds a message that ends with `cut`. `send` sends what is complete by that, of which it gets
    /// the first fragment and the one after the last.
    ///
    /// Returns false if something could not be sent: then RustDDS keeps the message, and sends it
    /// again.
    pub(crate) fn add(
        &mut self,
        to: &Target,
        cut: &Cut,
        message: &[u8],
        mut send: impl FnMut(&[u8], (u32, u32)) -> bool,
    ) -> bool {
        let ends = |joint: &Joint| {
            (joint.to, joint.cut.writer, joint.cut.reader) == (*to, cut.writer, cut.reader)
        };
        if let Some(at) = self.0.iter().position(ends)
            && let Some(joint) = self.0.get_mut(at)
        {
            let same = joint.cut.number == cut.number;
            // It is sent to several readers, and another one's socket had no room for it.
            if same && cut.first >= joint.cut.first && cut.end() <= joint.next {
                return true;
            }
            let payload = message.get(cut.payload..).unwrap_or_default();
            if same && cut.first == joint.next && joint.bytes.len() + payload.len() <= MOST {
                let before = joint.bytes.len();
                joint.bytes.extend_from_slice(payload);
                if !cut.last {
                    joint.next = cut.end();
                    return true;
                }
                joint.cut.extend(&mut joint.bytes, cut.end());
                if !send(&joint.bytes, (joint.cut.first, cut.end())) {
                    joint.bytes.truncate(before);
                    return false;
                }
                self.0.swap_remove(at);
                return true;
            }
            // Of a sample that is not sent any more, nothing else will come.
            if same {
                joint.cut.extend(&mut joint.bytes, joint.next);
                if !send(&joint.bytes, (joint.cut.first, joint.next)) {
                    return false;
                }
            }
            self.0.swap_remove(at);
        }
        if cut.last || message.len() >= LARGE || self.0.len() >= OPEN {
            return send(message, (cut.first, cut.end()));
        }
        let mut bytes = Vec::with_capacity(MOST);
        bytes.extend_from_slice(message);
        self.0.push(Joint { to: *to, cut: *cut, next: cut.end(), bytes });
        true
    }
}
