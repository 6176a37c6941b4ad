//! The `.gen` language: text to checked component model and diagnostics.
//!
//! Reading never fails: it returns what could be understood and everything there is to say
//! about it. This crate starts no thread, opens no socket and loads no code.
//!
//! ```
//! use genom_description::diagnostic::render;
//! use genom_description::{Options, read_text};
//!
//! let text = "component axis {
//!     version \"1.0\"; lang \"c\"; email \"axis@example.org\"; require \"genom3 >= 2.99\";
//!     ids { double speed; };
//!     attribute set_speed(in speed);
//!     function halve(out double speeed);
//! };";
//! let analysis = read_text("axis.gen", text, &Options::default());
//! assert!(!analysis.has_errors());
//! let axis = &analysis.specification.components[0];
//! assert_eq!(axis.name, "axis");
//! assert!(axis.services.iter().any(|service| service.name == "set_speed"));
//!
//! // What is wrong has a place and a code, which `diagnostic::explain` explains.
//! let analysis = read_text("axis.gen", "typedef lonk t;", &Options::default());
//! let told = render::short(&analysis.diagnostics, &analysis.sources);
//! assert_eq!(told, "axis.gen:1:9: error: unknown type `lonk` [E0206]\n");
//! ```
//!
//! The steps: [`preprocess`] makes tokens (of crate `genom-text`), [`parse`] a tree ([`syntax`]),
//! checking a [`model`] whose names are resolved.

#![forbid(unsafe_code)]

mod absent;
pub mod c_names;
mod check;
pub mod model;
pub mod parse;
mod read;
pub mod syntax;

pub use genom_text::{diagnostic, preprocess, source, token};
pub use read::{Analysis, Options, Parsed, parse_files, read, read_files, read_text};
