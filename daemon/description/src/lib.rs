//! The `.gen` language: from text to a checked component model and diagnostics.
//!
//! Reading never fails: it returns what could be understood, with all errors and warnings. This
//! crate starts no thread, opens no socket and loads no code.
//!
//! ```
//! use genom_description::diagnostic::render;
//! use genom_description::{Options, read_text};
//!
//! let text = "component axis {
//!     version \"1.0\"; lang \"c\"; email \"axis@example.org\"; require \"genom3 >= 2.99\";
//!     ids { double speed; };
//!     attribute set_speed(in speed);
//!     function stop_distance(in double slope, out double distance);
//! };";
//! let analysis = read_text("axis.gen", text, &Options::default());
//! assert!(!analysis.has_errors());
//!
//! // The services of the component, without those that every component has (`standard`).
//! let axis = &analysis.specification.components[0];
//! let mut list = String::new();
//! for service in axis.services.iter().filter(|service| !service.standard) {
//!     let parameters: Vec<&str> = service.parameters.iter().map(|p| p.name.as_str()).collect();
//!     list += &format!("{:?} {}({})\n", service.kind, service.name, parameters.join(", "));
//! }
//! assert_eq!(list, "Attribute set_speed(speed)\nFunction stop_distance(slope, distance)\n");
//!
//! // A diagnostic has a position and a code, which `diagnostic::explain` explains.
//! let analysis = read_text("axis.gen", "typedef lonk t;", &Options::default());
//! assert!(analysis.has_errors());
//! let shown = render::short(&analysis.diagnostics, &analysis.sources);
//! assert_eq!(shown, "axis.gen:1:9: error: unknown type `lonk` [E0206]\n");
//! ```
//!
//! The steps: [`preprocess`] (of crate `genom-text`) makes tokens, [`parse`] makes a tree
//! ([`syntax`]), and checking makes a [`model`], in which all names are resolved.

#![forbid(unsafe_code)]

mod absent;
pub mod c_names;
mod check;
pub mod model;
pub mod parse;
mod read;
pub mod syntax;

pub use genom_text::{diagnostic, pkg_config, preprocess, printed, source, token};
pub use read::{Analysis, Options, Parsed, parse_files, read, read_files, read_text};
