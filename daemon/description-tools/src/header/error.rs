//! Why there is no header.

/// Why there is no header.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HeaderError {
    /// The name is not that of a component.
    #[error("there is no component `{name}`; those described are: {known}")]
    NoComponent {
        /// The name asked for.
        name: String,
        /// Names of the components, or "none".
        known: String,
    },
    /// `any` has no mapping (genom3.md 5.2).
    #[error("type `any` has no mapping: use a union in `{name}`")]
    Any {
        /// The type that contains it.
        name: String,
    },
    /// Two things have one name in C: one of them would be missing.
    #[error("`{one}` and `{other}` have one name in C, `{name}`: rename one of them")]
    Clash {
        /// The C name.
        name: String,
        /// What has it first.
        one: String,
        /// What has it too.
        other: String,
    },
    /// A type has no mapping in C++ (genom3.md 6).
    #[error("{why}")]
    Cxx {
        /// Which, why, and what to do, in a sentence.
        why: String,
    },
    /// A header is for one interface or for the other.
    #[error(
        "component `{cxx}` has lang \"c++\" and component `{c}` has not: ask for one of them \
         (--component)"
    )]
    Mixed {
        /// A component in C++.
        cxx: String,
        /// One that is not.
        c: String,
    },
}
