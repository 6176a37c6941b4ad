//! Tools on descriptions: what is generated from one, and what an editor asks about one.
//!
//! Pure functions from model or text to text: [`header`] for codels, [`graph`]s, JSON [`schema`]s,
//! descriptions ([`describe`]), formatted text ([`format_text`]). [`navigate`] resolves the names
//! in a text that may be incomplete.
//!
//! ```
//! use genom_description::{Options, read_text};
//! use genom_description_tools::{Language, format_text, header};
//!
//! let tidy = format_text("struct pose { double x,y; };\n").unwrap();
//! assert_eq!(tidy, "struct pose { double x, y; };\n");
//! let analysis = read_text("pose.gen", &tidy, &Options::default());
//! let text = header(&analysis.specification, None, Language::C).unwrap();
//! assert!(text.contains("struct pose {"));
//! ```

#![forbid(unsafe_code)]

mod describe;
mod format;
mod graph;
mod header;
pub mod navigate;
mod schema;

pub use describe::{describe, describe_text};
pub use format::{FormatError, format_bytes, format_text};
pub use graph::{Graph, graph};
pub use header::{
    HeaderError, Language, Signatures, declaration, header, mappings, prototype, signature,
};
pub use schema::{schema, service_schemas};
