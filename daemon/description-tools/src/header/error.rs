//! Why no header can be made.

/// Why no header can be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HeaderError {
    /// No component has this name.
    #[error("there is no component `{name}`; those described are: {known}")]
    NoComponent {
        /// The requested name.
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
    /// Two items have the same name in C.
    #[error("`{one}` and `{other}` have one name in C, `{name}`: rename one of them")]
    Clash {
        /// The C name.
        name: String,
        /// IDL name of the first one.
        one: String,
        /// IDL name of the second one.
        other: String,
    },
    /// A type has no mapping in C++ (genom3.md 6).
    #[error("{why}")]
    Cxx {
        /// Which, why, and what to do, in a sentence.
        why: String,
    },
    /// A header has either the C or the C++ interface, not both.
    #[error(
        "component `{cxx}` has lang \"c++\" and component `{c}` has not: ask for one of them \
         (--component)"
    )]
    Mixed {
        /// A component with `lang "c++"`.
        cxx: String,
        /// A component with another language.
        c: String,
    },
}
