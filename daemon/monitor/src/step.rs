//! Steps that find out what holds where something happens, and note what is asked for later.
//!
//! Both are bits, one for each part, in one word. What a bit says, [`says`] tells.

use crate::program::Part;

/// One step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// It is done if of these bits those and no others are set.
    pub(crate) mask: u64,
    pub(crate) want: u64,
    /// Bits that change.
    pub(crate) turns: u64,
    /// Bits that are set at the next event.
    pub(crate) keeps: u64,
    pub(crate) what: What,
}

/// What is done, beside changing bits. Parts with bounds are given by number.
#[derive(Clone, Copy, Debug)]
pub(crate) enum What {
    /// Nothing.
    Turn,
    /// Bits change only if the date of the part is within its bounds.
    Look(u8),
    /// The date of the part is now, or it has none any more. No bits change.
    Note(u8, bool),
    /// The service of a part starts. No bits change.
    Starts(u8),
    /// It ends; bits change if it had started more often.
    Ends(u8),
}

/// Whether the bit of a part says that it holds; that of others is set if they do not.
pub(crate) fn says(part: &Part) -> bool {
    !matches!(part, Part::Or(..) | Part::Implies(..) | Part::Historically(..))
}
