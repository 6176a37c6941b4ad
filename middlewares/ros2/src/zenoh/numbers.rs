//! The numbers of samples, by which what arrives twice is taken once, and what is missing is counted.

use std::collections::HashMap;

use super::attachment::Attachment;
use crate::rmw::Gid;

/// Number of writers whose last numbers are remembered.
const MANY: usize = 256;

/// Number of the last sample of each writer.
#[derive(Default)]
pub(crate) struct Numbers(HashMap<Gid, i64>);

impl Numbers {
    /// Whether a sample is new; with the number of those that were lost before it.
    pub(crate) fn admit(&mut self, Attachment { number, gid }: Attachment) -> Option<u64> {
        if self.0.len() >= MANY && !self.0.contains_key(&gid) {
            self.0.clear();
        }
        let last = self.0.insert(gid, number);
        let Some(last) = last else { return Some(0) };
        if number <= last {
            self.0.insert(gid, last);
            return None;
        }
        // A peer may send any number.
        let missing = number.saturating_sub(last).saturating_sub(1);
        Some(u64::try_from(missing).unwrap_or(0).min(u64::from(u32::MAX)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_taken_once_and_those_between_are_counted_by_writer() {
        let mut numbers = Numbers::default();
        let mut admit = |gid: u8, number| numbers.admit(Attachment { number, gid: [gid; 16] });
        assert_eq!(admit(1, 7), Some(0), "what came before a reader is no loss of it");
        assert_eq!(admit(1, 7), None);
        assert_eq!(admit(1, 8), Some(0));
        assert_eq!(admit(2, 3), Some(0));
        assert_eq!(admit(1, 11), Some(2));
        assert_eq!(admit(1, 10), None);
        assert_eq!(admit(1, i64::MAX), Some(u64::from(u32::MAX)));
        assert_eq!(admit(3, i64::MIN), Some(0));
        assert_eq!(admit(3, i64::MAX), Some(u64::from(u32::MAX)));
        for gid in 0..=255u8 {
            admit(gid, 1);
        }
        assert!(numbers.0.len() <= MANY);
    }
}
