//! A message of a bus.

use std::sync::Arc;

use serde_json::Value;

/// A message and its number.
#[derive(Clone, Debug)]
pub struct Numbered {
    /// Consecutive numbers, from 1.
    pub id: u64,
    /// When it was sent: see `Dates::moment`.
    pub moment: u64,
    /// The message, as JSON.
    pub data: Arc<Value>,
}
