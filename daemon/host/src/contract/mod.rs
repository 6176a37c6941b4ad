//! Whether a library agrees with its description, as far as the library says.
//!
//! A Rust library built with the SDK exports a table of its codels and types; one of C or C++ may
//! carry debug information. Nothing of the library runs for this.

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

/// What the library was compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checked {
    /// The table that the Rust SDK exports.
    Descriptors,
    /// The debug information of C and C++.
    DebugInformation,
    /// Nothing: the library says nothing of its types.
    Unchecked,
}

/// What a check found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// What it went by.
    pub checked: Checked,
    /// Codels that were compared.
    pub codels: usize,
    /// What differs.
    pub differences: Vec<Difference>,
    /// Why nothing was compared, or which codels were not and why.
    pub unchecked: Option<String>,
}

/// Compares every codel and type that the library tells about with the plan's component.
///
/// `locate` shows a place of the `.gen` as file and line.
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
