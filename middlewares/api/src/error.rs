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
        /// Spelling of the type that cannot be carried.
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

/// A type or service cannot be shown as one of the middleware's own: there are no such names.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{ours} cannot masquerade as `{foreign}`: write {form}")]
pub struct NoForeignName {
    /// Full name of the IDL type or service.
    pub ours: String,
    /// What was given.
    pub foreign: String,
    /// How such names are written.
    pub form: &'static str,
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

/// A call of a service failed before the service answered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CallError {
    /// Nobody serves the address.
    #[error("nobody serves {address}: is the component running on this middleware?")]
    Nobody {
        /// What was called.
        address: Address,
    },
    /// The service takes or gives other types.
    #[error("{address} serves {theirs}, this side calls {ours}: make the two .gen types equal")]
    TypeMismatch {
        /// What was called.
        address: Address,
        /// Types of this side.
        ours: String,
        /// Types of the other side.
        theirs: String,
    },
    /// No answer in time.
    #[error("no answer within {0:?}")]
    Timeout(std::time::Duration),
    /// The service went away before it answered.
    #[error("the service went away before it answered")]
    Gone,
    /// The answer could not be decoded.
    #[error("the answer cannot be decoded: {0}")]
    Serialization(String),
    /// The middleware itself failed.
    #[error("{backend} failed: {why}")]
    Failed {
        /// Name of the middleware.
        backend: String,
        /// The middleware's own words.
        why: String,
    },
}
