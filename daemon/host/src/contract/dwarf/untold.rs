//! Why a library has no information on its types.

/// Why there is no debug information to compare with, and what to do.
#[derive(Debug, thiserror::Error)]
pub(in crate::contract) enum Untold {
    /// The library was built without debug information.
    #[error("the library tells no types (build it with -g)")]
    Nothing,
    /// The debug information covers other parts of the library only.
    #[error("the library tells no types of them (build all of it with -g)")]
    OfOthers,
    /// The debug information is in separate `.dwo` files.
    #[error(
        "types are in .dwo files, which do not go with the library (build it without -gsplit-dwarf)"
    )]
    Split,
    /// The debug information was stripped into another file.
    #[error(
        "its debug information is in another file, {file} (load the library that was not stripped)"
    )]
    Elsewhere {
        /// Name of that file.
        file: String,
    },
    /// A section cannot be decompressed.
    #[error("its section {section} is damaged: {why}")]
    Damaged {
        /// Name of the section.
        section: &'static str,
        /// The error.
        why: Damage,
    },
    /// A section is compressed by another method.
    #[error(
        "its section {section} is compressed in a way this daemon does not read (compress with \
         -gz=zlib, or not at all)"
    )]
    Compressed {
        /// Name of the section.
        section: &'static str,
    },
    /// The debug information is inconsistent.
    #[error("its debug information cannot be read: {0}")]
    Unreadable(#[from] gimli::Error),
}

/// What is wrong with a compressed section.
#[derive(Debug, thiserror::Error)]
pub(in crate::contract) enum Damage {
    /// Its header is invalid.
    #[error("{0}")]
    Header(#[from] object::Error),
    /// Its content cannot be decompressed.
    #[error("{0}")]
    Contents(#[from] std::io::Error),
    /// Its header claims an unreasonable size.
    #[error("it says it has {0} bytes")]
    Huge(u64),
    /// Its header claims another size.
    #[error("it is shorter or longer than it says")]
    Length,
}
