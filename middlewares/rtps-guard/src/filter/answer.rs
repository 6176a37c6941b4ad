//! What becomes of a submessage that is in order.

/// What RustDDS gets of a submessage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// All of it.
    Pass,
    /// Nothing: there is nothing new in it.
    Drop,
    /// Instead of a request for parts of this sample, one for all of it, with this base.
    Whole {
        /// The reader has all samples before this one.
        base: i64,
        /// The sample.
        number: i64,
    },
}
