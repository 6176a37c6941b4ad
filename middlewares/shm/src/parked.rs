//! The last value of a port that nobody reads, kept in ordinary memory until somebody does.
//!
//! The writer parks values, and another thread takes the newest when a reader comes. Neither
//! waits: there are two places, the thread holds one of them at most, and the writer takes the
//! other.

use std::sync::{Mutex, TryLockError};

use crate::raw::{SendError, Value};

pub(crate) struct Parked {
    places: [Mutex<Place>; 2],
}

#[derive(Default)]
struct Place {
    /// When it was parked, from 1; 0 for never.
    rank: u64,
    bytes: Vec<u8>,
}

impl Parked {
    /// For values of this size, or of any.
    pub(crate) fn new(size: Option<usize>) -> Self {
        // The system gives zeroed memory of some size when it is first written.
        let place = || Mutex::new(Place { rank: 0, bytes: vec![0; size.unwrap_or(0)] });
        Self { places: [place(), place()] }
    }

    /// Keeps a value; allocates nothing for types of fixed size. Called by one thread at a time,
    /// with a greater rank each time.
    pub(crate) fn park(&self, value: Value<'_>, rank: u64) -> Result<(), SendError> {
        for place in &self.places {
            let mut place = match place.try_lock() {
                Ok(place) => place,
                Err(TryLockError::Poisoned(place)) => place.into_inner(),
                Err(TryLockError::WouldBlock) => continue,
            };
            match value {
                Value::Plain(bytes) | Value::Encoded(bytes) if bytes.len() == place.bytes.len() => {
                    place.bytes.copy_from_slice(bytes);
                }
                Value::Plain(_) | Value::Encoded(_) => return Err(SendError::Refused),
                Value::Message(record, _) => {
                    place.rank = 0;
                    place.bytes.clear();
                    let encoded = record.encode_message(&mut place.bytes);
                    encoded.map_err(|_| SendError::Serialization)?;
                }
            }
            place.rank = rank;
            return Ok(());
        }
        Err(SendError::Refused)
    }

    /// Hands over the newest value that was parked after the one of this rank; its own rank.
    ///
    /// Called by one thread at a time, again when something was parked meanwhile: a place that is
    /// being written is passed over.
    pub(crate) fn newest(&self, after: u64, to: impl FnOnce(&[u8])) -> u64 {
        let places = self.places.iter().filter_map(|place| place.try_lock().ok());
        match places.max_by_key(|place| place.rank).filter(|place| place.rank > after) {
            Some(place) => {
                to(&place.bytes);
                place.rank
            }
            None => after,
        }
    }

    /// Gives the memory back.
    pub(crate) fn forget(&self) {
        for place in &self.places {
            if let Ok(mut place) = place.try_lock() {
                *place = Place::default();
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
