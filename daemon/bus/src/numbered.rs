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
    /// Who told it first, if that was not this process.
    pub teller: Option<Teller>,
}

/// Another process of this daemon, that of a cell, and the number that a message has there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Teller {
    /// Name of the cell.
    pub cell: Arc<str>,
    /// Number of its process.
    pub process: u32,
    /// Number of the message on the bus of that process.
    pub id: u64,
}
