//! Why a type or a place in a value does not exist in C++.

use genom_types::PathError;

/// Why C++ has no such type (genom3.md 6).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum CxxTypeError {
    /// The daemon does not know how its C++ library keeps texts and sequences.
    #[error(
        "the C++ library this daemon was built with keeps std::vector in a way it does not know: \
         lang \"c++\" needs libstdc++"
    )]
    OtherLibrary,
    /// `any`, or a type that is only announced.
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
    /// A sequence or array of nothing: the model is inconsistent.
    #[error("{ty} has no element")]
    NoElement {
        /// Spelling of the type.
        ty: String,
    },
}

/// Why there is no such place in a C++ value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum CxxPathError {
    /// The struct has fewer members.
    #[error("there is no such member")]
    Member,
    /// Bits have no address.
    #[error("an element of std::vector<bool> has no address: make it a sequence<octet>")]
    Bit,
    /// The type has no parts of that kind.
    #[error("{ty} has no such part")]
    Part {
        /// Spelling of the type.
        ty: String,
    },
    /// A sequence is within a type whose bytes are those of C: the layouts are inconsistent.
    #[error("a sequence is no plain type")]
    Sequence,
    /// There is no such place in C either.
    #[error("{0}")]
    InC(#[from] PathError),
    /// What is there has no type in C++.
    #[error("{0}")]
    Type(#[from] CxxTypeError),
}
