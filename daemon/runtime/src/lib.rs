//! The component model at work: tasks, activities, requests, exclusion (genom3.md 7).
//!
//! It calls codels and touches component memory only through [`body`], names no middleware and
//! does no I/O of its own.

#![forbid(unsafe_code)]

pub mod body;
pub mod plan;
