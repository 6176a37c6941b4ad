//! Every row of genom3.md section 3, one test each, named as its rule.
//!
//! A refused text has exactly one error.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod codels;
mod components;
mod constants;
mod drawn;
mod echo;
mod explained;
mod initialisers;
mod names;
mod pauses;
mod properties;
mod services;
mod syntax;
mod warnings;

use genom_description::diagnostic::{Severity, render};
use genom_description::{Analysis, Options, read_text};

fn analyse(text: &str) -> Analysis {
    let options = Options { standard_interface: false, ..Options::default() };
    read_text("test.gen", text, &options)
}

/// The text has one error, of this code, on this line.
#[track_caller]
fn refused(code: &str, line: u32, text: &str) {
    let analysis = analyse(text);
    let said = render::short(&analysis.diagnostics, &analysis.sources);
    let errors: Vec<_> =
        analysis.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
    let found: Vec<_> =
        errors.iter().map(|d| (d.code, analysis.sources.location(d.span).line)).collect();
    assert_eq!(found, [(code, line)], "{said}\n{text}");
}

/// The text has no error, and one warning: this one.
#[track_caller]
fn warned(code: &str, text: &str) {
    let analysis = analyse(text);
    let found: Vec<_> = analysis.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(found, [code], "{text}");
}

/// The text has no error and no warning.
#[track_caller]
fn accepted(text: &str) {
    let analysis = analyse(text);
    let said = render::short(&analysis.diagnostics, &analysis.sources);
    assert!(analysis.diagnostics.is_empty(), "{said}\n{text}");
}

/// One test a row: name, code, line of the error, text.
macro_rules! rules {
    ($($name:ident $code:literal $line:literal $text:expr;)*) => {
        $(#[test]
        fn $name() {
            crate::refused($code, $line, $text);
        })*
    };
}
pub(crate) use rules;
