//! How a part of a library differs from its description.

use genom_types::LayoutError;

use crate::cxx::CxxTypeError;

/// How a codel's argument or a type differs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Mismatch {
    /// A part of it differs.
    #[error("{part}: {why}")]
    In {
        /// The argument, member or type.
        part: String,
        /// The difference.
        why: Box<Mismatch>,
    },
    /// Another item (singular).
    #[error("{wanted} is wanted, not {found}")]
    Other {
        /// What the description asks for.
        wanted: String,
        /// What the library has.
        found: String,
    },
    /// Other items (plural).
    #[error("{wanted} are wanted, not {found}")]
    Others {
        /// What the description asks for.
        wanted: String,
        /// What the library has.
        found: String,
    },
    /// A size, an offset or a bound differs.
    #[error("{what} {wanted} is wanted, not {found}")]
    Number {
        /// The name of the number.
        what: &'static str,
        /// Value in the description.
        wanted: u64,
        /// Value in the library.
        found: u64,
    },
    /// Their number differs.
    #[error("{wanted} {what} are wanted{and} it {takes} {found}")]
    Count {
        /// `arguments` or `parameters`.
        what: &'static str,
        /// Number in the description.
        wanted: usize,
        /// Words between the two parts of the message.
        and: &'static str,
        /// Verb of the second part.
        takes: &'static str,
        /// Number in the library.
        found: usize,
    },
    /// The function of a remote has another number of arguments.
    #[error("its call takes {wanted} arguments, not {found}")]
    Call {
        /// Number in the description.
        wanted: usize,
        /// Number in the library.
        found: usize,
    },
    /// The members of a struct differ.
    #[error("`{ours}` has members {wanted}; `{theirs}` has {found}")]
    Members {
        /// Name of the type in the description.
        ours: String,
        /// Its members in the description.
        wanted: String,
        /// Name of the type in the library.
        theirs: String,
        /// Its members in the library.
        found: String,
    },
    /// A port is multiple in only one of them.
    #[error("the port is {kind}: its methods take {arguments}")]
    Methods {
        /// Its kind in the description.
        kind: &'static str,
        /// The arguments that its methods then take.
        arguments: &'static str,
    },
    /// A class of the C++ library has different sizes.
    #[error(
        "`{class}` has {ours} bytes in this host's C++ library and {theirs} in that of the codels: \
         compile them with libstdc++ and its usual options"
    )]
    OtherLibrary {
        /// Name of the class.
        class: String,
        /// Its size in the host.
        ours: u64,
        /// Its size in the codels.
        theirs: u64,
    },
    /// The library has no information on the item.
    #[error("the library tells no {0}")]
    Untold(&'static str),
    /// The model refers to something that it lacks.
    #[error("there is no such {0}")]
    Absent(&'static str),
    /// The library has no array there.
    #[error("an array is wanted")]
    NoArray,
    /// The library has no union there.
    #[error("`{0}._u` is no union")]
    NoUnion(String),
    /// The type has no layout.
    #[error("{0}")]
    Layout(#[from] LayoutError),
    /// The type does not exist in C++.
    #[error("{0}")]
    Cxx(#[from] CxxTypeError),
}

impl Mismatch {
    /// Another item (singular).
    pub(super) fn other(wanted: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Other { wanted: wanted.into(), found: found.into() }
    }

    /// Other items (plural).
    pub(super) fn others(wanted: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Others { wanted: wanted.into(), found: found.into() }
    }

    /// The same difference, as that of a part.
    pub(super) fn within(self, part: impl Into<String>) -> Self {
        Self::In { part: part.into(), why: Box::new(self) }
    }
}

/// Whether a part agrees; the error says how it differs.
pub(super) type Agreement = Result<(), Mismatch>;
