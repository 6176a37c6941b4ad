//! Draws what a daemon says: for `genomctl`, which asks it.
//!
//! [`plot`] draws numbers over time and [`top`] what goes on now, both in a terminal or as text;
//! [`picture`] draws what runs and its connections as SVG and in the languages of Graphviz and
//! Mermaid. [`units`] formats quantities, and [`xml`] text in SVG.

#![forbid(unsafe_code)]

pub mod picture;
mod plain;
pub mod plot;
pub mod top;
pub mod units;
pub mod xml;
