//! Errors of opening the middleware.

use crate::dds::rustdds::dds::CreateError;

use crate::options::OptionsError;

/// Name of this middleware in configurations and errors.
pub(crate) const BACKEND: &str = "ros2";

/// The middleware could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ParticipantError {
    /// An option is wrong.
    #[error(transparent)]
    Options(#[from] OptionsError),
    /// DDS failed.
    #[error("DDS does not open domain {domain}: {why}")]
    Dds {
        /// Number of the domain.
        domain: u16,
        /// The library's message.
        why: CreateError,
    },
    /// zenoh failed.
    #[error("zenoh does not open: {0}")]
    Zenoh(String),
    /// The system cannot start another thread.
    #[error("no thread for ROS 2: {0}")]
    Thread(#[from] std::io::Error),
}
