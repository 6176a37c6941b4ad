//! Keeps the last value of a port without readers in ordinary memory until there is a reader.
//!
//! The writer stores values, and another thread takes the newest when a reader appears. Neither
//! waits: there are two places, of which the thread holds at most one, and the writer uses the
//! other.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, TryLockError};

use crate::raw::{SendError, Value};

pub(crate) struct Parked {
    places: [Place; 2],
}

struct Place {
    /// Rank at which the value was stored, from 1; 0 if never. Outside the lock, so that the thread
    /// that takes the newest value locks only that place.
    rank: AtomicU64,
    bytes: Mutex<Vec<u8>>,
}

impl Parked {
    /// For values of this size in bytes, or of any size.
    pub(crate) fn new(size: Option<usize>) -> Self {
        // Zeroed memory of a known size; the system provides its pages when they are first written.
        let place =
            || Place { rank: AtomicU64::new(0), bytes: Mutex::new(vec![0; size.unwrap_or(0)]) };
        Self { places: [place(), place()] }
    }

    /// Stores a value. Allocates nothing for types of fixed size. Called by one thread at a time,
    /// with increasing ranks.
    pub(crate) fn park(&self, value: Value<'_>, rank: u64) -> Result<(), SendError> {
        for place in &self.places {
            let mut bytes = match place.bytes.try_lock() {
                Ok(bytes) => bytes,
                Err(TryLockError::Poisoned(bytes)) => bytes.into_inner(),
                Err(TryLockError::WouldBlock) => continue,
            };
            match value {
                Value::Plain(new) | Value::Encoded(new) if new.len() == bytes.len() => {
                    bytes.copy_from_slice(new);
                }
                Value::Plain(_) | Value::Encoded(_) => return Err(SendError::Refused),
                Value::Message(record, _) => {
                    place.rank.store(0, Ordering::Relaxed);
                    bytes.clear();
                    let encoded = record.encode_message(&mut bytes);
                    encoded.map_err(|_| SendError::Serialization)?;
                }
            }
            place.rank.store(rank, Ordering::Release);
            return Ok(());
        }
        Err(SendError::Refused)
    }

    /// Passes the newest value to `to` if its rank is greater than `after`, and returns its rank.
    ///
    /// Called by one thread at a time, and again whenever a value was stored meanwhile: a place
    /// that is being written is skipped.
    pub(crate) fn newest(&self, after: u64, to: impl FnOnce(&[u8])) -> u64 {
        let newest = self.places.iter().max_by_key(|place| place.rank.load(Ordering::Acquire));
        if let Some(place) = newest
            && let Ok(bytes) = place.bytes.try_lock()
        {
            // Read again: another value may have been stored before the lock was taken.
            let rank = place.rank.load(Ordering::Acquire);
            if rank > after {
                to(&bytes);
                return rank;
            }
        }
        after
    }

    /// Frees the memory.
    pub(crate) fn forget(&self) {
        for place in &self.places {
            if let Ok(mut bytes) = place.bytes.try_lock() {
                *bytes = Vec::new();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn newest(parked: &Parked, after: u64) -> Option<(u64, Vec<u8>)> {
        let mut found = None;
        let rank = parked.newest(after, |bytes| found = Some(bytes.to_vec()));
        found.map(|bytes| (rank, bytes))
    }

    #[test]
    fn the_newest_value_is_handed_over_once_also_if_one_is_parked_meanwhile() {
        let parked = Parked::new(Some(2));
        assert_eq!(newest(&parked, 0), None);
        parked.park(Value::Plain(&[1, 1]), 1).unwrap();
        parked.park(Value::Plain(&[2, 2]), 2).unwrap();
        let rank = parked.newest(0, |bytes| {
            assert_eq!(bytes, [2, 2]);
            parked.park(Value::Plain(&[3, 3]), 3).unwrap();
            parked.park(Value::Plain(&[4, 4]), 4).unwrap();
        });
        assert_eq!((rank, newest(&parked, rank)), (2, Some((4, vec![4, 4]))));
        assert_eq!(newest(&parked, 4), None);
        assert_eq!(parked.park(Value::Plain(&[1]), 5), Err(SendError::Refused));
    }
}
