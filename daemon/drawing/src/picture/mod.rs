//! Pictures of a running system: what is in it (`system`), where its parts are drawn (`layout`), and
//! the languages they are written in.

mod colour;
mod dot;
mod layout;
mod mermaid;
mod svg;
mod system;

pub use dot::dot;
pub use mermaid::mermaid;
pub use svg::svg;
pub use system::{System, Told};
