//! The model of legal descriptions.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod defaults;
mod digest;
mod exclusion;
mod inherit;
mod language;
mod standard;
mod timing;

use genom_description::diagnostic::render;
use genom_description::model::{Component, Specification};
use genom_description::{Analysis, Options, read_text};

/// Reads a legal text, without the standard interface.
#[track_caller]
fn plain(text: &str) -> Specification {
    let options = Options { standard_interface: false, ..Options::default() };
    legal(read_text("test.gen", text, &options))
}

/// Reads a legal text as the daemon does.
#[track_caller]
fn whole(text: &str) -> Specification {
    legal(read_text("test.gen", text, &Options::default()))
}

#[track_caller]
fn legal(analysis: Analysis) -> Specification {
    let said = render::short(&analysis.diagnostics, &analysis.sources);
    assert!(!analysis.has_errors(), "{said}");
    analysis.specification
}

fn component<'s>(specification: &'s Specification, name: &str) -> &'s Component {
    specification.components.iter().find(|component| component.name == name).unwrap()
}

/// Names of exceptions or other types.
fn type_names(specification: &Specification, types: &[genom_types::TypeId]) -> Vec<String> {
    let name = |ty| specification.types.kind(ty).name().map(ToString::to_string);
    types.iter().filter_map(|ty| name(*ty)).collect()
}
