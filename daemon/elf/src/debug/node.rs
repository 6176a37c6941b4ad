//! C types in debug information, one level at a time.

use gimli::{DwAte, UnitOffset};

/// Location of a type: index of its unit, and offset there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct At {
    /// Index of the unit.
    pub unit: usize,
    /// Offset in the unit, in bytes.
    pub offset: UnitOffset,
}

/// A C type. Inner types are locations to be read next; `None` there means `void`.
#[derive(Clone, Debug)]
pub enum Node {
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
pub struct Composite {
    /// Its tag; empty when it has none.
    pub name: String,
    /// Size in bytes; `None` when it is only declared.
    pub size: Option<u64>,
    /// Data members in order, including base classes.
    pub members: Vec<Member>,
    /// Virtual functions in order of declaration.
    pub methods: Vec<(String, Function)>,
    /// The first type among its template arguments.
    pub element: Option<At>,
}

/// A data member.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its name; empty when it has none.
    pub name: String,
    /// Offset from the start of the struct, in bytes.
    pub offset: u64,
    /// Its type.
    pub ty: Option<At>,
}

/// A function, or the type of one.
#[derive(Clone, Debug)]
pub struct Function {
    /// Type of what it returns.
    pub result: Option<At>,
    /// Name and type of each parameter.
    pub parameters: Vec<(String, Option<At>)>,
}
