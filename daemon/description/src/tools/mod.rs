//! What can be made of a checked description: pure functions from model or text to text.

mod describe;
mod fmt;
mod graph;
pub(crate) mod header;
mod schema;

pub use describe::{describe, describe_text};
pub use fmt::{FormatError, format_bytes, format_text};
pub use graph::{Graph, graph};
pub use header::{HeaderError, Language, declaration, header, prototype};
pub use schema::{schema, service_schemas};
