//! Debug information (DWARF) of C and C++: which functions and types a library has, and how these
//! are laid out.

mod node;
mod search;

pub use node::{At, Composite, Function, Member, Node};
pub use search::{DebugInfo, Found, Wanted};
