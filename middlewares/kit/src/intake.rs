//! The reading end of a port, on middlewares that receive encoded samples.

use std::ops::RangeInclusive;

use genom_middleware::{OpenError, Policy, ReadError, Reading};
use genom_types::{DataType, Record};

use crate::mailbox::{Full, MAX_DEPTH};

/// Sizes in bytes of samples that may wait in the memory in which a middleware received them: large
/// enough to save a copy that is worth it, but not so large that a few use up the memory that the
/// writer shares with its readers (16 MiB in zenoh by default).
const HELD: RangeInclusive<usize> = (16 << 10)..=(2 << 20);

/// Mailbox settings that implement the policy of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keeping {
    /// Number of unread samples that are kept.
    pub depth: usize,
    /// Which sample is dropped when there are more.
    pub full: Full,
    /// Whether dropped samples count as lost. False under [`Policy::Latest`], where only the newest
    /// matters.
    pub counts: bool,
}

impl Keeping {
    /// The mailbox settings for `policy`.
    ///
    /// # Errors
    /// The policy asks for more samples than a mailbox can hold.
    pub fn of(policy: Policy, backend: &str, ty: &DataType) -> Result<Self, OpenError> {
        let (depth, full, counts) = match policy {
            Policy::Latest => (1, Full::Oldest, false),
            Policy::Queue(depth) => (depth, Full::Newest, true),
            Policy::Ring(depth) => (depth, Full::Oldest, true),
        };
        if depth > MAX_DEPTH {
            return Err(OpenError::Unsupported {
                backend: backend.to_owned(),
                ty: ty.name().to_owned(),
                why: format!("a reader holds at most {MAX_DEPTH} samples, not {depth}"),
            });
        }
        Ok(Self { depth, full, counts })
    }

    /// Whether a sample of so many bytes may wait in the middleware's memory instead of a copy.
    /// Under [`Policy::Latest`] only, where few samples wait.
    #[must_use]
    pub fn holds(&self, bytes: usize) -> bool {
        !self.counts && HELD.contains(&bytes)
    }
}

/// Decodes samples for a codel.
#[derive(Debug)]
pub struct Intake {
    /// Samples are decoded into this record first, so that one that fails leaves the codel's record
    /// unchanged.
    scratch: Record,
    /// Whether a sample has been read yet.
    read: bool,
}

impl Intake {
    /// A decoder for samples of type `ty`.
    #[must_use]
    pub fn new(ty: &DataType) -> Self {
        ty.prepare();
        Self { scratch: Record::new(ty), read: false }
    }

    /// Reads the next sample into `into`. `take` passes the next sample, if there is one, to the
    /// function that it is given, and returns whether that could decode it.
    ///
    /// # Errors
    /// `into` has another type, or the sample cannot be decoded.
    pub fn read(
        &mut self,
        into: &mut Record,
        take: impl FnOnce(&mut dyn FnMut(&[u8]) -> bool) -> Option<bool>,
    ) -> Result<Reading, ReadError> {
        if !into.ty().same_as(self.scratch.ty()) {
            return Err(ReadError::Broken);
        }
        let scratch = &mut self.scratch;
        let taken = take(&mut |message| into.replace_from_message(message, scratch).is_ok());
        self.told(taken)
    }

    /// The same, but the sample stays a message.
    ///
    /// # Errors
    /// It is no value of the type.
    pub fn read_message(
        &mut self,
        into: &mut Vec<u8>,
        take: impl FnOnce(&mut dyn FnMut(&[u8]) -> bool) -> Option<bool>,
    ) -> Result<Reading, ReadError> {
        let ty = self.scratch.ty();
        let taken = take(&mut |message| {
            let size = ty.check_message(message);
            into.clear();
            into.extend_from_slice(message.get(..*size.as_ref().unwrap_or(&0)).unwrap_or_default());
            size.is_ok()
        });
        self.told(taken)
    }

    fn told(&mut self, taken: Option<bool>) -> Result<Reading, ReadError> {
        match taken {
            None if self.read => Ok(Reading::Same),
            None => Ok(Reading::Never),
            Some(false) => Err(ReadError::Serialization),
            Some(true) => {
                self.read = true;
                Ok(Reading::New)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use genom_types::{Kind, TypeTable};

    use super::*;

    #[test]
    fn only_the_latest_sample_may_wait_where_it_was_received_and_neither_small_nor_huge() {
        let mut types = TypeTable::default();
        let double = types.add(Kind::Double);
        let ty = DataType::new(&types.into(), double).unwrap();
        let of = |policy| Keeping::of(policy, "zenoh", &ty).unwrap();
        let latest = of(Policy::Latest);
        let sizes = [0, (16 << 10) - 1, 16 << 10, 2 << 20, (2 << 20) + 1];
        assert_eq!(sizes.map(|size| latest.holds(size)), [false, false, true, true, false]);
        for policy in [Policy::Queue(2), Policy::Ring(2)] {
            assert!(!of(policy).holds(64 << 10), "{policy:?}");
        }
    }
}
