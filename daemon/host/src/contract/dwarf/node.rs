//! C types in debug information, one level at a time.

use gimli::{DwAte, UnitOffset};

/// Location of a type: index of its unit, and offset there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct At {
    pub(super) unit: usize,
    pub(super) offset: UnitOffset,
}

/// A C type. Inner types are locations to be read next; `None` there means `void`.
#[derive(Clone, Debug)]
pub(super) enum Node {
    /// `int`, `double`, `bool`...
    Base {
        /// Name given by the compiler.
        name: String,
        /// Size in bytes.
        size: u64,
        /// Integer, float, boolean and so on.
        encoding: DwAte,
    },
    /// A pointer.
    Pointer(Option<At>),
    /// A reference of C++.
    Reference(Option<At>),
    /// `const`, `volatile`, `restrict`, `_Atomic`.
    Qualified(&'static str, Option<At>),
    /// A typedef.
    Typedef(String, Option<At>),
    /// A struct or class; without members when it is only declared.
    Struct(Composite),
    /// A union; without members when it is only declared.
    Union(Composite),
    /// An array with all its dimensions.
    Array {
        /// Type of an element.
        element: Option<At>,
        /// Length of each dimension, outermost first; `None` for `[]`.
        lengths: Vec<Option<u64>>,
    },
    /// An enum.
    Enum {
        /// Word after `enum`; empty without one.
        name: String,
        /// Size in bytes.
        size: u64,
    },
    /// The type of a function.
    Function(Function),
    /// A type that this reader does not support, such as one in another file.
    Unknown,
}

/// A struct, class or union.
#[derive(Clone, Debug, Default)]
pub(super) struct Composite {
    /// Its tag; empty when it has none.
    pub(super) name: String,
    /// Size in bytes; `None` when it is only declared.
    pub(super) size: Option<u64>,
    /// Data members in order, including base classes.
    pub(super) members: Vec<Member>,
    /// Virtual functions in order of declaration.
    pub(super) methods: Vec<(String, Function)>,
    /// The first type among its template arguments.
    pub(super) element: Option<At>,
}

/// A data member.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) name: String,
    pub(super) offset: u64,
    pub(super) ty: Option<At>,
}

/// A function, or the type of one.
#[derive(Clone, Debug)]
pub(super) struct Function {
    pub(super) result: Option<At>,
    /// Name and type of each parameter.
    pub(super) parameters: Vec<(String, Option<At>)>,
}
