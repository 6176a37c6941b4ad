//! Why a library has no information on its types.

use genom_elf::NoSections;

/// Why there is no debug information to compare with, and what to do.
#[derive(Debug, thiserror::Error)]
pub(in crate::contract) enum Untold {
    /// The debug information covers other parts of the library only.
    #[error("the library tells no types of them (build all of it with -g)")]
    OfOthers,
    /// The debug information is in separate `.dwo` files.
    #[error(
        "types are in .dwo files, which do not go with the library (build it without -gsplit-dwarf)"
    )]
    Split,
    /// There are no sections to read.
    #[error(transparent)]
    Sections(#[from] NoSections),
    /// The debug information is inconsistent.
    #[error("its debug information cannot be read: {0}")]
    Unreadable(#[from] gimli::Error),
}
