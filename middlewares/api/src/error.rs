//! What can go wrong, one enum per operation.

use crate::Address;

/// Opening a publisher or a subscription failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The other side carries another type under this address.
    #[error("{address} carries {theirs}, this side wants {ours}: make the two .gen types equal")]
    TypeMismatch {
        /// What was opened.
        address: Address,
        /// Type of this side: name, size and digest as far as known.
        ours: String,
        /// Type of the other side, likewise.
        theirs: String,
    },
    /// Another publisher already owns this address.
    #[error("{address} already has a publisher: give this instance another name (--name)")]
    Taken {
        /// What was opened.
        address: Address,
    },
    /// This middleware cannot carry such a type.
    #[error("{backend} cannot carry {ty}: {why}")]
    Unsupported {
        /// Name of the middleware.
        backend: String,
        /// The type.
        ty: String,
        /// What is missing.
        why: String,
    },
    /// The middleware itself failed.
    #[error("{backend} failed on {address}: {why}")]
    Failed {
        /// Name of the middleware.
        backend: String,
        /// What was opened.
        address: Address,
        /// The middleware's own words.
        why: String,
    },
}

/// Publishing failed. Small and without allocation: it is made on the real-time path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PublishError {
    /// The value has no encoding (an enumerator out of range, a string that is not UTF-8).
    #[error("the value cannot be encoded")]
    Serialization,
    /// The middleware refused the sample.
    #[error("the middleware refused the sample")]
    Refused,
}

/// Reading failed. Small and without allocation: it is made on the real-time path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The sample could not be decoded; the previous value is kept.
    #[error("the sample cannot be decoded")]
    Serialization,
    /// The middleware failed.
    #[error("the middleware failed")]
    Broken,
}

/// Listing what is visible failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{backend} cannot list its ports: {why}")]
pub struct DiscoverError {
    /// Name of the middleware.
    pub backend: String,
    /// The middleware's own words.
    pub why: String,
}
