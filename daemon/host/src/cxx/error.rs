//! Why a type, or a datum inside a value, does not exist in C++.

use genom_types::PathError;

/// Why a type does not exist in C++ (genom3.md 6).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum CxxTypeError {
    /// The layout of this C++ library's strings and vectors is unknown to the daemon.
    #[error(
        "the C++ library this daemon was built with keeps std::vector in a way it does not know: \
         lang \"c++\" needs libstdc++"
    )]
    OtherLibrary,
    /// `any`, or a type that is only declared.
    #[error("{ty} has no C++ type")]
    None {
        /// Spelling of the type.
        ty: String,
    },
    /// A member of a union has a constructor.
    #[error(
        "member '{member}' of type {ty} not allowed in C++ union {union}: put it beside the union"
    )]
    UnionMember {
        /// Name of the member.
        member: String,
        /// Spelling of its type.
        ty: String,
        /// Name of the union.
        union: String,
    },
    /// A sequence of arrays.
    #[error("{ty} has no C++ type, because {element} is an array there: put it in a struct")]
    ArrayElement {
        /// Spelling of the sequence.
        ty: String,
        /// Spelling of its element.
        element: String,
    },
    /// A sequence or array without element type: the model is inconsistent.
    #[error("{ty} has no element")]
    NoElement {
        /// Spelling of the type.
        ty: String,
    },
}

/// Why a path has no equivalent in a C++ value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum CxxPathError {
    /// The struct has no such member.
    #[error("there is no such member")]
    Member,
    /// Elements of `std::vector<bool>` have no address.
    #[error("an element of std::vector<bool> has no address: make it a sequence<octet>")]
    Bit,
    /// The type has no such part.
    #[error("{ty} has no such part")]
    Part {
        /// Spelling of the type.
        ty: String,
    },
    /// A sequence inside a type with the layout of C: the layouts are inconsistent.
    #[error("a sequence is no plain type")]
    Sequence,
    /// The path is invalid in C as well.
    #[error("{0}")]
    InC(#[from] PathError),
    /// A type on the path does not exist in C++.
    #[error("{0}")]
    Type(#[from] CxxTypeError),
}
