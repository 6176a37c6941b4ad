//! One sample in an inbox: its bytes, either copied or held in zenoh's buffer.

use zenoh::bytes::ZBytes;
use zenoh::shm::ShmBuf;

/// A slot of an inbox; reused.
#[derive(Debug, Default)]
pub(crate) struct Arrival {
    /// Its encoding names another type.
    alien: bool,
    copy: Vec<u8>,
    /// Used instead of the copy.
    held: Option<ZBytes>,
}

impl Arrival {
    /// A slot with space for copies of `size` bytes.
    pub(crate) fn with_room(size: usize) -> Self {
        Self { copy: Vec::with_capacity(size), ..Self::default() }
    }

    /// Replaces the content. A sample that may be held, and is in one piece, keeps a receive buffer
    /// or shared memory from zenoh.
    pub(crate) fn set(&mut self, payload: &ZBytes, alien: bool, holds: bool) {
        self.alien = alien;
        self.copy.clear();
        self.held = None;
        if holds && payload.slices().nth(1).is_none() {
            self.held = Some(payload.clone());
        } else {
            payload.slices().for_each(|part| self.copy.extend_from_slice(part));
        }
    }

    /// Passes the message to `decode`. Returns false if that does, or if there is nothing to
    /// decode.
    pub(crate) fn read(&self, decode: impl FnOnce(&[u8]) -> bool) -> bool {
        let message = match &self.held {
            Some(held) => held.slices().next().unwrap_or_default(),
            None => &self.copy,
        };
        !self.alien && self.is_whole() && decode(message) && self.is_whole()
    }

    /// Whether the shared memory is still valid: zenoh returns it to the writer if this process was
    /// stopped for so long that it seemed dead.
    fn is_whole(&self) -> bool {
        self.held.as_ref().and_then(ZBytes::as_shm).is_none_or(|shm| shm.is_valid())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes_of(arrival: &Arrival) -> Option<Vec<u8>> {
        let mut bytes = None;
        let read = arrival.read(|message| {
            bytes = Some(message.to_vec());
            true
        });
        read.then_some(bytes).flatten()
    }

    #[test]
    fn what_is_copied_and_what_is_held_reads_alike() {
        let mut arrival = Arrival::with_room(8);
        for size in [0, 1, 16 << 10, 2 << 20] {
            let payload = ZBytes::from(vec![7; size]);
            for holds in [false, true] {
                arrival.set(&payload, false, holds);
                assert_eq!(arrival.held.is_some(), holds);
                assert_eq!(bytes_of(&arrival), Some(vec![7; size]));
            }
        }
        arrival.set(&ZBytes::from("new"), false, true);
        assert_eq!(bytes_of(&arrival), Some(b"new".to_vec()));
    }

    #[test]
    fn a_sample_in_pieces_is_put_together() {
        let mut writer = ZBytes::writer();
        writer.append(ZBytes::from(vec![1; 16 << 10]));
        writer.append(ZBytes::from(vec![2; 16 << 10]));
        let mut arrival = Arrival::default();
        arrival.set(&writer.finish(), false, true);
        assert_eq!(bytes_of(&arrival), Some([[1; 16 << 10], [2; 16 << 10]].concat()));
    }

    #[test]
    fn nothing_is_decoded_of_another_type() {
        let mut arrival = Arrival::default();
        arrival.set(&ZBytes::from("text"), true, true);
        assert_eq!(bytes_of(&arrival), None);
    }
}
