//! A middleware with its two ends.

use crate::error::FloorError;
use crate::pair::{Receive, Send};

/// A bare middleware in one process.
pub trait Bare {
    /// The writing end for values of so many bytes.
    ///
    /// # Errors
    /// The middleware refuses.
    fn writer(&self, bytes: usize) -> Result<Box<dyn Send>, FloorError>;

    /// The reading end.
    ///
    /// # Errors
    /// The middleware refuses.
    fn reader(&self, bytes: usize) -> Result<Box<dyn Receive>, FloorError>;
}
