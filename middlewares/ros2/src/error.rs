//! Why the middleware does not open.

use rustdds::dds::CreateError;

use crate::options::OptionsError;

/// What configurations and errors call this middleware.
pub(crate) const BACKEND: &str = "ros2";

/// The middleware could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ParticipantError {
    /// An option is wrong.
    #[error(transparent)]
    Options(#[from] OptionsError),
    /// DDS did not open.
    #[error("DDS does not open domain {domain}: {why}")]
    Dds {
        /// Number of the domain.
        domain: u16,
        /// The library's own words.
        why: CreateError,
    },
    /// The system gave no thread.
    #[error("no thread for ROS 2: {0}")]
    Thread(#[from] std::io::Error),
}
