//! The codel's end of an in port on a middleware that receives encoded samples.

use genom_middleware::{OpenError, Policy, ReadError, Reading};
use genom_types::{DataType, Record};

use crate::mailbox::{Full, MAX_DEPTH};

/// How a mailbox keeps the samples of an in port, by the policy of its connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keeping {
    /// Samples that wait to be read.
    pub depth: usize,
    /// What gives way when there are more.
    pub full: Full,
    /// Whether those are losses: not where only the newest counts.
    pub counts: bool,
}

impl Keeping {
    /// What `policy` asks of a mailbox.
    ///
    /// # Errors
    /// It asks for more samples than a mailbox holds.
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
}

/// Decodes samples for a codel.
#[derive(Debug)]
pub struct Intake {
    /// Samples are decoded here first: one that fails leaves the codel's record alone.
    scratch: Record,
    /// Whether anything was read yet.
    read: bool,
}

impl Intake {
    /// For samples of a type.
    #[must_use]
    pub fn new(ty: &DataType) -> Self {
        ty.prepare();
        Self { scratch: Record::new(ty), read: false }
    }

    /// Reads the next sample into `into`. `take` gives it to the function it gets, if there is
    /// one, and says whether that could decode it.
    ///
    /// # Errors
    /// `into` is of another type, or the sample cannot be decoded.
    pub fn read(
        &mut self,
        into: &mut Record,
        take: impl FnOnce(&mut dyn FnMut(&[u8]) -> bool) -> Option<bool>,
    ) -> Result<Reading, ReadError> {
        if !into.ty().same_as(self.scratch.ty()) {
            return Err(ReadError::Broken);
        }
        let scratch = &mut self.scratch;
        match take(&mut |message| into.replace_from_message(message, scratch).is_ok()) {
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
