//! Compares a library with its description, as far as the library describes itself.
//!
//! A Rust library built with the SDK exports a table of its codels and types; a C or C++ library
//! may have debug information. No code of the library runs for this.

mod declare;
mod descriptors;
mod difference;
mod dwarf;
mod mismatch;
mod table;

use std::path::Path;

use genom_description::model::Span;
use genom_runtime::plan::Plan;

use crate::library::Library;
pub use difference::Difference;
use table::TableError;

/// The information that the library was compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checked {
    /// The table that the Rust SDK exports.
    Descriptors,
    /// The debug information of C and C++.
    DebugInformation,
    /// The library has no information on its types.
    Unchecked,
}

/// Result of a comparison.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// The information that was used.
    pub checked: Checked,
    /// Codels that were compared.
    pub codels: usize,
    /// The differences found.
    pub differences: Vec<Difference>,
    /// Why nothing was compared, or which codels were not compared and why.
    pub unchecked: Option<String>,
}

/// Compares every codel and type of the plan's component on which the library has information.
///
/// `locate` formats a position in the `.gen` as file and line.
#[must_use]
pub fn check(library: &Library, plan: &Plan, locate: &dyn Fn(Span) -> String) -> Report {
    match table::read(library) {
        Ok(Some(table)) => {
            let (codels, differences) = descriptors::compare(&table, plan, locate);
            Report { checked: Checked::Descriptors, codels, differences, unchecked: None }
        }
        Ok(None) => match dwarf::compare(library, plan, locate) {
            Ok(dwarf::Compared { codels, differences, unchecked }) => {
                Report { checked: Checked::DebugInformation, codels, differences, unchecked }
            }
            Err(why) => Report {
                checked: Checked::Unchecked,
                codels: 0,
                differences: Vec::new(),
                unchecked: Some(why.to_string()),
            },
        },
        Err(error) => {
            let difference = unreadable(library.path(), &error, locate(plan.component().span));
            Report {
                checked: Checked::Descriptors,
                codels: 0,
                differences: vec![difference],
                unchecked: None,
            }
        }
    }
}

fn unreadable(library: &Path, error: &TableError, place: String) -> Difference {
    Difference {
        subject: "table of codels".to_owned(),
        place,
        why: error.to_string(),
        description: format!("version {}.x of the table", genom::abi::ABI_MAJOR),
        library: library.display().to_string(),
    }
}
