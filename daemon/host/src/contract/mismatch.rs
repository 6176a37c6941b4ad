//! In what a part of a library differs from its description.

use genom_types::LayoutError;

use crate::cxx::CxxTypeError;

/// In what a codel's argument or a type differs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Mismatch {
    /// A part of it differs.
    #[error("{part}: {why}")]
    In {
        /// The part: an argument, a member, a type.
        part: String,
        /// In what that differs.
        why: Box<Mismatch>,
    },
    /// Another one is there.
    #[error("{wanted} is wanted, not {found}")]
    Other {
        /// What the description asks for.
        wanted: String,
        /// What the library has.
        found: String,
    },
    /// Others are there.
    #[error("{wanted} are wanted, not {found}")]
    Others {
        /// What the description asks for.
        wanted: String,
        /// What the library has.
        found: String,
    },
    /// A size, an offset or a bound is another one.
    #[error("{what} {wanted} is wanted, not {found}")]
    Number {
        /// Which number.
        what: &'static str,
        /// That of the description.
        wanted: u64,
        /// That of the library.
        found: u64,
    },
    /// There are more or fewer of them.
    #[error("{wanted} {what} are wanted{and} it {takes} {found}")]
    Count {
        /// Arguments or parameters.
        what: &'static str,
        /// Those of the description.
        wanted: usize,
        /// What joins the sentences.
        and: &'static str,
        /// How the library has them.
        takes: &'static str,
        /// Those of the library.
        found: usize,
    },
    /// The function of a remote takes more or fewer arguments.
    #[error("its call takes {wanted} arguments, not {found}")]
    Call {
        /// Those of the description.
        wanted: usize,
        /// Those of the library.
        found: usize,
    },
    /// A struct has other members.
    #[error("`{ours}` has members {wanted}; `{theirs}` has {found}")]
    Members {
        /// Name of the type in the description.
        ours: String,
        /// Its members.
        wanted: String,
        /// Name of the type in the library.
        theirs: String,
        /// Its members.
        found: String,
    },
    /// A port is multiple on one side only.
    #[error("the port is {kind}: its methods take {arguments}")]
    Methods {
        /// What it is in the description.
        kind: &'static str,
        /// What its methods take then.
        arguments: &'static str,
    },
    /// A class of the C++ library has another size.
    #[error(
        "`{class}` has {ours} bytes in this host's C++ library and {theirs} in that of the codels: \
         compile them with libstdc++ and its usual options"
    )]
    OtherLibrary {
        /// The class.
        class: String,
        /// Its size here.
        ours: u64,
        /// Its size there.
        theirs: u64,
    },
    /// The library does not say what is there.
    #[error("the library tells no {0}")]
    Untold(&'static str),
    /// The model refers to what it does not have.
    #[error("there is no such {0}")]
    Absent(&'static str),
    /// Something else stands in place of an array.
    #[error("an array is wanted")]
    NoArray,
    /// Something else stands in place of a union's members.
    #[error("`{0}._u` is no union")]
    NoUnion(String),
    /// The type has no place in memory.
    #[error("{0}")]
    Layout(#[from] LayoutError),
    /// The type has no place in C++.
    #[error("{0}")]
    Cxx(#[from] CxxTypeError),
}

impl Mismatch {
    /// Another one is there.
    pub(super) fn other(wanted: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Other { wanted: wanted.into(), found: found.into() }
    }

    /// Others are there.
    pub(super) fn others(wanted: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Others { wanted: wanted.into(), found: found.into() }
    }

    /// The same, of a part.
    pub(super) fn within(self, part: impl Into<String>) -> Self {
        Self::In { part: part.into(), why: Box::new(self) }
    }
}

/// Whether a part agrees, and in what not.
pub(super) type Agreement = Result<(), Mismatch>;
