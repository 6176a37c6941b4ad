//! Why a library tells nothing of its types.

/// Why there is no debug information to compare with, and what to do.
#[derive(Debug, thiserror::Error)]
pub(in crate::contract) enum Untold {
    /// It was built without.
    #[error("the library tells no types (build it with -g)")]
    Nothing,
    /// It is about other parts of the library.
    #[error("the library tells no types of them (build all of it with -g)")]
    OfOthers,
    /// It was left beside the library.
    #[error(
        "types are in .dwo files, which do not go with the library (build it without -gsplit-dwarf)"
    )]
    Split,
    /// It was taken out of the library.
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
        /// What is wrong with it.
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
    /// It contradicts itself.
    #[error("its debug information cannot be read: {0}")]
    Unreadable(#[from] gimli::Error),
}

/// What is wrong with a compressed section.
#[derive(Debug, thiserror::Error)]
pub(in crate::contract) enum Damage {
    /// Its header is none.
    #[error("{0}")]
    Header(#[from] object::Error),
    /// Its contents are not what the method makes.
    #[error("{0}")]
    Contents(#[from] std::io::Error),
    /// Its header announces more than is ever there.
    #[error("it says it has {0} bytes")]
    Huge(u64),
    /// Its header announces another length.
    #[error("it is shorter or longer than it says")]
    Length,
}
