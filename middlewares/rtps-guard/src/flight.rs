//! How much of a port's samples may be on their way to readers at a time.
//!
//! RustDDS sends a sample as one burst, and as many of them as it may hold, whatever readers have
//! taken of the earlier ones. What has no room in the buffer of a reader's socket is lost; RustDDS
//! sends it again, together with what was written since, so that a reader that was late once may
//! never catch up. So large samples wait until readers have acknowledged those before.

/// Most bytes of large samples that are on their way, unless it is a single one. The system lets a
/// socket have twice `net.core.rmem_max`, of which a datagram takes up to twice its size.
const MOST: usize = 4 << 20;

/// Samples of fewer bytes are not counted: RustDDS limits their number.
const LARGE: usize = 64 << 10;

/// What is on its way of one port: bytes of large samples since readers had all of them.
#[derive(Debug, Default)]
pub struct Flight(usize);

impl Flight {
    /// A sample is about to be sent. Has all earlier ones `settle` first if there are too many.
    pub fn add(&mut self, bytes: usize, settle: impl FnOnce()) {
        if bytes < LARGE {
            return;
        }
        if self.0 > 0 && self.0.saturating_add(bytes) > MOST {
            settle();
            self.0 = 0;
        }
        self.0 = self.0.saturating_add(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a sample of this size waits.
    fn waits(flight: &mut Flight, bytes: usize) -> bool {
        let mut waited = false;
        flight.add(bytes, || waited = true);
        waited
    }

    #[test]
    fn a_large_sample_waits_for_those_before_and_a_small_one_does_not() {
        let mut flight = Flight::default();
        assert!(!waits(&mut flight, 6_000_000), "a single one may be larger");
        assert!(waits(&mut flight, 6_000_000));
        assert!(!waits(&mut flight, 64));
        assert!(waits(&mut flight, LARGE));
        assert!(!waits(&mut flight, LARGE));
    }

    #[test]
    fn several_are_on_their_way_while_there_is_room() {
        let mut flight = Flight::default();
        let waited = (0..12).filter(|_| waits(&mut flight, 1 << 20));
        assert_eq!(waited.collect::<Vec<_>>(), [4, 8]);
    }
}
