//! The text of `.gen` files: from files to tokens, with diagnostics.
//!
//! [`source`] holds the files and converts byte offsets to lines and columns, [`preprocess`] makes
//! [`token`]s of them, and [`diagnostic`] holds errors and warnings, of this crate and of the
//! crates above. Every token knows its position in the files, also through includes and macros.
//!
//! ```
//! use genom_text::preprocess::tokenize_text;
//! use genom_text::source::SourceMap;
//! use genom_text::token::TokenKind;
//!
//! let mut sources = SourceMap::new();
//! let (tokens, diagnostics) =
//!     tokenize_text("axis.gen", "#define AXES 3\nlong x[AXES];", &mut sources);
//! assert!(diagnostics.is_empty());
//! assert!(tokens.iter().any(|token| token.kind == TokenKind::Integer(3)));
//! // A macro's tokens have the position where the macro is used.
//! assert_eq!(sources.location(tokens[3].span).line, 2);
//! ```
//!
//! No name is resolved here; `genom-description` does that. The only I/O is reading the files that
//! a description includes, and running pkg-config for `#pragma requires`.

#![forbid(unsafe_code)]

pub mod diagnostic;
mod lex;
pub mod pkg_config;
pub mod preprocess;
mod printed;
mod ptoken;
pub mod source;
pub mod token;

pub use lex::is_name;
pub use printed::printed;
