//! Finds the C++ function of a codel among those with its name.

use genom_description::model::{Codel, Component};
use genom_types::TypeTable;

use super::{shim, spelling};
use crate::library::Library;

/// What a library has for a codel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    /// The function, by its symbol.
    Found(String),
    /// Functions of that name with other parameters, demangled.
    Others(Vec<String>),
    /// None of that name.
    Missing,
}

/// Searches the codel among the C++ functions that the library exports.
///
/// Symbols are demangled and compared with the expected declaration. Mangling the expected name
/// instead, with the substitutions of the C++ ABI, could only show that a symbol is missing, not
/// what is there instead.
pub(crate) fn find(
    library: &Library,
    component: &Component,
    types: &TypeTable,
    codel: &Codel,
) -> Function {
    let wanted = spelling::codel(component, types, codel);
    let mut others = Vec::new();
    for symbol in library.mangled(&codel.name) {
        let Some(text) = shim::demangled(&symbol) else { continue };
        if spelling::compact(&text) == wanted {
            return Function::Found(symbol);
        }
        others.push(text);
    }
    if others.is_empty() { Function::Missing } else { Function::Others(others) }
}
