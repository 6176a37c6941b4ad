//! C types as debug information tells them, one step at a time.

use gimli::{DwAte, UnitOffset};

/// The place of a type: rank of its unit, and offset there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct At {
    pub(super) unit: usize,
    pub(super) offset: UnitOffset,
}

/// A C type. Types inside are places to look at next; `None` there is `void`.
#[derive(Clone, Debug)]
pub(super) enum Node {
    /// `int`, `double`, `bool`...
    Base {
        /// As the compiler names it.
        name: String,
        /// Bytes.
        size: u64,
        /// Integer, float, boolean...
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
    /// A struct or class; without members when it is only announced.
    Struct(Composite),
    /// A union; likewise.
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
        /// Bytes.
        size: u64,
    },
    /// A function, behind a pointer.
    Function(Function),
    /// Something this reader does not know, such as a type kept in another file.
    Unknown,
}

/// A struct, class or union.
#[derive(Clone, Debug, Default)]
pub(super) struct Composite {
    /// Its tag, empty when it has none.
    pub(super) name: String,
    /// Bytes; `None` when it is only announced.
    pub(super) size: Option<u64>,
    /// Data members in order, bases included.
    pub(super) members: Vec<Member>,
    /// Virtual functions in order of declaration.
    pub(super) methods: Vec<(String, Function)>,
    /// First type among the template's arguments.
    pub(super) element: Option<At>,
}

/// A data member.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) name: String,
    pub(super) offset: u64,
    pub(super) ty: Option<At>,
}

/// A function or the type of one.
#[derive(Clone, Debug)]
pub(super) struct Function {
    pub(super) result: Option<At>,
    /// Name and type of each parameter.
    pub(super) parameters: Vec<(String, Option<At>)>,
}
