//! The text of `.gen` files: from files to tokens, and what there is to say about them.
//!
//! [`source`] holds the files and tells where a byte stands, [`preprocess`] makes [`token`]s of
//! them, and [`diagnostic`] holds what is found wrong, here and by the crates above. Every token
//! knows its place in the files, over includes and macros.
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
//! // A macro's tokens stand where the macro is used.
//! assert_eq!(sources.location(tokens[3].span).line, 2);
//! ```
//!
//! Nothing is resolved here: what the tokens mean, `genom-description` says. The only I/O is
//! reading the files that a description includes, and running pkg-config for `#pragma requires`.

#![forbid(unsafe_code)]

pub mod diagnostic;
mod lex;
pub mod preprocess;
mod ptoken;
pub mod source;
pub mod token;

pub use lex::is_name;
