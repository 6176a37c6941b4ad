//! Errors of middlewares, one enum per operation.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::Address;

/// Opening a publisher or a subscription failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[non_exhaustive]
pub enum OpenError {
    /// The other side uses another type at this address.
    #[error("{address} carries {theirs}, this side wants {ours}: make the two .gen types equal")]
    TypeMismatch {
        /// Address that was opened.
        address: Address,
        /// Type on this side: name, size and digest as far as they are known.
        ours: String,
        /// Type on the other side, in the same form.
        theirs: String,
    },
    /// Another publisher has this address.
    #[error("{address} already has a publisher: give this instance another name (--name)")]
    Taken {
        /// Address that was opened.
        address: Address,
    },
    /// This middleware cannot carry the type.
    #[error("{backend} cannot carry {ty}: {why}")]
    Unsupported {
        /// Name of the middleware.
        backend: String,
        /// Spelling of the type that cannot be carried.
        ty: String,
        /// The reason.
        why: String,
    },
    /// The middleware itself failed.
    #[error("{backend} failed on {address}: {why}")]
    Failed {
        /// Name of the middleware.
        backend: String,
        /// Address that was opened.
        address: Address,
        /// The middleware's own message.
        why: String,
    },
}

/// A type or service cannot masquerade: the foreign name does not have the middleware's form.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[error("{ours} cannot masquerade as `{foreign}`: write {form}")]
pub struct NoForeignName {
    /// Full name of the IDL type or service.
    pub ours: String,
    /// The foreign name as given.
    pub foreign: String,
    /// Form of the middleware's names, such as `package/msg/Type`.
    pub form: Cow<'static, str>,
}

/// Publishing failed. Has no heap data, because it is created on the real-time path.
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

/// Reading failed. Has no heap data, because it is created on the real-time path.
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
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[error("{backend} cannot list its ports: {why}")]
pub struct DiscoverError {
    /// Name of the middleware.
    pub backend: String,
    /// The middleware's own message.
    pub why: String,
}

/// A call of a service failed before the service answered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[non_exhaustive]
pub enum CallError {
    /// Nobody serves the address.
    #[error("nobody serves {address}: is the component running on this middleware?")]
    Nobody {
        /// Address that was called.
        address: Address,
    },
    /// The service has other input or output types.
    #[error("{address} serves {theirs}, this side calls {ours}: make the two .gen types equal")]
    TypeMismatch {
        /// Address that was called.
        address: Address,
        /// Types on this side.
        ours: String,
        /// Types on the other side.
        theirs: String,
    },
    /// No reply within this time.
    #[error("no answer within {0:?}")]
    Timeout(std::time::Duration),
    /// The service went away before it replied.
    #[error("the service went away before it answered")]
    Gone,
    /// The reply could not be decoded.
    #[error("the answer cannot be decoded: {0}")]
    Serialization(String),
    /// The middleware itself failed.
    #[error("{backend} failed: {why}")]
    Failed {
        /// Name of the middleware.
        backend: String,
        /// The middleware's own message.
        why: String,
    },
}
