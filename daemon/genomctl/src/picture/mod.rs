//! Pictures of a running system: what is in it (`system`), where its parts are drawn (`layout`), and
//! the languages they are written in.

mod colour;
mod dot;
mod layout;
mod mermaid;
mod svg;
mod system;

pub(crate) use dot::dot;
pub(crate) use mermaid::mermaid;
pub(crate) use svg::svg;
pub(crate) use system::System;
